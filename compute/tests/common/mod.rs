//! Small scenes made by hand, and the program by its command line.
#![allow(dead_code)] // each test file uses some of them

pub mod methods;
pub mod objects;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};
use scene::{Material, MaterialId, ObjectId, Rgb, Scene, Solution, Surface};
use tempfile::TempDir;

pub fn material(reflectance: f32, emission: f32) -> Material {
    Material {
        name: "wall".into(),
        reflectance: Vec3::splat(reflectance),
        emission: Vec3::splat(emission),
    }
}

/// A quadrilateral, counter-clockwise from its front, as two triangles.
pub fn quad(corners: [Vec3; 4], material: u32) -> [Surface; 2] {
    let surface = |corners| Surface {
        corners,
        material: MaterialId(material),
        object: ObjectId(0),
    };
    let [a, b, c, d] = corners;
    [surface([a, b, c]), surface([a, c, d])]
}

/// The twelve triangles of a box, seen from inside, or from outside if `solid`.
pub fn block(low: Vec3, high: Vec3, solid: bool, material: u32) -> Vec<Surface> {
    let corner = |k: usize| {
        Vec3::new(
            if k & 1 == 0 { low.x } else { high.x },
            if k & 2 == 0 { low.y } else { high.y },
            if k & 4 == 0 { low.z } else { high.z },
        )
    };
    // Each face counter-clockwise from inside.
    [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ]
    .into_iter()
    .flat_map(|mut face| {
        if solid {
            face.reverse();
        }
        quad(face.map(corner), material)
    })
    .collect()
}

/// The same triangles with every corner moved a little, the same way wherever it occurs, so that no
/// ray from one patch's centroid meets an edge exactly.
pub fn shaken(surfaces: Vec<Surface>) -> Vec<Surface> {
    let shake = |p: Vec3| {
        let phase = p.dot(Vec3::new(12.9898, 78.233, 37.719));
        p + 0.05 * Vec3::new(phase.sin(), (1.7 * phase).cos(), (2.3 * phase).sin())
    };
    surfaces
        .into_iter()
        .map(|s| Surface {
            corners: s.corners.map(shake),
            ..s
        })
        .collect()
}

/// A scene of one object.
pub fn scene(materials: Vec<Material>, surfaces: Vec<Surface>, max_area: f64) -> Scene {
    Scene::with_max_area(
        materials,
        vec!["all".into()],
        surfaces,
        max_area,
        DVec3::ZERO,
    )
    .unwrap()
}

/// A closed unit cube whose walls all emit and reflect alike.
pub fn furnace(reflectance: f32, emission: f32, max_area: f64) -> Scene {
    scene(
        vec![material(reflectance, emission)],
        block(Vec3::ZERO, Vec3::ONE, false, 0),
        max_area,
    )
}

/// A closed room with two blocks floating in it.
pub fn furnished_room(max_area: f64) -> Scene {
    scene(
        vec![material(0.5, 0.0), material(0.3, 2.0)],
        furnished_room_surfaces(),
        max_area,
    )
}

/// The triangles of [`furnished_room`].
pub fn furnished_room_surfaces() -> Vec<Surface> {
    let mut surfaces = block(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0), false, 0);
    surfaces.extend(block(
        Vec3::new(1.0, 1.0, 0.5),
        Vec3::new(1.7, 1.4, 1.3),
        true,
        1,
    ));
    surfaces.extend(block(
        Vec3::new(2.5, 0.5, 0.2),
        Vec3::new(3.1, 2.1, 0.9),
        true,
        1,
    ));
    surfaces
}

/// A room whose walls differ in reflectance and emission, in every channel.
pub fn colourful_room(max_area: f64) -> Scene {
    let coloured = |reflectance: [f32; 3], emission: [f32; 3]| Material {
        name: "wall".into(),
        reflectance: reflectance.into(),
        emission: emission.into(),
    };
    let mut surfaces = furnished_room_surfaces();
    // The ceiling is a lamp, and one wall is red.
    for (first, material) in [(2, 2), (4, 3)] {
        for surface in &mut surfaces[first..first + 2] {
            surface.material = MaterialId(material);
        }
    }
    scene(
        vec![
            coloured([0.5, 0.6, 0.7], [0.0; 3]),
            coloured([0.3, 0.2, 0.1], [0.0, 0.0, 0.5]),
            coloured([0.1, 0.2, 0.3], [10.0, 8.0, 6.0]),
            coloured([0.75, 0.05, 0.05], [0.0; 3]),
        ],
        surfaces,
        max_area,
    )
}

/// A folder that is removed at the end of the test.
pub fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

/// A folder with a closed room in `in.rad`.
pub fn folder_with_room() -> TempDir {
    let folder = folder();
    save(folder.path(), "in.rad", &colourful_room(0.5));
    folder
}

/// Writes a scene without a solution.
pub fn save(folder: &Path, name: &str, scene: &Scene) -> PathBuf {
    let path = folder.join(name);
    scene::file::save(&path, scene, None).unwrap();
    path
}

/// Reads the solution of a file, which is whole.
#[track_caller]
pub fn load(folder: &Path, name: &str) -> Solution {
    scene::file::load(&folder.join(name)).unwrap().1.unwrap()
}

/// The program, in a folder, on the cpu unless the arguments say otherwise.
pub fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_compute"));
    command.args(arguments).current_dir(folder);
    if !arguments.contains(&"--backend") && arguments.len() > 1 {
        command.args(["--backend", "cpu"]);
    }
    command
}

/// Runs the program to its end.
pub fn compute(folder: &Path, arguments: &[&str]) -> Output {
    program(folder, arguments).output().unwrap()
}

/// Runs the program to an end that must be a good one.
#[track_caller]
pub fn solve(folder: &Path, arguments: &[&str]) -> Output {
    let output = compute(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {output:?}");
    output
}

/// Starts the program.
pub fn start(folder: &Path, arguments: &[&str]) -> Child {
    program(folder, arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

/// Bit patterns, for comparisons that tell -0 from 0.
pub fn bits(values: &[Rgb]) -> Vec<[u32; 3]> {
    values
        .iter()
        .map(|value| value.to_array().map(f32::to_bits))
        .collect()
}

/// Names of all files in a folder, those with a leading dot included.
pub fn files(folder: &Path) -> Vec<String> {
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

/// Nothing here takes a hundredth of it; a test that waits longer has found a defect.
const PATIENCE: Duration = Duration::from_mins(1);

/// Asks until it is true.
#[track_caller]
pub fn wait_until(mut is_so: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is_so() {
        assert!(start.elapsed() < PATIENCE, "waited for nothing");
        sleep(Duration::from_millis(2));
    }
}

/// Sends a signal by name, as a user's shell would.
pub fn signal(child: &Child, name: &str) {
    let sent = Command::new("kill")
        .args([format!("-{name}"), child.id().to_string()])
        .status();
    assert!(sent.unwrap().success());
}

/// Waits until a run holds the lock of its output, so that it listens to Ctrl-C too.
pub fn wait_for_lock(folder: &Path, output: &str) {
    wait_until(|| folder.join(format!(".{output}.lock")).exists());
}

/// A run that goes on until it is stopped, drawing all rows again in each iteration.
pub fn start_endless(folder: &Path, input: &str, output: &str, more: &[&str]) -> Child {
    let arguments = [input, output, "32", "--tolerance", "0", "--memory", "0KiB"];
    start(folder, &[&arguments[..], more].concat())
}
