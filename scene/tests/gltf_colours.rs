//! The laws of the glTF import: vertex colours.

mod common;

use common::gltf::{FLOAT, Gltf, U8, U16, painted, square};
use scene::Rgb;
use scene::import::{ImportOptions, ImportedModel};
use serde_json::{Value, json};

/// Colours are right to this share of themselves: they keep 12 bits behind the leading one, as means of textures.
const ROUNDING: f32 = 1.0 / 8192.0;

fn told(model: &ImportedModel, words: &str) -> bool {
    let mut warnings = model.report.warnings.iter();
    warnings.any(|warning| warning.contains(words))
}

/// The square with vertex colours.
fn coloured(material: Value, kind: &str, component: u32, normalized: bool, bytes: &[u8]) -> Gltf {
    let mut gltf = square(material);
    let view = gltf.view(bytes);
    let accessor = json!({"bufferView": view, "componentType": component, "normalized": normalized, "type": kind, "count": 4});
    let colours = gltf.push("accessors", accessor);
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(colours);
    gltf
}

/// The reflectance of each triangle.
fn reflectances(model: &ImportedModel) -> Vec<Rgb> {
    let surfaces = model.surfaces.iter();
    let of = |s: &scene::Surface| model.materials[s.material.index()].reflectance;
    surfaces.map(of).collect()
}

#[track_caller]
fn assert_near(found: Rgb, expected: [f32; 3]) {
    for (found, expected) in found.to_array().into_iter().zip(expected) {
        let is_near = (found - expected).abs() <= ROUNDING * expected;
        assert!(is_near, "{found} {expected}");
    }
}

/// Section 3.9.2: they are linear, and the base colour is multiplied by them; also white is, without a word of its 1.
#[test]
fn vertex_colours_multiply_the_base_colour_in_all_their_types() {
    let colours = [[51u8, 102, 255, 0]; 4].concat();
    let three: Vec<u8> = colours.chunks(4).flat_map(|c| c[..3].to_vec()).collect();
    let floats = |bytes: &[u8]| -> Vec<u8> {
        let values = bytes.iter().map(|&byte| f32::from(byte) / 255.0);
        values.flat_map(f32::to_le_bytes).collect()
    };
    let shorts: Vec<u8> = colours.iter().flat_map(|&byte| [byte, byte]).collect();
    for (kind, component, normalized, bytes) in [
        ("VEC4", U8, true, colours.clone()),
        ("VEC4", U16, true, shorts),
        ("VEC4", FLOAT, false, floats(&colours)),
        ("VEC3", FLOAT, false, floats(&three)),
    ] {
        for (base, factor) in [([1.0, 1.0, 0.5, 1.0], 1.0), ([0.5, 0.5, 0.25, 1.0], 0.5)] {
            let model = coloured(painted(base), kind, component, normalized, &bytes).load();
            for found in reflectances(&model) {
                assert_near(found, [0.2 * factor, 0.4 * factor, 0.5 * factor]);
            }
            assert_eq!(model.report.warnings, [""; 0], "{kind} {component}");
        }
    }
}

#[test]
fn a_triangle_has_the_mean_of_its_corners_colours() {
    let corners = [0.0f32, 0.25, 0.5, 0.75].map(|value| [value, 1.0, 7.0]);
    let bytes: Vec<u8> = corners
        .concat()
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let model = coloured(painted([0.5; 4]), "VEC3", FLOAT, false, &bytes).load();
    let found = reflectances(&model);
    // Beyond 1 they are 1.
    assert_near(found[0], [0.5 * 0.25, 0.5, 0.5]);
    assert_near(found[1], [0.5 * (1.25 / 3.0), 0.5, 0.5]);
}

#[test]
fn vertex_colours_leave_emission_and_given_reflectances() {
    let dark = [0u8; 16];
    let mut lamp = painted([0.5; 4]);
    lamp["emissiveFactor"] = json!([1, 1, 1]);
    let model = coloured(lamp, "VEC4", U8, true, &dark).load();
    assert_eq!(
        model.materials[0].emission,
        Rgb::splat(std::f32::consts::PI)
    );
    assert_eq!(model.materials[0].reflectance, Rgb::ZERO);
    let options = ImportOptions {
        reflectance: Some(0.25),
        ..ImportOptions::default()
    };
    let gltf = coloured(painted([0.5; 4]), "VEC4", U8, true, &dark);
    let model = gltf.load_as(&options).unwrap();
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.25));
    let white = [255u8; 16];
    let model = coloured(painted([1.0; 4]), "VEC4", U8, true, &white).load();
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.95));
    assert!(told(&model, "its base colour 1 1 1 is taken as 0.95"));
}

/// A scan has nothing but them: they are its reflectance, and not half of it.
#[test]
fn without_a_material_vertex_colours_are_the_reflectance() {
    let dark = [51u8; 16];
    let mut gltf = coloured(json!({}), "VEC4", U8, true, &dark);
    let primitive = gltf.json["meshes"][0]["primitives"][0].as_object_mut();
    primitive.unwrap().remove("material");
    let model = gltf.load();
    assert_near(model.materials[0].reflectance, [0.2; 3]);
    assert_eq!(model.report.warnings, [""; 0]);
    let options = ImportOptions {
        reflectance: Some(0.25),
        ..ImportOptions::default()
    };
    let model = gltf.load_as(&options).unwrap();
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.25));
}
