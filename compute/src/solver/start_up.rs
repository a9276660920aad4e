//! What there is to be seen before a gathering solver has done its first iteration.
//!
//! That iteration draws the rows of all patches, and while it lasts no patch has an irradiance. So the lamps shoot first, and then
//! what they light most (see [`Shoot`]), until a tenth of what is emitted is left to shoot or enough patches have shot. Until the
//! iteration ends a snapshot has the irradiances of these shots, and says so in its provenance. They are for the eye alone: the
//! solver starts from darkness, so that the shots change no bit of what comes of it. Their rows are those of the iteration, and as a
//! rule are kept for it.

use scene::{Rgb, Solution};

use super::{Gather, Shoot, Solver, Step};
use crate::problem::Problem;
use crate::row_cache::RowCache;
use crate::rows::BackendError;

/// The unshot share of the emitted power with which the shots end: the eye does not miss the rest.
const LEAST_UNSHOT: f64 = 0.1;

/// At most one patch in so many shoots: where rows are not kept, they have to be drawn again.
const PATCHES_PER_SHOT: usize = 32;

/// A gathering solver that starts from darkness, and the shots before it.
#[derive(Debug)]
pub struct StartUp {
    gather: Gather,
    shots: Shots,
}

#[derive(Debug)]
enum Shots {
    UnderWay {
        shoot: Box<Shoot>,
        most: u64,
    },
    /// W/m^2, one per patch, and by how many shots.
    Done(Vec<Rgb>, u64),
    /// The first iteration is over.
    Forgotten,
}

impl StartUp {
    /// A solver that goes on from `start`, without irradiances, for which `gather` was made.
    pub fn new(gather: Gather, problem: Problem) -> Self {
        let patches = problem.patch_count();
        let dark = Solution {
            irradiance: vec![Rgb::ZERO; patches],
            provenance: scene::Provenance::default(),
            state: scene::State::AtRest,
            function: None,
            layers: None,
        };
        Self {
            gather,
            shots: Shots::UnderWay {
                shoot: Box::new(Shoot::new(problem, dark)),
                most: patches.div_ceil(PATCHES_PER_SHOT) as u64,
            },
        }
    }
}

impl StartUp {
    /// Share of the first iteration that is done, 0 to 1: what takes its time are the rows, which the shots have drawn some of.
    fn share_done(&self, rows: &RowCache) -> f64 {
        let gathered = self.gather.share_done();
        let statistics = rows.statistics();
        if statistics.left_out_rows > 0 {
            return gathered;
        }
        let there = (statistics.drawn_rows + statistics.read_rows) as f64;
        gathered.max((there / f64::from(rows.lit_count().max(1))).min(1.0))
    }
}

impl Solver for StartUp {
    fn step(&mut self, rows: &mut RowCache) -> Result<Step, BackendError> {
        if let Shots::UnderWay { shoot, most } = &mut self.shots {
            shoot.step(rows)?;
            let is_bright = shoot.residual().is_some_and(|r| r <= LEAST_UNSHOT);
            if is_bright || shoot.iterations() >= *most {
                self.shots = Shots::Done(shoot.snapshot().irradiance, shoot.iterations());
            }
            return Ok(Step {
                ends_iteration: false,
                share_done: self.share_done(rows),
            });
        }
        let step = self.gather.step(rows)?;
        if step.ends_iteration {
            self.shots = Shots::Forgotten;
            return Ok(step);
        }
        Ok(Step {
            share_done: self.share_done(rows),
            ..step
        })
    }

    fn snapshot(&self) -> Solution {
        let mut solution = self.gather.snapshot();
        let (irradiance, shots) = match &self.shots {
            Shots::UnderWay { shoot, .. } => (shoot.snapshot().irradiance, shoot.iterations()),
            Shots::Done(irradiance, shots) => (irradiance.clone(), *shots),
            Shots::Forgotten => return solution,
        };
        solution.irradiance = irradiance;
        solution.provenance.start_up_shots = shots;
        solution
    }

    fn iterations(&self) -> u64 {
        self.gather.iterations()
    }

    fn residual(&self) -> Option<f64> {
        self.gather.residual()
    }
}
