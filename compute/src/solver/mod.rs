//! Solvers of the discrete radiosity equation B_i = E_i + rho_i sum_j F_ij B_j.
//!
//! A solver is advanced a batch of rows at a time, so that between any two batches a run can be
//! watched, stopped, or written to a file from which it goes on with the same bits.

pub mod convergence;
mod gather;
mod shoot;
mod start_up;

use scene::Solution;

pub use gather::{Gather, Update};
pub use shoot::{Shoot, ambient_radiosity};
pub use start_up::StartUp;

use crate::row_cache::RowCache;
use crate::rows::BackendError;

/// One way to solve, on its way.
pub trait Solver: Send {
    /// Does a short piece of work.
    fn step(&mut self, rows: &mut RowCache) -> Result<Step, BackendError>;

    /// What a file keeps of the state: enough to go on from here with the same bits.
    fn snapshot(&self) -> Solution;

    /// Iterations done, those of a continued file included.
    fn iterations(&self) -> u64;

    /// The relative residual after the last iteration, dimensionless; `None` before the first.
    fn residual(&self) -> Option<f64>;
}

/// What a step has done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// True where it was the last of an iteration.
    pub ends_iteration: bool,
    /// Share of the iteration that is done, 0 to 1.
    pub share_done: f64,
}
