//! Laws of shooting: what is unshot, and what is told of it.

mod common;

use std::ops::Range;
use std::sync::Arc;

use common::methods::{
    Method, ROUNDING, ROUNDINGS_PER_RADIOSITY, SETTINGS, converge, iterate, largest_reflectance,
    radiosity, relative_difference, rows, solved, solver,
};
use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::problem::Problem;
use compute::row_cache::RowCache;
use compute::rows::{BackendError, RowBatch, RowSource};
use compute::solver::ambient_radiosity;
use glam::DVec3;
use scene::{Solution, State};

/// A shot takes its power from the unshot, and gives back rho times that at most. The shooter has
/// the most, at least the mean.
#[test]
fn unshot_power_never_increases() {
    let scene = common::colourful_room(0.3);
    let patches = f64::from(scene.patch_count());
    let rho = largest_reflectance(&scene);
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

/// The unshot power is counted by blocks, and only where a shot has changed it; a solver that goes on from the
/// state counts it all. Sums of so few values differ by far less in any order.
#[test]
fn unshot_power_counted_on_the_way_is_that_of_the_state() {
    let scene = common::colourful_room(0.1);
    let areas = scene.patch_areas();
    let emitted = scene.emitted_power().element_sum();
    let mut rows = rows(&scene, u64::MAX);
    let mut solver = solver(Method::Shooting, &scene, Solution::dark(&scene));
    for _ in 0..40 {
        iterate(solver.as_mut(), &mut rows, 97);
        let State::Shooting { unshot, .. } = solver.snapshot().state else {
            panic!("shooting has a state of its own")
        };
        let powers = unshot.iter().zip(&areas);
        let power: f64 = powers
            .map(|(b, area)| area * b.as_dvec3().abs().element_sum())
            .sum();
        let error = (solver.residual().unwrap() * emitted / power - 1.0).abs();
        let bound = areas.len() as f64 * f64::EPSILON;
        assert!(error <= bound, "{error:e} > {bound:e}");
    }
}

/// In a furnace all that is unshot goes on as a geometric series, so the ambient radiosity tells all that is
/// missing: B + rho ambient is the solution, in power.
#[test]
fn ambient_radiosity_is_what_a_furnace_lacks() {
    for reflectance in [0.3_f32, 0.8] {
        let scene = common::furnace(reflectance, 1.0, 0.1);
        let problem = Problem::new(&scene);
        let rho = f64::from(reflectance);
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(Method::Shooting, &scene, Solution::dark(&scene));
        for _ in 0..20 {
            iterate(solver.as_mut(), &mut rows, 7);
            let solution = solver.snapshot();
            let ambient = ambient_radiosity(&problem, &solution).unwrap();
            let found = radiosity(&scene, &solution).into_iter();
            let power: DVec3 = found.zip(&problem.areas).map(|(b, a)| *a * b).sum();
            let mean = power / scene.area() + rho * ambient;
            // Each shot rounds what is unshot twice.
            let shots = solver.iterations() as f64;
            let bound = (ROUNDINGS_PER_RADIOSITY + 2.0 * shots) * ROUNDING / (1.0 - rho);
            let error = (mean * (1.0 - rho) - DVec3::ONE).abs().max_element();
            assert!(error <= bound, "{reflectance}: {error:e} > {bound:e}");
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

/// Rows that end in an error after some.
struct Failing<'a> {
    rows: CpuRows<'a>,
    left: u32,
}

impl RowSource for Failing<'_> {
    fn draw_rows(&mut self, receivers: Range<u32>) -> Result<RowBatch, BackendError> {
        let what = || "torn out".to_owned();
        self.left = self
            .left
            .checked_sub(receivers.len() as u32)
            .ok_or_else(|| BackendError::DeviceLost { what: what() })?;
        self.rows.draw_rows(receivers)
    }

    fn preferred_batch(&self) -> u32 {
        16
    }

    fn describe(&self) -> String {
        self.rows.describe()
    }
}

/// A solution of another solver is shot once before shots begin. Where that fails on the way, it is the solution still.
#[test]
fn a_back_end_that_fails_leaves_the_solution_that_is_taken_over() {
    let scene = common::colourful_room(0.3);
    let start = solved(Method::Jacobi, &scene, 1e-3);
    let hemicubes = Arc::new(Hemicubes::new(&scene, SETTINGS));
    let failing = Failing {
        rows: CpuRows::new(&hemicubes),
        left: scene.patch_count() / 2,
    };
    let mut rows = RowCache::new(&hemicubes, Box::new(failing), u64::MAX);
    let mut solver = solver(Method::Shooting, &scene, start.clone());
    while solver.step(&mut rows).is_ok() {}
    assert!(rows.statistics().kept_rows > 0);
    assert!(solver.snapshot() == start);
    // And once more, which would otherwise begin to shoot.
    assert!(solver.step(&mut rows).is_err());
    assert!(solver.snapshot() == start);
}
