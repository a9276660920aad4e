//! Shooting: progressive refinement by unshot power.
//!
//! # Theory
//! The patch i with the most unshot power shoots its unshot radiosity dB_i: every patch j receives
//! dH_j = F_ji dB_i, its radiosity and its unshot radiosity grow by rho_j dH_j, and i has nothing
//! unshot any more (Cohen, Chen, Wallace, Greenberg, "A progressive refinement approach to fast
//! radiosity image generation", SIGGRAPH 1988). One hemicube at i serves for all j by reciprocity:
//! F_ji = F_ij A_i / A_j. One shot is one iteration.
//!
//! The relative residual is the unshot power over the emitted power, each summed over the channels.
//!
//! # Differences
//! Unshot radiosities may be negative here, and then the largest magnitude shoots (Southwell
//! relaxation). So a solution of any other origin is a valid start: every patch first shoots all of
//! its radiosity once, and what is unshot then is the difference to what it had.

use glam::DVec3;
use scene::{Provenance, Rgb, Solution};

use super::{Solver, Step};
use crate::problem::Problem;
use crate::row_cache::RowCache;
use crate::rows::{BackendError, Entry, UNITS_PER_ONE};

/// A shooting solver.
#[derive(Debug)]
pub struct Shoot {
    problem: Problem,
    provenance: Provenance,
    /// W/m^2, one per patch.
    irradiance: Vec<Rgb>,
    /// W/m^2, one per patch.
    unshot: Vec<Rgb>,
    /// Sum over channels, W.
    emitted_power: f64,
    /// A start from another solver's solution, as long as it is under way.
    takeover: Option<Takeover>,
}

/// Every patch shoots the radiosity of a solution that did not say what is unshot.
#[derive(Debug)]
struct Takeover {
    start: Solution,
    /// The next patch to shoot.
    next: usize,
}

impl Shoot {
    /// A solver that goes on from `start`, whose lengths fit the problem.
    pub fn new(problem: Problem, start: Solution) -> Self {
        let emitted_power = (0..problem.patch_count())
            .map(|i| power(&problem, i, problem.emission[i]))
            .sum();
        let dark = vec![Rgb::ZERO; problem.patch_count()];
        let provenance = start.provenance.clone();
        let (irradiance, unshot, takeover) = match &start.unshot {
            Some(unshot) => (start.irradiance, unshot.clone(), None),
            None if start.irradiance == dark => (dark, problem.emission.clone(), None),
            None => (dark.clone(), dark, Some(Takeover { start, next: 0 })),
        };
        Self {
            problem,
            provenance,
            irradiance,
            unshot,
            emitted_power,
            takeover,
        }
    }

    /// Adds what all patches receive from `shooter`, whose row is given, to their irradiances, and
    /// what they reflect of it to their unshot radiosities.
    fn shoot(&mut self, shooter: usize, radiosity: Rgb, row: &[Entry]) {
        let from = radiosity.as_dvec3() * self.problem.areas[shooter] / f64::from(UNITS_PER_ONE);
        for entry in row {
            let j = entry.patch as usize;
            let received = (f64::from(entry.units) / self.problem.areas[j] * from).as_vec3();
            // Taking back what was shot too much may round to a little below nothing.
            self.irradiance[j] = (self.irradiance[j] + received).max(Rgb::ZERO);
            self.unshot[j] += self.problem.reflectance[j] * received;
        }
    }

    fn step_takeover(
        &mut self,
        mut takeover: Takeover,
        rows: &mut RowCache,
    ) -> Result<Step, BackendError> {
        let count = self.problem.patch_count();
        let batch = rows.batch_with(takeover.next as u32)?;
        let range = batch.patches();
        for patch in takeover.next..range.end as usize {
            let radiosity = self
                .problem
                .radiosity(patch, takeover.start.irradiance[patch]);
            self.shoot(patch, radiosity, batch.row(patch - range.start as usize));
        }
        takeover.next = range.end as usize;
        let share_done = takeover.next as f64 / count as f64;
        if takeover.next == count {
            for i in 0..count {
                let shot = self.problem.radiosity(i, takeover.start.irradiance[i]);
                self.unshot[i] = self.problem.radiosity(i, self.irradiance[i]) - shot;
            }
        } else {
            self.takeover = Some(takeover);
        }
        Ok(Step {
            ends_iteration: false,
            share_done,
        })
    }
}

/// Power of a radiosity of patch i, summed over channels, W.
fn power(problem: &Problem, i: usize, radiosity: Rgb) -> f64 {
    problem.areas[i] * radiosity.as_dvec3().abs().dot(DVec3::ONE)
}

impl Solver for Shoot {
    fn step(&mut self, rows: &mut RowCache) -> Result<Step, BackendError> {
        if let Some(takeover) = self.takeover.take() {
            return self.step_takeover(takeover, rows);
        }
        let (mut shooter, mut most) = (0, 0.0);
        for (i, &unshot) in self.unshot.iter().enumerate() {
            let power = power(&self.problem, i, unshot);
            if power > most {
                (shooter, most) = (i, power);
            }
        }
        let batch = rows.batch_with(shooter as u32)?;
        let row = batch.row(shooter - batch.patches().start as usize);
        let radiosity = std::mem::take(&mut self.unshot[shooter]);
        self.shoot(shooter, radiosity, row);

        let unshot_power: f64 = self
            .unshot
            .iter()
            .enumerate()
            .map(|(i, &b)| power(&self.problem, i, b))
            .sum();
        let residual = if unshot_power == 0.0 {
            0.0
        } else {
            unshot_power / self.emitted_power
        };
        self.provenance.iterations = self.provenance.iterations.saturating_add(1);
        self.provenance.residuals.push(residual);
        Ok(Step {
            ends_iteration: true,
            share_done: 1.0,
        })
    }

    fn snapshot(&self) -> Solution {
        if let Some(takeover) = &self.takeover {
            return takeover.start.clone();
        }
        Solution {
            irradiance: self.irradiance.clone(),
            provenance: self.provenance.clone(),
            unfinished: None,
            unshot: Some(self.unshot.clone()),
        }
    }

    fn iterations(&self) -> u64 {
        self.provenance.iterations
    }

    fn residual(&self) -> Option<f64> {
        self.provenance.residuals.last().copied()
    }
}
