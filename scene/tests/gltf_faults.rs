//! What the glTF import refuses, and what it says.

mod common;

use common::gltf::{Container, Gltf, U8, U32, painted, png, square};
use common::{checked_message, folder, write};
use scene::gltf::{GltfFault, load};
use serde_json::{Value, json};

fn sound() -> Gltf {
    square(painted([0.5; 4]))
}

/// The message of what is refused, without the file's name.
#[track_caller]
fn refused(gltf: &Gltf) -> String {
    let folder = folder();
    let path = gltf.write(&folder, Container::Binary);
    let error = load(&path).unwrap_err();
    checked_message(&error, &path)
}

/// What a change of the sound file is refused with.
#[track_caller]
fn refused_with(change: impl FnOnce(&mut Gltf)) -> String {
    let mut gltf = sound();
    change(&mut gltf);
    refused(&gltf)
}

#[track_caller]
fn assert_told(message: &str, words: &[&str]) {
    for word in words {
        assert!(message.contains(word), "{word} is missing in {message}");
    }
}

#[test]
fn files_that_are_no_gltf_are_refused_by_what_they_are() {
    for (contents, words) in [
        (&b""[..], "empty"),
        (b"v 0 0 0", "starts neither with \"glTF\""),
        (b"glTF", "4 bytes"),
        (b"{", "JSON"),
        (b"{\"asset\": {}}", "version"),
        (
            b"{\"asset\": {\"version\": \"1.0\"}, \"nodes\": {}}",
            "version 1.0",
        ),
        (
            b"{\"asset\": {\"version\": \"2.1\", \"minVersion\": \"2.1\"}}",
            "version 2.1",
        ),
        (b"{\"asset\": {\"version\": \"2.0\"}}", "no node"),
        (
            b"\xEF\xBB\xBF {\"asset\": {\"version\": \"2.0\"}, \"nodes\": 1}",
            "nodes: invalid type",
        ),
        (b"glTF\x01\0\0\0\x0c\0\0\0", "version 1"),
        (b"glTF\x02\0\0\0\x0c\0\0\0", "not JSON"),
        (b"glTF\x02\0\0\0\0\0\0\0", "not JSON"),
        (b"glTF\x02\0\0\0\xff\0\0\0", "header says 255"),
        (
            b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON",
            "chunk at byte 12",
        ),
    ] {
        let folder = folder();
        let path = write(&folder, "a.glb", contents);
        let message = checked_message(&load(&path).unwrap_err(), &path);
        assert_told(&message, &[words]);
    }
    let missing = folder().path().join("none.glb");
    assert_told(
        &checked_message(&load(&missing).unwrap_err(), &missing),
        &["cannot read"],
    );
}

#[test]
fn required_extensions_that_are_not_known_are_named_with_a_remedy() {
    for (extension, remedy) in [
        (
            "KHR_draco_mesh_compression",
            "export the model without compression",
        ),
        (
            "EXT_meshopt_compression",
            "export the model without compression",
        ),
        ("KHR_texture_basisu", "as PNG or JPEG"),
        ("ACME_thing", "export the model without it"),
    ] {
        let message = refused_with(|gltf| gltf.json["extensionsRequired"] = json!([extension]));
        assert_told(&message, &[extension, remedy]);
    }
}

#[test]
fn buffers_that_are_missing_or_short_are_named() {
    let in_folder = |change: &dyn Fn(&mut Value)| {
        let folder = folder();
        let path = sound().write(&folder, Container::ExternalFile);
        let mut json: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        change(&mut json["buffers"][0]);
        let path = write(&folder, "a.gltf", json.to_string());
        checked_message(&load(&path).unwrap_err(), &path)
    };
    let message = in_folder(&|buffer| buffer["uri"] = json!("nowhere.bin"));
    assert_told(
        &message,
        &["buffers[0]", "nowhere.bin", "put it beside the model"],
    );
    let message = in_folder(&|buffer| buffer["byteLength"] = json!(1000));
    assert_told(
        &message,
        &["buffers[0]", "1000 bytes", "the buffer.bin", "holds 60"],
    );
    let message = in_folder(&|buffer| buffer["uri"] = json!("data:;base64,AAAA"));
    assert_told(&message, &["buffers[0]", "60 bytes", "holds 3"]);
    let message = in_folder(&|buffer| buffer["uri"] = json!("data:;base64,A*AA"));
    assert_told(&message, &["buffers[0]", "base64"]);
    let message = in_folder(&|buffer| buffer["uri"] = json!("https://example.org/a.bin"));
    assert_told(&message, &["buffers[0]", "https", "beside the model"]);
    let message = in_folder(&|buffer| {
        buffer.as_object_mut().unwrap().remove("uri");
    });
    assert_told(&message, &["buffers[0]", "no URI"]);
}

type Change = fn(&mut Gltf);

#[test]
fn wrong_accessors_and_views_are_named_with_their_values() {
    let cases: [(Change, &[&str]); 15] = [
        (
            |g| g.json["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = json!(9),
            &["meshes[0].primitives[0]", "accessor 9", "has 2"],
        ),
        (
            |g| g.json["meshes"][0]["primitives"][0]["indices"] = json!(9),
            &["meshes[0].primitives[0].indices", "nothing of this index"],
        ),
        (
            |g| g.json["meshes"][0]["primitives"][0]["material"] = json!(9),
            &["meshes[0].primitives[0].material"],
        ),
        (
            |g| g.json["meshes"][0]["primitives"][0]["indices"] = json!(0),
            &["accessors[0]", "Vec3", "Scalar"],
        ),
        (
            |g| g.json["accessors"][0]["count"] = json!(5),
            &["accessors[0]", "5 elements", "bufferViews[0]"],
        ),
        (
            |g| g.json["accessors"][0]["count"] = json!(u64::MAX),
            &["accessors[0]"],
        ),
        (
            |g| g.json["accessors"][1]["count"] = json!(4_000_000_000u32),
            &["accessors[1]", "4000000000 elements"],
        ),
        (
            |g| g.json["accessors"][0]["byteOffset"] = json!(u64::MAX),
            &["accessors[0]", "beyond"],
        ),
        (
            |g| g.json["accessors"][0]["componentType"] = json!(7),
            &["accessors[0].componentType"],
        ),
        (
            |g| g.json["accessors"][1]["componentType"] = json!(5126),
            &["accessors[1]"],
        ),
        (
            |g| g.json["accessors"][1]["count"] = json!(5),
            &["meshes[0].primitives[0]", "5 corners"],
        ),
        (
            |g| g.json["bufferViews"][0]["byteStride"] = json!(8),
            &["accessors[0]", "byteStride 8", "12 bytes"],
        ),
        (
            |g| g.json["bufferViews"][0]["byteLength"] = json!(1_000_000),
            &["bufferViews[0]", "1000000 bytes", "buffers[0]"],
        ),
        (
            |g| g.json["bufferViews"][0]["byteOffset"] = json!(u64::MAX),
            &["bufferViews[0]"],
        ),
        (
            |g| g.json["bufferViews"][0]["buffer"] = json!(3),
            &["bufferViews[0].buffer"],
        ),
    ];
    for (change, words) in cases {
        assert_told(&refused_with(change), words);
    }
}

#[test]
fn indices_and_counts_that_do_not_fit_are_named() {
    let message = refused_with(|gltf| {
        let indices = gltf.indices(U32, &[0, 1, 4_000_000_000]);
        gltf.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
    });
    assert_told(
        &message,
        &["accessors[2]", "element 2", "4000000000", "4 vertices"],
    );
    for (semantic, is_normal) in [("NORMAL", true), ("TEXCOORD_0", false)] {
        let message = refused_with(|gltf| {
            let short = if is_normal {
                gltf.floats(&[[0.0, 0.0, 1.0]; 3])
            } else {
                gltf.floats(&[[0.0, 0.0]; 3])
            };
            let view = gltf.view(&png(1, 1, &[[9; 3]]));
            gltf.push("images", json!({"bufferView": view}));
            gltf.push("textures", json!({"source": 0}));
            gltf.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] =
                json!({"index": 0});
            gltf.json["meshes"][0]["primitives"][0]["attributes"][semantic] = json!(short);
        });
        assert_told(&message, &["accessors[2]", "3 elements", "4 vertices"]);
    }
}

#[test]
fn sparse_accessors_that_do_not_fit_are_named() {
    for (count, index, words) in [(9, 0, "9 elements"), (1, 4, "index 4 is out of range")] {
        let message = refused_with(|gltf| {
            let indices = gltf.view(&[index; 16]);
            let values = gltf.view(&[0; 200]);
            gltf.json["accessors"][0]["sparse"] = json!({"count": count,
                "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
        });
        assert_told(&message, &["accessors[0].sparse", words]);
    }
    // No buffer holds the elements, and no memory is taken for them.
    let message = refused_with(|gltf| {
        let accessor = gltf.json["accessors"][0].as_object_mut().unwrap();
        accessor.remove("bufferView");
        gltf.json["accessors"][0]["count"] = json!(u64::from(u32::MAX));
        let empty = gltf.view(&[]);
        gltf.json["accessors"][0]["sparse"] = json!({"count": 0,
            "indices": {"bufferView": empty, "componentType": U8}, "values": {"bufferView": empty}});
        let primitive = &mut gltf.json["meshes"][0]["primitives"][0];
        primitive.as_object_mut().unwrap().remove("indices");
    });
    assert_told(&message, &["triangles", "the limit is 16777215"]);
}

#[test]
fn values_that_are_not_finite_are_named() {
    for value in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let message =
            refused_with(|gltf| gltf.buffer[12..16].copy_from_slice(&value.to_le_bytes()));
        assert_told(
            &message,
            &[
                "accessors[0]",
                "element 1",
                &value.to_string(),
                "not finite",
            ],
        );
    }
    let message = refused_with(|gltf| {
        gltf.json["nodes"][0]["scale"] = json!([1e300, 1, 1]);
    });
    assert_told(
        &message,
        &["nodes[0].scale[0]", "1e300", "single precision"],
    );
    let message = refused_with(|gltf| {
        let nodes = gltf.json["nodes"].as_array_mut().unwrap();
        nodes.extend((0..9).map(|k| json!({"scale": [3e38, 1, 1], "children": [k]})));
        gltf.json["scenes"][0]["nodes"] = json!([9]);
    });
    assert_told(&message, &["nodes[1]", "not finite"]);
}

#[test]
fn nodes_that_are_no_tree_or_have_no_transform_are_named() {
    let cases: [(Change, &[&str]); 6] = [
        (
            |g| g.json["nodes"][0]["children"] = json!([0]),
            &["nodes[0] \"square\"", "below itself"],
        ),
        (
            |g| {
                g.root(json!({"children": [0]}));
            },
            &["nodes[0] \"square\"", "two parents"],
        ),
        (
            |g| g.json["nodes"][0]["children"] = json!([7]),
            &["nodes[0].children[0]"],
        ),
        (
            |g| g.json["nodes"][0]["mesh"] = json!(7),
            &["nodes[0].mesh"],
        ),
        (
            |g| g.json["nodes"][0]["rotation"] = json!([0, 0, 0, 0]),
            &["nodes[0] \"square\"", "no quaternion"],
        ),
        (
            |g| {
                g.json["nodes"][0]["matrix"] =
                    json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
            },
            &["nodes[0] \"square\"", "last row"],
        ),
    ];
    for (change, words) in cases {
        assert_told(&refused_with(change), words);
    }
}

#[test]
fn materials_and_lights_out_of_range_are_named() {
    let cases: [(Change, &[&str]); 7] = [
        (
            |g| g.json["materials"][0] = painted([-0.5, 0.0, 0.0, 1.0]),
            &["\"paint\"", "red reflectance -0.5"],
        ),
        (
            |g| g.json["materials"][0]["emissiveFactor"] = json!([0, -1, 0]),
            &["\"paint\"", "green emission -3.14"],
        ),
        (
            |g| g.json["materials"][0]["emissiveFactor"] = json!([3e38, 0, 0]),
            &["\"paint\"", "red emission inf"],
        ),
        (
            |g| g.json["materials"][0]["alphaMode"] = json!("GLASS"),
            &["materials[0].alphaMode"],
        ),
        (
            |g| g.json["materials"][0]["emissiveTexture"] = json!({"index": 3}),
            &["materials[0].emissiveTexture"],
        ),
        (
            |g| g.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}}),
            &["nodes[0].extensions.KHR_lights_punctual.light"],
        ),
        (
            |g| {
                g.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point", "intensity": -1}]}});
                g.json["nodes"][0]["extensions"] = json!({"KHR_lights_punctual": {"light": 0}});
            },
            &["nodes[0] \"square\"", "intensity -1"],
        ),
    ];
    for (change, words) in cases {
        let message = refused_with(change).replace("khrLightsPunctual", "KHR_lights_punctual");
        assert_told(&message, words);
    }
}

#[test]
fn a_light_whose_power_rounding_changes_is_an_error() {
    let message = refused_with(|gltf| {
        gltf.json["extensions"] = json!({"KHR_lights_punctual": {"lights": [{"type": "point"}]}});
        gltf.json["nodes"][0]["scale"] = json!([1e9, 1e9, 1]);
        gltf.root(json!({"name": "bulb", "translation": [3e8, 0, 1], "extensions": {"KHR_lights_punctual": {"light": 0}}}));
    });
    assert_told(&message, &["light \"bulb\"", "--light-radius"]);
}

#[test]
fn what_has_no_triangles_is_an_error() {
    let message = refused_with(|gltf| gltf.json["scenes"][0]["nodes"] = json!([]));
    assert_told(&message, &["no node of the scene has triangles"]);
    let message = refused_with(|gltf| gltf.json["nodes"][0]["scale"] = json!([0, 0, 0]));
    assert_told(&message, &["all 2 triangles are degenerate"]);
}

#[test]
fn more_triangles_than_a_scene_may_have_are_an_error_before_they_are_read() {
    let mut gltf = Gltf::new();
    let positions = gltf.floats(&vec![[0.0f32; 3]; 3 * 1024]);
    let primitive = json!({"attributes": {"POSITION": positions}});
    gltf.push("meshes", json!({"primitives": vec![primitive; 64]}));
    for _ in 0..1000 {
        gltf.root(json!({"mesh": 0}));
    }
    let folder = folder();
    let error = load(&gltf.write(&folder, Container::Binary)).unwrap_err();
    assert!(matches!(error.fault, GltfFault::TooManyTriangles { .. }));
}
