//! What the tests of this folder share.
#![allow(dead_code)] // each test binary uses a part

pub mod damage;
pub mod gltf;

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use scene::function::{IrradianceFunction, NodeId, Refinement};
use scene::import::ImportedModel;
use scene::obj::ObjError;
use scene::{
    Level, Material, MaterialId, ObjectId, Opening, PatchId, Provenance, RecordedSettings, Rgb,
    Scene, Solution, State, Surface,
};
use serde_json::json;
use tempfile::TempDir;

pub fn material(name: &str, reflectance: [f32; 3], emission: [f32; 3]) -> Material {
    Material {
        name: name.to_owned(),
        reflectance: Rgb::from(reflectance),
        emission: Rgb::from(emission),
    }
}

pub fn surface(corners: [[f32; 3]; 3], material: u32, object: u32) -> Surface {
    Surface {
        corners: corners.map(Vec3::from),
        material: MaterialId(material),
        object: ObjectId(object),
    }
}

/// Two triangles of 1 and 4 patches, the faces 3 and 7, two materials, two objects, an origin, two patches inside of a solid, an
/// opening.
pub fn small_scene() -> Scene {
    Scene::new(
        vec![
            material("wall", [0.1, 0.25, 0.9], [0.0; 3]),
            material("lamp", [0.3; 3], [1.0e4, 7.5, 0.0]),
        ],
        vec!["room".into(), "lamp".into()],
        vec![
            surface([[0.0, 0.0, 0.0], [0.3, 0.0, 0.0], [0.0, 0.4, 0.0]], 0, 0),
            surface([[0.1, 0.0, 1.0], [0.1, 2.0, 1.0], [1.7, 0.0, 1.3]], 1, 1),
        ],
        &[0, 2],
        DVec3::new(16.0, -8.0, 0.0),
    )
    .unwrap()
    .with_faces(vec![3, 7])
    .unwrap()
    .with_inside(vec![PatchId(1), PatchId(4)])
    .unwrap()
    .with_openings(vec![Opening {
        corners: [Vec3::ZERO, Vec3::Y, Vec3::new(0.0, 0.5, 0.25)],
        object: ObjectId(1),
    }])
    .unwrap()
}

/// Values that no other patch has: an iteration under way, patches that gather, and a function.
pub fn small_solution(scene: &Scene) -> Solution {
    Solution {
        irradiance: small_values(scene, 1.0),
        provenance: Provenance {
            settings: Some(RecordedSettings::new(
                &json!({"resolution": 100, "seed": "7"}),
            )),
            iterations: 2,
            residuals: vec![0.1, 1.0 / 3.0],
            start_up_shots: 3,
            level: Level::Gathering {
                max_area: 0.1,
                gathered: small_values(scene, 3.0)[..4].to_vec(),
            },
        },
        state: State::Unfinished {
            irradiance: small_values(scene, 2.0)[..3].to_vec(),
        },
        function: Some(small_function(scene)),
        layers: None,
    }
}

/// The same of shooting among sources.
pub fn small_shooting_solution(scene: &Scene) -> Solution {
    let mut solution = small_solution(scene);
    solution.provenance.level = Level::Sources { max_area: 0.1 };
    solution.state = State::Shooting {
        unshot: small_values(scene, 4.0),
        remainder: small_values(scene, 5.0),
    };
    solution
}

/// A function over the second surface alone, once bisected.
fn small_function(scene: &Scene) -> IrradianceFunction {
    let mut mesh = Refinement::new(scene, |surface| surface.0 == 1, |_, _| true);
    mesh.bisect(NodeId(0));
    let mesh = mesh.mesh().unwrap();
    let values = |offset: f32| {
        let vertices = (0..mesh.vertex_count()).map(|v| v as f32);
        vertices.map(|v| Rgb::new(offset, v, 1.0) / 3.0).collect()
    };
    let function = IrradianceFunction::new(mesh.clone(), values(6.0), values(7.0)).unwrap();
    let error = (0..scene.patch_count()).map(|patch| patch as f32 / 7.0);
    function.with_error(error.collect()).unwrap()
}

/// Different values, one per patch.
fn small_values(scene: &Scene, offset: f32) -> Vec<Rgb> {
    (0..scene.patch_count())
        .map(|p| Rgb::new(offset, p as f32, 1.0) / 3.0)
        .collect()
}

pub fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

pub fn write(folder: &TempDir, name: &str, contents: impl AsRef<[u8]>) -> PathBuf {
    let path = folder.path().join(name);
    std::fs::write(&path, contents).unwrap();
    path
}

/// Names of everything in a folder, sorted.
pub fn listing(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// The message of an error, held against what every message must be: one line that names the file
/// and does not end in a full stop.
#[track_caller]
pub fn checked_message(error: &dyn std::error::Error, path: &Path) -> String {
    let message = error.to_string();
    assert!(
        message.starts_with(&format!("{}: ", path.display())),
        "{message}"
    );
    assert!(
        !message.ends_with('.') && !message.contains('\n'),
        "{message}"
    );
    message
}

/// Bit patterns, for comparisons that tell -0 from 0.
pub fn bits(values: &[Rgb]) -> Vec<[u32; 3]> {
    values
        .iter()
        .map(|v| v.to_array().map(f32::to_bits))
        .collect()
}

/// A unit square in the floor, seen from above.
pub const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

/// Imports a text as `a.obj` in this folder.
pub fn load_text(folder: &TempDir, text: impl AsRef<[u8]>) -> Result<ImportedModel, ObjError> {
    scene::obj::load(&write(folder, "a.obj", text))
}
