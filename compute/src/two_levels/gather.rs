//! What all patches receive from the sources: one pass.

use scene::{Level, Rgb, Solution, State};

use super::Radiosities;
use crate::problem::Problem;
use crate::row_cache::RowCache;
use crate::rows::BackendError;
use crate::solver::{Solver, Step};
use crate::sources::Sources;

/// Each patch gathers once from the sources.
#[derive(Debug)]
pub struct GatherOnce {
    radiosities: Radiosities,
    /// The sources' solution, as one of the patches.
    sources: Solution,
    /// Their largest area, m^2.
    max_area: f64,
    /// Irradiances that have been gathered, W/m^2, the first patches.
    irradiance: Vec<Rgb>,
    patch_count: usize,
}

impl GatherOnce {
    /// Gathering from the `solution` of sources of at most `max_area`, m^2, as a solution of the scene; where it was
    /// gathering already, it goes on.
    pub fn new(sources: &Sources, max_area: f64, mut solution: Solution) -> Self {
        let irradiance = match std::mem::take(&mut solution.provenance.level) {
            Level::Gathering { gathered, .. } => gathered,
            _ => Vec::new(),
        };
        let among_sources = sources.restricted(&solution.irradiance);
        Self {
            radiosities: Radiosities::new(&Problem::new(sources.scene()), &among_sources),
            sources: solution,
            max_area,
            irradiance,
            patch_count: sources.patches().patch_count() as usize,
        }
    }

    fn is_done(&self) -> bool {
        self.irradiance.len() == self.patch_count
    }

    /// Share of the patches that have gathered, 0 to 1.
    pub fn share_done(&self) -> f64 {
        self.irradiance.len() as f64 / self.patch_count as f64
    }
}

impl Solver for GatherOnce {
    fn step(&mut self, rows: &mut RowCache) -> Result<Step, BackendError> {
        let from = self.irradiance.len() as u32;
        let batch = rows.batch_with(from)?;
        self.irradiance.extend(self.radiosities.gather(batch, from));
        Ok(Step {
            ends_iteration: self.is_done(),
            share_done: self.share_done(),
        })
    }

    fn snapshot(&self) -> Solution {
        if self.is_done() {
            return Solution {
                irradiance: self.irradiance.clone(),
                // The sources' own level has been taken from it: these are of the patches.
                provenance: self.sources.provenance.clone(),
                // What is unshot among sources says nothing of what patches have received from them.
                state: State::AtRest,
                function: None,
                layers: None,
            };
        }
        let mut solution = self.sources.clone();
        solution.provenance.level = Level::Gathering {
            max_area: self.max_area,
            gathered: self.irradiance.clone(),
        };
        solution
    }

    fn iterations(&self) -> u64 {
        self.sources.provenance.iterations
    }

    fn residual(&self) -> Option<f64> {
        self.sources.provenance.residuals.last().copied()
    }
}
