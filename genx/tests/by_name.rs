//! Reflectances and lights that materials and objects are given by name, and the list of the names.

mod common;

use common::program::{failure, folder, genx, load, make, stderr, stdout, usage_error};
use scene::{Material, Rgb, Scene};
use tempfile::TempDir;

/// Two squares of one material, "a lamp" of 2 m^2 and "floor" of 1 m^2, and "roof" of another one, of 1 m^2.
fn model() -> TempDir {
    let folder = folder();
    let obj = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 2\nv 2 0 2\nv 2 1 2\nv 0 1 2\n\
        v 0 0 3\nv 0 1 3\nv 1 1 3\nv 1 0 3\n\
        o floor\nusemtl grey\nf 1 2 3 4\no a lamp\nf 8 7 6 5\no roof\nusemtl dark = black\nf 9 10 11 12\n";
    let mtl = "newmtl grey\nKd 0.5\nnewmtl dark = black\nKd 0.1\n";
    std::fs::write(folder.path().join("m.obj"), obj).unwrap();
    std::fs::write(folder.path().join("m.mtl"), mtl).unwrap();
    folder
}

/// The materials of an object's surfaces.
fn materials<'s>(scene: &'s Scene, object: &str) -> Vec<&'s Material> {
    let surfaces = scene.surfaces().iter();
    let of_object = surfaces.filter(|s| scene.object(s.object) == object);
    of_object.map(|s| scene.material(s.material)).collect()
}

#[test]
fn names_of_materials_and_objects_are_given_light_and_paint() {
    let folder = model();
    let made = |more: &[&str]| {
        let output = make(
            &folder,
            &[&["a.rad", "m.obj", "--max-area", "inf"], more].concat(),
        );
        assert_eq!(stderr(&output), "");
        load(&folder, "a.rad")
    };
    let scene = made(&[
        "--light",
        "a lamp=3,2,1",
        "--reflectance",
        "dark = black=0.7",
    ]);
    for material in materials(&scene, "a lamp") {
        assert_eq!(material.emission, Rgb::new(3.0, 2.0, 1.0));
        assert_eq!(material.reflectance, Rgb::splat(0.5));
    }
    // What shares the lamp's material keeps it.
    for material in materials(&scene, "floor") {
        assert_eq!((material.emission, &material.name[..]), (Rgb::ZERO, "grey"));
    }
    for material in materials(&scene, "roof") {
        assert_eq!(material.reflectance, Rgb::splat(0.7));
    }
    // All surfaces of a material, those of an object alone, and an object that shares its material with none.
    for (name, power, emitting) in [("grey", 6.0, 3.0), ("a lamp", 6.0, 2.0), ("roof", 5.0, 1.0)] {
        let scene = made(&["--light-power", &format!("{name}={power}")]);
        // One rounding of the emission to f32.
        let off = (scene.emitted_power().x - power).abs();
        assert!(off <= 1e-6 * power, "{name}: {off}");
        let area = scene
            .surfaces()
            .iter()
            .filter(|s| scene.material(s.material).is_emitter());
        let area: f64 = area.map(scene::Surface::area).sum();
        assert!((area - emitting).abs() < 1e-6, "{name}: {area}");
    }
    // In their order: the last one counts.
    let scene = made(&["--light", "grey=1", "--light", "a lamp=9"]);
    assert_eq!(materials(&scene, "a lamp")[0].emission, Rgb::splat(9.0));
    assert_eq!(materials(&scene, "floor")[0].emission, Rgb::splat(1.0));
}

#[test]
fn models_of_the_program_change_by_name_too() {
    let folder = folder();
    make(
        &folder,
        &[
            "a.rad",
            "1",
            "--reflectance",
            "cube=0.9,0.1,0.1",
            "--light-power",
            "lamp=50",
        ],
    );
    let scene = load(&folder, "a.rad");
    assert_eq!(
        materials(&scene, "cube")[0].reflectance,
        Rgb::new(0.9, 0.1, 0.1)
    );
    assert!((scene.emitted_power().x - 50.0).abs() < 1e-4);
}

#[test]
fn names_that_nothing_has_and_values_out_of_range_are_errors() {
    let folder = model();
    let message = failure(&folder, &["a.rad", "m.obj", "--light", "lamp=1"]);
    assert!(
        message.contains("\"lamp\"") && message.contains("--list"),
        "{message}"
    );
    for (option, part) in [
        (["--reflectance", "grey=1"], "\"grey\": 1 is outside"),
        (["--light", "grey=-1,0,0"], "\"grey\": -1 is not"),
        (["--light", "grey=nan"], "\"grey\": NaN is not"),
        (["--light-power", "grey=inf"], "\"grey\": inf is not"),
        (["--light", "grey"], "is not a name"),
        (["--light", "grey=1,2"], "is not a name"),
        (["--light", "grey=bright"], "is not a name"),
        (["--max-reflectance", "1"], "--max-reflectance 1 is outside"),
        (["--orient", "up"], "auto, normals, winding"),
    ] {
        let message = usage_error(&[&["a.rad", "furnace"], &option[..]].concat());
        assert!(message.contains(part), "{part} is missing in {message}");
    }
}

#[test]
fn the_list_has_all_objects_and_materials_with_their_areas() {
    let folder = model();
    let text = stdout(&make(&folder, &["a.rad", "m.obj", "--list"]));
    let found = |parts: &[&str]| {
        let mut lines = text.lines();
        let has = |line: &str| parts.iter().all(|part| line.contains(part));
        assert!(lines.any(has), "{parts:?} is missing in {text}");
    };
    found(&[" 2 ", " 2.000000e0 ", "a lamp"]);
    found(&[" 2 ", " 1.000000e0 ", "floor"]);
    found(&[" 4 ", " 3.000000e0 ", " 0.5 ", "grey"]);
    found(&[" 2 ", " 1.000000e0 ", " 0.1 ", "dark = black"]);
}

/// Neither the model nor what belongs to it, however it is named.
#[test]
fn no_file_of_the_model_is_overwritten() {
    let folder = model();
    for (out, code) in [("m.obj", 2), ("m.mtl", 1), ("./m.mtl", 1)] {
        let before =
            ["m.obj", "m.mtl"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
        let output = genx(&folder, &[out, "m.obj"]);
        assert_eq!(output.status.code(), Some(code), "{output:?}");
        assert!(
            stderr(&output).contains(&out[out.len() - 5..]),
            "{output:?}"
        );
        let after = ["m.obj", "m.mtl"].map(|name| std::fs::read(folder.path().join(name)).unwrap());
        assert_eq!(before, after);
    }
}

/// A rename would replace it without asking.
#[test]
fn a_read_only_file_is_not_replaced() {
    let folder = folder();
    let path = folder.path().join("a.rad");
    std::fs::write(&path, "mine").unwrap();
    let mut permissions = std::fs::metadata(&path).unwrap().permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(&path, permissions).unwrap();
    let message = failure(&folder, &["a.rad", "furnace"]);
    assert!(
        message.contains("a.rad") && message.contains("read-only"),
        "{message}"
    );
    assert_eq!(std::fs::read(&path).unwrap(), b"mine");
}

#[test]
fn faces_are_turned_and_given_a_second_side_by_name() {
    let folder = model();
    let made = |more: &[&str]| {
        make(
            &folder,
            &[&["a.rad", "m.obj", "--max-area", "inf"], more].concat(),
        );
        load(&folder, "a.rad")
    };
    // z of the normals of the surfaces of one object, and the file's triangles that these are.
    let sides = |scene: &Scene, object: &str| -> Vec<(f64, u32)> {
        let surfaces = scene.surfaces().iter().zip(scene.faces());
        let of_object = surfaces.filter(|(s, _)| scene.object(s.object) == object);
        of_object.map(|(s, &face)| (s.normal().z, face)).collect()
    };
    let plain = made(&[]);
    assert_eq!(sides(&plain, "floor"), [(1.0, 0), (1.0, 1)]);
    let flipped = made(&["--flip", "floor"]);
    assert_eq!(sides(&flipped, "floor"), [(-1.0, 0), (-1.0, 1)]);
    assert_eq!(sides(&flipped, "roof"), sides(&plain, "roof"));
    let both = made(&["--two-sided", "floor"]);
    let expected = [(1.0, 0), (1.0, 1), (-1.0, 0), (-1.0, 1)];
    assert_eq!(sides(&both, "floor"), expected);
    assert_eq!(both.surfaces().len(), plain.surfaces().len() + 2);
    let message = failure(&folder, &["b.rad", "m.obj", "--flip", "flor"]);
    assert!(message.contains("\"flor\""), "{message}");
}

/// As a sheet that faces in or out, as a sheet with both sides, and as a body.
#[test]
fn an_opening_is_taken_out_with_what_lies_below_it() {
    let folder = folder();
    let wall = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\n\
        v 1 1 -1\nv 2 1 -1\nv 2 2 -1\nv 1 2 -1\no wall\nf 1 2 3 4\no window\n";
    let body = "f 5 6 7 8\nf 12 11 10 9\nf 5 9 10 6\nf 6 10 11 7\nf 7 11 12 8\nf 8 12 9 5\n";
    for (window, area) in [
        ("f 5 6 7 8\n", 1.0),
        ("f 8 7 6 5\n", 1.0),
        ("f 5 6 7 8\nf 8 7 6 5\n", 1.0),
        (body, 3.0),
    ] {
        std::fs::write(folder.path().join("m.obj"), format!("{wall}{window}")).unwrap();
        let common = ["a.rad", "m.obj", "--max-area", "inf", "--opening", "window"];
        let text = stdout(&make(&folder, &common));
        let line = format!("openings       {area} m^2, of \"window\"\n");
        assert!(text.contains(&line), "{text}");
        let scene = load(&folder, "a.rad");
        assert!((scene.area() - 15.0).abs() < 1e-6, "{window}");
        let openings: f64 = scene.openings().iter().map(scene::Opening::area).sum();
        assert!((openings - 2.0 * area).abs() < 1e-6, "{window}");
        assert_eq!(scene.materials().len(), 1);
        let is_window = |object| scene.object(object) == "window";
        assert!(scene.openings().iter().all(|o| is_window(o.object)));
        assert!(!scene.surfaces().iter().any(|s| is_window(s.object)));
        // The wall's own two.
        assert!(scene.faces().iter().all(|&face| face < 2));
    }
    // Models of the program have holes too, and a name that is given twice is taken out once.
    make(
        &folder,
        &["a.rad", "1", "--opening", "lamp", "--opening", "lamp"],
    );
    let scene = load(&folder, "a.rad");
    assert!(scene.emitted_power().x <= 0.0);
    let area: f64 = scene.openings().iter().map(scene::Opening::area).sum();
    assert!((area - 2.0 * 2.5 * 2.5).abs() < 1e-6);
    for (name, part) in [("windw", "\"windw\""), ("cube", "no surfaces")] {
        let more = ["a.rad", "1", "--opening", "lamp", "--opening", name];
        let message = failure(&folder, &more);
        assert!(message.contains(part), "{message}");
    }
}

#[test]
fn overlaps_are_cut_told_or_left_as_is_asked_for() {
    let folder = folder();
    let obj = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\nv 1 1 0\nv 2 1 0\nv 2 2 0\nv 1 2 0\n\
        o floor\nf 1 2 3 4\no rug\nf 5 6 7 8\n";
    std::fs::write(folder.path().join("m.obj"), obj).unwrap();
    let made = |cut: &str| {
        let output = make(
            &folder,
            &["a.rad", "m.obj", "--max-area", "inf", "--cut", cut],
        );
        (load(&folder, "a.rad").area(), stderr(&output))
    };
    for (cut, area, told) in [
        (
            "on",
            16.0,
            "\"rug\" lies in the plane of \"floor\", which is cut there: 1.0000e0 m^2",
        ),
        ("report", 17.0, "which would be cut there"),
        ("off", 17.0, ""),
    ] {
        let (found, said) = made(cut);
        assert!((found - area).abs() < 1e-5, "{cut}: {found}");
        assert!(
            said.contains(told) && said.contains("plane") != told.is_empty(),
            "{said}"
        );
    }
}
