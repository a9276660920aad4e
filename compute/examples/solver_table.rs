//! How fast the solvers get where they go: residual and error by seconds, as a table.
//!
//! `cargo run --release -p compute --example solver_table [MODEL AREA_THRESHOLD]...` solves models 1, 2, 3 and cornell, or
//! those given (`solver_table 2 5 cornell 0.005`; `-` is the model's own threshold), at 128 pixels on the CPU.
//! All rows are drawn first, so the seconds are those of iterating. The error is the root mean square by
//! area, over all channels, of the difference to a converged solution, relative to that one's: of
//! Gauss-Seidel's for the gathering solvers, and of shooting's own, after the residual is 1e-7, for shooting,
//! whose equation has the reciprocal factors. A line tells when an error was first reached: after how many
//! iterations, at which residual, and after how many seconds.

use std::ffi::OsStr;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use compute::backend;
use compute::hemicubes::Hemicubes;
use compute::lamps::with_lamps;
use compute::problem::Problem;
use compute::row_cache::RowCache;
use compute::settings::{BackendChoice, FormFactorSettings, LampViews};
use compute::solver::{Gather, Shoot, Solver, Update};
use genx::{Model, Settings};
use scene::{Scene, Solution};

const RESOLUTION: u32 = 128;

/// Errors to tell of, dimensionless.
const ERRORS: [f64; 5] = [0.1, 1e-2, 1e-3, 1e-4, 1e-5];

/// Longer than this no solver is waited for.
const MOST_SECS: f64 = 30.0;

fn main() -> anyhow::Result<()> {
    let mut given: Vec<String> = std::env::args().skip(1).collect();
    if given.is_empty() {
        given = ["1", "-", "2", "-", "3", "-", "cornell", "-"]
            .map(String::from)
            .into();
    }
    println!(
        "| model | patches | drawing s | solver | error reached | iterations | residual | s |"
    );
    println!("|---|---|---|---|---|---|---|---|");
    for pair in given.chunks(2) {
        let [model, threshold] = pair else {
            anyhow::bail!("a model needs a threshold, or -");
        };
        let mut settings = Settings::new(Model::try_from(OsStr::new(model))?);
        if threshold != "-" {
            settings.max_area = Some(threshold.parse().context("a threshold is a number")?);
        }
        table(model, &genx::make(&settings)?.scene)?;
    }
    Ok(())
}

fn table(name: &str, scene: &Scene) -> anyhow::Result<()> {
    let settings = FormFactorSettings::new(RESOLUTION);
    let hemicubes = Arc::new(Hemicubes::new(scene, settings));
    let source = backend::open(&hemicubes, BackendChoice::Cpu)?.source;
    let source = with_lamps(&hemicubes, LampViews::Auto, source);
    let mut rows = RowCache::new(&hemicubes, source, u64::MAX);
    rows.draw_missing()?;
    let statistics = rows.statistics();
    let drawing = statistics.duration.as_secs_f64();
    eprintln!(
        "{name}: {} rows, {:.1} MB, {:.2} bytes an entry, drawn in {drawing:.1} s",
        statistics.kept_rows,
        1e-6 * statistics.kept_bytes as f64,
        statistics.bytes_per_entry().unwrap_or(0.0),
    );
    let gather = |update| {
        Box::new(Gather::new(
            Problem::new(scene),
            update,
            Solution::dark(scene),
        )) as Box<dyn Solver>
    };
    let shoot =
        || Box::new(Shoot::new(Problem::new(scene), Solution::dark(scene))) as Box<dyn Solver>;
    let gathered = converged(gather(Update::AtOnce), &mut rows, 1e-8)?;
    let shot = converged(shoot(), &mut rows, 1e-7)?;
    for (solver_name, mut solver, reference) in [
        ("jacobi", gather(Update::AfterIteration), &gathered),
        ("gauss-seidel", gather(Update::AtOnce), &gathered),
        ("shooting", shoot(), &shot),
    ] {
        let mut spent = Duration::ZERO;
        let mut errors = ERRORS.iter().peekable();
        // An error is looked at after an iteration, or after a hundredth more shots.
        let mut look_at = 1;
        while errors.peek().is_some() && spent.as_secs_f64() < MOST_SECS {
            let start = Instant::now();
            while solver.iterations() < look_at {
                solver.step(&mut rows)?;
            }
            spent += start.elapsed();
            look_at += 1 + if solver_name == "shooting" {
                look_at / 100
            } else {
                0
            };
            let error = error(scene, &solver.snapshot(), reference);
            while let Some(reached) = errors.next_if(|&&reached| error <= reached) {
                println!(
                    "| {name} | {} | {drawing:.1} | {solver_name} | {reached:.0e} | {} | {:.1e} | {:.3} |",
                    scene.patch_count(),
                    solver.iterations(),
                    solver.residual().unwrap_or(f64::NAN),
                    spent.as_secs_f64(),
                );
            }
        }
    }
    Ok(())
}

fn converged(
    mut solver: Box<dyn Solver>,
    rows: &mut RowCache,
    residual: f64,
) -> anyhow::Result<Solution> {
    let start = Instant::now();
    while solver.residual().is_none_or(|r| r > residual)
        && start.elapsed().as_secs_f64() < MOST_SECS
    {
        solver.step(rows)?;
    }
    Ok(solver.snapshot())
}

/// |B - B'| / |B'| with |X|^2 = sum_i A_i X_i^2.
fn error(scene: &Scene, found: &Solution, reference: &Solution) -> f64 {
    let (mut difference, mut norm) = (0.0, 0.0);
    let pairs = found
        .radiosity(scene)
        .into_iter()
        .zip(reference.radiosity(scene));
    for ((found, reference), area) in pairs.zip(scene.patch_areas()) {
        difference += area * (found.as_dvec3() - reference.as_dvec3()).length_squared();
        norm += area * reference.as_dvec3().length_squared();
    }
    (difference / norm).sqrt()
}
