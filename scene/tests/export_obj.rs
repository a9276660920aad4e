//! What is exported as OBJ is the same scene when it is imported again.

mod common;

use std::path::Path;

use common::{folder, listing, material, small_scene, surface};
use glam::DVec3;
use scene::export::obj;
use scene::import::ImportOptions;
use scene::obj::load_with;
use scene::{Axis, ModelAxes, PatchId, Scene};

/// Exports, and imports without subdivision.
fn through_obj(scene: &Scene) -> Scene {
    let folder = folder();
    let path = folder.path().join("a b.obj");
    obj::save(&path, scene).unwrap();
    assert_eq!(listing(folder.path()), ["a b.mtl", "a b.obj"]);
    let model = scene::obj::load(&path).unwrap();
    // Patches alternate between objects, which is told.
    let mut warnings = model.report.warnings;
    warnings.retain(|warning| !warning.starts_with("objects of one name"));
    assert_eq!(warnings, [""; 0]);
    Scene::with_max_area(
        model.materials,
        model.objects,
        model.surfaces,
        f64::INFINITY,
        model.origin,
    )
    .unwrap()
}

/// Corners in the model's own coordinates, the least one first, in their cyclic order.
fn cycle(scene: &Scene, patch: u32) -> [[f64; 3]; 3] {
    let corners = scene.patch(PatchId(patch)).corners;
    let [a, b, c] = corners.map(|p| (p.as_dvec3() + scene.origin()).to_array());
    let mut turns = [[a, b, c], [b, c, a], [c, a, b]];
    turns.sort_by(|x, y| x.partial_cmp(y).unwrap());
    turns[0]
}

#[track_caller]
fn assert_same_patches(scene: &Scene, again: &Scene) {
    assert_eq!(again.patch_count(), scene.patch_count());
    for patch in 0..scene.patch_count() {
        assert_eq!(cycle(again, patch), cycle(scene, patch), "patch {patch}");
        let (one, other) = (
            scene.patch_material(PatchId(patch)),
            again.patch_material(PatchId(patch)),
        );
        assert_eq!(one.reflectance, other.reflectance);
        assert_eq!(one.emission, other.emission);
    }
}

#[test]
fn exported_obj_imports_to_the_same_patches_materials_and_objects() {
    // Without an origin of its own, as models are made.
    let small = small_scene();
    let scene = Scene::new(
        small.materials().to_vec(),
        small.objects().to_vec(),
        small.surfaces().to_vec(),
        &[3, 6],
        DVec3::ZERO,
    )
    .unwrap();
    for scene in [small, scene] {
        let again = through_obj(&scene);
        assert_same_patches(&scene, &again);
        assert_eq!(again.materials(), scene.materials());
        assert_eq!(again.objects(), scene.objects());
        // A second time nothing changes at all.
        let third = through_obj(&again);
        assert_eq!(third, again);
    }
}

#[test]
fn exported_obj_shares_the_vertices_of_neighbours() {
    let scene = Scene::new(
        vec![material("m", [0.5; 3], [0.0; 3])],
        vec!["o".into()],
        vec![surface([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 0, 0)],
        &[8],
        DVec3::ZERO,
    )
    .unwrap();
    let folder = folder();
    let path = folder.path().join("a.obj");
    obj::save(&path, &scene).unwrap();
    let text = std::fs::read_to_string(path).unwrap();
    let count = |keyword: &str| text.lines().filter(|l| l.starts_with(keyword)).count();
    // 256 triangles on a grid of 16 steps a leg: 17 * 18 / 2 vertices.
    assert_eq!((count("f "), count("v ")), (256, 153));
    assert_eq!((count("o "), count("usemtl ")), (1, 1));
}

#[test]
fn names_that_obj_cannot_hold_are_changed_so_that_the_import_finds_them() {
    let triangle = |i: u32| [[0.0; 3], [1.0, 0.0, i as f32], [0.0, 1.0, 0.0]];
    let names = [
        "wall",
        "wall",
        "wall_2",
        "",
        " \t",
        "a\nKd 1 1 1",
        "two words",
        "#\\",
        "room #2",
        "# ##",
    ];
    let reflectance = |i: usize| [0.09 * i as f32, 0.25, 0.0];
    let scene = Scene::new(
        names
            .iter()
            .enumerate()
            .map(|(i, name)| material(name, reflectance(i), [0.0; 3]))
            .collect(),
        vec!["first\nf 9 9 9".into(), String::new()],
        (0..10).map(|i| surface(triangle(i), i, i % 2)).collect(),
        &[0; 10],
        DVec3::ZERO,
    )
    .unwrap();
    let again = through_obj(&scene);
    assert_same_patches(&scene, &again);
    let names: Vec<&str> = again.materials().iter().map(|m| m.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "wall",
            "wall_2",
            "wall_2_2",
            "material",
            "material_2",
            "a_Kd 1 1 1",
            "two words",
            "#\\",
            "room #2",
            "# ##",
        ]
    );
    assert_eq!(again.objects(), ["first_f 9 9 9", "object"]);
}

/// A model in millimetres comes back in the digits that it had, and then as the same scene.
#[test]
fn models_in_other_units_come_back_as_they_were() {
    let folder = folder();
    let path = folder.path().join("a.obj");
    let text = "v 1501 -333.3 2000.25\nv 4207 -333.3 2000.25\nv 1501 1234.5 0.1\nf 1 2 3\n";
    std::fs::write(&path, text).unwrap();
    let options = ImportOptions {
        axes: ModelAxes {
            unit: 0.001,
            up: Some(Axis::Z),
        },
        ..ImportOptions::default()
    };
    let import = |path: &Path| {
        load_with(path, &options)
            .unwrap()
            .into_scene(f64::INFINITY)
            .unwrap()
    };
    let scene = import(&path);
    let copy = folder.path().join("b.obj");
    obj::save(&copy, &scene).unwrap();
    let written = std::fs::read_to_string(&copy).unwrap();
    for line in text.lines().filter(|line| line.starts_with("v ")) {
        assert!(written.contains(line), "{line} is missing in {written}");
    }
    let again = import(&copy);
    assert_eq!(again.surfaces(), scene.surfaces());
    assert_eq!(
        (again.origin(), again.axes()),
        (scene.origin(), scene.axes())
    );
}
