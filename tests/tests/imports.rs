//! Imports point one way: scene <- genx; scene <- compute <- display; all <- tests, demo.

use std::collections::BTreeSet;

use tests::cargo;

/// What a package is built from, itself left out, as Cargo resolves it for this machine.
fn dependencies(package: &str) -> BTreeSet<String> {
    let output = cargo()
        .args([
            "tree",
            "--locked",
            "--edges",
            "normal,build",
            "--prefix",
            "none",
        ])
        .args(["--format", "{p}", "--package", package])
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    let tree = String::from_utf8(output.stdout).unwrap();
    let names = tree.lines().filter_map(|line| line.split(' ').next());
    let names: BTreeSet<String> = names.map(str::to_owned).collect();
    assert!(names.contains(package), "{tree}");
    names.into_iter().filter(|name| name != package).collect()
}

const WORKSPACE: [&str; 6] = ["scene", "genx", "compute", "display", "tests", "demo"];

#[test]
fn crates_import_only_what_is_below_them() {
    for (package, below) in [
        ("scene", &[][..]),
        ("genx", &["scene"]),
        ("compute", &["scene"]),
        ("display", &["scene", "compute"]),
    ] {
        let dependencies = dependencies(package);
        for other in WORKSPACE {
            assert_eq!(
                dependencies.contains(other),
                below.contains(&other),
                "{package} -> {other}"
            );
        }
    }
}

#[test]
fn nothing_imports_the_tests_or_the_demo() {
    for package in WORKSPACE {
        let dependencies = dependencies(package);
        for top in ["tests", "demo"] {
            assert!(!dependencies.contains(top), "{package} -> {top}");
        }
    }
}

#[test]
fn scenes_and_models_are_made_without_a_graphics_library() {
    for package in ["scene", "genx"] {
        let dependencies = dependencies(package);
        for library in ["wgpu", "wgpu-core", "naga", "winit", "ash"] {
            assert!(!dependencies.contains(library), "{package} -> {library}");
        }
    }
    // The names are those that Cargo uses.
    assert!(dependencies("compute").contains("wgpu"));
}
