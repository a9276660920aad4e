//! Nothing makes the glTF import panic, and what it accepts is a scene.

mod common;

use common::gltf::{FLOAT, Gltf, U8, glb, painted, png, square};
use common::{folder, write};
use proptest::collection::vec;
use proptest::prelude::*;
use scene::Scene;
use scene::gltf::load;
use scene::import::{ImportOptions, ImportedModel};
use serde_json::{Value, json};

/// A small file with everything in it.
fn everything() -> (Value, Vec<u8>) {
    let mut material = painted([0.5, 0.6, 1.0, 0.9]);
    material["pbrMetallicRoughness"]["baseColorTexture"] =
        json!({"index": 0, "extensions": {"KHR_texture_transform": {"rotation": 1}}});
    material["emissiveFactor"] = json!([1, 0, 0]);
    material["emissiveTexture"] = json!({"index": 0});
    material["doubleSided"] = json!(true);
    let mut gltf = square(material);
    let view = gltf.view(&png(1, 2, &[[255, 0, 0], [0, 99, 0]]));
    gltf.push(
        "images",
        json!({"bufferView": view, "mimeType": "image/png"}),
    );
    gltf.push("samplers", json!({"wrapS": 33071}));
    gltf.push("textures", json!({"source": 0, "sampler": 0}));
    let coordinates = gltf.floats(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let normals = gltf.floats(&[[0.0, 0.0, 1.0]; 4]);
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    let indices = gltf.view(&[3]);
    let values = gltf.view(&[0; 12]);
    gltf.json["accessors"][normals]["sparse"] = json!({"count": 1,
        "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
    gltf.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
    gltf.root(json!({"rotation": [0, 0, 1, 0], "children": [2], "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    gltf.push("nodes", json!({"mesh": 0, "scale": [1, 2, -3]}));
    let moved = gltf.floats(&[[0.0, 0.0, 1.0]; 4]);
    let colours = gltf.floats(&[[0.5, 1.0, 0.25]; 4]);
    let joints = gltf.view(&[0, 1, 0, 0].repeat(4));
    let joints = json!({"bufferView": joints, "componentType": U8, "type": "VEC4", "count": 4});
    let joints = gltf.push("accessors", joints);
    let weights = gltf.floats(&[[0.5, 0.5, 0.0, 0.0]; 4]);
    let matrix = [
        1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.5, 0.0, 1.0f32,
    ];
    let matrices: Vec<u8> = matrix
        .repeat(2)
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let matrices = gltf.view(&matrices);
    let matrices =
        json!({"bufferView": matrices, "componentType": FLOAT, "type": "MAT4", "count": 2});
    let matrices = gltf.push("accessors", matrices);
    gltf.push(
        "skins",
        json!({"joints": [1, 2], "inverseBindMatrices": matrices}),
    );
    gltf.json["nodes"][2]["skin"] = json!(0);
    let primitive = &mut gltf.json["meshes"][0]["primitives"][0];
    primitive["targets"] = json!([{"POSITION": moved, "NORMAL": moved}]);
    primitive["attributes"]["COLOR_0"] = json!(colours);
    primitive["attributes"]["JOINTS_0"] = json!(joints);
    primitive["attributes"]["WEIGHTS_0"] = json!(weights);
    gltf.json["meshes"][0]["weights"] = json!([0.25]);
    gltf.push("animations", json!({"channels": [], "samplers": []}));
    gltf.json["buffers"][0]["byteLength"] = json!(gltf.buffer.len());
    (gltf.json, gltf.buffer)
}

/// Loads, and makes a scene of what was accepted. True if something was.
fn import(folder: &tempfile::TempDir, bytes: &[u8]) -> bool {
    let path = write(folder, "a.glb", bytes);
    let model: ImportedModel = match load(&path) {
        Ok(model) => model,
        Err(error) => {
            assert!(error.to_string().starts_with(path.to_str().unwrap()));
            return false;
        }
    };
    assert!(model.materials.iter().all(|m| m.validate().is_ok()));
    let scene: Scene = model.into_scene(f64::INFINITY).unwrap();
    assert!(!scene.surfaces().is_empty());
    true
}

#[test]
fn the_file_with_everything_is_sound() {
    let (json, buffer) = everything();
    assert!(import(&folder(), &glb(&json, &buffer)));
}

#[test]
fn truncation_at_every_length_is_an_error() {
    let folder = folder();
    let (json, buffer) = everything();
    let file = glb(&json, &buffer);
    for length in 0..file.len() {
        assert!(!import(&folder, &file[..length]), "{length}");
    }
    let text = json.to_string();
    for length in 0..text.len() {
        assert!(!import(&folder, &text.as_bytes()[..length]), "{length}");
    }
}

#[test]
fn truncation_of_each_part_never_panics() {
    let folder = folder();
    let (json, buffer) = everything();
    for length in (0..buffer.len()).step_by(4) {
        assert!(!import(&folder, &glb(&json, &buffer[..length])), "{length}");
    }
}

/// What takes the place of a number in the JSON.
const NUMBERS: [&str; 12] = [
    "0",
    "1",
    "2",
    "3",
    "4",
    "255",
    "65536",
    "4294967295",
    "18446744073709551615",
    "-1",
    "1e300",
    "0.5",
];

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(3000) })]

    #[test]
    fn changed_bytes_never_panic(changes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..4)) {
        let (json, buffer) = everything();
        let mut file = glb(&json, &buffer);
        for (at, value) in changes {
            let at = at.index(file.len());
            file[at] = value;
        }
        import(&folder(), &file);
    }

    #[test]
    fn changed_numbers_never_panic(changes in vec((any::<prop::sample::Index>(), 0..NUMBERS.len()), 1..4)) {
        let (json, buffer) = everything();
        let mut text = json.to_string();
        for (which, value) in changes {
            let starts: Vec<usize> = text
                .match_indices(|c: char| c.is_ascii_digit())
                .map(|(at, _)| at)
                .filter(|&at| b":[,-".contains(&text.as_bytes()[at - 1]))
                .collect();
            let start = starts[which.index(starts.len())];
            let rest = &text[start..];
            let end = rest.find(|c: char| !(c.is_ascii_digit() || ".e-+".contains(c))).unwrap();
            text.replace_range(start..start + end, NUMBERS[value]);
        }
        let Ok(changed) = serde_json::from_str(&text) else { return Ok(()) };
        import(&folder(), &glb(&changed, &buffer));
    }

    #[test]
    fn any_bytes_never_panic(bytes in vec(any::<u8>(), 0..200), is_binary in any::<bool>()) {
        let mut file = if is_binary { b"glTF\x02\0\0\0".to_vec() } else { b"{".to_vec() };
        file.extend(bytes);
        import(&folder(), &file);
    }
}

#[test]
fn options_of_all_kinds_take_the_file_with_everything() {
    let (json, buffer) = everything();
    let gltf = Gltf { json, buffer };
    let options = ImportOptions {
        reflectance: Some(0.25),
        light_radius: Some(0.5),
        ..ImportOptions::default()
    };
    assert!(gltf.load_as(&options).is_ok());
}
