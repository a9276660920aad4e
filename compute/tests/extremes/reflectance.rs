//! Reflectances from 0 to next to 1, and iterations without end.

use compute::settings::SolverChoice;
use compute::solver::Solver;
use compute::solver::convergence::{Convergence, ERROR_TOLERANCE};
use glam::Vec3;
use scene::{Scene, Solution};

use crate::common::methods::{
    Method, ROUNDING, ROUNDINGS_PER_RADIOSITY, converge, iterate, radiosity, rows, solver,
};
use crate::common::{self, block, compute, folder, load, material, save, scene, solve, stderr};

/// The default of `--tolerance`.
const TOLERANCE: f64 = 1e-5;

/// The fewest patches that make a closed room: each wall of a cube is two.
fn small_furnace(reflectance: f32) -> Scene {
    common::furnace(reflectance, 1.0, f64::INFINITY)
}

fn choice(method: Method) -> SolverChoice {
    match method {
        Method::Jacobi => SolverChoice::Jacobi,
        Method::GaussSeidel => SolverChoice::GaussSeidel,
        Method::Shooting => SolverChoice::Shooting,
    }
}

fn convergence(method: Method, solver: &dyn Solver) -> Convergence {
    let residuals = solver.snapshot().provenance.residuals;
    Convergence::new(choice(method), &residuals).unwrap()
}

/// Largest |B / B* - 1| of a furnace with E = 1, where B* = 1 / (1 - rho) for the rho that an f32 holds.
fn furnace_error(scene: &Scene, solution: &Solution, reflectance: f32) -> f64 {
    let exact = 1.0 / (1.0 - f64::from(reflectance));
    radiosity(scene, solution)
        .iter()
        .map(|b| (b.x / exact - 1.0).abs())
        .fold(0.0, f64::max)
}

/// A small pool: a few patches are gathered faster by one thread than shared out.
fn on_one_thread<T: Send>(work: impl FnOnce() -> T + Send) -> T {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.unwrap().install(work)
}

/// At the default tolerance a furnace is right to 0.1 percent, or the residuals say that it is not: an
/// estimate of more than that, and not less than half of the truth. (Within a factor of two: the
/// estimate takes its rate from changes whose rounding may be a quarter of their fall.)
#[test]
fn furnace_is_right_or_is_known_not_to_be() {
    on_one_thread(|| {
        for method in [Method::Jacobi, Method::GaussSeidel] {
            for reflectance in [0.001, 0.5, 0.9, 0.99, 0.999, 0.9999, 0.99999, 0.999_999] {
                let scene = small_furnace(reflectance);
                let mut rows = rows(&scene, u64::MAX);
                let mut solver = solver(method, &scene, Solution::dark(&scene));
                converge(solver.as_mut(), &mut rows, TOLERANCE);
                let error = furnace_error(&scene, &solver.snapshot(), reflectance);
                let said = convergence(method, solver.as_ref());
                println!("{method:?} {reflectance}: error {error:.2e}, {said:?}");
                assert!(
                    error <= ERROR_TOLERANCE || said.estimated_error > ERROR_TOLERANCE,
                    "{method:?} {reflectance}: {error:e}, {said:?}"
                );
                assert!(
                    error <= 2.0 * said.estimated_error,
                    "{method:?} {reflectance}: {error:e}, {said:?}"
                );
                // Nobody is warned of what is well within.
                assert!(
                    error > 0.5 * ERROR_TOLERANCE || said.warning(TOLERANCE).is_none(),
                    "{method:?} {reflectance}: {error:e}, {said:?}"
                );
            }
        }
    });
}

/// Where nothing is reflected the first iteration is the last, and right but for the two roundings of H
/// and B.
#[test]
fn black_furnace_is_right_at_once() {
    let scene = small_furnace(0.0);
    for method in [Method::Jacobi, Method::GaussSeidel] {
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(method, &scene, Solution::dark(&scene));
        assert_eq!(converge(solver.as_mut(), &mut rows, 0.0), 1, "{method:?}");
        let error = furnace_error(&scene, &solver.snapshot(), 0.0);
        assert!(error <= 2.0 * ROUNDING, "{method:?}: {error:e}");
    }
}

/// After as many more iterations as were announced the furnace is within 0.1 percent, or twice that, as
/// above; and not after half of them, or the announcement would be worth nothing. Where nothing is
/// announced, rounding may keep it away: three roundings an iteration, each times 1 / (1 - rho).
#[test]
fn announced_iterations_bring_the_furnace_within_a_thousandth() {
    on_one_thread(|| {
        for method in [Method::Jacobi, Method::GaussSeidel] {
            for reflectance in [0.99, 0.999, 0.9998] {
                let scene = small_furnace(reflectance);
                let mut rows = rows(&scene, u64::MAX);
                let mut solver = solver(method, &scene, Solution::dark(&scene));
                converge(solver.as_mut(), &mut rows, 1e-4);
                let said = convergence(method, solver.as_ref());
                let more = said.iterations_to(ERROR_TOLERANCE).unwrap();
                iterate(solver.as_mut(), &mut rows, more / 2);
                let early = furnace_error(&scene, &solver.snapshot(), reflectance);
                iterate(solver.as_mut(), &mut rows, more - more / 2);
                let error = furnace_error(&scene, &solver.snapshot(), reflectance);
                println!("{method:?} {reflectance}: {more} more, {early:.2e} then {error:.2e}");
                assert!(
                    early > ERROR_TOLERANCE && error <= 2.0 * ERROR_TOLERANCE,
                    "{method:?} {reflectance}: {early:e} {error:e} after {more}"
                );
            }
        }
    });
}

/// A tenth of the radiosity is there when the default tolerance is reached: the program says so, and that
/// f32 cannot do better than 3 2^-24 / (1 - rho) = 18 percent. With 0.999 it says how many iterations.
#[test]
fn program_warns_of_false_convergence() {
    let folder = folder();
    for (reflectance, words) in [
        (0.999_999, &["not converged", "lower the highest"][..]),
        (0.999, &["not converged", "more, with --tolerance"]),
    ] {
        save(folder.path(), "in.rad", &small_furnace(reflectance));
        let arguments = ["in.rad", "out.rad", "8", "--threads", "1"];
        let said = stderr(&solve(folder.path(), &arguments));
        for word in words {
            assert!(said.contains(word), "{reflectance}: {word} not in {said}");
        }
        // The same of a file that is done.
        let again = ["out.rad", "again.rad", "8", "--threads", "1"];
        assert_eq!(stderr(&solve(folder.path(), &again)), said);
    }
    // What the warning tells to do is enough.
    let said = stderr(&solve(folder.path(), &["out.rad", "again.rad", "8"]));
    let tolerance = said.split("--tolerance ").nth(1).unwrap();
    let tolerance = tolerance.split(',').next().unwrap();
    let arguments = ["out.rad", "again.rad", "8", "--threads", "1"];
    let more = [&arguments[..], &["--tolerance", tolerance]].concat();
    assert_eq!(stderr(&solve(folder.path(), &more)), "", "{said}");
    let solution = load(folder.path(), "again.rad");
    let error = furnace_error(&small_furnace(0.999), &solution, 0.999);
    assert!(error <= 2.0 * ERROR_TOLERANCE, "{error:e}");

    save(folder.path(), "in.rad", &small_furnace(0.9));
    assert_eq!(
        stderr(&compute(folder.path(), &["in.rad", "out.rad", "8"])),
        ""
    );
}

/// One white box in a grey room: the rate is that of the room as a whole, not the box's reflectance, and
/// nobody is warned.
#[test]
fn one_white_object_in_a_grey_room_is_no_false_alarm() {
    let mut surfaces = block(Vec3::ZERO, Vec3::splat(4.0), false, 0);
    surfaces.extend(block(Vec3::ONE, Vec3::splat(2.0), true, 1));
    let materials = vec![material(0.3, 1.0), material(0.999_999, 0.0)];
    let scene = scene(materials, surfaces, 0.5);
    for method in [Method::Jacobi, Method::GaussSeidel, Method::Shooting] {
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(method, &scene, Solution::dark(&scene));
        converge(solver.as_mut(), &mut rows, TOLERANCE);
        let said = convergence(method, solver.as_ref());
        assert!(said.warning(TOLERANCE).is_none(), "{method:?}: {said:?}");
        // At least by half of what the box alone could keep, and it is a tenth of what is seen.
        assert!(
            said.rate < 0.7 || method == Method::Shooting,
            "{method:?}: {said:?}"
        );
    }
}

/// Shooting never mistakes standstill for the end: what is unshot, of what was emitted, is what is missing
/// of the furnace's power, for every shot is reflected as often as what was emitted. Each of the shots
/// rounds what it leaves unshot, twice at most for each patch.
#[test]
fn unshot_share_is_the_missing_share_of_the_power() {
    let reflectance = 0.99_f32;
    let scene = small_furnace(reflectance);
    let mut rows = rows(&scene, u64::MAX);
    let mut solver = solver(Method::Shooting, &scene, Solution::dark(&scene));
    let exact = 1.0 / (1.0 - f64::from(reflectance));
    for residual in [0.5, 0.1, 1e-3] {
        converge(solver.as_mut(), &mut rows, residual);
        let power: f64 = radiosity(&scene, &solver.snapshot())
            .iter()
            .zip(scene.patch_areas())
            .map(|(b, area)| area * b.x)
            .sum();
        let missing = 1.0 - power / (scene.area() * exact);
        let said = convergence(Method::Shooting, solver.as_ref());
        let rounding = 2.0 * solver.iterations() as f64 * ROUNDING + ROUNDING / (1.0 - 0.99);
        // Unshot radiosity that has arrived is part of the radiosity, but its reflections are not.
        let expected = f64::from(reflectance) * said.estimated_error;
        assert!(
            (missing - expected).abs() <= rounding,
            "{missing:e} {expected:e} {rounding:e}"
        );
    }
}

/// Ten thousand Jacobi iterations in a closed room of reflectance 1/2. In the furnace a change x becomes
/// rho F x, at most half of x; the residual never grows, but for the roundings of the two radiosities
/// that are subtracted. In the end what is emitted is absorbed: B is off by at most three roundings of
/// 2^-24 in each iteration, times 1 / (1 - rho) = 2, and H by as much and its own rounding: 4.2e-7.
#[test]
fn ten_thousand_iterations_leave_all_as_it_is() {
    on_one_thread(|| {
        let reflectance = 0.5_f32;
        let scene = small_furnace(reflectance);
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(Method::Jacobi, &scene, Solution::dark(&scene));
        let rounding = 2.0 * ROUNDINGS_PER_RADIOSITY * ROUNDING;
        iterate(solver.as_mut(), &mut rows, 10_000);
        let solution = solver.snapshot();
        assert_eq!(solution.provenance.residuals.len(), 10_000);
        let mut before = f64::INFINITY;
        for (k, &residual) in solution.provenance.residuals.iter().enumerate() {
            assert!(
                residual <= before.max(rounding),
                "{k}: {residual:e} after {before:e}"
            );
            before = residual;
        }
        let absorbed: f64 = solution
            .irradiance
            .iter()
            .zip(scene.patch_areas())
            .map(|(h, area)| area * (1.0 - f64::from(reflectance)) * f64::from(h.x))
            .sum();
        let emitted = scene.emitted_power().x;
        assert!(
            (absorbed / emitted - 1.0).abs() <= 7.0 * ROUNDING,
            "{absorbed} of {emitted}"
        );
    });
}
