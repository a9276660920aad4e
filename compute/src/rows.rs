//! Form factor rows: F_ij of some patches i to all patches j.
//!
//! F_ij = units / UNITS_PER_ONE, the fraction of the power leaving patch i that arrives at patch
//! j. Only non-zero entries are kept, in patch order. Geometry alone decides them.

use std::ops::Range;

/// Units of a form factor of 1: nearly 2^32, and a multiple of 3 and of 2^10, so that as many hemicubes
/// have equal shares in it.
pub const UNITS_PER_ONE: u32 = ((1 << 22) - 1) << 10;

/// One non-zero form factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The patch j that receives.
    pub patch: u32,
    /// F_ij in units of 1/[`UNITS_PER_ONE`]: a whole number where pixels were counted, rounded to 24 bits; of
    /// any size where a formula gave it, since a lamp can be too far away for a unit.
    pub units: f32,
}

/// What of a hemisphere is not seen as a patch's front, in units of 1/[`UNITS_PER_ONE`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unseen {
    /// Share that sees nothing: an opening.
    pub open: u32,
    /// Share that sees back faces: a leak, or wrong winding.
    pub back_face: u32,
}

/// The form factors of one patch.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// In patch order.
    pub entries: Vec<Entry>,
    /// What the patch does not see as patches.
    pub unseen: Unseen,
}

/// Rows of consecutive patches.
#[derive(Clone, Debug, PartialEq)]
pub struct RowBatch {
    first_patch: u32,
    rows: Vec<Row>,
}

impl RowBatch {
    /// A batch without rows, whose first will be that of `first_patch`.
    pub fn new(first_patch: u32) -> Self {
        Self::of(first_patch, Vec::new())
    }

    /// The rows of consecutive patches, the first of which is `first_patch`'s.
    pub fn of(first_patch: u32, rows: Vec<Row>) -> Self {
        Self { first_patch, rows }
    }

    /// Adds the next patch's row.
    pub fn push(&mut self, row: Row) {
        self.rows.push(row);
    }

    /// Adds the rows of the patches that follow.
    pub fn append(&mut self, mut next: Self) {
        self.rows.append(&mut next.rows);
    }

    /// The patches whose rows these are.
    pub fn patches(&self) -> Range<u32> {
        self.first_patch..self.first_patch + self.rows.len() as u32
    }

    /// The row of the batch's k-th patch.
    pub fn row(&self, k: usize) -> &[Entry] {
        &self.rows[k].entries
    }

    /// What the batch's k-th patch does not see as patches.
    pub fn unseen(&self, k: usize) -> Unseen {
        self.rows[k].unseen
    }

    /// All rows.
    pub fn rows_mut(&mut self) -> &mut [Row] {
        &mut self.rows
    }
}

/// Something that makes form factor rows, of hemicubes as a rule: a back end.
pub trait RowSource: Send {
    /// Draws the rows of consecutive patches, which all exist.
    fn draw_rows(&mut self, patches: Range<u32>) -> Result<RowBatch, BackendError>;

    /// How many patches it likes to be asked for at a time.
    fn preferred_batch(&self) -> u32;

    /// What it is, for people: "cpu, 2 threads" or an adapter's name.
    fn describe(&self) -> String;

    /// False where the rows are formulas, see [`crate::convex`].
    fn draws_hemicubes(&self) -> bool {
        true
    }
}

/// Why a back end cannot go on.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum BackendError {
    #[error(
        "no GPU adapter was found; install a Vulkan driver (Mesa's software one will do) or use --backend cpu"
    )]
    NoAdapter,
    #[error("adapter \"{adapter}\": {what}; use --backend cpu")]
    Unsuitable { adapter: String, what: String },
    #[error(
        "the GPU device was lost ({what}); continue from the checkpoint, if need be with --backend cpu"
    )]
    DeviceLost { what: String },
    #[error("the threads could not be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
