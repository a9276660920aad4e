//! The laws of the glTF import: vertices that follow joints or are moved by morph targets.

mod common;

use common::checked_message;
use common::gltf::{FLOAT, Gltf, SQUARE, painted, square};
use glam::DVec3;
use scene::Surface;
use scene::gltf::load;
use scene::import::ImportedModel;
use serde_json::{Value, json};

/// Coordinates up to 8, moved by f64 and rounded to f32 once in the file and once in the scene.
const ROUNDING: f64 = 8.0 * 2.0 * f32::EPSILON as f64;

/// Corners in the model's coordinates.
fn corners(model: &ImportedModel) -> Vec<DVec3> {
    let place = |s: &Surface| s.corners.map(|corner| corner.as_dvec3() + model.origin);
    model.surfaces.iter().flat_map(place).collect()
}

/// The square's corners as its triangles have them.
fn expected(place: impl Fn(usize) -> DVec3) -> Vec<DVec3> {
    [0, 1, 2, 0, 2, 3].map(place).to_vec()
}

fn corner(k: usize) -> DVec3 {
    DVec3::from(SQUARE[k].map(f64::from))
}

#[track_caller]
fn assert_at(model: &ImportedModel, expected: &[DVec3]) {
    let found = corners(model);
    assert_eq!(found.len(), expected.len());
    for (found, expected) in found.iter().zip(expected) {
        assert!(found.distance(*expected) <= ROUNDING, "{found} {expected}");
    }
}

#[track_caller]
fn refused(gltf: &Gltf) -> String {
    let folder = common::folder();
    let path = gltf.write(&folder, common::gltf::Container::Binary);
    checked_message(&load(&path).unwrap_err(), &path)
}

/// The square in a skin of two joints, nodes 1 and 2, whose node is far away; each vertex has one set of joints and weights.
fn skinned(joints: [[u8; 4]; 4], weights: &[[f32; 4]; 4], nodes: [Value; 2]) -> Gltf {
    let mut gltf = square(painted([0.5; 4]));
    let view = gltf.view(&joints.concat());
    let joints = json!({"bufferView": view, "componentType": 5121, "type": "VEC4", "count": 4});
    let joints = gltf.push("accessors", joints);
    let weights = gltf.floats(weights);
    let attributes = &mut gltf.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] = json!(joints);
    attributes["WEIGHTS_0"] = json!(weights);
    for node in nodes {
        gltf.root(node);
    }
    gltf.push("skins", json!({"joints": [1, 2]}));
    gltf.json["nodes"][0]["skin"] = json!(0);
    gltf.json["nodes"][0]["translation"] = json!([100, 0, 0]);
    gltf
}

const FIRST: [[f32; 4]; 4] = [[1.0, 0.0, 0.0, 0.0]; 4];

/// Section 3.7.3.3: the transform of the node that has the mesh counts for nothing.
#[test]
fn a_skinned_mesh_is_where_its_joints_are() {
    let nodes = [
        json!({"scale": [0.01, 0.01, 0.01], "translation": [1, 2, 3]}),
        json!({}),
    ];
    let model = skinned([[0; 4]; 4], &FIRST, nodes).load();
    assert_at(
        &model,
        &expected(|k| DVec3::new(1.0, 2.0, 3.0) + 0.01 * corner(k)),
    );
}

#[test]
fn inverse_bind_matrices_undo_what_joints_do_at_rest() {
    let nodes = [
        json!({"scale": [2, 2, 2], "translation": [4, 0, 0]}),
        json!({"translation": [0, 5, 0]}),
    ];
    let mut gltf = skinned([[0, 1, 0, 0]; 4], &[[0.5, 0.5, 0.0, 0.0]; 4], nodes);
    let half = [
        0.5, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 0.0, 0.5, 0.0, -2.0, 0.0, 0.0, 1.0f32,
    ];
    let back = [
        1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, -5.0, 0.0, 1.0f32,
    ];
    let bytes: Vec<u8> = [half, back]
        .concat()
        .iter()
        .flat_map(|v| v.to_le_bytes())
        .collect();
    let view = gltf.view(&bytes);
    let accessor = json!({"bufferView": view, "componentType": FLOAT, "type": "MAT4", "count": 2});
    gltf.json["skins"][0]["inverseBindMatrices"] = json!(gltf.push("accessors", accessor));
    assert_at(&gltf.load(), &expected(corner));
    gltf.json["accessors"][4]["count"] = json!(1);
    assert!(
        refused(&gltf).contains("index 1 is out of range"),
        "{}",
        refused(&gltf)
    );
}

/// p = (w_0 p_0 + w_1 p_1) / (w_0 + w_1), whatever the weights sum to; unused joints may be any.
#[test]
fn vertices_are_blended_by_their_weights() {
    let nodes = [
        json!({"translation": [4, 0, 0]}),
        json!({"translation": [0, 8, 0]}),
    ];
    let joints = [[0, 1, 9, 9]; 4];
    let weights = [
        [3.0, 1.0, 0.0, 0.0],
        [0.75, 0.25, 0.0, 0.0],
        [0.0, 2.0, 0.0, 0.0],
        [1.0, 0.0, 0.0, 0.0],
    ];
    let model = skinned(joints, &weights, nodes).load();
    let moved = [
        DVec3::new(3.0, 2.0, 0.0),
        DVec3::new(3.0, 2.0, 0.0),
        DVec3::new(0.0, 8.0, 0.0),
        DVec3::new(4.0, 0.0, 0.0),
    ];
    assert_at(&model, &expected(|k| moved[k] + corner(k)));
}

#[test]
fn joints_that_mirror_turn_no_front_to_the_back() {
    let nodes = [json!({"scale": [-1, 1, 1]}), json!({})];
    let model = skinned([[0; 4]; 4], &FIRST, nodes).load();
    assert!(model.surfaces.iter().all(|s| s.normal() == DVec3::Z));
}

#[test]
fn skins_that_cannot_be_followed_are_named() {
    let nodes = || [json!({}), json!({})];
    for (joints, weight, words) in [
        (0, 0.0, "vertex 0 sum to 0"),
        (0, -1.0, "weight -1 is below 0"),
        (2, 1.0, "joint 2, but the skin has 2"),
    ] {
        let message = refused(&skinned(
            [[joints; 4]; 4],
            &[[weight, 0.0, 0.0, 0.0]; 4],
            nodes(),
        ));
        assert!(message.contains(words), "{message}");
    }
    let mut gltf = skinned([[0; 4]; 4], &FIRST, nodes());
    let attributes = gltf.json["meshes"][0]["primitives"][0]["attributes"].as_object_mut();
    attributes.unwrap().remove("JOINTS_0");
    assert!(refused(&gltf).contains("no JOINTS_0"), "{}", refused(&gltf));
}

/// The square, of which a target moves the first two corners by 1 along x.
fn morphed() -> Gltf {
    let mut gltf = square(painted([0.5; 4]));
    let moved = gltf.floats(&[[1.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]]);
    gltf.json["meshes"][0]["primitives"][0]["targets"] = json!([{"POSITION": moved}]);
    gltf
}

/// Section 3.7.4: the weights of the node, else those of the mesh, else 0.
#[test]
fn morph_targets_count_with_the_weights_of_the_node_else_of_the_mesh() {
    for (of_node, of_mesh, weight) in [
        (None, None, 0.0),
        (None, Some(1.0), 1.0),
        (Some(0.5), Some(1.0), 0.5),
        (Some(-2.0), None, -2.0),
    ] {
        let mut gltf = morphed();
        if let Some(weight) = of_node {
            gltf.json["nodes"][0]["weights"] = json!([weight]);
        }
        if let Some(weight) = of_mesh {
            gltf.json["meshes"][0]["weights"] = json!([weight]);
        }
        let model = gltf.load();
        let moved = |k: usize| {
            if k < 2 {
                weight * DVec3::X
            } else {
                DVec3::ZERO
            }
        };
        assert_at(&model, &expected(|k| corner(k) + moved(k)));
        assert_eq!(model.report.warnings, [""; 0]);
    }
}

#[test]
fn a_target_without_bytes_moves_nothing() {
    let mut gltf = morphed();
    let target = &mut gltf.json["accessors"][2];
    target.as_object_mut().unwrap().remove("bufferView");
    gltf.json["meshes"][0]["weights"] = json!([1]);
    assert_at(&gltf.load(), &expected(corner));
}

#[test]
fn other_numbers_of_weights_than_of_targets_are_named() {
    let mut gltf = morphed();
    gltf.json["nodes"][0]["weights"] = json!([1, 1]);
    let message = refused(&gltf);
    assert!(
        message.contains("2 weights") && message.contains("1 morph targets"),
        "{message}"
    );
}
