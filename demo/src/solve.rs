//! Solving one scene with the library, keeping what the pictures show.

use std::sync::Arc;
use std::time::Instant;

use compute::hemicubes::Hemicubes;
use compute::lamps::with_lamps;
use compute::problem::Problem;
use compute::report::{self, Closure};
use compute::row_cache::RowCache;
use compute::settings::{BackendChoice, FormFactorSettings, LampViews};
use compute::solver::{Gather, Solver, Update};
use scene::{Scene, Solution};

/// Kept form factors may take this much.
const MEMORY_BYTES: u64 = 4 << 30;

/// Relative residual to stop at.
const TOLERANCE: f64 = 1e-5;

/// A solved scene.
pub struct Solved {
    /// After iterations 1 and 2, and the last.
    pub states: Vec<Solution>,
    /// Figures for the table.
    pub summary: Summary,
}

/// What solving a scene took and how good it is.
pub struct Summary {
    pub patches: u32,
    pub surfaces: usize,
    pub hemicubes: u64,
    pub iterations: u64,
    pub residual: f64,
    pub closure: Option<Closure>,
    /// Dimensionless, see [`compute::report::Energy`].
    pub imbalance: Option<f64>,
    pub drawing_secs: f64,
    pub total_secs: f64,
}

/// Jacobi iterations until nothing changes.
pub fn solve(scene: &Scene, resolution: u32, backend: BackendChoice) -> anyhow::Result<Solved> {
    let start = Instant::now();
    let settings = FormFactorSettings::new(resolution);
    let hemicubes = Arc::new(Hemicubes::new(scene, settings));
    let backend = compute::backend::open(&hemicubes, backend)?;
    let source = with_lamps(&hemicubes, LampViews::Auto, backend.source);
    let mut rows = RowCache::new(&hemicubes, source, MEMORY_BYTES);
    let problem = Problem::new(scene);
    let mut solver = Gather::new(problem, Update::AfterIteration, Solution::dark(scene));
    let mut states = Vec::new();
    while solver
        .residual()
        .is_none_or(|residual| residual > TOLERANCE)
    {
        let step = solver.step(&mut rows)?;
        if step.ends_iteration && solver.iterations() <= 2 {
            states.push(solver.snapshot());
        }
    }
    let last = solver.snapshot();
    let (energy, closure, _) = report::measure(scene, &last, &rows);
    let statistics = rows.statistics();
    let summary = Summary {
        patches: scene.patch_count(),
        surfaces: scene.surfaces().len(),
        hemicubes: statistics.hemicubes,
        iterations: solver.iterations(),
        residual: solver.residual().unwrap_or(0.0),
        closure,
        imbalance: energy.imbalance,
        drawing_secs: statistics.duration.as_secs_f64(),
        total_secs: start.elapsed().as_secs_f64(),
    };
    states.push(last);
    Ok(Solved { states, summary })
}
