//! The laws of the glTF import: geometry.

mod common;

use common::gltf::{Container, Gltf, SQUARE, U8, U16, U32, painted, square};
use common::{folder, write};
use glam::{DMat4, DQuat, DVec3};
use scene::import::{ImportOptions, ImportedModel, Orient};
use scene::{Axis, ModelAxes, Surface};
use serde_json::{Value, json};

/// The corners of a unit cube and its faces, counter-clockwise from outside.
const CORNERS: [[f32; 3]; 8] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, 0.0, 1.0],
    [1.0, 0.0, 1.0],
    [1.0, 1.0, 1.0],
    [0.0, 1.0, 1.0],
];
const FACES: [[u32; 3]; 12] = [
    [0, 2, 1],
    [0, 3, 2],
    [4, 5, 6],
    [4, 6, 7],
    [0, 1, 5],
    [0, 5, 4],
    [1, 2, 6],
    [1, 6, 5],
    [2, 3, 7],
    [2, 7, 6],
    [3, 0, 4],
    [3, 4, 7],
];

fn cube() -> Gltf {
    let mut gltf = Gltf::new();
    let positions = gltf.floats(&CORNERS);
    let indices = gltf.indices(U16, &FACES.concat());
    let material = gltf.push("materials", painted([0.2, 0.4, 0.6, 1.0]));
    gltf.push(
        "meshes",
        json!({"name": "cube", "primitives": [{"attributes": {"POSITION": positions}, "indices": indices, "material": material}]}),
    );
    gltf.root(json!({"mesh": 0}));
    gltf
}

/// Corners in the model's coordinates.
fn triangles(model: &ImportedModel) -> Vec<[DVec3; 3]> {
    let place = |s: &Surface| s.corners.map(|corner| corner.as_dvec3() + model.origin);
    model.surfaces.iter().map(place).collect()
}

#[test]
fn a_cube_is_the_same_as_obj_and_in_all_containers() {
    let vertices = CORNERS.map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = FACES.map(|[a, b, c]| format!("f {} {} {}\n", a + 1, b + 1, c + 1));
    let (vertices, faces) = (vertices.concat(), faces.concat());
    let obj = format!("mtllib a.mtl\no cube\nusemtl paint\n{vertices}{faces}");
    let folder = folder();
    write(&folder, "a.mtl", "newmtl paint\nKd 0.2 0.4 0.6\n");
    let expected = scene::obj::load(&write(&folder, "a.obj", obj)).unwrap();
    for container in Container::ALL {
        let found = scene::gltf::load(&cube().write(&folder, container)).unwrap();
        assert_eq!(found.surfaces, expected.surfaces, "{container:?}");
        assert_eq!(found.materials, expected.materials, "{container:?}");
        assert_eq!(found.objects, expected.objects, "{container:?}");
        assert_eq!(found.origin, expected.origin, "{container:?}");
        assert_eq!(found.report, expected.report, "{container:?}");
        let files = match container {
            Container::ExternalFile => vec![folder.path().join("the buffer.bin")],
            _ => vec![],
        };
        assert_eq!(found.files, files, "{container:?}");
    }
}

#[test]
fn y_is_up_and_metres_are_the_unit_unless_the_options_say_otherwise() {
    let axes = |unit, up| ModelAxes { unit, up: Some(up) };
    assert_eq!(cube().load().axes, axes(1.0, Axis::Y));
    let options = ImportOptions {
        axes: axes(0.001, Axis::Z),
        ..ImportOptions::default()
    };
    let model = cube().load_as(&options).unwrap();
    assert_eq!(model.axes, options.axes);
    let area: f64 = model.surfaces.iter().map(Surface::area).sum();
    assert!((area - 6e-6).abs() < 1e-12, "{area}");
}

/// The square, drawn in some mode.
fn drawn(mode: u32, indices: Option<(u32, &[u32])>, positions: &[[f32; 3]]) -> ImportedModel {
    let mut gltf = Gltf::new();
    let positions = gltf.floats(positions);
    let mut primitive = json!({"attributes": {"POSITION": positions}, "mode": mode});
    if let Some((component, indices)) = indices {
        primitive["indices"] = json!(gltf.indices(component, indices));
    }
    gltf.push("meshes", json!({"primitives": [primitive]}));
    gltf.root(json!({"mesh": 0, "name": "square"}));
    gltf.load()
}

#[test]
fn indices_of_all_types_and_none_give_the_same_triangles() {
    let list: Vec<[f32; 3]> = [0, 1, 2, 0, 2, 3].map(|k: usize| SQUARE[k]).to_vec();
    let expected = drawn(4, None, &list);
    assert_eq!(expected.surfaces.len(), 2);
    for component in [U8, U16, U32] {
        let found = drawn(4, Some((component, &[0, 1, 2, 0, 2, 3])), &SQUARE);
        assert_eq!(found.surfaces, expected.surfaces);
    }
}

#[test]
fn strips_and_fans_have_the_triangles_of_the_list_and_all_fronts_on_one_side() {
    // A strip goes zigzag, a fan around.
    let zigzag: Vec<[f32; 3]> = (0..6u8)
        .map(|k| [f32::from(k / 2), f32::from(k % 2), 0.0])
        .collect();
    for indices in [None, Some((U8, &[0, 1, 2, 3, 4, 5][..]))] {
        let strip = drawn(5, indices, &zigzag);
        let listed = [0, 1, 2, 1, 3, 2, 2, 3, 4, 3, 5, 4];
        let list = drawn(4, Some((U8, &listed)), &zigzag);
        assert_eq!(strip.surfaces, list.surfaces);
        assert!(strip.surfaces.iter().all(|s| s.normal() == DVec3::NEG_Z));
    }
    let fan = drawn(6, None, &SQUARE);
    let list = drawn(4, Some((U8, &[1, 2, 0, 2, 3, 0])), &SQUARE);
    assert_eq!(fan.surfaces, list.surfaces);
    assert!(fan.surfaces.iter().all(|s| s.normal() == DVec3::Z));
}

#[test]
fn points_and_lines_are_left_out_and_told() {
    let mut gltf = square(painted([0.5; 4]));
    for mode in 0..4 {
        let primitives = gltf.json["meshes"][0]["primitives"].as_array_mut().unwrap();
        primitives.push(json!({"attributes": {"POSITION": 0}, "mode": mode}));
    }
    let model = gltf.load();
    assert_eq!(model.surfaces.len(), 2);
    assert_eq!(model.report.points_and_lines_ignored, 4);
    assert!(told(&model, "points or lines (4)"), "{:?}", model.report);
}

fn told(model: &ImportedModel, words: &str) -> bool {
    model
        .report
        .warnings
        .iter()
        .any(|warning| warning.contains(words))
}

#[test]
fn transforms_are_those_of_the_node_and_all_above_it() {
    let rotation = DQuat::from_rotation_z(0.3) * DQuat::from_rotation_x(-1.1);
    let outer = DMat4::from_scale_rotation_translation(
        DVec3::new(2.0, 3.0, 0.5),
        rotation,
        DVec3::new(1.0, -2.0, 5.0),
    );
    let inner = DMat4::from_cols_array_2d(&[
        [1.0, 0.25, 0.0, 0.0],
        [0.0, 2.0, 0.5, 0.0],
        [0.0, 0.0, 1.5, 0.0],
        [7.0, 8.0, 9.0, 1.0],
    ]);
    let matrix = |matrix: DMat4| json!({"matrix": matrix.to_cols_array()});
    let trs =
        json!({"translation": [1, -2, 5], "rotation": rotation.to_array(), "scale": [2, 3, 0.5]});
    for outer_node in [matrix(outer), trs] {
        let mut gltf = square(painted([0.5; 4]));
        gltf.json["nodes"][0]["matrix"] = json!(inner.to_cols_array());
        let mut node = outer_node;
        node["children"] = json!([0]);
        gltf.json["scenes"][0]["nodes"] = json!([]);
        gltf.root(node);
        let model = gltf.load();
        let expected = [0, 1, 2, 0, 2, 3].map(|k: usize| {
            let corner = DVec3::from(SQUARE[k].map(f64::from));
            (outer * inner).transform_point3(corner)
        });
        for (found, expected) in triangles(&model).concat().iter().zip(expected) {
            // Rotations in the file and corners in the scene are f32: a few roundings of values up to 32.
            assert!(found.distance(expected) < 32.0 * 8.0 * f64::from(f32::EPSILON));
        }
    }
}

#[test]
fn a_mirror_leaves_fronts_where_they_are() {
    for scale in [[-1, 1, 1], [1, -1, 1], [-1, -1, -1]] {
        let mut gltf = cube();
        gltf.json["nodes"][0]["scale"] = json!(scale);
        let model = gltf.load();
        let centre = 0.5 * DVec3::from(scale.map(f64::from));
        for [a, b, c] in triangles(&model) {
            let normal = (b - a).cross(c - a);
            assert!(normal.dot(a - centre) > 0.0, "{scale:?}");
        }
    }
}

#[test]
fn nodes_without_size_leave_triangles_out_and_are_told() {
    let mut gltf = square(painted([0.5; 4]));
    gltf.root(json!({"mesh": 0, "name": "flat", "scale": [0, 1, 1]}));
    let model = gltf.load();
    assert_eq!(
        (model.surfaces.len(), model.report.degenerate_dropped),
        (2, 2)
    );
    assert!(
        told(&model, "triangle 1 of object \"flat\""),
        "{:?}",
        model.report
    );
    assert_eq!(model.objects, ["square"]);
}

#[test]
fn sparse_accessors_replace_elements_with_and_without_a_base() {
    for has_base in [true, false] {
        let mut gltf = square(painted([0.5; 4]));
        let (indices, corners) = if has_base {
            (&[2u8][..], &[[5.0f32, 6.0, 0.0]][..])
        } else {
            (&[0u8, 2][..], &[[0.0f32, 1.0, 0.0], [5.0, 6.0, 0.0]][..])
        };
        let indices = gltf.view(indices);
        let bytes = corners.as_flattened().iter();
        let bytes: Vec<u8> = bytes.flat_map(|v| v.to_le_bytes()).collect();
        let values = gltf.view(&bytes);
        let accessor = &mut gltf.json["accessors"][0];
        accessor["sparse"] = json!({
            "count": corners.len(),
            "indices": {"bufferView": indices, "componentType": U8},
            "values": {"bufferView": values},
        });
        if !has_base {
            accessor.as_object_mut().unwrap().remove("bufferView");
            // All corners but two are at zero, so that one triangle is left.
            gltf.json["meshes"][0]["primitives"][0]["mode"] = json!(5);
            let strip = gltf.indices(U8, &[0, 1, 2]);
            gltf.json["meshes"][0]["primitives"][0]["indices"] = json!(strip);
        }
        let model = gltf.load();
        let [a, b, c] = triangles(&model)[0];
        assert_eq!(c, DVec3::new(5.0, 6.0, 0.0));
        let first = if has_base { DVec3::ZERO } else { DVec3::Y };
        let second = if has_base { DVec3::X } else { DVec3::ZERO };
        assert_eq!([a, b], [first, second]);
    }
}

#[test]
fn quantized_positions_are_read_as_integers_and_as_fractions() {
    for (normalized, side) in [(false, 255.0), (true, 1.0)] {
        let mut gltf = square(painted([0.5; 4]));
        let corners = SQUARE.map(|corner| corner.map(|x| if x > 0.0 { 255 } else { 0 }));
        let bytes: Vec<u8> = corners.iter().flat_map(|&[x, y, z]| [x, y, z, 0]).collect();
        let view = gltf.view(&bytes);
        gltf.json["bufferViews"][view]["byteStride"] = json!(4);
        let accessor = &mut gltf.json["accessors"][0];
        accessor["bufferView"] = json!(view);
        accessor["componentType"] = json!(U8);
        accessor["normalized"] = json!(normalized);
        gltf.json["extensionsRequired"] = json!(["KHR_mesh_quantization"]);
        let area: f64 = gltf.load().surfaces.iter().map(Surface::area).sum();
        assert!((area - side * side).abs() < 1e-9, "{area}");
    }
}

#[test]
fn objects_are_nodes_named_apart() {
    let mut gltf = Gltf::new();
    let positions = gltf.floats(&SQUARE);
    for name in [json!("the mesh"), Value::Null] {
        let primitive = json!({"attributes": {"POSITION": positions}, "mode": 6});
        gltf.push("meshes", json!({"name": name, "primitives": [primitive]}));
    }
    for (k, (mesh, name)) in [(0, "Cube"), (0, ""), (1, "Cube"), (1, "")]
        .iter()
        .enumerate()
    {
        gltf.root(json!({"mesh": mesh, "name": name, "translation": [0, 0, k]}));
    }
    let model = gltf.load();
    assert_eq!(model.objects, ["Cube", "the mesh", "Cube.2", "node 3"]);
    assert!(told(&model, "several nodes are named \"Cube\""));
    gltf.json["nodes"][1]
        .as_object_mut()
        .unwrap()
        .remove("name");
    assert_eq!(gltf.load().objects[1], "the mesh");
}

#[test]
fn double_sided_materials_have_fronts_on_both_sides() {
    let mut material = painted([0.5; 4]);
    material["doubleSided"] = json!(true);
    let model = square(material).load();
    let normals: Vec<DVec3> = model.surfaces.iter().map(Surface::normal).collect();
    let (up, down) = (DVec3::Z, DVec3::NEG_Z);
    assert_eq!(normals, [up, down, up, down]);
    assert_eq!(model.faces, [0, 0, 1, 1]);
    assert_eq!(model.report.faces, 2);
}

#[test]
fn faces_wound_against_normals_are_turned_as_the_options_say() {
    for (orient, is_up) in [
        (Orient::Auto, true),
        (Orient::Winding, true),
        (Orient::Normals, false),
    ] {
        let mut gltf = square(painted([0.5; 4]));
        let normals = gltf.floats(&[[0.0, 0.0, -1.0]; 4]);
        gltf.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = json!(normals);
        let options = ImportOptions {
            orient,
            ..ImportOptions::default()
        };
        let model = gltf.load_as(&options).unwrap();
        for surface in &model.surfaces {
            assert_eq!(surface.normal().z > 0.0, is_up, "{orient:?}");
        }
    }
}

#[test]
fn only_the_default_scene_is_taken() {
    let mut gltf = square(painted([0.5; 4]));
    gltf.push(
        "nodes",
        json!({"mesh": 0, "name": "other", "translation": [0, 0, 1]}),
    );
    gltf.push("scenes", json!({"nodes": [1]}));
    for (scene, name) in [
        (json!(0), "square"),
        (json!(1), "other"),
        (Value::Null, "square"),
    ] {
        gltf.json["scene"] = scene;
        let model = gltf.load();
        assert_eq!(model.objects, [name]);
        assert!(told(&model, "2 scenes"));
    }
    gltf.json.as_object_mut().unwrap().remove("scenes");
    assert_eq!(gltf.load().objects, ["square", "other"]);
}

#[test]
fn what_moves_or_has_no_place_here_is_told_once() {
    let mut gltf = square(painted([0.5; 4]));
    gltf.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}),
    );
    let view = gltf.push("animations", json!({"channels": [], "samplers": []}));
    assert_eq!(view, 0);
    let attributes = &mut gltf.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["_CUSTOM"] = json!(0);
    gltf.json["extensionsUsed"] = json!(["EXT_mesh_gpu_instancing", "KHR_materials_unlit"]);
    for array in ["nodes", "meshes", "materials"] {
        gltf.json[array][0]["extras"] = json!({"anything": [1, "a", null]});
    }
    gltf.json["extras"] = json!("words");
    let model = gltf.load();
    assert_eq!(model.surfaces.len(), 2);
    assert_eq!(model.report.warnings.len(), 2, "{:?}", model.report);
    for words in [
        "animations (1), cameras (1); what they move stays",
        "EXT_mesh_gpu_instancing",
    ] {
        assert!(told(&model, words), "{words}");
    }
}

#[test]
fn cameras_alone_are_not_said_to_move_anything() {
    let mut gltf = square(painted([0.5; 4]));
    gltf.push(
        "cameras",
        json!({"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}),
    );
    gltf.json["nodes"][0]["camera"] = json!(0);
    assert_eq!(gltf.load().report.warnings, ["left out: cameras (1)"]);
}

#[test]
fn a_deep_chain_of_nodes_needs_no_deep_stack() {
    let mut gltf = square(painted([0.5; 4]));
    let nodes = gltf.json["nodes"].as_array_mut().unwrap();
    for k in 0..100_000 {
        nodes.push(json!({"children": [k], "translation": [0, 0, 0]}));
    }
    gltf.json["scenes"][0]["nodes"] = json!([100_000]);
    assert_eq!(gltf.load().surfaces.len(), 2);
}
