//! Laws of the solvers, on scenes small enough to be solved in other ways.

mod common;

use common::methods::{
    METHODS, Method, ROUNDING, ROUNDINGS_PER_RADIOSITY, converge, dense_solution, error_bound,
    factors, form_factors, iterate, largest_row_sum, norm, radiosity, relative_difference, rows,
    shooting_factors, solver,
};
use glam::DVec3;
use scene::{Rgb, Solution, State};

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
const AGREEMENT: f64 = 5e-4;

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

/// What the agreement above rests on: it fails where the factors to a lamp are off by a hundredth.
#[test]
fn gaussian_elimination_tells_wrong_form_factors() {
    let scene = common::colourful_room(0.6);
    let mut factors = form_factors(&scene);
    let exact = dense_solution(&scene, &factors);
    let emission = scene.patch_emissions();
    let lamp = emission.iter().position(|e| e.x > 1.0).unwrap();
    for row in factors.iter_mut().filter(|row| row[lamp] > 0.0) {
        row[lamp] += 0.01;
    }
    let wrong = dense_solution(&scene, &factors);
    for method in METHODS {
        let error = relative_difference(method, &scene, &wrong, &exact);
        assert!(error > AGREEMENT, "{method:?}: {error:e}");
    }
}

/// A change x becomes rho F x, and rows sum to 1: the largest change falls by the largest reflectance.
#[test]
fn jacobi_largest_change_falls_by_the_reflectance_in_a_closed_room() {
    for reflectance in [0.3_f32, 0.7, 0.95] {
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
    for reflectance in [0.3_f32, 0.6, 0.8] {
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

/// As fast as patch by patch, which takes about half of Jacobi's iterations.
#[test]
fn gauss_seidel_converges_in_two_thirds_of_jacobis_iterations() {
    let scene = common::colourful_room(0.1);
    let iterations = |method| {
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(method, &scene, Solution::dark(&scene));
        converge(solver.as_mut(), &mut rows, 1e-5)
    };
    let (jacobi, gauss_seidel) = (iterations(Method::Jacobi), iterations(Method::GaussSeidel));
    println!("jacobi {jacobi}, gauss-seidel {gauss_seidel}");
    assert!(3 * gauss_seidel <= 2 * jacobi, "{gauss_seidel} {jacobi}");
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
            start.state = State::AtRest;
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
            let done = |s: &Solution| match &s.state {
                State::Unfinished { irradiance } => irradiance.len(),
                _ => 0,
            };
            let before = done(&solution);
            solution = advance(method, threads, solution, &|s: &Solution| {
                done(s) >= before + rows_more
            });
            assert_eq!(solution.provenance.iterations, 0);
        }
        let solution = advance(method, 2, solution, &two_iterations);
        assert_eq!(solution, whole, "{method:?}");
    }
}
