//! How fast the solvers get where they go.

use std::time::Instant;

use compute::FormFactors;
use compute::form_factors::Needed;
use compute::problem::Problem;
use compute::row_cache::RowCache;
use compute::settings::{BackendChoice, Drawing, FormFactorSettings};
use compute::solver::{Gather, Shoot, Solver, Update};
use genx::{Model, Settings};
use scene::{Scene, Solution};

use crate::arguments::{Plan, Section, command_of};
use crate::text::{count, figures, heading, table};

/// Pixels, the program's default.
const PIXELS: u32 = 128;

/// Errors to tell of, dimensionless.
const ERRORS: [f64; 5] = [0.1, 1e-2, 1e-3, 1e-4, 1e-5];

/// Residuals after which gathering and shooting are taken to have converged.
const CONVERGED: f64 = 1e-8;
const CONVERGED_SHOTS: f64 = 1e-7;

/// Longer than this no solver is waited for.
const MOST_SECONDS: f64 = 30.0;

/// A solver's name, whether its iterations are shots, and what makes it.
type Choice = (&'static str, bool, fn(&Scene) -> Box<dyn Solver>);

const SOLVERS: [Choice; 3] = [
    ("jacobi", false, |scene| {
        gather(scene, Update::AfterIteration)
    }),
    ("gauss-seidel", false, |scene| gather(scene, Update::AtOnce)),
    ("shooting", true, shoot),
];

/// The section.
pub fn section(plan: &Plan) -> anyhow::Result<String> {
    let models = [
        ("Cornell box", Model::Cornell),
        ("model 1", Model::Cube),
        ("model 2, the hall", Model::Hall),
        ("model 3", Model::Bend),
    ];
    let mut rows = Vec::new();
    for (name, model) in &models[..plan.choose(1, models.len())] {
        eprintln!("performance: solvers, {name}");
        let scene = genx::make(&Settings::new(model.clone()))?.scene;
        rows.extend(rows_of(name, &scene)?);
    }
    let errors = ERRORS.map(|error| format!("{error:.0e}"));
    let mut header = vec!["scene", "patches", "drawing, s", "solver"];
    header.extend(errors.iter().map(String::as_str));
    Ok(format!(
        "{}Iterations, or shots, and seconds of iterating until the radiosities' error was below what the column says \
         ({}): the root mean square by area, over all channels, of the difference to a converged solution, relative to \
         that one's; for shooting its own, whose equation has the reciprocal form factors. All rows were drawn first, \
         at {PIXELS} pixels. The built-in models are as `genx` makes them.\n\n{}\n\
         Gauss-Seidel needs half to two thirds of Jacobi's iterations; in the smallest scenes each of them takes \
         longer. Both are a small part of drawing the rows, so the default is Jacobi's, of which each iteration is a \
         bounce of light, as in the thesis. Where rows do not fit the memory, and are drawn again in each iteration, \
         Gauss-Seidel saves a third to a half of that. Shooting is first where a first impression is wanted, and last \
         where an answer is.\n",
        heading("Solvers"),
        command_of(Section::Solvers),
        table(&header, 1, &rows)
    ))
}

fn gather(scene: &Scene, update: Update) -> Box<dyn Solver> {
    let start = Solution::dark(scene);
    Box::new(Gather::new(Problem::new(scene), update, start))
}

fn shoot(scene: &Scene) -> Box<dyn Solver> {
    Box::new(Shoot::new(Problem::new(scene), Solution::dark(scene)))
}

/// A line for each solver.
fn rows_of(name: &str, scene: &Scene) -> anyhow::Result<Vec<Vec<String>>> {
    let drawing = Drawing {
        backend: BackendChoice::Cpu,
        memory_bytes: u64::MAX,
        ..Drawing::default()
    };
    let form_factors = FormFactors::new(scene, FormFactorSettings::new(PIXELS), drawing);
    let mut rows = form_factors.rows(Needed::All)?;
    rows.draw_missing()?;
    let drawing = rows.statistics().duration.as_secs_f64();
    let gathered = converged(gather(scene, Update::AtOnce), &mut rows, CONVERGED)?;
    let shot = converged(shoot(scene), &mut rows, CONVERGED_SHOTS)?;
    let mut lines = Vec::new();
    for (solver_name, is_shooting, make) in SOLVERS {
        let reference = if is_shooting { &shot } else { &gathered };
        let mut line = vec![
            name.to_owned(),
            count(scene.patch_count().into()),
            figures(drawing),
            solver_name.to_owned(),
        ];
        line.extend(progress(
            scene,
            make(scene),
            reference,
            &mut rows,
            is_shooting,
        )?);
        lines.push(line);
    }
    Ok(lines)
}

/// A cell for each error.
fn progress(
    scene: &Scene,
    mut solver: Box<dyn Solver>,
    reference: &Solution,
    rows: &mut RowCache,
    is_shooting: bool,
) -> anyhow::Result<Vec<String>> {
    let mut cells = Vec::new();
    let mut seconds = 0.0;
    // An error is looked at after an iteration, or after a hundredth more shots.
    let mut look_at = 1;
    while cells.len() < ERRORS.len() && seconds < MOST_SECONDS {
        let start = Instant::now();
        while solver.iterations() < look_at {
            solver.step(rows)?;
        }
        seconds += start.elapsed().as_secs_f64();
        look_at += 1 + if is_shooting { look_at / 100 } else { 0 };
        let error = error(scene, &solver.snapshot(), reference);
        while cells.len() < ERRORS.len() && error <= ERRORS[cells.len()] {
            let iterations = count(solver.iterations());
            cells.push(format!("{iterations} in {} s", figures(seconds)));
        }
    }
    cells.resize(ERRORS.len(), "not reached".to_owned());
    Ok(cells)
}

fn converged(
    mut solver: Box<dyn Solver>,
    rows: &mut RowCache,
    residual: f64,
) -> anyhow::Result<Solution> {
    while solver.residual().is_none_or(|r| r > residual) {
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
