//! Imports point one way, between crates and between the folders of a crate.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use tests::{cargo, workspace};

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

const WORKSPACE: [&str; 10] = [
    "scene",
    "visibility",
    "genx",
    "compute",
    "display",
    "window",
    "test_scenes",
    "test_needs",
    "tests",
    "demo",
];

#[test]
fn crates_import_only_what_is_below_them() {
    for (package, below) in [
        ("scene", &[][..]),
        ("genx", &["scene"]),
        ("visibility", &["scene"]),
        ("compute", &["scene", "visibility"]),
        ("display", &["scene", "visibility", "compute"]),
        ("window", &["scene", "visibility", "compute", "display"]),
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
fn pictures_are_made_without_a_graphics_card_or_the_solvers_program() {
    for (package, libraries) in [
        ("scene", &["wgpu", "clap"][..]),
        ("genx", &["wgpu"]),
        ("visibility", &["wgpu", "clap", "ctrlc", "indicatif"]),
        ("display", &["wgpu", "ctrlc", "indicatif", "egui", "winit"]),
    ] {
        let dependencies = dependencies(package);
        for &library in libraries {
            assert!(!dependencies.contains(library), "{package} -> {library}");
        }
    }
    // The names are those that Cargo uses.
    let compute = dependencies("compute");
    for library in ["wgpu", "clap", "ctrlc", "indicatif"] {
        assert!(compute.contains(library), "{library}");
    }
    let window = dependencies("window");
    for library in ["egui", "winit"] {
        assert!(window.contains(library), "{library}");
    }
}

/// The modules right below `src` of a crate that each of them names as `crate::MODULE`, tests left out.
fn imports(package: &str) -> BTreeMap<String, BTreeSet<String>> {
    let src = workspace().join(package).join("src");
    let mut modules: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for entry in std::fs::read_dir(&src).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if !["lib", "main"].contains(&name.as_str()) {
            let found = modules.entry(name.clone()).or_default();
            named_in(&path, found);
            found.remove(&name);
        }
    }
    let names: BTreeSet<String> = modules.keys().cloned().collect();
    for found in modules.values_mut() {
        found.retain(|name| names.contains(name));
    }
    modules
}

/// Adds the modules that a file or a folder names.
fn named_in(path: &Path, found: &mut BTreeSet<String>) {
    if path.is_dir() {
        for entry in std::fs::read_dir(path).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap();
            if !["tests", "test"].contains(&name) {
                named_in(&path, found);
            }
        }
        return;
    }
    if path.extension().is_none_or(|extension| extension != "rs") {
        return;
    }
    let text = std::fs::read_to_string(path).unwrap();
    let code = text.split("#[cfg(test)]\nmod tests {").next().unwrap();
    for line in code.lines().map(str::trim_start) {
        if line.starts_with("//") {
            continue;
        }
        for (at, prefix) in line.match_indices("crate::") {
            let rest = &line[at + prefix.len()..];
            // `use crate::{a, b::c}` names several.
            let inner = rest.strip_prefix('{').unwrap_or(rest);
            let parts = if rest.starts_with('{') {
                inner.split(", ").collect()
            } else {
                vec![inner]
            };
            for part in parts {
                let end = part.find(|c: char| !(c.is_alphanumeric() || c == '_'));
                found.insert(part[..end.unwrap_or(part.len())].to_owned());
            }
        }
    }
}

/// A module that leads back to itself, and through which.
fn circle(imports: &BTreeMap<String, BTreeSet<String>>) -> Option<Vec<String>> {
    fn visit<'a>(
        at: &'a str,
        imports: &'a BTreeMap<String, BTreeSet<String>>,
        way: &mut Vec<&'a str>,
        done: &mut BTreeSet<&'a str>,
    ) -> Option<Vec<String>> {
        if let Some(start) = way.iter().position(|&name| name == at) {
            return Some(way[start..].iter().map(|&name| name.to_owned()).collect());
        }
        if done.contains(at) {
            return None;
        }
        way.push(at);
        for next in &imports[at] {
            if let Some(circle) = visit(next, imports, way, done) {
                return Some(circle);
            }
        }
        way.pop();
        done.insert(at);
        None
    }
    let mut done = BTreeSet::new();
    imports
        .keys()
        .find_map(|name| visit(name, imports, &mut Vec::new(), &mut done))
}

#[test]
fn modules_do_not_import_each_other_in_circles() {
    for package in [
        "scene",
        "visibility",
        "compute",
        "display",
        "window",
        "genx",
    ] {
        let imports = imports(package);
        assert!(imports.len() > 3, "{imports:?}");
        assert_eq!(circle(&imports), None, "{package}");
    }
}

/// From below to above; each imports from those before it alone.
const VISIBILITY: [&[&str]; 6] = [
    &[
        "affine", "frame", "hemicube", "outcode", "regions", "rounding", "runs", "vectors",
        "window",
    ],
    &["buffer", "geometry", "eye"],
    &["spans"],
    &["specks", "rays", "look_up"],
    &["drawable", "view", "picture", "facets"],
    &["item_buffer", "reference"],
];

#[test]
fn strategies_of_visibility_stand_beside_each_other() {
    let imports = imports("visibility");
    let layers: Vec<&str> = VISIBILITY.concat();
    for name in imports.keys() {
        assert!(layers.contains(&name.as_str()), "{name} has no layer");
    }
    let level = |name: &str| VISIBILITY.iter().position(|layer| layer.contains(&name));
    for (name, imported) in &imports {
        for other in imported {
            assert!(level(other) <= level(name), "{name} -> {other}");
        }
    }
    for strategy in ["specks", "rays"] {
        for other in ["specks", "rays", "look_up"] {
            assert!(!imports[strategy].contains(other), "{strategy} -> {other}");
        }
    }
}

/// What draws knows nothing of what solves, and neither of the program.
#[test]
fn back_ends_solvers_and_the_program_of_compute_point_one_way() {
    let imports = imports("compute");
    let lower = [
        "cpu",
        "gpu",
        "convex",
        "lamps",
        "unlit",
        "rows",
        "compact_rows",
        "hemicubes",
        "receivers",
        "sources",
        "delta_form_factors",
        "backend",
    ];
    for name in lower {
        for above in [
            "form_factors",
            "row_cache",
            "solver",
            "solve",
            "report",
            "verify",
            "program",
        ] {
            assert!(!imports[name].contains(above), "{name} -> {above}");
        }
    }
    for (name, imported) in &imports {
        assert!(
            name == "program" || !imported.contains("program"),
            "{name} -> program"
        );
    }
    for other in ["cpu", "gpu"] {
        let users: Vec<&String> = imports
            .iter()
            .filter(|(_, i)| i.contains(other))
            .map(|(n, _)| n)
            .collect();
        assert!(
            users.iter().all(|user| *user == "backend"),
            "{other}: {users:?}"
        );
    }
}

#[test]
fn a_circle_is_found() {
    let set = |names: &[&str]| names.iter().map(|&n| n.to_owned()).collect::<BTreeSet<_>>();
    let with = |of_c: &[&str]| {
        BTreeMap::from([
            ("a".to_owned(), set(&["b"])),
            ("b".to_owned(), set(&["c"])),
            ("c".to_owned(), set(of_c)),
        ])
    };
    assert_eq!(circle(&with(&[])), None);
    assert_eq!(
        circle(&with(&["b"])),
        Some(vec!["b".to_owned(), "c".to_owned()])
    );
}
