//! Gathering: Jacobi and Gauss-Seidel iterations.
//!
//! # Theory
//! An iteration gathers H_i = sum_j F_ij B_j for every patch i in turn, and B_i = E_i + rho_i H_i.
//! Jacobi's B_j are all of the last iteration; Gauss-Seidel's are the newest known. Both converge
//! because rho F has a norm below 1 (rows of F sum to at most 1, reflectances are below 1).
//!
//! Gauss-Seidel's patches are taken in blocks of consecutive ones, whose size the number of patches alone
//! decides: a block gathers what the blocks before it have reached in this iteration, and of itself and
//! of those after it what the last one left (block Gauss-Seidel with a Jacobi step in each block: Golub and
//! Van Loan, "Matrix computations", section 11.2). So the rows of a block are gathered in parallel, and all
//! threads give the same bits. Patches of a block are neighbours, mostly in one plane, and hardly see each
//! other, so it converges as fast as patch by patch.
//!
//! # Practice
//! The state is f32 so that a file keeps all of it; each sum runs in f64 over the row's patches in
//! an order that the row alone decides, so the threads, the batches and the back end do not change a bit.
//!
//! The relative residual of an iteration is |B - B'| / |B| with |X|^2 = sum_i A_i X_i^2 over patches
//! and channels, B' from before it.

use rayon::prelude::*;
use scene::{Provenance, Rgb, Solution, State};

use super::{Solver, Step};
use crate::compact_rows::{Channels, CompactRows, Gatherer};
use crate::problem::Problem;
use crate::row_cache::RowCache;
use crate::rows::BackendError;

/// When a patch's new radiosity is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// In the next iteration: Jacobi.
    AfterIteration,
    /// From the next block of patches on: Gauss-Seidel.
    AtOnce,
}

/// A gathering solver.
#[derive(Debug)]
pub struct Gather {
    problem: Problem,
    provenance: Provenance,
    /// After the last whole iteration, W/m^2, one per patch.
    irradiance: Vec<Rgb>,
    /// Of the iteration under way, W/m^2, the first patches.
    next: Vec<Rgb>,
    /// What is gathered, W/m^2, one per patch.
    radiosity: Channels,
    /// What patches receive besides, W/m^2, one per patch, may be negative; empty where it is nothing.
    besides: Vec<Rgb>,
    gatherer: Gatherer,
    /// Patches whose new radiosities are used together.
    block: usize,
}

/// Kept rows that a step gathers, bytes: some hundredths of a second, so that a run is stopped soon.
const STEP_BYTES: u64 = 32 << 20;

/// Rows that a thread gathers at a time.
const ROWS_PER_TASK: usize = 8;

/// Blocks of Gauss-Seidel, where there are patches enough: iterations hardly fall any more with more.
const BLOCKS: usize = 64;

/// The largest block: enough work for some threads.
const LARGEST_BLOCK: usize = 256;

impl Gather {
    /// A solver that goes on from `start`, whose lengths fit the problem. What shooting has under way is no use to it.
    pub fn new(problem: Problem, update: Update, start: Solution) -> Self {
        let Solution {
            irradiance,
            provenance,
            state,
            ..
        } = start;
        let radiosity = irradiance.iter().enumerate();
        let radiosity = Channels::new(radiosity.map(|(i, &h)| problem.radiosity(i, h)));
        let next = match state {
            State::Unfinished { irradiance } => irradiance,
            State::AtRest | State::Shooting { .. } => Vec::new(),
        };
        let block = match update {
            Update::AfterIteration => problem.patch_count().max(1),
            Update::AtOnce => (problem.patch_count() / BLOCKS).clamp(1, LARGEST_BLOCK),
        };
        let mut gather = Self {
            problem,
            provenance,
            irradiance,
            next,
            radiosity,
            besides: Vec::new(),
            gatherer: Gatherer::default(),
            block,
        };
        gather.use_blocks(0);
        gather
    }

    /// The same where patches receive this besides what they gather, W/m^2, one per patch, which may be negative.
    #[must_use]
    pub fn with_besides(self, besides: Vec<Rgb>) -> Self {
        Self { besides, ..self }
    }

    /// Share of the iteration that is done, 0 to 1.
    pub(super) fn share_done(&self) -> f64 {
        self.next.len() as f64 / self.problem.patch_count() as f64
    }

    /// Makes the radiosities of the blocks that have been gathered, from that of patch `from` on, known.
    fn use_blocks(&mut self, from: usize) {
        let end = self.next.len() / self.block * self.block;
        for patch in from / self.block * self.block..end {
            let radiosity = self.problem.radiosity(patch, self.next[patch]);
            self.radiosity.set(patch, radiosity);
        }
    }

    /// Gathers the rows of the next patches, up to `end`, all of which are in `batches`.
    fn gather(&mut self, batches: &[&CompactRows], end: usize) {
        let (radiosity, besides, gatherer) = (&self.radiosity, &self.besides, self.gatherer);
        let irradiance = (self.next.len()..end)
            .into_par_iter()
            .with_min_len(ROWS_PER_TASK)
            .map(|patch| {
                let batch = batches.partition_point(|b| b.receivers().end as usize <= patch);
                let batch = batches[batch];
                let row = batch.row(patch - batch.receivers().start as usize);
                let irradiance = gatherer.irradiance(row, radiosity);
                let besides = besides.get(patch);
                besides.map_or(irradiance, |&more| (irradiance + more).max(Rgb::ZERO))
            });
        self.next.par_extend(irradiance);
    }

    fn finish_iteration(&mut self) {
        let (mut change, mut norm) = (0.0, 0.0);
        for (i, (&old, &new)) in self.irradiance.iter().zip(&self.next).enumerate() {
            let radiosity = self.problem.radiosity(i, new);
            let difference = (radiosity - self.problem.radiosity(i, old)).as_dvec3();
            change += self.problem.areas[i] * difference.length_squared();
            norm += self.problem.areas[i] * radiosity.as_dvec3().length_squared();
            self.radiosity.set(i, radiosity);
        }
        let residual = if norm == 0.0 {
            0.0
        } else {
            (change / norm).sqrt()
        };
        std::mem::swap(&mut self.irradiance, &mut self.next);
        self.next.clear();
        self.provenance.iterations = self.provenance.iterations.saturating_add(1);
        self.provenance.residuals.push(residual);
    }
}

impl Solver for Gather {
    fn step(&mut self, rows: &mut RowCache) -> Result<Step, BackendError> {
        let first = self.next.len();
        let batches = rows.batches_with(first as u32, STEP_BYTES)?;
        // The first may begin before the next patch where an iteration was stopped in other batches.
        let end = batches.last().map_or(first, |b| b.receivers().end as usize);
        while self.next.len() < end {
            let from = self.next.len();
            self.gather(&batches, end.min((from / self.block + 1) * self.block));
            self.use_blocks(from);
        }
        let share_done = self.share_done();
        let ends_iteration = self.next.len() == self.problem.patch_count();
        if ends_iteration {
            self.finish_iteration();
        }
        Ok(Step {
            ends_iteration,
            share_done,
        })
    }

    fn snapshot(&self) -> Solution {
        Solution {
            irradiance: self.irradiance.clone(),
            provenance: self.provenance.clone(),
            state: if self.next.is_empty() {
                State::AtRest
            } else {
                State::Unfinished {
                    irradiance: self.next.clone(),
                }
            },
            function: None,
            layers: None,
        }
    }

    fn iterations(&self) -> u64 {
        self.provenance.iterations
    }

    fn residual(&self) -> Option<f64> {
        self.provenance.residuals.last().copied()
    }
}
