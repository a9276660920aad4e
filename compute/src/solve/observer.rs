//! Watching a run.

use std::fmt::{Display, Formatter};
use std::time::Duration;

use scene::Solution;

use crate::function::Errors;
use crate::quantity::show_size;
use crate::row_file::RowFileRemark;

/// Somebody who is told how a run goes. All of it is optional.
pub trait Observer {
    /// Where the run is; after each short piece of work.
    fn progress(&mut self, _position: &Position) {}

    /// An irradiance function is gathered: at how many vertices so far, and its estimated error, once it is known.
    fn function(&mut self, _vertices: u32, _error: Option<Errors>) {}

    /// Something that a user should know.
    fn remark(&mut self, _remark: &Remark) {}

    /// An iteration among the scene's patches has ended, which was this one, counted from 1; `solution` makes what there is
    /// now. Those among coarser sources, of which patches have nothing yet, are not told.
    fn iteration(&mut self, _iterations: u64, _solution: &dyn Fn() -> Solution) {}

    /// What there is of the solution, now and then: the run goes on from it with the same bits as if it had never
    /// stopped. Who finds no room for it may ask `make_room`, which gives up what is only there to save time; false
    /// where there is nothing to give up.
    fn checkpoint(&mut self, _solution: &Solution, _make_room: &mut dyn FnMut() -> bool) {}
}

/// Who is told and does nothing.
pub(super) struct Nobody;

impl Observer for Nobody {}

/// Where a run is.
#[derive(Clone, Copy, Debug)]
pub struct Position {
    /// Iterations done.
    pub iterations: u64,
    /// Whether all patches gather once, after the iterations.
    pub is_gathering: bool,
    /// Share of the iteration under way, 0 to 1.
    pub share_done: f64,
    /// The relative residual, dimensionless.
    pub residual: Option<f64>,
    /// Hemicubes drawn in this run.
    pub hemicubes: u64,
    /// Rows whose hemicubes they are.
    pub rows: u64,
    /// Time spent drawing them.
    pub drawing: Duration,
    /// Rows that will have to be drawn after the iterations: those with which patches gather from coarser sources.
    pub rows_after: u32,
}

/// Something that a user should know on the way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Remark {
    /// The start was solved in another way than the run: what differs, as the end of a sentence about it.
    Start(String),
    /// The start has had all the iterations that were asked for: so many.
    NothingToDo(u64),
    /// Why another back end draws than might be expected.
    Backend(String),
    /// Rows do not fit the memory and are drawn or read again whenever they are needed.
    Shortage {
        /// Rows that are kept.
        kept: u64,
        /// Of so many.
        rows: u32,
        /// What would keep all of them, bytes.
        enough: u64,
    },
    /// Something about files of rows.
    RowFile(RowFileRemark),
}

/// As a sentence about the start or the run.
impl Display for Remark {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        match self {
            Self::Start(difference) => {
                write!(f, "{difference}; its radiosities are the start")
            }
            Self::NothingToDo(had) => write!(f, "has had {had} iterations"),
            Self::Backend(remark) => f.write_str(remark),
            Self::RowFile(remark) => write!(f, "{remark}"),
            Self::Shortage { kept, rows, enough } => write!(
                f,
                "{kept} of {rows} rows of form factors are kept, the others are drawn or read again whenever they are needed; \
                 --memory {} would keep all",
                show_size(*enough).replace(' ', "")
            ),
        }
    }
}
