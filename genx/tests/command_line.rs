//! The program by its command line.

mod common;

use std::path::PathBuf;

use common::program::{
    failure, files, folder, genx, load, make, stderr, stdout, usage_error, write_obj,
};

use scene::Rgb;
use scene::file::OutputLock;

#[test]
fn without_arguments_the_usage_is_printed() {
    let message = usage_error(&[]);
    assert!(message.contains("Usage: genx OUT MODEL"), "{message}");
}

#[test]
fn help_names_every_model_and_is_no_error() {
    let output = make(&folder(), &["--help"]);
    let help = stdout(&output);
    for word in [
        "1 ",
        "2 ",
        "3 ",
        "cornell",
        "furnace",
        "FILE.obj",
        "--max-area",
        "inf",
    ] {
        assert!(help.contains(word), "{word} is missing in {help}");
    }
    assert!(stdout(&make(&folder(), &["--version"])).starts_with("genx "));
}

#[test]
fn unknown_models_are_usage_errors_that_list_the_choices() {
    for model in ["4", "0", "hall", "Cornell", "model.stl", "obj", ""] {
        let message = usage_error(&["out.rad", model]);
        assert!(
            message.starts_with("genx: error: ")
                && message.contains("choose 1, 2, 3, cornell, furnace"),
            "{message}"
        );
    }
}

#[test]
fn the_last_three_positionals_are_all_or_none() {
    for arguments in [&["out.rad", "1", "5"][..], &["out.rad", "1", "5", "0.5"]] {
        let message = usage_error(arguments);
        assert!(message.contains("use --max-area"), "{message}");
    }
    usage_error(&["out.rad", "1", "5", "0.5", "10", "6"]);
    usage_error(&["out.rad"]);
}

#[test]
fn threshold_and_max_area_together_are_a_usage_error() {
    let message = usage_error(&["out.rad", "1", "5", "0.5", "10", "--max-area", "5"]);
    assert!(message.contains("give one of them"), "{message}");
}

#[test]
fn numbers_outside_their_ranges_are_usage_errors_that_name_value_and_limit() {
    for (numbers, value, limit) in [
        (["0", "0.5", "1"], "area threshold 0 ", "above 0"),
        (["-5", "0.5", "1"], "area threshold -5 ", "above 0"),
        (["nan", "0.5", "1"], "area threshold NaN ", "above 0"),
        (["1", "1", "1"], "REFLECTANCE 1 ", "[0, 1)"),
        (["1", "-0.25", "1"], "REFLECTANCE -0.25 ", "[0, 1)"),
        (["1", "nan", "1"], "REFLECTANCE NaN ", "[0, 1)"),
        (["1", "0.5", "-1"], "LIGHT_POWER -1 ", ">= 0"),
        (["1", "0.5", "inf"], "LIGHT_POWER inf ", ">= 0"),
        (["1", "0.5", "1e39"], "LIGHT_POWER inf ", ">= 0"),
        (["1", "0.5", "nan"], "LIGHT_POWER NaN ", ">= 0"),
        (["wide", "0.5", "1"], "wide", "AREA_THRESHOLD"),
    ] {
        let [area, reflectance, power] = numbers;
        let message = usage_error(&["out.rad", "furnace", area, reflectance, power]);
        assert!(
            message.contains(value) && message.contains(limit),
            "{message}"
        );
    }
    let message = usage_error(&["out.rad", "furnace", "--max-area", "-1"]);
    assert!(message.contains("above 0"), "{message}");
}

#[test]
fn the_example_of_the_thesis_makes_what_it_says() {
    let folder = folder();
    let output = make(&folder, &["model1.out", "1", "2.5", "0.15", "100000"]);
    let scene = load(&folder, "model1.out");
    assert!(scene.patch_areas().iter().all(|&area| area <= 2.5));
    assert!(
        scene
            .materials()
            .iter()
            .all(|m| m.reflectance == Rgb::splat(0.15))
    );
    // The lamp's 2.5 m by 2.5 m at 100,000 W/m^2; all of these numbers are exact.
    assert_eq!(scene.emitted_power(), glam::DVec3::splat(625_000.0));
    let text = stdout(&output);
    for (name, value) in [
        ("surfaces", scene.surfaces().len().to_string()),
        ("patches", scene.patch_count().to_string()),
        ("area", "600 m^2".to_owned()),
        (
            "emitted power",
            "625000 625000 625000 W (red, green, blue)".to_owned(),
        ),
    ] {
        assert!(
            text.lines()
                .any(|line| line.starts_with(name) && line.ends_with(&format!(" {value}"))),
            "{name} {value} is missing in {text}"
        );
    }
    assert_eq!(stderr(&output), "");
    assert_eq!(files(folder.path()), ["model1.out"]);
}

#[test]
fn every_model_makes_a_file_that_loads() {
    for model in ["1", "2", "3", "cornell", "furnace"] {
        let folder = folder();
        make(&folder, &["out.rad", model]);
        assert!(load(&folder, "out.rad").patch_count() > 100, "{model}");
    }
}

#[test]
fn the_same_command_makes_the_same_bytes() {
    let folder = folder();
    make(&folder, &["a.rad", "cornell"]);
    make(&folder, &["b.rad", "cornell"]);
    let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
    assert_eq!(bytes("a.rad"), bytes("b.rad"));
}

#[test]
fn max_area_and_the_positional_mean_the_same() {
    let folder = folder();
    make(&folder, &["a.rad", "furnace", "0.01", "0.5", "1"]);
    make(&folder, &["b.rad", "furnace", "--max-area", "0.01"]);
    make(&folder, &["c.rad", "--max-area=0.01", "furnace"]);
    let a = load(&folder, "a.rad");
    assert_eq!(a, load(&folder, "b.rad"));
    assert_eq!(a, load(&folder, "c.rad"));
}

#[test]
fn infinite_area_keeps_the_triangles_of_an_obj_file_in_order() {
    for arguments in [
        &["out.rad", "model.obj", "--max-area", "inf"][..],
        &["out.rad", "model.obj", "inf", "0.5", "1"],
    ] {
        let folder = folder();
        write_obj(&folder, "model.obj");
        let output = make(&folder, arguments);
        let scene = load(&folder, "out.rad");
        // A pentagon and a square.
        assert_eq!(scene.patch_count(), 3 + 2);
        let objects: Vec<&str> = scene
            .surfaces()
            .iter()
            .map(|s| scene.object(s.object))
            .collect();
        assert_eq!(objects, ["bottom", "bottom", "bottom", "top", "top"]);
        let text = stdout(&output);
        assert!(
            text.contains("2 faces, 2 of them polygons, cut into triangles"),
            "{text}"
        );
    }
}

#[test]
fn obj_files_get_some_thousand_patches_unless_told_otherwise() {
    let folder = folder();
    write_obj(&folder, "MODEL.OBJ");
    make(&folder, &["out.rad", "MODEL.OBJ"]);
    let patches = load(&folder, "out.rad").patch_count();
    // Each patch has more than half the threshold, a 4000th of the area.
    assert!((4000..8000).contains(&patches), "{patches}");
}

#[test]
fn power_scales_an_obj_files_emission_and_reflectance_leaves_its_lamps() {
    let folder = folder();
    write_obj(&folder, "model.obj");
    make(&folder, &["out.rad", "model.obj", "1", "0.25", "8"]);
    let scene = load(&folder, "out.rad");
    let material = |name: &str| scene.materials().iter().find(|m| m.name == name).unwrap();
    assert_eq!(material("lamp").emission, Rgb::new(8.0, 4.0, 2.0));
    assert_eq!(material("lamp").reflectance, Rgb::splat(0.2));
    assert_eq!(material("floor").reflectance, Rgb::splat(0.25));
}

#[test]
fn an_obj_file_without_emitters_or_mtl_is_made_with_warnings() {
    let folder = folder();
    let text =
        "mtllib missing.mtl\nusemtl grey\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nf 1 2 3\nf 1 2 4\n";
    std::fs::write(folder.path().join("model.obj"), text).unwrap();
    let output = make(&folder, &["out.rad", "model.obj", "--max-area", "inf"]);
    let warnings = stderr(&output);
    for word in [
        "missing.mtl",
        "nothing emits",
        "1 of 2 triangles have no area and are dropped",
    ] {
        assert!(warnings.contains(word), "{word} is missing in {warnings}");
    }
    assert!(
        warnings
            .lines()
            .all(|line| line.starts_with("genx: warning: "))
    );
    assert_eq!(load(&folder, "out.rad").patch_count(), 1);
}

/// White as most programs write it, which no solution could have, is nearly white.
#[test]
fn white_is_nearly_white_unless_it_is_given_something_else() {
    let folder = folder();
    write_obj(&folder, "model.obj");
    let mtl = "newmtl lamp\nKd 0.9999\nKe 4 2 1\nnewmtl floor\nKd 1.0 0.5 1.5\n";
    std::fs::write(folder.path().join("model.mtl"), mtl).unwrap();
    let reflectances = |more: &[&str]| {
        let output = genx(&folder, &[&["out.rad", "model.obj"], more].concat());
        assert_eq!(output.status.code(), Some(0), "{output:?}");
        let scene = load(&folder, "out.rad");
        let of = |name: &str| {
            let mut materials = scene.materials().iter();
            materials.find(|m| m.name == name).unwrap().reflectance
        };
        let said = String::from_utf8(output.stderr).unwrap();
        ([of("lamp"), of("floor")], said)
    };
    let lamp = Rgb::splat(0.9999);
    let (found, said) = reflectances(&[]);
    assert_eq!(found, [lamp, Rgb::new(0.95, 0.5, 0.95)]);
    assert_eq!(said.lines().count(), 1, "{said}");
    for word in ["\"floor\"", "1 0.5 1.5", "--reflectance \"floor\"=R,G,B"] {
        assert!(said.contains(word), "{word} is missing in {said}");
    }
    let (found, _) = reflectances(&["--max-reflectance", "0.8"]);
    assert_eq!(found, [Rgb::splat(0.8), Rgb::new(0.8, 0.5, 0.8)]);
    let (found, said) = reflectances(&["--reflectance", "floor=0.9,0.8,0.7"]);
    assert_eq!(found, [lamp, Rgb::new(0.9, 0.8, 0.7)]);
    assert_eq!(said, "", "what no longer matters is not told");
    let (found, said) = reflectances(&["inf", "0.25", "8"]);
    assert_eq!(found, [lamp, Rgb::splat(0.25)]);
    assert_eq!(said, "");
}

#[test]
fn bad_obj_files_fail_and_leave_nothing() {
    let folder = folder();
    for (name, text) in [
        ("empty.obj", ""),
        ("not.obj", "this is a letter, not a model\n"),
        ("faceless.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n"),
        ("range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n"),
        ("nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
    ] {
        std::fs::write(folder.path().join(name), text).unwrap();
        let message = failure(&folder, &["out.rad", name]);
        assert!(message.contains(name), "{message}");
    }
    let message = failure(&folder, &["out.rad", "missing.obj"]);
    assert!(message.contains("missing.obj"), "{message}");
}

#[test]
fn more_patches_than_ids_fail_and_leave_nothing() {
    let message = failure(&folder(), &["out.rad", "furnace", "--max-area", "1e-9"]);
    assert!(message.contains("16777215"), "{message}");
}

#[test]
fn a_missing_folder_is_named() {
    let message = failure(&folder(), &["nowhere/out.rad", "1"]);
    assert!(message.contains("nowhere/out.rad"), "{message}");
}

#[test]
fn a_folder_is_no_output() {
    let folder = folder();
    std::fs::create_dir(folder.path().join("out.rad")).unwrap();
    failure(&folder, &["out.rad", "1"]);
}

#[test]
fn failures_leave_an_existing_output_as_it_was() {
    let folder = folder();
    make(&folder, &["out.rad", "furnace"]);
    let bytes = || std::fs::read(folder.path().join("out.rad")).unwrap();
    let before = bytes();
    failure(&folder, &["out.rad", "missing.obj"]);
    failure(&folder, &["out.rad", "1", "--max-area", "1e-9"]);
    assert_eq!(genx(&folder, &["out.rad", "9"]).status.code(), Some(2));
    assert_eq!(bytes(), before);
    make(&folder, &["out.rad", "1"]);
    assert_ne!(bytes(), before);
}

#[test]
fn two_programs_do_not_write_the_same_output() {
    let folder = folder();
    let out: PathBuf = folder.path().join("out.rad");
    let lock = OutputLock::acquire(&out).unwrap();
    let message = failure(&folder, &["out.rad", "1"]);
    assert!(message.contains("another program"), "{message}");
    drop(lock);
    make(&folder, &["out.rad", "1"]);
}

#[test]
fn the_model_is_never_overwritten_by_its_scene() {
    let folder = folder();
    write_obj(&folder, "model.obj");
    let text = || std::fs::read(folder.path().join("model.obj")).unwrap();
    let before = text();
    let output = genx(&folder, &["./model.obj", "model.obj"]);
    assert_eq!(output.status.code(), Some(2));
    assert_eq!(text(), before);
}

#[test]
fn file_keeps_the_faces_of_an_import_and_the_numbers_of_a_models_surfaces() {
    let folder = folder();
    let obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 2\nf 1 2 3 4\nf 3 3 3\nf 1 2 3\nf 3 2 1\n";
    std::fs::write(folder.path().join("a.obj"), obj).unwrap();
    make(&folder, &["a.rad", "a.obj"]);
    let scene = load(&folder, "a.rad");
    assert!(scene.patch_count() > 3);
    // Of the triangles 1 and 4, which are the same, one is left; 5 faces the other way.
    assert_eq!(scene.faces(), [1, 2, 5]);
    make(&folder, &["cube.rad", "1"]);
    let scene = load(&folder, "cube.rad");
    let numbers: Vec<u32> = (0..scene.surfaces().len() as u32).collect();
    assert_eq!(scene.faces(), numbers);
}
