//! Iterations over kept rows, and whole solves, on all cores. `cargo bench -p compute --bench solves`.

use std::hint::black_box;

use compute::FormFactors;
use compute::form_factors::Needed;
use compute::problem::Problem;
use compute::row_cache::RowCache;
use compute::settings::{BackendChoice, Drawing, FormFactorSettings};
use compute::solver::{Gather, Shoot, Solver, Update};
use criterion::{Criterion, SamplingMode, criterion_group, criterion_main};
use genx::{Model, Settings};
use scene::{Scene, Solution};

/// Pixels, the program's default.
const RESOLUTION: u32 = 128;

/// Residual at which a solve ends.
const RESIDUAL: f64 = 1e-4;

const MODELS: [(&str, Model); 2] = [("cornell", Model::Cornell), ("cube", Model::Cube)];

/// A solver's name and what makes it.
type Choice = (&'static str, fn(&Scene) -> Box<dyn Solver>);

const SOLVERS: [Choice; 3] = [
    ("jacobi", |scene| gather(scene, Update::AfterIteration)),
    ("gauss-seidel", |scene| gather(scene, Update::AtOnce)),
    ("shooting", |scene| {
        Box::new(Shoot::new(Problem::new(scene), Solution::dark(scene)))
    }),
];

fn gather(scene: &Scene, update: Update) -> Box<dyn Solver> {
    let start = Solution::dark(scene);
    Box::new(Gather::new(Problem::new(scene), update, start))
}

fn scene(model: &Model) -> Scene {
    genx::make(&Settings::new(model.clone()))
        .expect("the built-in models are valid")
        .scene
}

/// Rows of which none is drawn yet.
fn rows(scene: &Scene) -> RowCache<'_> {
    let drawing = Drawing {
        backend: BackendChoice::Cpu,
        memory_bytes: u64::MAX,
        ..Drawing::default()
    };
    let form_factors = FormFactors::new(scene, FormFactorSettings::new(RESOLUTION), drawing);
    let rows = form_factors.rows(Needed::All);
    rows.expect("the cpu is always there")
}

/// Of Jacobi and of Gauss-Seidel; shooting has none.
fn iterations(c: &mut Criterion) {
    for (model_name, model) in &MODELS {
        let scene = scene(model);
        let mut rows = rows(&scene);
        rows.draw_missing().expect("nobody interrupts it");
        let mut group = c.benchmark_group(format!("iteration/{model_name}"));
        for (name, make) in &SOLVERS[..2] {
            let mut solver = make(&scene);
            group.bench_function(*name, |b| {
                b.iter(|| {
                    while !solver
                        .step(&mut rows)
                        .expect("rows are kept")
                        .ends_iteration
                    {}
                });
            });
        }
    }
}

/// From a scene to its solution: what `compute` does between reading and writing.
fn solves(c: &mut Criterion) {
    for (model_name, model) in &MODELS {
        let scene = scene(model);
        let mut group = c.benchmark_group(format!("solve/{model_name}"));
        group.sample_size(10).sampling_mode(SamplingMode::Flat);
        for (name, make) in &SOLVERS {
            group.bench_function(*name, |b| {
                b.iter(|| {
                    let mut rows = rows(&scene);
                    let mut solver = make(&scene);
                    while solver.residual().is_none_or(|residual| residual > RESIDUAL) {
                        solver.step(&mut rows).expect("nobody interrupts it");
                    }
                    black_box(solver.snapshot())
                });
            });
        }
    }
}

criterion_group!(benches, iterations, solves);
criterion_main!(benches);
