//! The program by its command line.

use std::path::Path;
use std::process::{Command, Output};

use scene::Scene;
use tempfile::TempDir;

pub fn genx(folder: &TempDir, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_genx"))
        .args(arguments)
        .current_dir(folder)
        .output()
        .unwrap()
}

pub fn folder() -> TempDir {
    tempfile::tempdir().unwrap()
}

pub fn stdout(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).unwrap()
}

pub fn stderr(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).unwrap()
}

pub fn load(folder: &TempDir, name: &str) -> Scene {
    let (scene, solution) = scene::file::load(&folder.path().join(name)).unwrap();
    assert!(solution.is_none());
    scene
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

pub fn make(folder: &TempDir, arguments: &[&str]) -> Output {
    let output = genx(folder, arguments);
    assert_eq!(output.status.code(), Some(0), "{arguments:?}: {output:?}");
    output
}

/// A usage error leaves nothing behind; the message is given back.
#[track_caller]
pub fn usage_error(arguments: &[&str]) -> String {
    let folder = folder();
    let output = genx(&folder, arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {output:?}");
    assert_eq!(output.stdout, b"");
    assert_eq!(files(folder.path()), [] as [&str; 0], "{arguments:?}");
    stderr(&output)
}

/// A failure prints one error and leaves nothing behind; the message is given back.
pub fn failure(folder: &TempDir, arguments: &[&str]) -> String {
    let before = files(folder.path());
    let output = genx(folder, arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {output:?}");
    assert_eq!(output.stdout, b"");
    assert_eq!(files(folder.path()), before, "{arguments:?}");
    let message = stderr(&output);
    assert!(message.starts_with("genx: error: "), "{message}");
    assert_eq!(message.matches("error:").count(), 1, "{message}");
    message
}

/// Writes an OBJ file: a lit square above a pentagon, both facing each other.
pub fn write_obj(folder: &TempDir, name: &str) {
    std::fs::write(
        folder.path().join("model.mtl"),
        "newmtl lamp\nKd 0.2 0.2 0.2\nKe 4 2 1\nnewmtl floor\nKd 0.6 0.5 0.4\n",
    )
    .unwrap();
    std::fs::write(
        folder.path().join(name),
        "mtllib model.mtl
v 0 0 0\nv 0 0 1\nv 1 0 2\nv 2 0 1\nv 2 0 0
v 0 1 0\nv 1 1 0\nv 1 1 1\nv 0 1 1
o bottom\nusemtl floor\nf 1 2 3 4 5
o top\nusemtl lamp\nf 6 7 8 9\n",
    )
    .unwrap();
}
