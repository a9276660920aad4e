//! Corners, where walls meet, and bodies that stand on a floor.

use std::sync::Arc;

use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::polygon_form_factor::point_to_triangle;
use compute::row_cache::RowCache;
use compute::rows::UNITS_PER_ONE;
use compute::settings::Points;
use glam::{DQuat, DVec3, EulerRot, Vec3};
use scene::{Scene, Solution, Surface};

use super::{all_rows, cache, counting_error, frame, settings};
use crate::common::methods::{Method, converge, radiosity, solver};
use crate::common::{self, block, material, quad};

const REFLECTANCE: f32 = 0.5;
const RESOLUTION: u32 = 64;

/// Largest error of a furnace's radiosities, relative: a patch that sees a share of x of anything but
/// patches is off by x rho / (1 - rho), which is x. Three pixels of 64 x 64 are a thousandth.
const TOLERANCE: f64 = 1e-3;

/// The floor of a 4 x 4 x 3 m room, from z = 0 up.
fn floor(low: [f32; 2], high: [f32; 2]) -> [Surface; 2] {
    let at = |x: f32, y: f32| Vec3::new(x, y, 0.0);
    quad(
        [
            at(low[0], low[1]),
            at(high[0], low[1]),
            at(high[0], high[1]),
            at(low[0], high[1]),
        ],
        0,
    )
}

/// How far a furnace's radiosities may be off if nothing is lost: its residual 1e-7 and the roundings of
/// f32, twice that much for a reflectance of 1/2.
const CLOSURE: f64 = 1e-6;

/// The room's walls and ceiling.
fn walls() -> Vec<Surface> {
    let whole = block(Vec3::ZERO, Vec3::new(4.0, 4.0, 3.0), false, 0);
    let is_floor = |s: &Surface| s.corners.iter().all(|p| p.z == 0.0);
    whole.into_iter().filter(|s| !is_floor(s)).collect()
}

fn is_bottom(surface: &Surface) -> bool {
    surface.corners.iter().all(|p| p.z == 0.0)
}

/// Two boxes, one beside the other's edge.
fn boxes() -> Vec<Surface> {
    [
        block(Vec3::new(1.0, 1.0, 0.0), Vec3::new(2.0, 2.0, 1.0), true, 0),
        block(Vec3::new(3.0, 2.0, 0.0), Vec3::new(3.5, 3.0, 2.0), true, 0),
    ]
    .concat()
}

/// The rooms, by name.
fn rooms() -> Vec<(&'static str, Vec<Surface>)> {
    let cube = block(Vec3::ZERO, Vec3::splat(4.0), false, 0);
    // The floor goes on below the boxes, and their bottoms lie in it. Its patches are right triangles
    // with legs of 1/2 m, so that none is half below a box.
    let on_floor = [walls(), floor([0.0, 0.0], [4.0, 4.0]).to_vec(), boxes()].concat();
    // The floor is cut out where the boxes stand, which have no bottoms.
    let lines = [0.0, 1.0, 2.0, 3.0, 3.5, 4.0];
    let mut cut_out = walls();
    for x in lines.windows(2) {
        for y in [0.0, 1.0, 2.0, 3.0, 4.0].windows(2) {
            let (x_mid, y_mid) = (0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
            let below = ((1.0..2.0).contains(&x_mid) && (1.0..2.0).contains(&y_mid))
                || ((3.0..3.5).contains(&x_mid) && (2.0..3.0).contains(&y_mid));
            if !below {
                cut_out.extend(floor([x[0], y[0]], [x[1], y[1]]));
            }
        }
    }
    cut_out.extend(boxes().into_iter().filter(|s| !is_bottom(s)));
    vec![
        ("cube", cube),
        ("boxes on the floor", on_floor),
        ("boxes on cut-outs", cut_out),
    ]
}

fn furnace(surfaces: Vec<Surface>, scale: f32) -> Scene {
    let area = 0.125 * f64::from(scale).powi(2) * (1.0 + 1e-6);
    common::scene(vec![material(REFLECTANCE, 1.0)], surfaces, area)
}

fn mapped(surfaces: Vec<Surface>, mut map: impl FnMut(DVec3) -> Vec3) -> Vec<Surface> {
    surfaces
        .into_iter()
        .map(|s| Surface {
            corners: s.corners.map(|p| map(p.as_dvec3())),
            ..s
        })
        .collect()
}

/// The largest error of a furnace's patches that anybody sees, and their number.
fn furnace_error(scene: &Scene) -> (f64, usize) {
    let mut rows: RowCache = cache(scene, RESOLUTION);
    rows.draw_missing().unwrap();
    let mut solver = solver(Method::Jacobi, scene, Solution::dark(scene));
    converge(solver.as_mut(), &mut rows, 1e-7);
    let found = radiosity(scene, &solver.snapshot());
    let seen = (0..found.len()).filter(|&k| rows.received().is_seen(k));
    let errors: Vec<f64> = seen
        .map(|k| (found[k].x * (1.0 - f64::from(REFLECTANCE)) - 1.0).abs())
        .collect();
    (errors.iter().copied().fold(0.0, f64::max), errors.len())
}

#[track_caller]
fn assert_furnace(scene: &Scene, what: &str) {
    let (error, seen) = furnace_error(scene);
    println!("{what}: {error:.1e} of {seen} patches");
    assert!(error <= TOLERANCE, "{what}: {error:e}");
    // What stands on the floor hides less than a tenth of all.
    assert!(
        10 * seen > 9 * scene.patch_count() as usize,
        "{what}: {seen}"
    );
}

/// In a closed furnace every patch is as bright as every other, in corners too, in rooms of millimetres and
/// of kilometres, with and without a floor below the boxes.
#[test]
fn every_patch_of_a_furnace_is_as_bright_as_any_other() {
    for scale in [1e-3_f32, 1.0, 1e3] {
        for (name, surfaces) in rooms() {
            let surfaces = mapped(surfaces, |p| scale * p.as_vec3());
            assert_furnace(&furnace(surfaces, scale), &format!("{name} times {scale}"));
        }
    }
}

/// Turned by an odd angle all corners are rounded, and each triangle's are moved by up to one more unit
/// in the last place each way, each triangle's its own: walls meet within rounding only. Fronts are drawn
/// as much too large as corners may be off, so no ray passes between them: what is left is f32.
#[test]
fn walls_that_meet_within_rounding_leave_no_seam() {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.37, 1.1, 2.3);
    for scale in [1e-3, 1.0, 1e3] {
        for (name, surfaces) in rooms() {
            let mut state = 1_u32;
            let mut step = |x: f32| {
                // Numerical Recipes' generator; the top bits are good enough for a third of the cases each.
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                match (state >> 24) % 3 {
                    0 => x.next_up(),
                    1 => x.next_down(),
                    _ => x,
                }
            };
            let surfaces = mapped(surfaces, |p| {
                let p = (scale * (turn * p)).as_vec3();
                Vec3::new(step(p.x), step(p.y), step(p.z))
            });
            let what = format!("{name} times {scale}, turned and shaken");
            let scene = furnace(surfaces, scale as f32);
            assert_furnace(&scene, &what);
            let (error, _) = furnace_error(&scene);
            assert!(error <= CLOSURE, "{what}: {error:e}");
        }
    }
}

/// A unit cube with one bright wall, x = 0, all else black; the floor is cut into strips, each half as far
/// from the bright wall as the one before, down to a millionth of a metre.
fn lit_corner() -> (Scene, std::ops::Range<u32>) {
    let mut surfaces = block(Vec3::ZERO, Vec3::ONE, false, 0);
    surfaces.retain(|s| !is_bottom(s));
    for s in &mut surfaces {
        if s.corners.iter().all(|p| p.x == 0.0) {
            s.material.0 = 1;
        }
    }
    let first = surfaces.len() as u32;
    let mut far = 1.0;
    for k in 0..=20 {
        let near = if k == 20 { 0.0 } else { 0.5 * far };
        surfaces.extend(floor([near, 0.0], [far, 1.0]));
        far = near;
    }
    let materials = vec![material(0.0, 0.0), material(0.0, 1.0)];
    let strips = first..surfaces.len() as u32;
    (common::scene(materials, surfaces, f64::INFINITY), strips)
}

/// Irradiance of a floor's patches before a bright wall, one row of patches towards it: the exact form
/// factor of the wall (Lambert's formula) but for the pixels along its top side and its two upright
/// sides; the fourth is the horizon's. So it grows towards the corner wherever the exact one grows by
/// more than that, to one half: there is no dark seam, and no bright one.
#[test]
fn irradiance_in_a_lit_corner_is_the_exact_one() {
    let (scene, strips) = lit_corner();
    let wall: Vec<&Surface> = scene
        .surfaces()
        .iter()
        .filter(|s| s.material.0 == 1)
        .collect();
    assert_eq!(wall.len(), 2);
    for resolution in [32, 128, 512] {
        let rows = all_rows(&scene, resolution);
        let bound = counting_error(resolution, 1, 2);
        let one = f64::from(UNITS_PER_ONE);
        let mut before = [(0.0, 0.0); 2];
        for patch in strips.clone() {
            let frame = frame(&scene, patch);
            let exact: f64 = wall
                .iter()
                .map(|s| point_to_triangle(s.corners.map(|p| frame.to_local(p.as_dvec3()))))
                .sum();
            let units: f64 = rows
                .row(patch as usize)
                .iter()
                .filter(|e| scene.patch_emissions()[e.source as usize].x > 0.0)
                .map(|e| f64::from(e.units))
                .sum();
            let found = units / one;
            let x = frame.position.x;
            let at = format!("{resolution} pixels, {x:e} m: {found} {exact}");
            assert!((found - exact).abs() <= bound, "{at}");
            let (found_before, exact_before) = before[patch as usize % 2];
            assert!(exact > exact_before, "{at}");
            if exact > exact_before + 2.0 * bound {
                assert!(found > found_before, "{at}");
            }
            before[patch as usize % 2] = (found, exact);
        }
        // A third or two thirds of a micrometre before the wall it fills half of the hemisphere.
        let last = before[0].0.min(before[1].0);
        assert!((last - 0.5).abs() <= bound, "{resolution}: {last}");
    }
}

/// From points next to the patches' very corners, a sixty-fourth of the way to their middles, nothing but
/// patches is seen either.
#[test]
fn closed_rooms_are_closed_from_their_corners_too() {
    let points = Points::Vertices;
    for (name, surfaces) in rooms() {
        if name == "boxes on the floor" {
            continue; // corners of the floor's patches touch the boxes
        }
        let scene = furnace(surfaces, 1.0);
        let mut settings = settings(32);
        settings.points = points;
        let hemicubes = Arc::new(Hemicubes::new(&scene, settings));
        let source = Box::new(CpuRows::new(&hemicubes));
        let mut rows = RowCache::new(&hemicubes, source, 0);
        rows.draw_missing().unwrap();
        for (k, unseen) in rows.unseen().iter().enumerate() {
            assert_eq!(
                unseen.unwrap(),
                compute::rows::Unseen::default(),
                "{name} {k}"
            );
        }
    }
}
