//! The Cornell box against a minimal triangulation of the published data that was made elsewhere
//! (`data/cornell_coarse.obj`).

mod common;

use std::path::PathBuf;

use common::{Random, contains};
use genx::{Format, Model, Settings, make};
use scene::{Material, Rgb, Scene, Surface};

/// Corners are rounded to f32, by 2^-25 m below 1 m; both models are, in each of three coordinates,
/// and a distance to a side is stretched by at most 1 / sin of the flattest corner, about 4.
const ROUNDING: f64 = 2.0 * 1.732 * 4.0 / (1 << 25) as f64;

fn made(model: Model) -> Scene {
    let mut settings = Settings::new(model);
    settings.max_area = Some(f64::INFINITY);
    make(&settings).unwrap().scene
}

fn published() -> Scene {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/data/cornell_coarse.obj");
    let scene = made(Model::File {
        format: Format::Obj,
        path,
    });
    assert_eq!(scene.origin(), glam::DVec3::ZERO);
    scene
}

fn colours(scene: &Scene, surface: &Surface) -> (Rgb, Rgb) {
    let Material {
        reflectance,
        emission,
        ..
    } = scene.material(surface.material);
    (*reflectance, *emission)
}

/// Same front and same colours. Normals of f32 triangles of 0.03 m are good to 1e-6; the two halves
/// of the left wall differ by 6e-3.
fn alike(ours: (&Scene, &Surface), theirs: (&Scene, &Surface)) -> bool {
    ours.1.normal().distance(theirs.1.normal()) < 1e-4
        && colours(ours.0, ours.1) == colours(theirs.0, theirs.1)
}

#[test]
fn areas_facing_each_way_in_each_colour_are_the_published_ones() {
    let (ours, theirs) = (made(Model::Cornell), published());
    for surface in theirs.surfaces() {
        let area = |scene: &Scene| -> f64 {
            scene
                .surfaces()
                .iter()
                .filter(|s| alike((scene, s), (&theirs, surface)))
                .map(Surface::area)
                .sum()
        };
        let (a, b) = (area(&ours), area(&theirs));
        // Both areas are at most 0.6 m^2 with borders of at most 4 m, moved by rounding.
        assert!((a - b).abs() < 4.0 * ROUNDING, "{surface:?}: {a}, not {b}");
    }
    assert!((ours.area() - theirs.area()).abs() < 30.0 * ROUNDING);
}

#[test]
fn every_point_of_the_published_surfaces_lies_on_a_like_surface() {
    let (ours, theirs) = (made(Model::Cornell), published());
    let mut random = Random(5);
    for surface in theirs.surfaces() {
        for _ in 0..200 {
            let point = random.point_on(surface);
            let covering = ours
                .surfaces()
                .iter()
                .filter(|s| alike((&ours, s), (&theirs, surface)))
                .filter(|s| contains(s, point, ROUNDING))
                .count();
            assert!(covering >= 1, "{point} of {surface:?}");
        }
    }
}

#[test]
fn given_reflectance_leaves_the_light_and_given_power_keeps_its_colour() {
    let published = made(Model::Cornell);
    let settings = Settings {
        max_area: None,
        reflectance: Some(0.25),
        light_power: Some(10.0),
        ..Settings::new(Model::Cornell)
    };
    let scene = make(&settings).unwrap().scene;
    for (material, before) in scene.materials().iter().zip(published.materials()) {
        if before.is_emitter() {
            assert_eq!(material.reflectance, before.reflectance);
            assert_eq!(
                material.emission.max_element().to_bits(),
                10.0_f32.to_bits()
            );
            let ratio = material.emission / before.emission;
            // Each channel is rounded once, and so is the division above.
            assert!(
                ratio.max_element() - ratio.min_element() < 4.0 * f32::EPSILON * ratio.x,
                "{ratio}"
            );
        } else {
            assert_eq!(material.reflectance, Rgb::splat(0.25));
            assert_eq!(material.emission, Rgb::ZERO);
        }
    }
}
