//! Solving among sources, as a run of the patches sees it.

use scene::{Scene, Solution, Sources, Unfinished};

use super::{prolonged, restricted};
use crate::row_cache::RowCache;
use crate::rows::BackendError;
use crate::solver::{Solver, Step};

/// A solver among the sources of a scene, whose solutions are the scene's: each patch has what its source has.
pub struct OnSources<'a> {
    solver: Box<dyn Solver + 'a>,
    scene: &'a Scene,
    sources: &'a Scene,
    max_area: f64,
}

impl<'a> OnSources<'a> {
    /// The solver that `make` makes among `sources`, those of at most `max_area`, m^2, going on from `start`, one
    /// of the scene.
    pub fn new(
        scene: &'a Scene,
        sources: &'a Scene,
        max_area: f64,
        start: Solution,
        make: impl FnOnce(Solution) -> Box<dyn Solver + 'a>,
    ) -> Self {
        Self {
            solver: make(restrict(scene, sources, start)),
            scene,
            sources,
            max_area,
        }
    }

    /// The sources' own solution.
    pub fn among_sources(&self) -> Solution {
        self.solver.snapshot()
    }
}

/// A solution of the sources. What of an iteration was reached is kept where it was reached among them.
fn restrict(scene: &Scene, sources: &Scene, mut start: Solution) -> Solution {
    let unfinished = start
        .unfinished
        .filter(|_| start.provenance.sources.is_some());
    let to_sources = |values: &[_]| restricted(scene, sources, values);
    start.provenance.sources = None;
    Solution {
        irradiance: to_sources(&start.irradiance),
        unfinished: unfinished.map(|unfinished| Unfinished {
            irradiance: to_sources(&unfinished.irradiance),
        }),
        unshot: start.unshot.as_deref().map(to_sources),
        remainder: start.remainder.as_deref().map(to_sources),
        provenance: start.provenance,
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
            unfinished,
            unshot,
            remainder,
        } = self.solver.snapshot();
        let to_patches = |values: &[_]| prolonged(self.scene, self.sources, values);
        provenance.sources = Some(Sources {
            max_area: self.max_area,
            is_gathering: false,
        });
        Solution {
            irradiance: to_patches(&irradiance),
            unfinished: unfinished.map(|unfinished| Unfinished {
                irradiance: to_patches(&unfinished.irradiance),
            }),
            unshot: unshot.as_deref().map(to_patches),
            remainder: remainder.as_deref().map(to_patches),
            provenance,
        }
    }

    fn iterations(&self) -> u64 {
        self.solver.iterations()
    }

    fn residual(&self) -> Option<f64> {
        self.solver.residual()
    }
}
