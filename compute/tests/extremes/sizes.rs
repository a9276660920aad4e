//! The fewest patches, the most, and hemicubes of every size.

use std::sync::Arc;

use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::polygon_form_factor::point_to_triangle;
use compute::rows::{RowSource, UNITS_PER_ONE};
use glam::{DVec3, Vec3};
use scene::{MAX_PATCHES, MaterialId, ObjectId, Scene, Solution, Surface, SurfaceId};

use super::{
    all_rows, assert_closed, assert_sums_to_one, counting_error, frame, row_sum, settings,
};
use crate::common::methods::{
    METHODS, Method, ROUNDING, ROUNDINGS_PER_RADIOSITY, converge, radiosity, rows, solver,
};
use crate::common::{self, bits, block, folder, load, material, save, solve};

fn triangle(corners: [Vec3; 3], material: u32) -> Surface {
    Surface {
        corners,
        material: MaterialId(material),
        object: ObjectId(0),
    }
}

/// A patch alone sees nothing, receives nothing, and has its own emission for a radiosity.
#[test]
fn one_patch_has_its_emission_for_a_radiosity() {
    let surface = triangle([Vec3::ZERO, Vec3::X, Vec3::Y], 0);
    let scene = common::scene(vec![material(0.7, 2.0)], vec![surface], f64::INFINITY);
    assert_eq!(scene.patch_count(), 1);
    let folder = folder();
    save(folder.path(), "in.rad", &scene);
    for method in ["jacobi", "gauss-seidel", "shooting"] {
        for strict in [&[][..], &["--strict"]] {
            let arguments = ["in.rad", "out.rad", "64", "--solver", method];
            solve(folder.path(), &[&arguments[..], strict].concat());
            let solution = load(folder.path(), "out.rad");
            assert_eq!(bits(&solution.irradiance), bits(&[Vec3::ZERO]), "{method}");
            assert_eq!(bits(&solution.radiosity(&scene)), bits(&[Vec3::splat(2.0)]));
        }
    }
}

/// Two triangles face to face, in different places.
fn two_patches() -> Scene {
    let below = [
        Vec3::ZERO,
        Vec3::new(2.0, 0.0, 0.1),
        Vec3::new(0.3, 1.5, 0.0),
    ];
    let above = [
        Vec3::new(0.1, 0.2, 0.8),
        Vec3::new(0.4, 1.9, 0.7),
        Vec3::new(1.7, -0.3, 1.0),
    ];
    let surfaces = vec![triangle(below, 0), triangle(above, 1)];
    let materials = vec![material(0.6, 1.0), material(0.8, 3.0)];
    common::scene(materials, surfaces, f64::INFINITY)
}

/// The form factor from a patch's centroid to a surface that nothing hides.
fn exact(scene: &Scene, patch: u32, surface: u32) -> f64 {
    let frame = frame(scene, patch);
    let corners = scene.surface(SurfaceId(surface)).corners;
    point_to_triangle(corners.map(|p| frame.to_local(p.as_dvec3())))
}

/// B_1 = E_1 + rho_1 F_12 B_2 and the same the other way round, solved by hand, with the form factors as
/// they were drawn; these are the exact ones but for three sides' pixels. Both are solved to a residual
/// of 1e-9 and rounded thrice in each iteration.
#[test]
fn two_patches_have_the_radiosities_of_two_equations() {
    let scene = two_patches();
    let resolution = common::methods::SETTINGS.resolution;
    let drawn = all_rows(&scene, resolution);
    let factor = |k: usize| row_sum(&drawn, k);
    let (f_12, f_21) = (factor(0), factor(1));
    for (found, expected) in [(f_12, exact(&scene, 0, 1)), (f_21, exact(&scene, 1, 0))] {
        let error = (found - expected).abs();
        assert!(
            error <= counting_error(resolution, 3, 0) && expected > 0.2,
            "{found} {expected}"
        );
    }
    let areas = scene.patch_areas();
    for method in METHODS {
        // Shooting has F_21 from F_12 by reciprocity.
        let (to_1, to_2) = match method {
            Method::Shooting => (f_21 * areas[1] / areas[0], f_12 * areas[0] / areas[1]),
            _ => (f_12, f_21),
        };
        let (rho_1, rho_2) = (f64::from(0.6_f32), f64::from(0.8_f32));
        let loop_gain = rho_1 * rho_2 * to_1 * to_2;
        let b_1 = (1.0 + rho_1 * to_1 * 3.0) / (1.0 - loop_gain);
        let b_2 = (3.0 + rho_2 * to_2) / (1.0 - loop_gain);
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(method, &scene, Solution::dark(&scene));
        converge(solver.as_mut(), &mut rows, 1e-9);
        let found = radiosity(&scene, &solver.snapshot());
        let iterations = solver.iterations() as f64;
        let bound =
            (1e-9 + ROUNDINGS_PER_RADIOSITY * ROUNDING) / (1.0 - loop_gain) + iterations * ROUNDING;
        for (found, expected) in found.iter().zip([b_1, b_2]) {
            let error = (found.x / expected - 1.0).abs();
            assert!(error <= bound, "{method:?}: {found} {expected}");
        }
    }
}

/// From the coarsest hemicube, of 12 pixels, to twelve million: a closed room sums to exactly 1, with a
/// box in it too.
#[test]
fn closed_rooms_are_closed_at_every_resolution() {
    let mut surfaces = block(Vec3::ZERO, Vec3::splat(3.0), false, 0);
    surfaces.extend(block(Vec3::ONE, Vec3::splat(1.7), true, 0));
    let scene = common::scene(vec![material(0.5, 1.0)], surfaces, f64::INFINITY);
    for resolution in [2, 4, 6, 8, 14, 30, 62, 128, 250, 510, 1024, 2048] {
        assert_closed(&scene, resolution, "room");
    }
}

/// All form factors of two triangles and of the walls of a cube, which nothing hides, come closer to the
/// exact ones with the resolution, as the pixels along their sides do: as R^-3/2, but as 1 / R for the
/// sides that run along pixels. These are the upright ones, and the first patch's hemicube, which alone
/// is not turned, has the opposite wall's diagonal along a row: half a row of the top is at most
/// 1/R times the integral of 1 / (pi (1 + x^2)^2) over x from -1 to 1, (1/2 + pi/4) / pi.
#[test]
fn form_factors_converge_with_the_resolution() {
    let cube = common::furnace(0.5, 1.0, f64::INFINITY);
    let mut largest = Vec::new();
    for resolution in [2, 8, 32, 128, 512, 2048] {
        let mut worst = 0.0_f64;
        for (scene, upright) in [(two_patches(), 0), (cube.clone(), 2)] {
            let rows = all_rows(&scene, resolution);
            let row = (0.5 / std::f64::consts::PI + 0.25) / f64::from(resolution);
            let units_per_one = f64::from(UNITS_PER_ONE);
            for i in 0..scene.patch_count() {
                let along = if i == 0 { row } else { 0.0 };
                let bound = counting_error(resolution, 3, upright) + along;
                for j in 0..scene.patch_count() {
                    let row = rows.row(i as usize);
                    let entry = row.iter().find(|e| e.source == j);
                    let found = entry.map_or(0.0, |e| f64::from(e.units)) / units_per_one;
                    let own_plane = scene.surface(SurfaceId(i)).normal()
                        == scene.surface(SurfaceId(j)).normal();
                    let expected = if own_plane { 0.0 } else { exact(&scene, i, j) };
                    let error = (found - expected).abs();
                    assert!(
                        error <= bound,
                        "{resolution}: {i} to {j}, {found} {expected}"
                    );
                    worst = worst.max(error);
                }
            }
        }
        println!("{resolution} pixels: {worst:.1e}");
        largest.push(worst);
    }
    assert!(largest.is_sorted_by(|a, b| a > b), "{largest:?}");
}

/// A cube of as many patches as have IDs: each wall is four triangles around its middle, and no two of the
/// 24 have the same depth, 0 to 23, which makes 2^24 - 1 patches.
fn cube_of_all_patches() -> Scene {
    let middles = block(Vec3::ZERO, Vec3::ONE, false, 0)
        .chunks(2)
        .flat_map(|wall| {
            let ([a, b, c], [_, _, d]) = (wall[0].corners, wall[1].corners);
            let middle = 0.5 * (a + c);
            [[a, b], [b, c], [c, d], [d, a]].map(|[p, q]| triangle([p, q, middle], 0))
        })
        .collect();
    let depths: Vec<u32> = (0..24).collect();
    let materials = vec![material(0.5, 1.0)];
    Scene::new(materials, vec!["all".into()], middles, &depths, DVec3::ZERO).unwrap()
}

/// Rows of the first patch, of one in the middle, and of the last are complete, in order, and name no
/// patch that does not exist; the finest wall is seen in as many patches as pixels, or nearly.
#[test]
fn rows_among_all_the_patches_that_have_ids_are_complete() {
    let scene = cube_of_all_patches();
    assert_eq!(scene.patch_count(), MAX_PATCHES);
    let mut source = CpuRows::new(&Arc::new(Hemicubes::new(&scene, settings(64))));
    for patch in [0, MAX_PATCHES / 3, MAX_PATCHES - 1] {
        let rows = source.draw_rows(patch..patch + 1).unwrap();
        assert_sums_to_one(&rows, 0, &patch.to_string());
        let row = rows.row(0);
        assert!(row.is_sorted_by(|a, b| a.source < b.source), "{patch}");
        assert!(row.last().unwrap().source < MAX_PATCHES);
    }
    let rows = source.draw_rows(0..1).unwrap();
    let finest = scene.mesh().tree(SurfaceId(23)).patches();
    let seen: Vec<_> = rows
        .row(0)
        .iter()
        .filter(|e| finest.contains(&e.source))
        .collect();
    // A triangle of a quarter of a wall, opposite or beside: some hundred pixels of 64 x 64.
    assert!(seen.len() > 100, "{}", seen.len());
}
