//! The laws of the glTF import: what stands in for lights.

mod common;

use std::f64::consts::PI;

use common::gltf::{Gltf, painted, square};
use glam::DVec3;
use scene::import::{ImportOptions, ImportedModel};
use scene::{Rgb, Surface};
use serde_json::{Value, json};

fn told(model: &ImportedModel, words: &str) -> bool {
    let mut warnings = model.report.warnings.iter();
    warnings.any(|warning| warning.contains(words))
}

/// The square, and a light one metre above it.
fn lit(light: &Value) -> Gltf {
    let mut gltf = square(painted([0.5; 4]));
    gltf.json["extensionsUsed"] = json!(["KHR_lights_punctual"]);
    gltf.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [light]}});
    gltf.root(
        json!({"name": "bulb", "translation": [0.5, 0.5, 1], "scale": [3, 3, 3],
        "extensions": {"KHR_lights_punctual": {"light": 0}}}),
    );
    gltf
}

/// The surfaces of the light, their exitance and their area.
fn lamp(model: &ImportedModel) -> (Vec<Surface>, Rgb, f64) {
    let material = model.materials.iter().position(|m| m.name == "light bulb");
    let index = material.unwrap();
    let emission = model.materials[index].emission;
    assert_eq!(model.materials[index].reflectance, Rgb::ZERO);
    let surfaces = model.surfaces.iter().copied();
    let surfaces: Vec<Surface> = surfaces.filter(|s| s.material.index() == index).collect();
    let area = surfaces.iter().map(Surface::area).sum();
    (surfaces, emission, area)
}

/// Corners are f32: near 1, of triangles of half a radius, each side is wrong by this share of 1 cm at most.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64 / 0.01;

#[test]
fn a_point_light_is_a_sphere_of_power_4_pi_times_its_intensity() {
    for radius in [None, Some(0.1)] {
        let gltf = lit(
            &json!({"type": "point", "intensity": 7, "color": [1, 0.5, 0], "extras": {"a": 1}}),
        );
        let options = ImportOptions {
            light_radius: radius,
            ..ImportOptions::default()
        };
        let model = gltf.load_as(&options).unwrap();
        assert_eq!(model.objects, ["square", "bulb"]);
        let (surfaces, emission, area) = lamp(&model);
        assert_eq!(surfaces.len(), 80);
        for (channel, colour) in [(emission.x, 1.0), (emission.y, 0.5), (emission.z, 0.0)] {
            let power = f64::from(channel) * area;
            let expected = 4.0 * PI * 7.0 * colour;
            assert!(
                (power - expected).abs() <= ROUNDING * expected,
                "{power} {expected}"
            );
        }
        let centre = DVec3::new(0.5, 0.5, 1.0) - model.origin;
        let radius = radius.unwrap_or(0.01);
        for surface in surfaces {
            for corner in surface.corners {
                // The polyhedron has the area of the sphere, so its corners are a little outside.
                let ratio = corner.as_dvec3().distance(centre) / radius;
                assert!((1.0..1.05).contains(&ratio), "{ratio}");
            }
            assert!(surface.normal().dot(surface.corners[0].as_dvec3() - centre) > 0.0);
        }
        assert!(told(&model, "a candela taken as 1 W/sr"));
    }
}

#[test]
fn a_spot_light_is_a_disc_with_its_intensity_on_the_axis() {
    let mut gltf = lit(&json!({"type": "spot", "intensity": 3, "spot": {"outerConeAngle": 0.5}}));
    // A quarter turn about x points its axis, -z, at +y.
    let half = 0.5f64.sqrt();
    gltf.json["nodes"][1]["rotation"] = json!([half, 0, 0, half]);
    let model = gltf.load();
    let (surfaces, emission, area) = lamp(&model);
    // On the axis, I = M / pi times the area.
    let intensity = f64::from(emission.x) / PI * area;
    assert!((intensity - 3.0).abs() <= 3.0 * ROUNDING, "{intensity}");
    for surface in surfaces {
        assert!(surface.normal().dot(DVec3::Y) > 1.0 - ROUNDING);
    }
    assert!(told(&model, "outside of their cones"));
}

#[test]
fn lights_that_nothing_can_stand_in_for_are_named() {
    for (light, words) in [
        (
            json!({"type": "directional"}),
            "infinitely far away: \"bulb\"",
        ),
        (
            json!({"type": "point", "intensity": 0}),
            "without intensity are left out: \"bulb\"",
        ),
    ] {
        let model = lit(&light).load();
        assert_eq!(model.surfaces.len(), 2);
        assert!(told(&model, words), "{:?}", model.report);
    }
}
