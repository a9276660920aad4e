//! Solving one scene with the library, as `compute` does by default: to a stated error.

use std::time::Instant;

use anyhow::Context;
use compute::function::Errors;
use compute::settings::{BackendChoice, Quality, SolveSettings};
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
    pub sources: u32,
    pub vertices: u32,
    /// Estimated, relative.
    pub error: Errors,
    pub iterations: u64,
    pub drawing_secs: f64,
    pub total_secs: f64,
}

/// The light after one bounce, two, and all.
///
/// # Errors
/// A back end that cannot draw, and a scene without light.
pub fn solve(
    scene: &Scene,
    resolution: Option<u32>,
    backend: BackendChoice,
) -> anyhow::Result<Steps> {
    let solve = |iterations: Option<u64>| -> anyhow::Result<Solved> {
        let mut settings = SolveSettings {
            max_iterations: iterations,
            ..Quality::Standard.settings()
        };
        settings.drawing.backend = backend;
        if let Some(resolution) = resolution {
            settings.solution.form_factors.resolution = resolution;
        }
        Ok(Solve::new(scene).settings(settings).run()?)
    };
    let mut states = Vec::new();
    for iterations in [1, 2] {
        states.push(solve(Some(iterations))?.into_solution());
    }
    let start = Instant::now();
    let solved = solve(None)?;
    let function = solved
        .function
        .context("nothing was gathered between patches")?;
    let summary = Summary {
        patches: scene.patch_count(),
        surfaces: scene.surfaces().len(),
        hemicubes: solved.rows.hemicubes,
        sources: solved
            .sources
            .map_or(scene.patch_count(), |sources| sources.count),
        vertices: function.vertices,
        error: function.error.context("light reaches nothing")?.total,
        iterations: solved.solution().provenance.iterations,
        drawing_secs: solved.seconds.draw,
        total_secs: start.elapsed().as_secs_f64(),
    };
    states.push(solved.into_solution());
    Ok(Steps { states, summary })
}
