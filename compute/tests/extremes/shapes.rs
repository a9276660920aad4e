//! Slivers, areas a hundred million apart, and plates that almost touch.

use compute::certificate::{Known, RECIPROCITY_TOLERANCE, certify};
use compute::polygon_form_factor::point_to_triangle;
use compute::rows::UNITS_PER_ONE;
use glam::Vec3;
use scene::{PatchId, Scene, Solution, SurfaceId};

use super::{all_rows, assert_closed, cache, counting_error, frame};
use crate::common::methods::{
    METHODS, Method, ROUNDING, ROUNDINGS_PER_RADIOSITY, converge, radiosity, rows, solver,
};
use crate::common::{self, block, material, quad};

const REFLECTANCE: f32 = 0.5;

/// A closed box whose walls all emit 1 W/m^2 and reflect half.
fn furnace(size: Vec3, max_area: f64) -> Scene {
    let surfaces = block(Vec3::ZERO, size, false, 0);
    common::scene(vec![material(REFLECTANCE, 1.0)], surfaces, max_area)
}

/// B = E / (1 - rho) in every patch of a furnace that is closed, whatever its shape, but for the residual
/// and for three roundings an iteration, both times 1 / (1 - rho).
#[track_caller]
fn assert_furnace(scene: &Scene, what: &str) {
    for method in [Method::Jacobi, Method::GaussSeidel] {
        let mut rows = rows(scene, u64::MAX);
        let mut solver = solver(method, scene, Solution::dark(scene));
        converge(solver.as_mut(), &mut rows, 1e-8);
        let rho = f64::from(REFLECTANCE);
        let bound = (1e-8 + ROUNDINGS_PER_RADIOSITY * ROUNDING) / (1.0 - rho);
        for (k, b) in radiosity(scene, &solver.snapshot()).iter().enumerate() {
            let error = (b.x * (1.0 - rho) - 1.0).abs();
            assert!(error <= bound, "{what}, {method:?}, patch {k}: {error:e}");
        }
    }
}

/// A duct of slivers a thousand times as long as they are wide, and one of a million, whole and cut.
#[test]
fn ducts_of_slivers_are_closed_furnaces() {
    for (size, max_area) in [
        (Vec3::new(1.0, 1e-3, 1e-3), f64::INFINITY),
        (Vec3::new(1.0, 1e-3, 1.0), f64::INFINITY),
        (Vec3::new(1.0, 1e-3, 0.7), 1e-4),
        (Vec3::new(1.0, 1e-6, 1e-6), f64::INFINITY),
    ] {
        let what = format!("{size}, {max_area} m^2");
        let scene = furnace(size, max_area);
        for resolution in [2, 32, 128] {
            assert_closed(&scene, resolution, &what);
        }
        assert_furnace(&scene, &what);
    }
}

/// A box of 1 cm in a hall of 100 m: areas of 5000 and 5e-5 m^2. Every row is closed, so all is as bright
/// as in any furnace. A box that no pixel sees gets nothing by shooting, which is right for the power:
/// what is emitted is absorbed, but for the box's share of a hundred millionth, and the residual.
#[test]
fn areas_a_hundred_million_apart_are_one_furnace() {
    let mut surfaces = block(Vec3::ZERO, Vec3::splat(100.0), false, 0);
    let corner = Vec3::new(31.0, 47.0, 13.0);
    surfaces.extend(block(corner, corner + Vec3::splat(0.01), true, 0));
    let scene = common::scene(vec![material(REFLECTANCE, 1.0)], surfaces, f64::INFINITY);
    let areas = scene.patch_areas();
    assert!(areas[0] / areas[23] > 0.99e8, "{areas:?}");
    for resolution in [16, 256] {
        assert_closed(&scene, resolution, "hall");
    }
    assert_furnace(&scene, "hall");
    let mut rows = rows(&scene, u64::MAX);
    let mut solver = solver(Method::Shooting, &scene, Solution::dark(&scene));
    converge(solver.as_mut(), &mut rows, 1e-7);
    let power: f64 = radiosity(&scene, &solver.snapshot())
        .iter()
        .zip(&areas)
        .map(|(b, area)| area * b.x)
        .sum();
    let share = power * (1.0 - f64::from(REFLECTANCE)) / scene.area();
    let shots = solver.iterations() as f64;
    let bound = 1e-7 + 1e-8 + (2.0 * shots + ROUNDINGS_PER_RADIOSITY) * ROUNDING;
    assert!((share - 1.0).abs() <= bound, "{share} {bound:e}");
}

/// Plates of 1 m, 1e-4 m apart, with rims between them. No pixel of 128 is so low that it sees a rim from
/// the plates' middles, but none sees past it either: rows are closed, and the plates see each other
/// alone. Their reciprocity is exact; rims are seen by nobody, which is an error of 1 on their share of
/// the area, 4e-4 of 2: root mean square 1.5 percent.
#[test]
fn plates_that_almost_touch_lose_nothing() {
    let scene = furnace(Vec3::new(1.0, 1.0, 1e-4), 0.01);
    for resolution in [32, 128] {
        assert_closed(&scene, resolution, "plates");
    }
    assert_furnace(&scene, "plates");
    let mut rows = cache(&scene, 128);
    rows.draw_missing().unwrap();
    let certificate = certify(&rows, Known::default());
    assert_eq!(certificate.violations, [""; 0]);
    let rms = certificate.reciprocity.unwrap().rms;
    assert!(rms < RECIPROCITY_TOLERANCE, "{rms}");
}

/// The same plates without rims: what leaves is 1 less the exact form factor of the other plate, a share of
/// 1e-4 / 2 times its rim over its distance. What pixels see of it, at the horizon, is no more than
/// their lowest row, and power is conserved: what is emitted is absorbed or leaves.
#[test]
fn plates_without_rims_lose_what_leaves_between_them() {
    let gap = 1e-4_f32;
    let corners =
        |z: f32| [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x, y, z));
    let mut upper = corners(gap);
    upper.reverse();
    let surfaces = [quad(corners(0.0), 0), quad(upper, 0)].concat();
    let scene = common::scene(vec![material(REFLECTANCE, 1.0)], surfaces, 0.01);
    let resolution = 128;
    let drawn = all_rows(&scene, resolution);
    let one = f64::from(UNITS_PER_ONE);
    for patch in 0..scene.patch_count() {
        let frame = frame(&scene, patch);
        let own = scene.mesh().surface_of(PatchId(patch)).0 / 2;
        let expected: f64 = (0..4)
            .filter(|surface| surface / 2 != own)
            .map(|surface| {
                let corners = scene.surface(SurfaceId(surface)).corners;
                point_to_triangle(corners.map(|p| frame.to_local(p.as_dvec3())))
            })
            .sum();
        let k = patch as usize;
        let found = 1.0 - f64::from(drawn.unseen(k).open) / one;
        let error = (found - expected).abs();
        assert!(
            error <= counting_error(resolution, 4, 0),
            "{patch}: {found} {expected}"
        );
        assert_eq!(drawn.unseen(k).back_face, 0, "{patch}");
    }
    for method in METHODS {
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(method, &scene, Solution::dark(&scene));
        converge(solver.as_mut(), &mut rows, 1e-6);
        rows.draw_missing().unwrap();
        let solution = solver.snapshot();
        let energy = compute::energy::measure(&scene, &solution, &rows, &[]).0;
        // As much as reciprocity misses, and what the residual leaves.
        let certificate = certify(
            &rows,
            Known {
                imbalance: energy.imbalance,
                ..Known::default()
            },
        );
        let missed = certificate.reciprocity.unwrap().rms;
        let imbalance = energy.imbalance.unwrap();
        assert!(
            imbalance.abs() <= missed / (1.0 - f64::from(REFLECTANCE)) + 1e-5,
            "{method:?}: {imbalance:e}, {missed:e}"
        );
        assert!(missed < 0.1, "{missed:e} shows nothing");
    }
}
