//! Laws of `--points auto`.

mod common;

use std::sync::Arc;

use common::{block, material, quad};
use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::receivers::ReceiverId;
use compute::rows::{RowSource, UNITS_PER_ONE};
use compute::settings::FormFactorSettings;
use glam::Vec3;
use scene::{PatchId, Scene, Surface};

const AUTO: FormFactorSettings = FormFactorSettings::new(128);

/// A unit square at height z, its front upwards, or downwards.
fn square(z: f32, up: bool) -> [Surface; 2] {
    let mut corners =
        [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(|(x, y)| Vec3::new(x, y, z));
    if !up {
        corners.reverse();
    }
    quad(corners, 0)
}

fn dark(surfaces: Vec<Surface>, max_area: f64) -> Scene {
    common::scene(vec![material(0.5, 0.0)], surfaces, max_area)
}

fn counts(scene: &Scene) -> Vec<u32> {
    let hemicubes = Hemicubes::new(scene, AUTO);
    let counts: Vec<u32> = (0..scene.patch_count())
        .map(|patch| hemicubes.receivers().point_count(ReceiverId(patch)))
        .collect();
    // Hemicubes are numbered through the patches.
    let mut first = 0;
    for (patch, &count) in (0..).map(PatchId).zip(&counts) {
        assert_eq!(
            hemicubes.receivers().first_point(ReceiverId(patch.0)),
            first
        );
        assert_eq!(
            hemicubes.receivers().frames(ReceiverId(patch.0)).len(),
            count as usize
        );
        first += u64::from(count);
    }
    assert_eq!(hemicubes.total(), first);
    counts
}

/// Mean form factor between the surfaces whose normals pass a test and those whose pass another, all of
/// one area.
fn form_factor(scene: &Scene, from: impl Fn(Vec3) -> bool, to: impl Fn(Vec3) -> bool) -> f64 {
    let mut rows = CpuRows::new(&Arc::new(Hemicubes::new(scene, AUTO)));
    let rows = rows.draw_rows(0..scene.patch_count()).unwrap();
    let normal = |patch: u32| {
        let surface = scene.mesh().surface_of(PatchId(patch));
        scene.surface(surface).normal().as_vec3()
    };
    let (mut units, mut count) = (0.0, 0);
    for patch in (0..scene.patch_count()).filter(|&patch| from(normal(patch))) {
        let row = rows.row(patch as usize).iter();
        units += row
            .filter(|entry| to(normal(entry.source)))
            .map(|entry| f64::from(entry.units))
            .sum::<f64>();
        count += 1;
    }
    units / f64::from(UNITS_PER_ONE) / f64::from(count)
}

/// Opposite and adjacent walls of a cube, in closed form (Howell C-11 and C-14).
const OPPOSITE: f64 = 0.199_824_895_698;
const ADJACENT: f64 = 0.200_043_776_075;

/// Of two triangles a wall the points' rule leaves up to 0.06 percent (its error for 6 points), and
/// pixels 0.2 percent a hemicube, over 12 hemicubes and more 0.06: five times that is half a percent. Of
/// 128 triangles the pixels' part is 0.01 percent: a tenth of a percent.
#[test]
fn walls_of_a_cube_see_each_other_as_the_closed_forms_say() {
    for (max_area, tolerance) in [(f64::INFINITY, 5e-3), (1.0 / 127.0, 1e-3)] {
        let scene = dark(block(Vec3::ZERO, Vec3::ONE, false, 0), max_area);
        assert!(counts(&scene).iter().all(|&count| count < 40));
        let opposite = form_factor(&scene, |n| n.z > 0.5, |n| n.z < -0.5);
        let adjacent = form_factor(&scene, |n| n.z > 0.5, |n| n.x > 0.5);
        assert!((opposite / OPPOSITE - 1.0).abs() < tolerance, "{opposite}");
        assert!((adjacent / ADJACENT - 1.0).abs() < tolerance, "{adjacent}");
    }
}

/// The nearer, the more: one point 20 radii away (a patch's radius is three quarters of its legs), three
/// at 2 m, more where the gap is far narrower than the patches, and the most next to nothing.
#[test]
fn points_grow_in_number_as_a_plate_comes_near() {
    let most_at = |distance: f32| {
        let plates = [square(0.0, true), square(distance, false)].concat();
        counts(&dark(plates, f64::INFINITY))
            .into_iter()
            .max()
            .unwrap()
    };
    let found = [20.0, 2.0, 0.1, 1e-3].map(most_at);
    assert_eq!((found[0], found[1], found[3]), (1, 3, 96), "{found:?}");
    assert!(found[2] > 3 && found[2] <= 96, "{found:?}");
}

/// What is alone, or sees backs only, or continues its plane, has one point; the next facet of a sphere
/// of many does not ask for more either, though it touches.
#[test]
fn nothing_near_needs_one_point() {
    let alone = square(0.0, true).to_vec();
    let back = [square(0.0, true), square(0.3, true)].concat();
    for (name, surfaces) in [("alone", alone), ("back", back)] {
        let counts = counts(&dark(surfaces, 0.2));
        assert!(
            counts.iter().take(4).all(|&count| count == 1),
            "{name}: {counts:?}"
        );
    }
    // A shallow bowl: slopes of some degrees between its facets.
    let facet = |k: usize| {
        let at = |k: usize| {
            let (sin, cos) = (std::f32::consts::TAU * k as f32 / 48.0).sin_cos();
            Vec3::new(cos, sin, 0.05)
        };
        quad([Vec3::ZERO, at(k), at(k + 1), at(k + 1)], 0)[0]
    };
    let bowl: Vec<Surface> = (0..48).map(facet).collect();
    let counts = counts(&dark(bowl, f64::INFINITY));
    assert!(counts.iter().all(|&count| count == 1), "{counts:?}");
}

/// Across a gap of a fiftieth of a patch only what lies at its rim needs many points; the view factor between unit squares at
/// distance 1e-3 is 0.998006 (the closed form). What it lacks to 1, twice the gap, lies in a strip of the gap's width at the rim,
/// of which points see three quarters here; two thirds are asked for.
#[test]
fn only_the_rim_of_a_gap_needs_many_points() {
    let gap = 1e-3;
    let scene = dark([square(0.0, true), square(gap, false)].concat(), 1e-3);
    let counts = counts(&scene);
    let (mut rim, mut middle) = (Vec::new(), Vec::new());
    for (patch, &count) in (0..).map(PatchId).zip(&counts) {
        let corners = scene.patch(patch).corners;
        let is_rim = corners
            .iter()
            .any(|p| p.x.min(p.y).min(1.0 - p.x).min(1.0 - p.y) <= 0.0);
        if is_rim {
            rim.push(count);
        } else {
            middle.push(count);
        }
    }
    let mean = |counts: &[u32]| f64::from(counts.iter().sum::<u32>()) / counts.len() as f64;
    assert!(
        mean(&rim) > 48.0 && mean(&middle) < 16.0,
        "{}, {}",
        mean(&rim),
        mean(&middle)
    );
    let found = form_factor(&scene, |n| n.z > 0.0, |n| n.z < 0.0);
    assert!(
        (found - 0.998_006).abs() < 2.0 / 3.0 * f64::from(gap),
        "{found}"
    );
}
