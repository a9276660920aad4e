//! Solving among sources, as a run of the patches sees it.

use scene::{Level, Solution, State};

use crate::row_cache::RowCache;
use crate::rows::BackendError;
use crate::solver::{Solver, Step};
use crate::sources::Sources;

/// A solver among the sources of a scene, whose solutions are the scene's: each patch has what its source has.
pub struct OnSources<'a> {
    solver: Box<dyn Solver + 'a>,
    sources: Sources<'a>,
    max_area: f64,
}

impl<'a> OnSources<'a> {
    /// The solver that `make` makes among `sources`, those of at most `max_area`, m^2, going on from `start`, one
    /// of the scene.
    pub fn new(
        sources: Sources<'a>,
        max_area: f64,
        start: Solution,
        make: impl FnOnce(Solution) -> Box<dyn Solver + 'a>,
    ) -> Self {
        Self {
            solver: make(restrict(&sources, start)),
            sources,
            max_area,
        }
    }

    /// The sources.
    pub fn sources(&self) -> &Sources<'a> {
        &self.sources
    }

    /// The sources' own solution.
    pub fn among_sources(&self) -> Solution {
        self.solver.snapshot()
    }
}

/// A solution of the sources. What of an iteration was reached is kept where it was reached among them.
fn restrict(sources: &Sources, start: Solution) -> Solution {
    let Solution {
        irradiance,
        mut provenance,
        state,
        ..
    } = start;
    let to_sources = |values: &[_]| sources.restricted(values);
    let level = std::mem::take(&mut provenance.level);
    let state = match (state, level.source_area()) {
        (State::Unfinished { .. }, None) => State::AtRest,
        (state, _) => state.map(to_sources),
    };
    Solution {
        irradiance: to_sources(&irradiance),
        provenance,
        state,
        function: None,
        layers: None,
    }
}

impl Solver for OnSources<'_> {
    fn step(&mut self, rows: &mut RowCache) -> Result<Step, BackendError> {
        self.solver.step(rows)
    }

    fn snapshot(&self) -> Solution {
        let Solution {
            irradiance,
            mut provenance,
            state,
            ..
        } = self.solver.snapshot();
        let to_patches = |values: &[_]| self.sources.prolonged(values);
        provenance.level = Level::Sources {
            max_area: self.max_area,
        };
        Solution {
            irradiance: to_patches(&irradiance),
            provenance,
            state: state.map(to_patches),
            function: None,
            layers: None,
        }
    }

    fn iterations(&self) -> u64 {
        self.solver.iterations()
    }

    fn residual(&self) -> Option<f64> {
        self.solver.residual()
    }
}
