//! The program by its command line, and the scenes that it is given.
#![allow(dead_code)] // each test file uses some of them

pub mod methods;

use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use glam::Vec3;
use scene::{Rgb, Scene, Solution, State, Surface};
use tempfile::TempDir;
pub use test_scenes::*;

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

/// The program, in a folder, on the cpu and by one value a patch unless the arguments say otherwise.
pub fn program(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_compute"));
    command.args(arguments).current_dir(folder);
    // wgpu's EGL probe writes a warning to standard error without it.
    if std::env::var_os("XDG_RUNTIME_DIR").is_none() {
        command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    }
    if !arguments.contains(&"--backend") && arguments.len() > 1 {
        command.args(["--backend", "cpu"]);
    }
    let solves = arguments.len() > 1 && !["gather", "study", "verify"].contains(&arguments[0]);
    let asks = |option: &&str| ["--quality", "--target-error"].contains(option);
    if solves && !arguments.iter().any(asks) {
        command.args(["--quality", "mesh"]);
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

/// A failure says so in one line and leaves the folder as it was; the message is given back.
#[track_caller]
pub fn failure(folder: &Path, arguments: &[&str]) -> String {
    let before = files(folder);
    let output = compute(folder, arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {output:?}");
    assert_eq!(output.stdout, b"");
    assert_eq!(files(folder), before, "{arguments:?}");
    let message = stderr(&output);
    assert!(message.starts_with("compute: error: "), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(!message.trim_end().ends_with('.'), "{message}");
    message
}

/// Solves `in.rad` into `part.rad` by runs that are stopped, IN = OUT, on changing numbers of threads, until one is done;
/// gives what the others have left. The first lasts `limit_ms` milliseconds, each other a tenth longer than the one before
/// it. So they stop at ever other moments, and some of them suffice, although each loads the file, and one among sources
/// solves the coarser ones once more.
pub fn solve_in_parts(folder: &Path, settings: &[&str], mut limit_ms: f64) -> Vec<Solution> {
    std::fs::copy(folder.join("in.rad"), folder.join("part.rad")).unwrap();
    let mut stopped = Vec::new();
    loop {
        let limit = format!("{limit_ms}ms");
        let threads = ["1", "2", "5"][stopped.len() % 3];
        let limits = ["--time-limit", &limit, "--threads", threads];
        let output = solve(
            folder,
            &[&["part.rad", "part.rad"], settings, &limits].concat(),
        );
        if !stdout(&output).contains("stopped by --time-limit") {
            return stopped;
        }
        stopped.push(load(folder, "part.rad"));
        limit_ms *= 1.1;
        assert!(stopped.len() < 200, "{limit_ms}");
    }
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

/// All bits a run goes on from, and the iterations it has had.
pub fn state(solution: &Solution) -> (Vec<Vec<[u32; 3]>>, u64) {
    let mut arrays = vec![&solution.irradiance];
    match &solution.state {
        State::AtRest => {}
        State::Unfinished { irradiance } => arrays.push(irradiance),
        State::Shooting { unshot, remainder } => arrays.extend([unshot, remainder]),
    }
    let arrays = arrays.into_iter().map(|values| bits(values));
    (arrays.collect(), solution.provenance.iterations)
}

/// Two solutions go on with the same bits, and have come about in the same way.
#[track_caller]
pub fn assert_same(a: &Solution, b: &Solution, what: &str) {
    assert!(state(a) == state(b), "{what}: the bits differ");
    assert_eq!(a.provenance, b.provenance, "{what}");
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

/// Pixels along a face in tests, where the number does not matter.
pub const PIXELS: &str = "64";

/// A scene of named objects whose materials reflect half and emit 1, in a folder, as `in.rad`.
pub fn folder_with(objects: &[(&str, Vec<Surface>)], max_area: f64) -> TempDir {
    let folder = folder();
    save(folder.path(), "in.rad", &named(objects, max_area));
    folder
}

/// A room cut in two by a wall of two sides that stands on its uncut floor, with a lamp on one side.
pub fn two_rooms() -> Scene {
    let size = Vec3::new(4.0, 2.0, 2.0);
    let mut surfaces: Vec<Surface> = test_scenes::block(Vec3::ZERO, size, false, 0);
    let wall = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(|[y, z]| Vec3::new(2.0, y, z));
    let mut back = wall;
    back.reverse();
    surfaces.extend(test_scenes::quad(wall, 0));
    surfaces.extend(test_scenes::quad(back, 0));
    let lamp = [[0.5, 0.5], [0.5, 1.5], [1.5, 1.5], [1.5, 0.5]].map(|[x, y]| Vec3::new(x, y, 1.9));
    surfaces.extend(test_scenes::quad(lamp, 1));
    let materials = vec![
        test_scenes::material(0.5, 0.0),
        test_scenes::material(0.0, 10.0),
    ];
    let faces: Vec<u32> = (0..surfaces.len() as u32).collect();
    let (mut cut, mut faces) = (surfaces, faces);
    let objects = ["all".to_owned()];
    let model = genx::cut::Model {
        surfaces: &mut cut,
        faces: &mut faces,
        materials: &materials,
        objects: &objects,
        opening: None,
    };
    genx::cut::put_in_order(model, genx::cut::Cut::On).unwrap();
    test_scenes::scene(materials, cut, 0.05)
}
