//! What glTF forbids is refused by what it is, and what it allows is taken.

mod common;

use common::checked_message;
use common::gltf::{Container, FLOAT, Gltf, SQUARE, U8, U16, U32, painted, square};
use scene::gltf::load;
use scene::import::ImportedModel;
use serde_json::{Value, json};

type Change = fn(&mut Gltf);

fn sound() -> Gltf {
    square(painted([0.5; 4]))
}

#[track_caller]
fn refused(gltf: &Gltf, words: &[&str]) {
    let folder = common::folder();
    let path = gltf.write(&folder, Container::Binary);
    let message = checked_message(&load(&path).unwrap_err(), &path);
    for word in words {
        assert!(message.contains(word), "{word} is missing in {message}");
    }
}

#[track_caller]
fn each_refused(cases: &[(Change, &[&str])]) {
    for (change, words) in cases {
        let mut gltf = sound();
        change(&mut gltf);
        refused(&gltf, words);
    }
}

fn told(model: &ImportedModel, words: &str) -> bool {
    let mut warnings = model.report.warnings.iter();
    warnings.any(|warning| warning.contains(words))
}

/// Sections 3.6.2.2 and 3.7.2.1: floats and 32-bit integers are no fractions, and attributes have the types of a table.
#[test]
fn components_that_an_attribute_cannot_have_are_refused() {
    each_refused(&[
        (
            |g| g.json["accessors"][0]["normalized"] = json!(true),
            &["accessors[0]", "F32 with normalized true"],
        ),
        (
            |g| g.json["accessors"][0]["componentType"] = json!(U32),
            &["accessors[0]", "U32 with normalized false"],
        ),
        (
            |g| {
                let indices = g.indices(U32, &[0, 1, 2]);
                g.json["accessors"][indices]["normalized"] = json!(true);
                g.json["meshes"][0]["primitives"][0]["indices"] = json!(indices);
            },
            &["accessors[2]", "U32 with normalized true"],
        ),
        (
            |g| {
                let view = g.view(&[0; 64]);
                let normals =
                    json!({"bufferView": view, "componentType": U8, "type": "VEC3", "count": 4});
                let normals = g.push("accessors", normals);
                g.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
            },
            &["accessors[2]", "U8 with normalized false"],
        ),
    ]);
}

/// Section 3.6.2.4.
#[test]
fn strides_are_multiples_of_a_component() {
    each_refused(&[(
        |g| {
            g.view(&[0; 80]);
            g.json["bufferViews"][0]["byteStride"] = json!(13);
            g.json["bufferViews"][0]["byteLength"] = json!(60);
        },
        &["accessors[0]", "byteStride 13", "4 bytes of a component"],
    )]);
}

/// Section 3.6.2.3.
#[test]
fn sparse_indices_increase() {
    for indices in [[2u8, 2], [3, 1]] {
        let mut gltf = sound();
        let indices = gltf.view(&indices);
        let values = gltf.view(&[0; 24]);
        gltf.json["accessors"][0]["sparse"] = json!({"count": 2,
            "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
        refused(&gltf, &["accessors[0].sparse", "indices have to increase"]);
    }
}

/// Section 3.7.2.1.
#[test]
fn the_largest_number_of_its_type_is_no_index() {
    for (component, largest) in [(U8, 255), (U16, 65535), (U32, u32::MAX)] {
        let mut gltf = Gltf::new();
        let positions = gltf.floats(&vec![[0.0f32; 3]; 1 << 16]);
        let indices = gltf.indices(component, &[0, 1, largest]);
        let primitive = json!({"attributes": {"POSITION": positions}, "indices": indices});
        gltf.push("meshes", json!({"primitives": [primitive]}));
        gltf.root(json!({"mesh": 0}));
        refused(
            &gltf,
            &[
                "accessors[1]",
                &format!("element 2 is {largest}"),
                "no index",
            ],
        );
    }
}

#[test]
fn indices_beyond_32_bits_are_no_others() {
    let wide = 1u64 << 32;
    for place in [
        "nodes/0/mesh",
        "scene",
        "meshes/0/primitives/0/mode",
        "meshes/0/primitives/0/indices",
    ] {
        let mut gltf = sound();
        let member = gltf.json.pointer_mut(&format!("/{place}"));
        let told = place.replace("/0", "[0]").replace('/', ".");
        match member {
            Some(member) => *member = json!(wide),
            None => gltf.json["meshes"][0]["primitives"][0]["mode"] = json!(wide + 4),
        }
        refused(&gltf, &[&told, "4294967"]);
    }
    // Numbers that are no indices may be so large.
    let mut gltf = sound();
    gltf.json["nodes"][0]["scale"] = json!([wide, wide, wide]);
    assert_eq!(gltf.load().surfaces.len(), 2);
}

/// Sections 3.5.2 and 3.5.3.
#[test]
fn nodes_are_trees_and_have_one_transform() {
    each_refused(&[
        (
            |g| {
                g.json["nodes"][0]["children"] = json!([1]);
                g.push("nodes", json!({"children": [0]}));
                g.json.as_object_mut().unwrap().remove("scenes");
                g.json.as_object_mut().unwrap().remove("scene");
            },
            &["nodes[0] \"square\"", "below itself"],
        ),
        (
            |g| {
                g.push("nodes", json!({"children": [2]}));
                g.push("nodes", json!({"children": [1]}));
            },
            &["nodes[1]", "below itself"],
        ),
        (
            |g| {
                g.push("nodes", json!({"children": [3]}));
                g.push("nodes", json!({"children": [3]}));
                g.push("nodes", json!({}));
            },
            &["nodes[3]", "two parents, nodes[1] and nodes[2]"],
        ),
        (
            |g| {
                g.push("nodes", json!({"children": [0]}));
            },
            &["nodes[0] \"square\"", "in the scene and below nodes[1]"],
        ),
        (
            |g| g.json["scenes"][0]["nodes"] = json!([0, 0]),
            &["nodes[0] \"square\"", "twice"],
        ),
        (
            |g| {
                g.json["nodes"][0]["matrix"] =
                    json!([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
                g.json["nodes"][0]["scale"] = json!([3, 3, 3]);
            },
            &["nodes[0] \"square\"", "matrix beside"],
        ),
    ]);
}

#[test]
fn what_the_format_allows_is_taken() {
    let sampler = json!([{"input": 0, "output": 0}]);
    let pointer = json!({"path": "pointer", "extensions": {"KHR_animation_pointer": {"pointer": "/materials/0/emissiveFactor"}}});
    let cases: [(&str, Value); 3] = [
        ("scenes", json!([{"nodes": [0]}, {"name": "empty"}])),
        (
            "animations",
            json!([{"samplers": sampler, "channels": [{"sampler": 0, "target": pointer}]}]),
        ),
        ("cameras", json!([{"type": "of another kind"}])),
    ];
    for (member, value) in cases {
        let mut gltf = sound();
        gltf.json[member] = value;
        gltf.json["nodes"][0]["camera"] = json!(0);
        assert_eq!(gltf.load().surfaces.len(), 2, "{member}");
    }
}

/// Section 3.7.2.1: such primitives should be skipped.
#[test]
fn primitives_without_positions_are_left_out_and_told() {
    for mode in [4, 0] {
        let mut gltf = sound();
        let primitives = gltf.json["meshes"][0]["primitives"].as_array_mut().unwrap();
        primitives.push(json!({"attributes": {"NORMAL": 0}, "mode": mode}));
        let model = gltf.load();
        assert_eq!(model.surfaces.len(), 2);
        let words = [
            "primitives of points or lines (1)",
            "primitives without POSITION (1)",
        ][usize::from(mode == 4)];
        assert!(told(&model, words), "{:?}", model.report);
    }
}

/// Section 3.6.2.3: an accessor without a view and without replacements is of zeros.
#[test]
fn accessors_without_bytes_are_zero() {
    let mut gltf = sound();
    let normals = json!({"componentType": FLOAT, "type": "VEC3", "count": 4});
    let normals = gltf.push("accessors", normals);
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
    assert_eq!(gltf.load().surfaces.len(), 2);
}

/// Normals of what has two fronts, coordinates without a texture, joints without a skin, buffers without a view.
#[test]
fn what_is_not_used_is_not_checked() {
    let mut material = painted([0.5; 4]);
    material["doubleSided"] = json!(true);
    let mut gltf = square(material);
    let normals = gltf.floats(&[[f32::NAN, 0.0, 0.0]; 4]);
    let coordinates = gltf.floats(&[[f32::NAN, 0.0]; 3]);
    let attributes = &mut gltf.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["NORMAL"] = json!(normals);
    attributes["TEXCOORD_0"] = json!(coordinates);
    attributes["JOINTS_0"] = json!(coordinates);
    attributes["WEIGHTS_0"] = json!(coordinates);
    gltf.push("buffers", json!({"uri": "nowhere.bin", "byteLength": 9}));
    assert_eq!(gltf.load().surfaces.len(), 4);
}

/// Many buffers of one file, which is read and told once.
#[test]
fn a_file_of_several_buffers_is_read_once() {
    let folder = common::folder();
    let path = sound().write(&folder, Container::ExternalFile);
    let mut json: Value = serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    let buffer = json["buffers"][0].clone();
    json["buffers"].as_array_mut().unwrap().push(buffer);
    json["bufferViews"][1]["buffer"] = json!(1);
    let model = load(&common::write(&folder, "a.gltf", json.to_string())).unwrap();
    assert_eq!(model.surfaces.len(), 2);
    assert_eq!(model.files, [folder.path().join("the buffer.bin")]);
}

#[test]
fn sparse_elements_are_found_wherever_they_are() {
    for replaced in [&[0u8][..], &[1, 2], &[3], &[0, 1, 2, 3], &[0, 3]] {
        let mut gltf = sound();
        let indices = gltf.view(replaced);
        let corners = replaced.iter().flat_map(|&k| {
            let [x, y, _] = SQUARE[usize::from(k)];
            [x, y, f32::from(k) + 1.0]
        });
        let values: Vec<u8> = corners.flat_map(f32::to_le_bytes).collect();
        let values = gltf.view(&values);
        gltf.json["accessors"][0]["sparse"] = json!({"count": replaced.len(),
            "indices": {"bufferView": indices, "componentType": U8}, "values": {"bufferView": values}});
        let model = gltf.load();
        let heights =
            |s: &scene::Surface| s.corners.map(|corner| f64::from(corner.z) + model.origin.z);
        let found: Vec<f64> = model.surfaces.iter().flat_map(heights).collect();
        let height = |k: u8| {
            if replaced.contains(&k) {
                f64::from(k) + 1.0
            } else {
                0.0
            }
        };
        assert_eq!(found, [0, 1, 2, 0, 2, 3].map(height), "{replaced:?}");
    }
}
