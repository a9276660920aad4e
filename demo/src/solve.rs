//! Solving one scene with the library, keeping what the pictures show.

use std::time::Instant;

use compute::energy::Closure;
use compute::settings::{BackendChoice, Drawing, SolveSettings};
use compute::solve::Observer;
use compute::{Solve, Solved};
use scene::{Scene, Solution};

/// A solved scene.
pub struct Steps {
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
    /// Dimensionless, see [`compute::energy::Energy`].
    pub imbalance: Option<f64>,
    pub drawing_secs: f64,
    pub total_secs: f64,
}

/// Keeps the solutions after iterations 1 and 2.
#[derive(Default)]
struct FirstTwo(Vec<Solution>);

impl Observer for FirstTwo {
    fn iteration(&mut self, iterations: u64, solution: &dyn Fn() -> Solution) {
        if iterations <= 2 {
            self.0.push(solution());
        }
    }
}

/// Jacobi iterations until nothing changes.
pub fn solve(scene: &Scene, resolution: u32, backend: BackendChoice) -> anyhow::Result<Steps> {
    let start = Instant::now();
    let settings = SolveSettings {
        drawing: Drawing {
            backend,
            ..Drawing::default()
        },
        ..SolveSettings::default()
    };
    let mut first = FirstTwo::default();
    let solved: Solved = Solve::new(scene)
        .settings(settings)
        .resolution(resolution)
        .observer(&mut first)
        .run()?;
    let provenance = &solved.solution().provenance;
    let summary = Summary {
        patches: scene.patch_count(),
        surfaces: scene.surfaces().len(),
        hemicubes: solved.rows.hemicubes,
        iterations: provenance.iterations,
        residual: provenance.residuals.last().copied().unwrap_or(0.0),
        closure: solved.closure,
        imbalance: solved.energy.imbalance,
        drawing_secs: solved.seconds.draw,
        total_secs: start.elapsed().as_secs_f64(),
    };
    let mut states = first.0;
    states.push(solved.into_solution());
    Ok(Steps { states, summary })
}
