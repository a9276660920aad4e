//! Form factor rows: F_ij of some receivers i to all sources j.
//!
//! F_ij = units / UNITS_PER_ONE, the fraction of the power leaving receiver i that arrives at source
//! j. Only non-zero entries are kept, in the order of the sources. Geometry alone decides them.

use std::ops::Range;

/// Units of a form factor of 1: nearly 2^32, and a multiple of 3 and of 2^10, so that as many hemicubes
/// have equal shares in it.
pub const UNITS_PER_ONE: u32 = ((1 << 22) - 1) << 10;

/// One non-zero form factor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Entry {
    /// The source j that arrives there.
    pub source: u32,
    /// F_ij in units of 1/[`UNITS_PER_ONE`]: a whole number where pixels were counted, rounded to 24 bits; of
    /// any size where a formula gave it, since a lamp can be too far away for a unit.
    pub units: f32,
}

/// What of a hemisphere is not seen as a source's front, in units of 1/[`UNITS_PER_ONE`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Unseen {
    /// Share that sees nothing: an opening.
    pub open: u32,
    /// Share that sees back faces: a leak, or wrong winding.
    pub back_face: u32,
}

/// The form factors of one receiver.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Row {
    /// In the order of the sources.
    pub entries: Vec<Entry>,
    /// What the receiver does not see as sources.
    pub unseen: Unseen,
}

/// Rows of consecutive receivers.
#[derive(Clone, Debug, PartialEq)]
pub struct RowBatch {
    first: u32,
    rows: Vec<Row>,
}

impl RowBatch {
    /// A batch without rows, whose first will be that of receiver `first`.
    pub fn new(first: u32) -> Self {
        Self::of(first, Vec::new())
    }

    /// The rows of consecutive receivers from `first` on.
    pub fn of(first: u32, rows: Vec<Row>) -> Self {
        Self { first, rows }
    }

    /// Adds the next receiver's row.
    pub fn push(&mut self, row: Row) {
        self.rows.push(row);
    }

    /// Adds the rows of the receivers that follow.
    pub fn append(&mut self, mut next: Self) {
        self.rows.append(&mut next.rows);
    }

    /// The receivers whose rows these are.
    pub fn receivers(&self) -> Range<u32> {
        self.first..self.first + self.rows.len() as u32
    }

    /// The row of the batch's k-th receiver.
    pub fn row(&self, k: usize) -> &[Entry] {
        &self.rows[k].entries
    }

    /// What the batch's k-th receiver does not see as sources.
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
    /// Draws the rows of consecutive receivers, which all exist.
    fn draw_rows(&mut self, receivers: Range<u32>) -> Result<RowBatch, BackendError>;

    /// How many receivers it likes to be asked for at a time.
    fn preferred_batch(&self) -> u32;

    /// The back end that draws, as on the command line: `cpu` or `gpu`.
    fn backend(&self) -> &'static str {
        "cpu"
    }

    /// What it is, for people: "cpu, 2 threads" or an adapter's name.
    fn describe(&self) -> String;

    /// What of it decides the bits of the rows, as a file of them says: the same however many threads there are.
    fn identity(&self) -> String {
        self.backend().to_owned()
    }

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
