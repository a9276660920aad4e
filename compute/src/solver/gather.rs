//! Gathering: Jacobi and Gauss-Seidel iterations.
//!
//! # Theory
//! An iteration gathers H_i = sum_j F_ij B_j for every patch i in turn, and B_i = E_i + rho_i H_i.
//! Jacobi's B_j are all of the last iteration; Gauss-Seidel's are the newest known. Both converge
//! because rho F has a norm below 1 (rows of F sum to at most 1, reflectances are below 1).
//!
//! # Practice
//! The state is f32 so that a file keeps all of it; each sum runs in f64 over the row's patches in
//! their order, so the threads, the batches and the back end do not change a bit.
//!
//! The relative residual of an iteration is |B - B'| / |B| with |X|^2 = sum_i A_i X_i^2 over patches
//! and channels, B' from before it.

use glam::DVec3;
use rayon::prelude::*;
use scene::{Provenance, Rgb, Solution, Unfinished};

use super::{Solver, Step};
use crate::problem::Problem;
use crate::row_cache::RowCache;
use crate::rows::{BackendError, Entry, UNITS_PER_ONE};

/// When a patch's new radiosity is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Update {
    /// In the next iteration: Jacobi.
    AfterIteration,
    /// From the next patch on: Gauss-Seidel.
    AtOnce,
}

/// A gathering solver.
#[derive(Debug)]
pub struct Gather {
    problem: Problem,
    update: Update,
    provenance: Provenance,
    /// After the last whole iteration, W/m^2, one per patch.
    irradiance: Vec<Rgb>,
    /// Of the iteration under way, W/m^2, the first patches.
    next: Vec<Rgb>,
    /// What is gathered, W/m^2, one per patch.
    radiosity: Vec<Rgb>,
}

impl Gather {
    /// A solver that goes on from `start`, whose lengths fit the problem.
    pub fn new(problem: Problem, update: Update, start: Solution) -> Self {
        let Solution {
            irradiance,
            provenance,
            unfinished,
            ..
        } = start;
        let mut radiosity: Vec<Rgb> = irradiance
            .iter()
            .enumerate()
            .map(|(i, &h)| problem.radiosity(i, h))
            .collect();
        let next = unfinished.map_or_else(Vec::new, |unfinished| unfinished.irradiance);
        if update == Update::AtOnce {
            for (i, &h) in next.iter().enumerate() {
                radiosity[i] = problem.radiosity(i, h);
            }
        }
        Self {
            problem,
            update,
            provenance,
            irradiance,
            next,
            radiosity,
        }
    }

    fn finish_iteration(&mut self) {
        let (mut change, mut norm) = (0.0, 0.0);
        for (i, (&old, &new)) in self.irradiance.iter().zip(&self.next).enumerate() {
            let radiosity = self.problem.radiosity(i, new);
            let difference = (radiosity - self.problem.radiosity(i, old)).as_dvec3();
            change += self.problem.areas[i] * difference.length_squared();
            norm += self.problem.areas[i] * radiosity.as_dvec3().length_squared();
            self.radiosity[i] = radiosity;
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

/// H_i = sum_j F_ij B_j of one row, W/m^2.
fn gather(row: &[Entry], radiosity: &[Rgb]) -> Rgb {
    let sum: DVec3 = row
        .iter()
        .map(|entry| f64::from(entry.units) * radiosity[entry.patch as usize].as_dvec3())
        .sum();
    (sum / f64::from(UNITS_PER_ONE)).as_vec3()
}

impl Solver for Gather {
    fn step(&mut self, rows: &mut RowCache) -> Result<Step, BackendError> {
        let first = self.next.len();
        let batch = rows.batch_with(first as u32)?;
        let range = batch.patches();
        // A batch may start before the first patch when an iteration was stopped in other batches.
        let in_batch = first - range.start as usize..range.len();
        let row = |k: usize| batch.row(k);
        match self.update {
            Update::AfterIteration => {
                let radiosity = &self.radiosity;
                self.next
                    .par_extend(in_batch.into_par_iter().map(|k| gather(row(k), radiosity)));
            }
            Update::AtOnce => {
                for k in in_batch {
                    let irradiance = gather(row(k), &self.radiosity);
                    let patch = self.next.len();
                    self.radiosity[patch] = self.problem.radiosity(patch, irradiance);
                    self.next.push(irradiance);
                }
            }
        }
        let share_done = self.next.len() as f64 / self.problem.patch_count() as f64;
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
            unfinished: (!self.next.is_empty()).then(|| Unfinished {
                irradiance: self.next.clone(),
            }),
            unshot: None,
        }
    }

    fn iterations(&self) -> u64 {
        self.provenance.iterations
    }

    fn residual(&self) -> Option<f64> {
        self.provenance.residuals.last().copied()
    }
}
