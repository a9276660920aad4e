//! Laws of the solvers, on scenes small enough to be solved in other ways.

mod common;

use compute::cpu::CpuRows;
use compute::problem::Problem;
use compute::row_cache::RowCache;
use compute::settings::{FormFactorSettings, Maps, Points};
use compute::solver::{Gather, Shoot, Solver, Update};
use glam::DVec3;
use scene::{Rgb, Scene, Solution};

/// Half a unit in the last place of an f32, relative: what storing a value may round away.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Every patch's radiosity is stored as B = E + rho H: H, the product and the sum are rounded.
const ROUNDINGS_PER_RADIOSITY: f64 = 3.0;

const SETTINGS: FormFactorSettings = FormFactorSettings {
    resolution: 32,
    maps: Maps::Exact,
    points: Points::CENTROID,
};

#[derive(Clone, Copy, Debug, PartialEq)]
enum Method {
    Jacobi,
    GaussSeidel,
    Shooting,
}

const METHODS: [Method; 3] = [Method::Jacobi, Method::GaussSeidel, Method::Shooting];

fn solver(method: Method, scene: &Scene, start: Solution) -> Box<dyn Solver> {
    let problem = Problem::new(scene);
    match method {
        Method::Jacobi => Box::new(Gather::new(problem, Update::AfterIteration, start)),
        Method::GaussSeidel => Box::new(Gather::new(problem, Update::AtOnce, start)),
        Method::Shooting => Box::new(Shoot::new(problem, start)),
    }
}

fn rows(scene: &Scene, budget_bytes: u64) -> RowCache<'_> {
    let source = Box::new(CpuRows::new(scene, SETTINGS));
    RowCache::new(scene, source, SETTINGS, budget_bytes)
}

/// Goes on until `iterations` more are done; steps that end none are free.
fn iterate(solver: &mut dyn Solver, rows: &mut RowCache, iterations: u64) {
    let end = solver.iterations() + iterations;
    while solver.iterations() < end {
        solver.step(rows).unwrap();
    }
}

/// Goes on until the residual is at most `residual`, and gives the iterations back.
fn converge(solver: &mut dyn Solver, rows: &mut RowCache, residual: f64) -> u64 {
    let before = solver.iterations();
    loop {
        iterate(solver, rows, 1);
        if solver.residual().unwrap() <= residual {
            return solver.iterations() - before;
        }
        assert!(solver.iterations() < 100_000, "{:?}", solver.residual());
    }
}

/// From the dark to this residual.
fn solved(method: Method, scene: &Scene, residual: f64) -> Solution {
    let mut rows = rows(scene, u64::MAX);
    let mut solver = solver(method, scene, Solution::dark(scene));
    converge(solver.as_mut(), &mut rows, residual);
    solver.snapshot()
}

/// F_ij as a matrix, row by row.
fn form_factors(scene: &Scene) -> Vec<Vec<f64>> {
    let mut rows = rows(scene, u64::MAX);
    let count = scene.patch_count() as usize;
    let units_per_one = f64::from(rows.units_per_one());
    (0..count)
        .map(|i| {
            let batch = rows.batch_with(i as u32).unwrap();
            let mut row = vec![0.0; count];
            for entry in batch.row(i - batch.patches().start as usize) {
                row[entry.patch as usize] = f64::from(entry.units) / units_per_one;
            }
            row
        })
        .collect()
}

/// The factors by which shooting distributes: G_ji = F_ij A_i / A_j, which is F_ji but for the
/// error of the hemicubes' reciprocity.
fn shooting_factors(scene: &Scene) -> Vec<Vec<f64>> {
    let form_factors = form_factors(scene);
    let areas = scene.patch_areas();
    (0..areas.len())
        .map(|j| {
            (0..areas.len())
                .map(|i| form_factors[i][j] * areas[i] / areas[j])
                .collect()
        })
        .collect()
}

fn factors(method: Method, scene: &Scene) -> Vec<Vec<f64>> {
    if method == Method::Shooting {
        shooting_factors(scene)
    } else {
        form_factors(scene)
    }
}

fn largest_row_sum(matrix: &[Vec<f64>]) -> f64 {
    matrix
        .iter()
        .map(|row| row.iter().sum())
        .fold(0.0, f64::max)
}

/// B of B_i = E_i + rho_i sum_j F_ij B_j by Gaussian elimination with pivoting, one channel at a
/// time.
fn dense_solution(scene: &Scene, factors: &[Vec<f64>]) -> Vec<DVec3> {
    let count = scene.patch_count() as usize;
    let (reflectance, emission) = (scene.patch_reflectances(), scene.patch_emissions());
    let mut radiosity = vec![DVec3::ZERO; count];
    for channel in 0..3 {
        let mut system: Vec<Vec<f64>> = (0..count)
            .map(|i| {
                let rho = f64::from(reflectance[i][channel]);
                let mut row: Vec<f64> = factors[i].iter().map(|f| -rho * f).collect();
                row[i] += 1.0;
                row.push(f64::from(emission[i][channel]));
                row
            })
            .collect();
        for column in 0..count {
            let pivot = (column..count)
                .max_by(|&a, &b| system[a][column].abs().total_cmp(&system[b][column].abs()))
                .unwrap();
            system.swap(column, pivot);
            let (above, below) = system.split_at_mut(column + 1);
            let pivot = &above[column];
            for row in below {
                let factor = row[column] / pivot[column];
                for (value, &p) in row[column..].iter_mut().zip(&pivot[column..]) {
                    *value -= factor * p;
                }
            }
        }
        for i in (0..count).rev() {
            let known: f64 = (i + 1..count)
                .map(|j| system[i][j] * radiosity[j][channel])
                .sum();
            radiosity[i][channel] = (system[i][count] - known) / system[i][i];
        }
    }
    radiosity
}

/// The norm in which an iteration of the method shrinks what is wrong.
///
/// Gathering multiplies by rho F, whose rows sum to at most rho: the largest value of any patch and
/// channel, W/m^2. Shooting multiplies by rho_j F_ij A_i / A_j: all that leaves i sums to at most rho, so
/// the power, W. (The reciprocal factors' own row sums are another matter: a small patch in a corner
/// receives half too much or too little.)
fn norm(method: Method, scene: &Scene, values: impl Iterator<Item = DVec3>) -> f64 {
    if method == Method::Shooting {
        let powers = values
            .zip(scene.patch_areas())
            .map(|(v, area)| area * v.abs().element_sum());
        powers.sum()
    } else {
        values.fold(0.0, |most, v| f64::max(most, v.abs().max_element()))
    }
}

/// How far a is from b, as a share of b.
fn relative_difference(method: Method, scene: &Scene, a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    norm(method, scene, a.iter().zip(b).map(|(a, b)| *a - *b))
        / norm(method, scene, b.iter().copied())
}

fn radiosity(scene: &Scene, solution: &Solution) -> Vec<DVec3> {
    let radiosity = solution.radiosity(scene);
    radiosity.into_iter().map(Rgb::as_dvec3).collect()
}

fn largest_reflectance(scene: &Scene) -> f64 {
    let reflectances = scene.patch_reflectances();
    let most = reflectances.iter().map(|r| r.max_element());
    f64::from(most.fold(0.0, f32::max))
}

/// How far a solution of a closed room may be from its equation's exact one, relative, in the method's
/// [`norm`].
///
/// With q the largest reflectance, an error of e left in the equation is one of at most e / (1 - q) in
/// the solution. Left over are, for gathering, q times the last change; for shooting, q times what is
/// unshot. Gathering rounds each radiosity anew in each iteration; shooting adds up what it rounds, a
/// shot changing a patch once.
fn error_bound(scene: &Scene, method: Method, solver: &mut dyn Solver, rows: &mut RowCache) -> f64 {
    let before = solver.snapshot();
    let size = norm(method, scene, radiosity(scene, &before).into_iter());
    let q = largest_reflectance(scene);
    let (left, roundings) = if method == Method::Shooting {
        let unshot = before.unshot.unwrap().into_iter().map(Rgb::as_dvec3);
        let shots = solver.iterations() as f64;
        (
            norm(method, scene, unshot) / size,
            ROUNDINGS_PER_RADIOSITY * shots,
        )
    } else {
        iterate(solver, rows, 1);
        let after = radiosity(scene, &solver.snapshot());
        let before = radiosity(scene, &before);
        let change = relative_difference(method, scene, &before, &after);
        (change, ROUNDINGS_PER_RADIOSITY)
    };
    (q * left + roundings * ROUNDING) / (1.0 - q)
}

/// The furnace: E and rho alike everywhere, so B = E / (1 - rho), whatever the mesh. Rows sum to
/// exactly 1, so this holds of every patch for gathering, and of the power for shooting, up to
/// [`error_bound`].
#[test]
fn furnace_radiosity_is_emission_over_one_minus_reflectance() {
    const EMISSION: f32 = 3.0;
    for method in METHODS {
        for reflectance in [0.0, 0.1, 0.5, 0.8, 0.95] {
            let scene = common::furnace(reflectance, EMISSION, 0.1);
            let mut rows = rows(&scene, u64::MAX);
            let mut solver = solver(method, &scene, Solution::dark(&scene));
            converge(solver.as_mut(), &mut rows, 1e-6);
            let exact = f64::from(EMISSION) / (1.0 - f64::from(reflectance));
            let bound = error_bound(&scene, method, solver.as_mut(), &mut rows);
            let found = radiosity(&scene, &solver.snapshot());
            let error = if method == Method::Shooting {
                let power = norm(method, &scene, found.iter().copied());
                (power / (3.0 * scene.area() * exact) - 1.0).abs()
            } else {
                let expected = vec![DVec3::splat(exact); found.len()];
                relative_difference(method, &scene, &found, &expected)
            };
            println!("{method:?} {reflectance}: error {error:.1e}, bound {bound:.1e}");
            assert!(
                error <= bound,
                "{method:?} {reflectance}: {error:e} > {bound:e}"
            );
            assert!(
                bound < 0.01,
                "{method:?} {reflectance}: {bound:e} shows nothing"
            );
        }
    }
}

/// In a furnace Jacobi's k-th radiosity is the sum of the first k + 1 reflections, and its residual
/// follows; so the residual alone tells the error, |B - B*| / B* = r rho / (1 - rho) B / B*.
#[test]
fn jacobi_residual_tells_the_error_in_a_furnace() {
    for reflectance in [0.1_f32, 0.5, 0.8, 0.95] {
        let scene = common::furnace(reflectance, 1.0, 0.1);
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(Method::Jacobi, &scene, Solution::dark(&scene));
        let rho = f64::from(reflectance);
        for iteration in 1..=20 {
            iterate(solver.as_mut(), &mut rows, 1);
            let partial = (1.0 - rho.powi(iteration + 1)) / (1.0 - rho);
            let residual = rho.powi(iteration) / partial;
            // Both radiosities in the difference have been rounded in every iteration.
            let rounding = 2.0 * ROUNDINGS_PER_RADIOSITY * ROUNDING / (1.0 - rho);
            let found = solver.residual().unwrap();
            assert!(
                (found - residual).abs() <= rounding,
                "{reflectance}: {found} {residual}"
            );
            let error = 1.0 - radiosity(&scene, &solver.snapshot())[0].x * (1.0 - rho);
            let bound = found * rho / (1.0 - rho) + rounding;
            assert!(
                error <= bound,
                "{reflectance}, {iteration}: {error:e} > {bound:e}"
            );
        }
    }
}

/// What the bounds of the agreement with Gaussian elimination must be better than to show anything.
const AGREEMENT: f64 = 1e-3;

#[test]
fn solvers_agree_with_gaussian_elimination() {
    let scene = common::colourful_room(0.6);
    assert!(
        (100..400).contains(&scene.patch_count()),
        "{}",
        scene.patch_count()
    );
    for method in METHODS {
        let expected = dense_solution(&scene, &factors(method, &scene));
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(method, &scene, Solution::dark(&scene));
        let residual = if method == Method::Shooting {
            1e-6
        } else {
            1e-8
        };
        let iterations = converge(solver.as_mut(), &mut rows, residual);
        let bound = error_bound(&scene, method, solver.as_mut(), &mut rows);
        let found = radiosity(&scene, &solver.snapshot());
        let error = relative_difference(method, &scene, &found, &expected);
        println!("{method:?}: {iterations} iterations, error {error:.1e}, bound {bound:.1e}");
        assert!(error <= bound, "{method:?}: {error:e} > {bound:e}");
        assert!(bound < AGREEMENT, "{method:?}: {bound:e} shows nothing");
    }
}

/// What the agreement above rests on: it fails for a factor that is off by a hundredth.
#[test]
fn gaussian_elimination_tells_a_wrong_form_factor() {
    let scene = common::colourful_room(0.6);
    let mut factors = form_factors(&scene);
    let exact = dense_solution(&scene, &factors);
    // From the floor to the lamp.
    let lamp = scene
        .patch_emissions()
        .iter()
        .position(|e| e.x > 1.0)
        .unwrap();
    factors[0][lamp] += 0.01;
    let wrong = dense_solution(&scene, &factors);
    for method in METHODS {
        // Ten times what any of the solvers may differ by there.
        let error = relative_difference(method, &scene, &wrong, &exact);
        assert!(error > 10.0 * AGREEMENT, "{method:?}: {error:e}");
    }
}

/// A change x becomes rho F x, and rows sum to 1: the largest change falls by the largest reflectance.
#[test]
fn jacobi_largest_change_falls_by_the_reflectance_in_a_closed_room() {
    for reflectance in [0.3, 0.7, 0.95] {
        let materials = vec![
            common::material(reflectance, 0.0),
            common::material(0.5 * reflectance, 2.0),
        ];
        let scene = common::scene(materials, common::furnished_room_surfaces(), 0.3);
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(Method::Jacobi, &scene, Solution::dark(&scene));
        let mut last = radiosity(&scene, &solver.snapshot());
        let mut before = f64::INFINITY;
        for iteration in 1..30 {
            iterate(solver.as_mut(), &mut rows, 1);
            let now = radiosity(&scene, &solver.snapshot());
            let change = relative_difference(Method::Jacobi, &scene, &last, &now);
            // Two rounded radiosities are subtracted, now and before.
            let bound = f64::from(reflectance) * before + 4.0 * ROUNDINGS_PER_RADIOSITY * ROUNDING;
            assert!(
                change <= bound,
                "{reflectance}, {iteration}: {change:e} > {bound:e}"
            );
            (last, before) = (now, change);
        }
    }
}

/// In the residual's norm, |x|^2 = sum A_i x_i^2, F is at most the root of its largest row sum, 1, times
/// the largest of the reciprocal factors (Schur's test). Radiosities grow from the dark on, so the
/// residual's denominator does too.
#[test]
fn jacobi_residual_never_grows_in_a_closed_room_of_one_reflectance() {
    for reflectance in [0.3, 0.6, 0.8] {
        let materials = vec![
            common::material(reflectance, 0.0),
            common::material(reflectance, 2.0),
        ];
        let scene = common::scene(materials, common::furnished_room_surfaces(), 0.3);
        let factor = f64::from(reflectance) * largest_row_sum(&shooting_factors(&scene)).sqrt();
        assert!(factor < 1.0, "{factor}");
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(Method::Jacobi, &scene, Solution::dark(&scene));
        let mut before = f64::INFINITY;
        for iteration in 1..30 {
            iterate(solver.as_mut(), &mut rows, 1);
            let residual = solver.residual().unwrap();
            // Two rounded radiosities are subtracted, now and before.
            let bound = factor * before + 4.0 * ROUNDINGS_PER_RADIOSITY * ROUNDING;
            assert!(
                residual <= bound,
                "{reflectance}, {iteration}: {residual:e} > {bound:e}"
            );
            before = residual;
        }
    }
}

/// A shot takes its power from the unshot, and gives back rho times that at most. The shooter has
/// the most, at least the mean.
#[test]
fn unshot_power_never_increases() {
    let scene = common::colourful_room(0.3);
    let patches = f64::from(scene.patch_count());
    let reflectances = scene.patch_reflectances();
    let rho = reflectances
        .iter()
        .fold(0.0, |most, r| f32::max(most, r.max_element()));
    let mut rows = rows(&scene, u64::MAX);
    let mut solver = solver(Method::Shooting, &scene, Solution::dark(&scene));
    // Before the first shot all that is emitted is unshot.
    let mut before = 1.0;
    for shot in 1..2000 {
        iterate(solver.as_mut(), &mut rows, 1);
        let residual = solver.residual().unwrap();
        let most = before * (1.0 - (1.0 - rho) / patches);
        // Each patch that receives rounds what it received, its product, and its sum.
        let rounding = 1.0 + ROUNDINGS_PER_RADIOSITY * ROUNDING;
        assert!(
            residual <= most * rounding,
            "shot {shot}: {residual:e} > {most:e}"
        );
        before = residual;
    }
    assert!(before < 0.1, "{before}");
}

#[test]
fn without_emission_all_stays_dark_and_solvers_stop() {
    let scene = common::furnace(0.9, 0.0, 0.1);
    for method in METHODS {
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(method, &scene, Solution::dark(&scene));
        assert_eq!(solver.residual(), None);
        assert_eq!(converge(solver.as_mut(), &mut rows, 0.0), 1, "{method:?}");
        assert_eq!(
            solver.snapshot().irradiance,
            Solution::dark(&scene).irradiance
        );
    }
}

/// Black walls reflect nothing: the irradiance is the sum of the lamps' emissions by their form
/// factors, rounded once, and a second iteration changes no bit of it.
#[test]
fn black_walls_are_lit_by_one_gather() {
    let materials = vec![common::material(0.0, 0.25), common::material(0.0, 2.0)];
    let scene = common::scene(materials, common::furnished_room_surfaces(), 0.2);
    let emission = scene.patch_emissions();
    let expected: Vec<Rgb> = form_factors(&scene)
        .iter()
        .map(|row| {
            let terms = row.iter().zip(&emission).map(|(f, e)| *f * e.as_dvec3());
            terms.sum::<DVec3>().as_vec3()
        })
        .collect();
    for method in [Method::Jacobi, Method::GaussSeidel] {
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(method, &scene, Solution::dark(&scene));
        iterate(solver.as_mut(), &mut rows, 1);
        let first = solver.snapshot().irradiance;
        for (found, expected) in first.iter().zip(&expected) {
            // The solver's f64 sums are of integers, these of quotients: they may round to
            // neighbouring f32s.
            let error = ((*found - *expected) / *expected).abs().max_element();
            assert!(
                f64::from(error) <= 2.0 * ROUNDING,
                "{method:?}: {found} {expected}"
            );
        }
        iterate(solver.as_mut(), &mut rows, 1);
        assert_eq!(
            common::bits(&solver.snapshot().irradiance),
            common::bits(&first)
        );
        assert_eq!(solver.residual(), Some(0.0));
    }
}

#[test]
fn rows_kept_partly_kept_and_redrawn_give_the_same_bits() {
    // All patches of the furnace have the same to shoot, and do so in turn.
    let (room, furnace) = (common::colourful_room(0.1), common::furnace(0.8, 1.0, 0.01));
    for (method, scene, iterations) in [
        (Method::Jacobi, &room, 4),
        (Method::GaussSeidel, &room, 4),
        (Method::Shooting, &furnace, 400),
    ] {
        let run = |budget| {
            let mut rows = rows(scene, budget);
            let mut solver = solver(method, scene, Solution::dark(scene));
            iterate(solver.as_mut(), &mut rows, iterations);
            (
                common::bits(&solver.snapshot().irradiance),
                rows.statistics(),
            )
        };
        let (all, statistics) = run(u64::MAX);
        let patches = u64::from(scene.patch_count());
        assert!(
            statistics.hemicubes <= patches,
            "{method:?}: {statistics:?}"
        );
        let half = statistics.kept_bytes / 2;
        let kept = statistics.kept_rows;
        let (some, statistics) = run(half);
        assert!(
            (1..kept).contains(&statistics.kept_rows),
            "{method:?}: {statistics:?}"
        );
        assert!(statistics.kept_bytes <= half);
        assert!(some == all, "{method:?}, partly kept");
        let (none, statistics) = run(0);
        assert_eq!((statistics.kept_rows, statistics.kept_bytes), (0, 0));
        assert!(none == all, "{method:?}, redrawn");
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = common::colourful_room(0.1);
    for method in METHODS {
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| {
                let mut rows = rows(&scene, u64::MAX);
                let mut solver = solver(method, &scene, Solution::dark(&scene));
                iterate(solver.as_mut(), &mut rows, 5);
                common::bits(&solver.snapshot().irradiance)
            })
        };
        let one = run(1);
        for threads in [2, 5, 16] {
            assert!(run(threads) == one, "{method:?} on {threads} threads");
        }
    }
}

/// Ten iterations with one solver, the rest with another: the same radiosities as the equation of
/// the second has, which is the dense one.
#[test]
fn a_solution_continued_with_another_solver_converges_to_the_same() {
    let scene = common::colourful_room(0.6);
    for first in METHODS {
        for second in METHODS {
            if first == second {
                continue;
            }
            let mut rows = rows(&scene, u64::MAX);
            let mut before = solver(first, &scene, Solution::dark(&scene));
            iterate(before.as_mut(), &mut rows, 10);
            // As the program does where settings differ.
            let mut start = before.snapshot();
            start.unfinished = None;
            start.unshot = None;
            start.provenance.residuals.clear();
            let mut after = solver(second, &scene, start);
            assert_eq!(after.iterations(), 10);
            let residual = if second == Method::Shooting {
                1e-6
            } else {
                1e-8
            };
            converge(after.as_mut(), &mut rows, residual);
            let bound = error_bound(&scene, second, after.as_mut(), &mut rows);
            let expected = dense_solution(&scene, &factors(second, &scene));
            let found = radiosity(&scene, &after.snapshot());
            let error = relative_difference(second, &scene, &found, &expected);
            assert!(
                error <= bound,
                "{first:?}, {second:?}: {error:e} > {bound:e}"
            );
        }
    }
}

/// A solution of Jacobi's has nothing left to shoot but what the two equations differ by.
#[test]
fn shooting_takes_over_what_another_solver_has_done() {
    const RESIDUAL: f64 = 1e-3;
    let scene = common::colourful_room(0.3);
    let start = solved(Method::Jacobi, &scene, 1e-6);
    let mut rows = rows(&scene, u64::MAX);
    let mut fresh = solver(Method::Shooting, &scene, Solution::dark(&scene));
    let from_dark = converge(fresh.as_mut(), &mut rows, RESIDUAL);
    let mut taken_over = solver(
        Method::Shooting,
        &scene,
        Solution {
            provenance: scene::Provenance::default(),
            ..start.clone()
        },
    );
    // Under way a file would get the start itself, so that no half-told state is ever kept.
    let step = taken_over.step(&mut rows).unwrap();
    assert!(!step.ends_iteration && step.share_done < 1.0, "{step:?}");
    assert_eq!(taken_over.snapshot().irradiance, start.irradiance);
    let from_start = converge(taken_over.as_mut(), &mut rows, RESIDUAL);
    assert!(
        2 * from_start < from_dark,
        "{from_start} shots, {from_dark} from the dark"
    );
    let a = radiosity(&scene, &taken_over.snapshot());
    let b = radiosity(&scene, &fresh.snapshot());
    let difference = relative_difference(Method::Shooting, &scene, &a, &b);
    // Of either, at most so much of the emitted power is unshot, and the whole power is more.
    let rho = largest_reflectance(&scene);
    assert!(
        difference <= 2.0 * rho / (1.0 - rho) * RESIDUAL,
        "{difference:e}"
    );
}

/// Half an iteration, a file, the other half, in other batches: as if never stopped.
#[test]
fn an_iteration_goes_on_in_other_batches_with_the_same_bits() {
    let scene = common::colourful_room(0.1);
    let advance = |method, threads, start: Solution, done: &(dyn Fn(&Solution) -> bool + Sync)| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            // The number of threads decides how many rows a batch has.
            let mut rows = rows(&scene, 0);
            let mut solver = solver(method, &scene, start);
            while !done(&solver.snapshot()) {
                solver.step(&mut rows).unwrap();
            }
            let file = scene::file::to_bytes(&scene, Some(&solver.snapshot()));
            scene::file::from_bytes(&file).unwrap().1.unwrap()
        })
    };
    let two_iterations = |s: &Solution| s.provenance.iterations == 2;
    for method in [Method::Jacobi, Method::GaussSeidel] {
        let whole = advance(method, 2, Solution::dark(&scene), &two_iterations);
        let mut solution = Solution::dark(&scene);
        for (threads, rows_more) in [(1, 1), (5, 64), (3, 1), (1, 1)] {
            let before = solution
                .unfinished
                .as_ref()
                .map_or(0, |u| u.irradiance.len());
            solution = advance(method, threads, solution, &|s: &Solution| {
                let unfinished = s.unfinished.as_ref();
                unfinished.is_some_and(|u| u.irradiance.len() >= before + rows_more)
            });
            assert_eq!(solution.provenance.iterations, 0);
        }
        let solution = advance(method, 2, solution, &two_iterations);
        assert_eq!(solution, whole, "{method:?}");
    }
}
