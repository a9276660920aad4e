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
//! What is still unshot is going to be reflected around. Spread evenly over the scene that is an ambient
//! radiosity, with the mean reflectance rho = sum A_i rho_i / sum A_i, of each channel
//!
//! ambient = (1 + rho + rho^2 + ...) sum A_i dB_i / sum A_i = sum A_i dB_i / (sum A_i (1 - rho_i))
//!
//! (Cohen et al. 1988, section 3.3). rho_i times it is what a patch's radiosity is likely to lack. It is told,
//! and added to nothing.
//!
//! # Practice
//! A patch's irradiance is the sum of as many shares as there are shots, each far below its rounding as an
//! f32, so what the f32 leaves out is kept beside it, in the file too; together they have 48 bits. What
//! is unshot is small and starts anew after each of the patch's own shots, so f32 serves.
//!
//! A shot changes a sixth to a half of all unshot powers. A heap would take a few comparisons for each of
//! them, more than looking at all. Instead blocks of patches have their sums and their largest; a shot
//! has those blocks counted again that it reaches. So the next shooter is found among the blocks, and the
//! unshot power, being a sum of sums in a fixed order, is the same as if it were added up from the start: it
//! cannot drift.
//!
//! # Differences
//! Unshot radiosities may be negative here, and then the largest magnitude shoots (Southwell
//! relaxation). So a solution of any other origin is a valid start: every patch first shoots all of
//! its radiosity once, and what is unshot then is the difference to what it had.

use glam::DVec3;
use scene::{Provenance, Rgb, Solution, State};

use super::{Solver, Step};
use crate::compact_rows::{CompactRows, Row};
use crate::problem::Problem;
use crate::row_cache::RowCache;
use crate::rows::{BackendError, UNITS_PER_ONE};

/// A shooting solver.
#[derive(Debug)]
pub struct Shoot {
    problem: Problem,
    provenance: Provenance,
    /// W/m^2, one per patch.
    irradiance: Vec<Rgb>,
    /// What the irradiance is more than its f32, W/m^2, one per patch.
    remainder: Vec<Rgb>,
    /// W/m^2, one per patch.
    unshot: Vec<Rgb>,
    unshot_powers: UnshotPowers,
    /// 1/A, m^-2, one per patch.
    inverse_areas: Vec<f64>,
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
        let none = dark.clone();
        let (irradiance, remainder, unshot, takeover) = match start.state {
            State::Shooting { unshot, remainder } => (start.irradiance, remainder, unshot, None),
            _ if start.irradiance == dark => (dark, none, problem.emission.clone(), None),
            _ => (dark.clone(), none, dark, Some(Takeover { start, next: 0 })),
        };
        Self {
            unshot_powers: UnshotPowers::new(&problem, &unshot),
            inverse_areas: problem.areas.iter().map(|area| 1.0 / area).collect(),
            problem,
            provenance,
            irradiance,
            remainder,
            unshot,
            emitted_power,
            takeover,
        }
    }

    /// Adds what all patches receive from `shooter`, whose row is given, to their irradiances, and
    /// what they reflect of it to their unshot radiosities.
    fn shoot(&mut self, shooter: usize, radiosity: Rgb, row: Row) {
        let from = radiosity.as_dvec3() * self.problem.areas[shooter] / f64::from(UNITS_PER_ONE);
        for entry in row {
            let j = entry.source as usize;
            let received = f64::from(entry.units) * self.inverse_areas[j] * from;
            let before = self.irradiance[j].as_dvec3() + self.remainder[j].as_dvec3();
            // Taking back what was shot too much may round to a little below nothing.
            let irradiance = (before + received).max(DVec3::ZERO);
            self.irradiance[j] = irradiance.as_vec3();
            self.remainder[j] = (irradiance - self.irradiance[j].as_dvec3()).as_vec3();
            self.unshot[j] += self.problem.reflectance[j] * received.as_vec3();
            let power = power(&self.problem, j, self.unshot[j]);
            self.unshot_powers.set(j, power);
        }
    }

    /// Shoots all radiosity of the batch's patches, which the takeover comes to next.
    fn step_takeover(&mut self, mut takeover: Takeover, batch: &CompactRows) -> Step {
        let count = self.problem.patch_count();
        let range = batch.receivers();
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
            self.unshot_powers = UnshotPowers::new(&self.problem, &self.unshot);
        } else {
            self.takeover = Some(takeover);
        }
        Step {
            ends_iteration: false,
            share_done,
        }
    }
}

/// Unshot powers, by patch and by block of patches, W.
#[derive(Debug)]
struct UnshotPowers {
    /// One per patch.
    powers: Vec<f64>,
    /// One per block.
    blocks: Vec<Block>,
    /// Blocks that must be counted again.
    changed: Vec<usize>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Block {
    sum: f64,
    largest: f64,
    /// True while it is among `changed`.
    is_changed: bool,
}

/// Patches in a block of powers.
const POWERS_PER_BLOCK: usize = 64;

impl UnshotPowers {
    /// `unshot` has one element per patch, W/m^2.
    fn new(problem: &Problem, unshot: &[Rgb]) -> Self {
        let powers = unshot.iter().enumerate();
        let powers: Vec<f64> = powers.map(|(i, &b)| power(problem, i, b)).collect();
        let blocks = powers.len().div_ceil(POWERS_PER_BLOCK);
        let is_changed = Block {
            is_changed: true,
            ..Block::default()
        };
        let mut powers = Self {
            powers,
            blocks: vec![is_changed; blocks],
            changed: (0..blocks).collect(),
        };
        powers.count();
        powers
    }

    #[inline]
    fn set(&mut self, patch: usize, power: f64) {
        self.powers[patch] = power;
        let index = patch / POWERS_PER_BLOCK;
        let block = &mut self.blocks[index];
        if !block.is_changed {
            block.is_changed = true;
            self.changed.push(index);
        }
    }

    /// Counts the blocks again that were changed.
    fn count(&mut self) {
        for index in self.changed.drain(..) {
            let start = index * POWERS_PER_BLOCK;
            let end = self.powers.len().min(start + POWERS_PER_BLOCK);
            let (mut sums, mut most) = ([0.0; 4], [0.0_f64; 4]);
            for powers in self.powers[start..end].chunks(4) {
                for ((sum, most), &power) in sums.iter_mut().zip(&mut most).zip(powers) {
                    *sum += power;
                    *most = if power > *most { power } else { *most };
                }
            }
            self.blocks[index] = Block {
                sum: sums.iter().sum(),
                largest: most.into_iter().fold(0.0, f64::max),
                is_changed: false,
            };
        }
    }

    /// The patch with the most; the first of several, and where nobody has any.
    fn largest(&mut self) -> usize {
        self.count();
        let (mut index, mut most) = (0, 0.0);
        for (k, block) in self.blocks.iter().enumerate() {
            if block.largest > most {
                (index, most) = (k, block.largest);
            }
        }
        let start = index * POWERS_PER_BLOCK;
        let end = self.powers.len().min(start + POWERS_PER_BLOCK);
        let in_block = self.powers[start..end].iter().position(|&p| p >= most);
        start + in_block.unwrap_or(0)
    }

    /// Of all patches.
    fn total(&mut self) -> f64 {
        self.count();
        self.blocks.iter().map(|block| block.sum).sum()
    }
}

/// The ambient radiosity of what is unshot, W/m^2; `None` where a solution does not tell that, or where nothing
/// is absorbed.
pub fn ambient_radiosity(problem: &Problem, solution: &Solution) -> Option<DVec3> {
    let State::Shooting { unshot, .. } = &solution.state else {
        return None;
    };
    let (mut power, mut absorbing) = (DVec3::ZERO, DVec3::ZERO);
    for (i, b) in unshot.iter().enumerate() {
        power += problem.areas[i] * b.as_dvec3();
        absorbing += problem.areas[i] * (1.0 - problem.reflectance[i].as_dvec3());
    }
    (absorbing.min_element() > 0.0).then(|| power / absorbing)
}

/// Power of a radiosity of patch i, summed over channels, W.
fn power(problem: &Problem, i: usize, radiosity: Rgb) -> f64 {
    problem.areas[i] * radiosity.as_dvec3().abs().dot(DVec3::ONE)
}

impl Solver for Shoot {
    fn step(&mut self, rows: &mut RowCache) -> Result<Step, BackendError> {
        if let Some(takeover) = self.takeover.take() {
            let next = takeover.next as u32;
            return match rows.batch_with(next) {
                Ok(batch) => Ok(self.step_takeover(takeover, batch)),
                Err(error) => {
                    // Without it, what is half taken over would be a solution.
                    self.takeover = Some(takeover);
                    Err(error)
                }
            };
        }
        let shooter = self.unshot_powers.largest();
        let batch = rows.batch_for_one(shooter as u32)?;
        let row = batch.row(shooter - batch.receivers().start as usize);
        let radiosity = std::mem::take(&mut self.unshot[shooter]);
        self.unshot_powers.set(shooter, 0.0);
        self.shoot(shooter, radiosity, row);

        let unshot_power = self.unshot_powers.total();
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
            state: State::Shooting {
                unshot: self.unshot.clone(),
                remainder: self.remainder.clone(),
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
