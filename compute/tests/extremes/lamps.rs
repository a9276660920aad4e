//! Lamps with views of their own under the same conditions as the rest.

use std::sync::Arc;

use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::lamps::with_lamps;
use compute::polygon_form_factor::point_to_triangle;
use compute::rows::{RowBatch, UNITS_PER_ONE, Unseen};
use compute::settings::LampViews;
use glam::{DVec3, Vec3};
use scene::{Material, MaterialId, PatchId, Scene, Surface};

use super::{frame, settings};
use crate::common::methods::ROUNDING;
use crate::common::{self, block, material, quad, shaken};

const RESOLUTION: u32 = 32;

fn rows(scene: &Scene, views: LampViews) -> RowBatch {
    let hemicubes = Arc::new(Hemicubes::new(scene, settings(RESOLUTION)));
    let source = Box::new(CpuRows::new(&hemicubes));
    let mut rows = with_lamps(&hemicubes, views, source);
    rows.draw_rows(0..scene.patch_count()).unwrap()
}

/// A room with lamps on boxes and on the ceiling, with all lengths times a factor.
fn room(factor: f32) -> (Vec<Material>, Vec<Surface>, f64) {
    let room = common::colourful_room(0.8);
    let mut surfaces = shaken(room.surfaces().to_vec());
    for surface in &mut surfaces {
        surface.corners = surface.corners.map(|p| factor * p);
    }
    let area = 0.8 * f64::from(factor).powi(2);
    (room.materials().to_vec(), surfaces, area)
}

fn scaled(factor: f32) -> Scene {
    let (materials, surfaces, area) = room(factor);
    common::scene(materials, surfaces, area)
}

/// As without lamps: a power of two changes no digit.
#[test]
fn lamps_by_a_power_of_two_give_the_same_bits() {
    let one = rows(&scaled(1.0), LampViews::All);
    for exponent in [-40, -20, 20, 40] {
        let scene = scaled(2.0_f32.powi(exponent));
        assert!(rows(&scene, LampViews::All) == one, "2^{exponent}");
    }
}

/// As without lamps: what is outside a closed room changes no bit inside, be it a lamp or not.
#[test]
fn lamps_in_a_room_far_from_something_give_the_same_bits() {
    let (materials, surfaces, area) = room(1.0);
    let alone = common::scene(materials.clone(), surfaces.clone(), area);
    let expected = rows(&alone, LampViews::All);
    let depths: Vec<u32> = alone
        .mesh()
        .trees()
        .iter()
        .map(|tree| tree.depth)
        .chain([0; 12])
        .collect();
    for distance in [1e2, 1e4, 1e6] {
        for is_lamp in [false, true] {
            let mut surfaces = surfaces.clone();
            let (low, high) = (Vec3::splat(distance), Vec3::splat(1.1 * distance));
            surfaces.extend(block(low, high, true, if is_lamp { 2 } else { 0 }));
            let objects = vec!["all".to_owned()];
            let origin = DVec3::ZERO;
            let scene = Scene::new(materials.clone(), objects, surfaces, &depths, origin).unwrap();
            let found = rows(&scene, LampViews::All);
            let differing = (0..alone.patch_count() as usize)
                .filter(|&k| found.row(k) != expected.row(k))
                .count();
            assert_eq!(differing, 0, "{distance} m, lamp {is_lamp}");
        }
    }
}

/// Rows keep their sum to the unit: in a duct of emitting slivers, in a hall with a lamp of a centimetre,
/// between emitting plates that almost touch, and with one lamp over half of another.
#[test]
fn rows_with_extreme_lamps_sum_to_one() {
    let duct = block(Vec3::ZERO, Vec3::new(1.0, 1e-3, 1e-3), false, 1);
    let mut hall = block(Vec3::ZERO, Vec3::splat(100.0), false, 0);
    let corner = Vec3::new(31.0, 47.0, 13.0);
    hall.extend(block(corner, corner + Vec3::splat(0.01), true, 1));
    let plates = block(Vec3::ZERO, Vec3::new(1.0, 1.0, 1e-4), false, 1);
    let mut posters = block(Vec3::ZERO, Vec3::splat(4.0), false, 0);
    for low in [1.0, 1.5] {
        let at = |x: f32, y: f32| Vec3::new(low + x, low + y, 4.0);
        posters.extend(quad(
            [at(0.0, 0.0), at(0.0, 1.0), at(1.0, 1.0), at(1.0, 0.0)],
            1,
        ));
    }
    for (name, surfaces, max_area) in [
        ("duct", duct, f64::INFINITY),
        ("hall", hall, 200.0),
        ("plates", plates, 0.05),
        ("posters", posters, 0.5),
    ] {
        let materials = vec![material(0.5, 0.0), material(0.5, 1.0)];
        let scene = common::scene(materials, surfaces, max_area);
        for views in [LampViews::Auto, LampViews::All] {
            let rows = rows(&scene, views);
            for k in 0..scene.patch_count() as usize {
                super::assert_sums_to_one(&rows, k, &format!("{name} {views:?} {k}"));
                assert_eq!(rows.unseen(k), Unseen::default(), "{name} {views:?} {k}");
            }
        }
    }
}

/// The light of a lamp of a centimetre a hundred metres away is the exact form factor, which no hemicube
/// sees: 1e-4 m^2 / (pi 1e4 m^2) is 3e-9, where a pixel is 1e-3. Two entries are rounded to half of 2^-24
/// of themselves; view and formula are f64.
#[test]
fn a_centimetre_at_a_hundred_metres_is_exact() {
    let mut surfaces = block(Vec3::ZERO, Vec3::splat(100.0), false, 0);
    let at = |x: f32, y: f32| Vec3::new(50.0 + x, 50.0 + y, 99.0);
    surfaces.extend(quad(
        [at(0.0, 0.0), at(0.0, 0.01), at(0.01, 0.01), at(0.01, 0.0)],
        1,
    ));
    let materials = vec![material(0.5, 0.0), material(0.0, 1e6)];
    let scene = common::scene(materials, surfaces, 2000.0);
    let rows = rows(&scene, LampViews::Auto);
    let one = f64::from(UNITS_PER_ONE);
    let lamp = |s: &Surface| s.material == MaterialId(1);
    let lit: Vec<u32> = (0..scene.patch_count())
        .filter(|&k| lamp(scene.surface(scene.mesh().surface_of(PatchId(k)))))
        .collect();
    let mut seen = 0;
    for k in 0..scene.patch_count() {
        let frame = frame(&scene, k);
        // The lamp faces down.
        if frame.position.z > 98.0 {
            continue;
        }
        let exact: f64 = scene
            .surfaces()
            .iter()
            .filter(|s| lamp(s))
            .map(|s| {
                let corners = s.corners.map(|p| frame.to_local(p.as_dvec3()));
                point_to_triangle(corners)
            })
            .sum();
        let found: f64 = rows
            .row(k as usize)
            .iter()
            .filter(|e| lit.contains(&e.source))
            .map(|e| f64::from(e.units) / one)
            .sum();
        let error = (found - exact).abs();
        assert!(error <= ROUNDING * exact, "{k}: {found:e} {exact:e}");
        seen += usize::from(exact > 0.0);
    }
    assert!(seen > 10, "{seen}");
}
