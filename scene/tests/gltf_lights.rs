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

/// The square, and lights with their nodes.
fn with_lights(lights: &[(Value, Value)]) -> Gltf {
    let mut gltf = square(painted([0.5; 4]));
    let of_file: Vec<&Value> = lights.iter().map(|(light, _)| light).collect();
    gltf.json["extensions"] = json!({"KHR_lights_punctual": {"lights": of_file}});
    for (k, (_, node)) in lights.iter().enumerate() {
        let mut node = node.clone();
        node["extensions"] = json!({"KHR_lights_punctual": {"light": k}});
        gltf.root(node);
    }
    gltf
}

/// The triangles of an object.
fn of_object<'a>(model: &'a ImportedModel, name: &str) -> Vec<&'a Surface> {
    let surfaces = model.surfaces.iter();
    let found: Vec<_> = surfaces
        .filter(|s| model.objects[s.object.index()] == name)
        .collect();
    assert!(!found.is_empty(), "{name} in {:?}", model.objects);
    found
}

/// W, of some surfaces.
fn power<'a>(model: &ImportedModel, surfaces: impl IntoIterator<Item = &'a Surface>) -> DVec3 {
    let of = |s: &Surface| s.area() * model.materials[s.material.index()].emission.as_dvec3();
    surfaces.into_iter().map(of).sum()
}

#[track_caller]
fn assert_power(found: DVec3, expected: DVec3) {
    let off = (found - expected).abs() - ROUNDING * expected;
    assert!(off.max_element() <= 0.0, "{found} {expected}");
}

fn point(colour: [f64; 3]) -> Value {
    json!({"type": "point", "intensity": 1, "color": colour})
}

fn spot() -> Value {
    json!({"type": "spot", "intensity": 1, "spot": {}})
}

#[test]
fn point_lights_at_one_place_are_one_sphere_of_all_their_power() {
    let at = |name: &str, x: f64| json!({"name": name, "translation": [x, 0.5, 1]});
    let model = with_lights(&[
        (point([1.0; 3]), at("a", 0.5)),
        (point([1.0, 0.0, 0.0]), at("b", 0.5)),
        (point([0.0, 0.0, 1.0]), at("c", 0.51)),
        (point([0.0, 1.0, 0.0]), at("d", 0.6)),
    ])
    .load();
    assert_eq!(model.objects, ["square", "a", "d"]);
    assert_power(
        power(&model, of_object(&model, "a")),
        4.0 * PI * DVec3::new(2.0, 1.0, 2.0),
    );
    assert_power(power(&model, of_object(&model, "d")), 4.0 * PI * DVec3::Y);
    assert!(
        told(&model, "\"b\" with \"a\", \"c\" with \"a\""),
        "{:?}",
        model.report
    );
    assert_eq!(model.report.repeated_dropped, 0);
}

/// How far away from a place corners are, metres.
fn distances(model: &ImportedModel, name: &str, place: DVec3) -> Vec<f64> {
    let corners = of_object(model, name).into_iter().flat_map(|s| s.corners);
    corners
        .map(|c| (c.as_dvec3() + model.origin).distance(place))
        .collect()
}

/// Each disc is outside of the sphere, and in front of no other disc: all of its light leaves.
#[test]
fn discs_among_other_bodies_stand_ahead_of_them() {
    let half = 0.5f64.sqrt();
    let place = DVec3::new(0.5, 0.5, 1.0);
    let at = |name: &str, rotation: [f64; 4]| json!({"name": name, "translation": place.to_array(), "rotation": rotation});
    let down = [0.0, 0.0, 0.0, 1.0];
    let model = with_lights(&[
        (spot(), at("down", down)),
        (point([1.0; 3]), at("bulb", down)),
        (spot(), at("also down", down)),
        (spot(), at("aside", [0.0, half, 0.0, half])),
    ])
    .load();
    assert_eq!(model.objects, ["square", "down", "bulb", "aside"]);
    assert_power(
        power(&model, of_object(&model, "bulb")),
        4.0 * PI * DVec3::ONE,
    );
    assert_power(
        power(&model, of_object(&model, "down")),
        2.0 * PI * DVec3::ONE,
    );
    assert_power(power(&model, of_object(&model, "aside")), PI * DVec3::ONE);
    let farthest = distances(&model, "bulb", place)
        .into_iter()
        .fold(0.0, f64::max);
    for name in ["down", "aside"] {
        assert!(
            distances(&model, name, place).iter().all(|&d| d > farthest),
            "{name}"
        );
    }
    let discs = ["down", "aside"].map(|name| of_object(&model, name));
    for [disc, other] in [[&discs[0], &discs[1]], [&discs[1], &discs[0]]] {
        let front = disc[0].normal();
        let height = |p: glam::Vec3| (p - disc[0].corners[0]).as_dvec3().dot(front);
        assert!(
            other
                .iter()
                .flat_map(|s| s.corners)
                .all(|corner| height(corner) < 0.0)
        );
    }
    assert!(
        told(&model, "ahead of these: \"down\", \"aside\""),
        "{:?}",
        model.report
    );
}

/// Lights all along a line, closer than their bodies are wide.
#[test]
fn a_strip_of_lights_keeps_its_power_and_its_bodies_are_apart() {
    let lights: Vec<(Value, Value)> = (0..100)
        .map(|k| {
            (
                point([1.0; 3]),
                json!({"name": format!("{k}"), "translation": [0.009 * f64::from(k), 0, 1]}),
            )
        })
        .collect();
    let model = with_lights(&lights).load();
    let lit = model.surfaces.iter().filter(|s| s.object.index() > 0);
    assert_power(power(&model, lit), 400.0 * PI * DVec3::ONE);
    let range = |name: &String| {
        let along = of_object(&model, name)
            .into_iter()
            .flat_map(|s| s.corners)
            .map(|c| c.x);
        along.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], x| {
            [low.min(x), high.max(x)]
        })
    };
    let ranges: Vec<[f32; 2]> = model.objects[1..].iter().map(range).collect();
    assert!(ranges.len() > 30 && ranges.windows(2).all(|pair| pair[0][1] < pair[1][0]));
}

#[test]
fn lamps_of_blender_are_told_to_be_too_bright_perhaps() {
    for (generator, light, is_told) in [
        ("Khronos glTF Blender I/O v4.2.60", point([1.0; 3]), true),
        (
            "Khronos glTF Blender I/O v4.2.60",
            json!({"type": "directional"}),
            false,
        ),
        ("another program", point([1.0; 3]), false),
    ] {
        let mut gltf = lit(&light);
        gltf.json["asset"]["generator"] = json!(generator);
        assert_eq!(
            told(&gltf.load(), "683 times too bright"),
            is_told,
            "{generator}"
        );
    }
}

#[test]
fn directional_lights_are_left_out_whatever_their_intensity() {
    for intensity in [json!(-1), json!(1e36)] {
        let model = lit(&json!({"type": "directional", "intensity": intensity})).load();
        assert!(told(&model, "infinitely far away: \"bulb\""));
    }
}

#[test]
fn radii_that_bodies_cannot_have_are_errors() {
    let load = |radius| {
        let options = ImportOptions {
            light_radius: Some(radius),
            ..ImportOptions::default()
        };
        let error = lit(&point([1.0; 3])).load_as(&options).unwrap_err();
        error.to_string()
    };
    for radius in [0.0, -0.01, f64::INFINITY, f64::NAN] {
        let message = load(radius);
        assert!(
            message.contains(&format!("light radius {radius} m is not")),
            "{message}"
        );
    }
    // The exitance would be no number, or none of single precision.
    for radius in [1e30, 1e-30] {
        let message = load(radius);
        assert!(
            message.contains("light \"bulb\"") && message.contains("--light-radius"),
            "{message}"
        );
    }
}

#[test]
fn a_node_with_a_mesh_and_a_light_is_two_objects_without_a_word() {
    let mut gltf = square(painted([0.5; 4]));
    gltf.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [point([1.0; 3])]}});
    gltf.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
    let model = gltf.load();
    assert_eq!(model.objects, ["square", "square.light"]);
    assert!(!told(&model, "several nodes"), "{:?}", model.report);
}
