//! The laws of the glTF import: what surfaces reflect and emit.

mod common;

use std::f64::consts::PI;

use base64::Engine;
use common::gltf::{Gltf, SQUARE, painted, png, square};
use common::{folder, write};
use scene::import::{ImportOptions, ImportedModel};
use scene::{Rgb, srgb};
use serde_json::{Value, json};

/// Means are right to this share of themselves: they keep 12 bits behind the leading one.
const ROUNDING_OF_MEANS: f32 = 1.0 / 8192.0;

fn told(model: &ImportedModel, words: &str) -> bool {
    let mut warnings = model.report.warnings.iter();
    warnings.any(|warning| warning.contains(words))
}

#[test]
fn base_colour_is_the_reflectance_and_only_used_materials_are_kept() {
    let mut gltf = square(painted([0.25, 0.5, 0.75, 1.0]));
    gltf.push(
        "materials",
        json!({"name": "unused", "normalTexture": {"index": 0}}),
    );
    gltf.push("textures", json!({}));
    let model = gltf.load();
    assert_eq!(model.materials.len(), 1);
    assert_eq!(model.materials[0].name, "paint");
    assert_eq!(model.materials[0].reflectance, Rgb::new(0.25, 0.5, 0.75));
    assert_eq!(model.report.warnings, [""; 0]);
}

#[test]
fn white_is_limited_and_told_and_the_options_decide() {
    let gltf = square(painted([1.0, 1.0, 0.5, 1.0]));
    let model = gltf.load();
    assert_eq!(model.materials[0].reflectance, Rgb::new(0.95, 0.95, 0.5));
    assert!(told(
        &model,
        "its base colour 1 1 0.5 is taken as 0.95 0.95 0.5"
    ));
    let options = ImportOptions {
        max_reflectance: Some(0.25),
        ..ImportOptions::default()
    };
    let model = gltf.load_as(&options).unwrap();
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.25));
    let options = ImportOptions {
        reflectance: Some(0.125),
        ..ImportOptions::default()
    };
    let model = gltf.load_as(&options).unwrap();
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.125));
    assert_eq!(model.report.warnings, [""; 0]);
}

#[test]
fn without_a_material_faces_are_grey_and_that_is_told() {
    let mut gltf = square(json!({}));
    let primitive = gltf.json["meshes"][0]["primitives"][0].as_object_mut();
    primitive.unwrap().remove("material");
    let model = gltf.load();
    assert_eq!(model.materials[0].name, "default");
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.5));
    assert!(told(&model, "no material"));
}

#[test]
fn optical_properties_that_are_left_out_are_told_once_a_material() {
    for (material, words) in [
        (json!({}), &["metallicFactor 1"][..]),
        (
            json!({"pbrMetallicRoughness": {"metallicFactor": 0.5, "metallicRoughnessTexture": {"index": 0}}}),
            &["metallicFactor 0.5 times its texture"],
        ),
        (
            json!({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 0, 0.5], "metallicFactor": 0}}),
            &["alphaMode BLEND with alpha 0.5"],
        ),
        (
            json!({"normalTexture": {"index": 0}, "extensions": {"KHR_materials_transmission": {"transmissionFactor": 1},
                   "KHR_materials_clearcoat": {}, "KHR_materials_unlit": {}}}),
            &[
                "normalTexture",
                "KHR_materials_transmission",
                "KHR_materials_clearcoat",
                "KHR_materials_unlit",
            ],
        ),
    ] {
        let mut gltf = square(material);
        gltf.push("textures", json!({}));
        let model = gltf.load();
        let lines: Vec<&String> = model
            .report
            .warnings
            .iter()
            .filter(|warning| warning.contains("left out"))
            .collect();
        assert_eq!(lines.len(), 1, "{:?}", model.report);
        for word in words {
            assert!(lines[0].contains(word), "{word}: {}", lines[0]);
        }
    }
}

#[test]
fn wholly_transparent_materials_leave_their_faces_out() {
    for (mode, alpha) in [("BLEND", 0.0), ("MASK", 0.25)] {
        let mut gltf = square(painted([0.5, 0.5, 0.5, alpha]));
        gltf.json["materials"][0]["alphaMode"] = json!(mode);
        let error = gltf.load_as(&ImportOptions::default()).unwrap_err();
        let message = error.to_string();
        assert!(
            message.contains("all 2 triangles have materials that are wholly transparent"),
            "{message}"
        );
        gltf.push("materials", painted([0.5; 4]));
        let mut primitive = gltf.json["meshes"][0]["primitives"][0].clone();
        primitive["material"] = json!(1);
        gltf.push("meshes", json!({"primitives": [primitive]}));
        gltf.root(json!({"mesh": 1}));
        let model = gltf.load();
        assert_eq!(model.surfaces.len(), 2);
        assert!(
            told(&model, "wholly transparent (alpha"),
            "{:?}",
            model.report
        );
    }
    // The mode OPAQUE has no alpha.
    assert_eq!(square(painted([0.0; 4])).load().surfaces.len(), 2);
}

#[test]
fn specular_glossiness_gives_its_diffuse_colour() {
    let model = square(json!({"extensions": {"KHR_materials_pbrSpecularGlossiness":
        {"diffuseFactor": [0.1, 0.2, 0.3, 1]}}}))
    .load();
    assert_eq!(model.materials[0].reflectance, Rgb::new(0.1, 0.2, 0.3));
    assert!(told(&model, "KHR_materials_pbrSpecularGlossiness"));
}

#[test]
fn emission_is_pi_times_factor_times_strength() {
    let mut material = painted([0.5; 4]);
    material["emissiveFactor"] = json!([1, 0.5, 0]);
    let emission = |material: &Value| square(material.clone()).load().materials[0].emission;
    let pi = std::f32::consts::PI;
    assert_eq!(emission(&material), Rgb::new(pi, 0.5 * pi, 0.0));
    material["extensions"] = json!({"KHR_materials_emissive_strength": {"emissiveStrength": 20}});
    assert_eq!(emission(&material), Rgb::new(20.0 * pi, 10.0 * pi, 0.0));
}

/// Where a file has its picture.
#[derive(Clone, Copy, Debug)]
enum Place {
    View,
    DataUri,
    File,
}

/// The square with texture coordinates that put the picture on it upright, and a picture of two rows: red above green.
fn textured(place: Place, material: Value) -> (Gltf, Vec<u8>) {
    let picture = png(1, 2, &[[255, 0, 0], [0, 255, 0]]);
    let mut gltf = square(material);
    let coordinates = gltf.floats(&SQUARE.map(|[x, y, _]| [x, 1.0 - y]));
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    let image = match place {
        Place::View => json!({"bufferView": gltf.view(&picture), "mimeType": "image/png"}),
        Place::DataUri => {
            let data = base64::prelude::BASE64_STANDARD.encode(&picture);
            json!({"uri": format!("data:image/png;base64,{data}")})
        }
        Place::File => json!({"uri": "a%20picture.png"}),
    };
    gltf.push("images", image);
    gltf.push("textures", json!({"source": 0}));
    (gltf, picture)
}

fn load_in_folder(gltf: &Gltf, picture: &[u8]) -> ImportedModel {
    let folder = folder();
    write(&folder, "a picture.png", picture);
    let path = gltf.write(&folder, common::gltf::Container::Binary);
    let mut model = scene::gltf::load(&path).unwrap();
    for file in &mut model.files {
        *file = file.strip_prefix(folder.path()).unwrap().to_owned();
    }
    model
}

const IN_COLOUR: &str = r#"{"pbrMetallicRoughness":
    {"baseColorFactor": [0.5, 0.5, 0.5, 1], "metallicFactor": 0, "baseColorTexture": {"index": 0}}}"#;

#[test]
fn textures_count_with_their_mean_wherever_they_are() {
    for place in [Place::View, Place::DataUri, Place::File] {
        let (gltf, picture) = textured(place, serde_json::from_str(IN_COLOUR).unwrap());
        let model = load_in_folder(&gltf, &picture);
        assert_eq!(model.report.warnings, [""; 0], "{place:?}");
        // Of the lower right triangle of the square three quarters are green, of the other one red.
        for (surface, share) in model.surfaces.iter().zip([0.25, 0.75]) {
            let Rgb { x, y, z } = model.materials[surface.material.index()].reflectance;
            for (found, expected) in [(x, share), (y, 1.0 - share), (z, 0.0)] {
                assert!(
                    (found - 0.5 * expected).abs() <= ROUNDING_OF_MEANS * expected,
                    "{found} {expected}"
                );
            }
        }
        let files: Vec<_> = model.files.iter().map(|f| f.to_str().unwrap()).collect();
        let expected: &[&str] = match place {
            Place::File => &["a picture.png"],
            _ => &[],
        };
        assert_eq!(files, expected, "{place:?}");
    }
}

#[test]
fn textures_are_decoded_from_srgb() {
    let mut gltf = textured(Place::View, serde_json::from_str(IN_COLOUR).unwrap()).0;
    let view = gltf.view(&png(1, 1, &[[128, 128, 128]]));
    gltf.json["images"][0]["bufferView"] = json!(view);
    let found = gltf.load().materials[0].reflectance.x;
    let expected = 0.5 * srgb::decode(128.0 / 255.0);
    assert!(
        (found - expected).abs() <= ROUNDING_OF_MEANS * expected,
        "{found} {expected}"
    );
}

#[test]
fn texture_coordinates_are_transformed_and_wrapped() {
    // The red upper row alone, then the green lower one.
    for (transform, sampler, red) in [
        (
            json!({"scale": [1, 0], "offset": [0, 0.25]}),
            json!({}),
            1.0,
        ),
        (
            json!({"scale": [1, 0], "offset": [0, 0.75]}),
            json!({}),
            0.0,
        ),
        (
            json!({"scale": [1, 0], "offset": [0, 1.25]}),
            json!({}),
            1.0,
        ),
        (
            json!({"scale": [1, 0], "offset": [0, 1.25]}),
            json!({"wrapT": 33648}),
            0.0,
        ),
        (
            json!({"scale": [1, 0], "offset": [0, -9.5]}),
            json!({"wrapT": 33071}),
            1.0,
        ),
        (
            json!({"scale": [1, 0], "offset": [0, 9.5]}),
            json!({"wrapT": 33071}),
            0.0,
        ),
        // A quarter turn counter-clockwise brings u to -v.
        (
            json!({"scale": [0.25, 0], "rotation": -0.5 * PI, "extras": "x"}),
            json!({}),
            1.0,
        ),
        (
            json!({"scale": [0.25, 0], "rotation": 0.5 * PI}),
            json!({}),
            0.0,
        ),
        (json!({"texCoord": 1}), json!({}), 0.0),
    ] {
        let material = serde_json::from_str(IN_COLOUR).unwrap();
        let (mut gltf, picture) = textured(Place::View, material);
        let second = gltf.floats(&[[0.5, 0.75]; 4]);
        gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_1"] = json!(second);
        gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"] =
            json!({"KHR_texture_transform": transform});
        gltf.push("samplers", sampler.clone());
        gltf.json["textures"][0]["sampler"] = json!(0);
        let model = load_in_folder(&gltf, &picture);
        assert_eq!(model.materials.len(), 1, "{transform}");
        let found = model.materials[0].reflectance;
        let expected = 0.5 * Rgb::new(red, 1.0 - red, 0.0);
        assert_eq!(found, expected, "{transform} {sampler}");
    }
}

#[test]
fn emissive_textures_shine_where_they_are_bright() {
    let mut material: Value = serde_json::from_str(IN_COLOUR).unwrap();
    let metallic = material["pbrMetallicRoughness"].as_object_mut().unwrap();
    metallic.remove("baseColorTexture");
    material["emissiveFactor"] = json!([1, 1, 1]);
    material["emissiveTexture"] = json!({"index": 0,
        "extensions": {"KHR_texture_transform": {"scale": [1, 0], "offset": [0, 0.25]}}});
    let (mut gltf, picture) = textured(Place::View, material);
    let model = load_in_folder(&gltf, &picture);
    assert_eq!(
        model.materials[0].emission,
        Rgb::new(std::f32::consts::PI, 0.0, 0.0)
    );
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.5));
    // Without the picture nobody knows what shines.
    let broken = gltf.view(b"no picture");
    gltf.json["images"][0]["bufferView"] = json!(broken);
    let model = load_in_folder(&gltf, &picture);
    assert_eq!(model.materials[0].emission, Rgb::ZERO);
    assert!(told(&model, "is left out"), "{:?}", model.report);
}

#[test]
fn pictures_that_cannot_be_had_are_told_once_and_leave_the_factor() {
    let material: Value = serde_json::from_str(IN_COLOUR).unwrap();
    let mut missing = textured(Place::File, material.clone()).0;
    missing.json["images"][0]["uri"] = json!("nowhere.png");
    let mut without_source = textured(Place::View, material).0;
    without_source.json["textures"][0] = json!({"extensions": {"EXT_texture_webp": {"source": 0}}});
    for (gltf, words) in [
        (missing, "nowhere.png"),
        (without_source, "no picture in PNG or JPEG"),
    ] {
        let model = gltf.load();
        assert_eq!(model.materials[0].reflectance, Rgb::splat(0.5));
        assert_eq!(model.report.warnings.len(), 1, "{:?}", model.report);
        assert!(told(&model, words), "{:?}", model.report);
    }
}

#[test]
fn what_is_repainted_is_not_told_to_be_white() {
    let options = ImportOptions {
        repainted: vec!["paint".to_owned()],
        ..ImportOptions::default()
    };
    let model = square(painted([1.0; 4])).load_as(&options).unwrap();
    assert_eq!(model.report.warnings, [""; 0]);
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.95));
}

/// One warning for each property that is lost, which says what is there in its place.
#[test]
fn textures_without_coordinates_are_told_by_what_they_leave() {
    let mut material: Value = serde_json::from_str(IN_COLOUR).unwrap();
    material["emissiveFactor"] = json!([1, 1, 1]);
    material["emissiveTexture"] = json!({"index": 0});
    let mut gltf = textured(Place::View, material).0;
    let primitive = &mut gltf.json["meshes"][0]["primitives"][0];
    primitive["attributes"]
        .as_object_mut()
        .unwrap()
        .remove("TEXCOORD_0");
    let model = gltf.load();
    assert_eq!(model.materials[0].emission, Rgb::ZERO);
    assert_eq!(model.report.warnings.len(), 2, "{:?}", model.report);
    assert!(told(
        &model,
        "there it has reflectance [0.5, 0.5, 0.5] instead of"
    ));
    assert!(told(&model, "there nothing is emitted instead of"));
}
