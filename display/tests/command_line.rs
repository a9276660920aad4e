//! The program by its command line.

mod common;

use std::path::Path;
use std::process::{Command, Output};

use common::{Builder, lit_room};
use glam::Vec3;
use tempfile::TempDir;

/// A folder with a solved scene, `room`, and the same unsolved, `unsolved`.
fn folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let (scene, solution) = lit_room();
    scene::file::save(&folder.path().join("room"), &scene, Some(&solution)).unwrap();
    scene::file::save(&folder.path().join("unsolved"), &scene, None).unwrap();
    folder
}

fn display(folder: &Path, arguments: &str) -> Output {
    Command::new(env!("CARGO_BIN_EXE_display"))
        .args(arguments.split_whitespace())
        .current_dir(folder)
        .output()
        .unwrap()
}

/// Runs the program, which is to end with this code, and gives what it printed and what it
/// complained.
fn run(folder: &Path, arguments: &str, code: i32) -> [String; 2] {
    let output = display(folder, arguments);
    let [out, err] = [output.stdout, output.stderr].map(|text| String::from_utf8(text).unwrap());
    assert_eq!(
        output.status.code(),
        Some(code),
        "display {arguments}\n{out}{err}"
    );
    [out, err]
}

fn names(folder: &Path) -> Vec<String> {
    let files = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = files
        .map(|f| f.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn no_arguments_print_the_usage() {
    let folder = folder();
    let [_, err] = run(folder.path(), "", 2);
    assert!(err.contains("Usage: display"), "{err}");
}

/// Whether the window's program is there or not: without a screen there is none.
#[test]
fn without_a_screen_there_is_a_line_that_says_what_makes_pictures() {
    let folder = folder();
    let mut command = Command::new(env!("CARGO_BIN_EXE_display"));
    for screen in ["DISPLAY", "WAYLAND_DISPLAY", "WAYLAND_SOCKET"] {
        command.env_remove(screen);
    }
    let output = command
        .arg("room")
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("window") && said.contains("--out"), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
}

#[test]
fn wrong_usage_exits_with_2_and_writes_nothing() {
    let folder = folder();
    let before = names(folder.path());
    for (arguments, said) in [
        ("room x --out a.png", "'x'"),
        ("room --out a.jpg", ".png or .exr"),
        ("room --out a", ".png or .exr"),
        ("room --export a.stl", ".ply or .glb or .obj or .csv"),
        ("room --out a.png --mode loud", "loud"),
        ("room --out a.png --size 0x5", "1 to 16384"),
        ("room --out a.png --size 5", "1024x768"),
        ("room --out a.png --size=-5x5", "1024x768"),
        ("room --out a.png --size 20000x5", "1 to 16384"),
        ("room --out a.png --size 16384x16384", "134217728"),
        ("room --out a.png --fov 180", "between 0 and 180"),
        ("room --out a.png --fov -1", "between 0 and 180"),
        ("room --out a.png --fov wide", "wide"),
        ("room --out a.png --eye 1,2", "three numbers"),
        ("room --out a.png --eye 1,2,inf", "eye"),
        (
            "room --out a.png --eye -1,2,3 --look-at -1,2,3",
            "move one of them",
        ),
        ("room --out a.png --range 5:2", "lower one first"),
        ("room --out a.png --range 0:2", "more than 0"),
        ("room --out a.png --range nan:2 --mode linear", "finite"),
        ("room --out a.png --range 2", "0.1:50"),
        ("room --out a.png --raw", "--mode ids"),
        ("room c --out a.png --contours 5", "no meaning"),
        ("room --out a.png --contours 5,inf", "finite"),
        ("room --out a.png --contours many", "many"),
        ("room --out a.png --channel yellow", "yellow"),
        (
            "room --out a.png --luminous --quantity reflectance",
            "no lumens",
        ),
        ("room c --out a.png --range room.rad", "no meaning"),
        ("room --by colour", "colour"),
        ("room --out a.gif", "--path"),
        ("room --out a.svg", "--plot"),
        ("room --path walk.txt --out a.exr", ".apng"),
        ("room --path walk.txt", "--out"),
        ("room --mask m.png --out a.png", "--compare"),
        ("room c --compare b.rad", "no meaning"),
        ("room --compare b.rad --out a.exr", ".png"),
        ("room --compare b.rad --luminous", "in W/m^2"),
        ("room --compare b.rad --quantity radiance", "in W/m^2"),
        ("room --hemicube 3 --luminous --out a.png", "--luminous"),
        (
            "room --hemicube 3 --quantity direct --out a.png",
            "--quantity",
        ),
        ("room --hemicube 3", "--out"),
        ("room --hemicube -3 --out a.png", "-3"),
        ("room --hemicube 3 --out a.exr", ".png"),
        ("--maps --out a.exr", ".png"),
        ("--maps room --out a.png", "--maps"),
        ("--plot report.json --out a.png", ".svg"),
        ("room.gif --path walk.txt --out room.gif", "is the input"),
        ("room c --out a.png --mode log", "--mode ids"),
        ("room c --out a.png --smooth", "no meaning"),
        ("room c --out a.exr", ".png"),
        ("room.csv --export room.csv", "is the input"),
        ("room --out a.png --gpu", "--gpu"),
    ] {
        let [out, err] = run(folder.path(), arguments, 2);
        assert!(err.contains(said), "display {arguments}: {err}");
        assert!(err.starts_with("display: error: "), "{err}");
        assert!(out.is_empty());
    }
    assert_eq!(names(folder.path()), before);
}

#[test]
fn files_that_cannot_be_read_or_written_exit_with_1_and_leave_nothing() {
    let folder = folder();
    std::fs::write(folder.path().join("text"), "not a scene").unwrap();
    std::fs::create_dir(folder.path().join("taken.png")).unwrap();
    let before = names(folder.path());
    for (arguments, said) in [
        ("missing --out a.png", "missing"),
        ("text --out a.png", "text"),
        ("room --out nowhere/a.png --size 8x6", "nowhere/a.png"),
        ("room --out nowhere/a.exr --size 8x6", "nowhere/a.exr"),
        ("room --out taken.png --size 8x6", "taken.png"),
        ("room --export nowhere/a.csv", "nowhere/a.csv"),
        ("room --export nowhere/a.glb", "nowhere/a.glb"),
    ] {
        let [out, err] = run(folder.path(), arguments, 1);
        assert!(
            err.contains(said) && err.lines().count() == 1,
            "display {arguments}: {err}"
        );
        assert!(err.starts_with("display: error: "), "{err}");
        // The file that was asked for, and no temporary one.
        assert!(!err.contains(".tmp"), "{err}");
        assert!(out.is_empty(), "{out}");
    }
    assert_eq!(names(folder.path()), before);
}

#[test]
fn picture_and_export_are_both_written_and_reported() {
    let folder = folder();
    let [out, err] = run(
        folder.path(),
        "room --out a.png --size 64x48 --range 0.1:50 --export a.csv",
        0,
    );
    assert_eq!(
        out,
        "a.png: 64x48, log radiosity, 0.1 to 50 W/m^2\na.csv: 2946 patches\n"
    );
    assert!(err.is_empty(), "{err}");
    let picture = image::open(folder.path().join("a.png")).unwrap();
    assert_eq!((picture.width(), picture.height()), (64, 48));
    let rows = std::fs::read_to_string(folder.path().join("a.csv"))
        .unwrap()
        .lines()
        .count();
    assert_eq!(rows, 2947);
}

#[test]
fn a_table_is_printed_and_says_its_units() {
    let folder = folder();
    let [out, err] = run(folder.path(), "room --by material --quantity irradiance", 0);
    assert!(err.is_empty(), "{err}");
    let headings = "material    patches  area m^2  minimum W/m^2  mean W/m^2  maximum W/m^2  received W  emitted W";
    assert!(out.starts_with(headings), "{out}");
    assert_eq!(out.lines().count(), 5, "{out}");
    let [lumens, _] = run(
        folder.path(),
        "room --by object --quantity irradiance --luminous",
        0,
    );
    assert!(
        lumens.contains("mean lx") && lumens.contains("received lm"),
        "{lumens}"
    );
}

/// What a file is like that is compared with itself, and with a picture of itself.
#[test]
fn a_file_does_not_differ_from_itself() {
    let folder = folder();
    std::fs::copy(folder.path().join("room"), folder.path().join("same.rad")).unwrap();
    let [out, err] = run(
        folder.path(),
        "room --compare same.rad --out d.png --size 64x48",
        0,
    );
    assert!(err.is_empty(), "{err}");
    let lines: Vec<&str> = out.lines().collect();
    assert!(
        lines[0].starts_with("same.rad: by area: power 0.00 %, visible 0.00 %, over 100 %"),
        "{out}"
    );
    assert!(
        lines[1].starts_with("same.rad: in the picture: power 0.00 %"),
        "{out}"
    );
    assert!(
        lines[2].starts_with("d.png: 64x48, the difference"),
        "{out}"
    );
    run(folder.path(), "room --out same.exr --size 64x48", 0);
    let [out, _] = run(folder.path(), "room --compare same.exr", 0);
    assert!(out.contains("power 0.00 %"), "{out}");
    let [_, err] = run(folder.path(), "room --compare same.exr --size 32x48", 1);
    assert!(
        err.contains("same.exr: 64x48 pixels") && err.contains("--size 64x48"),
        "{err}"
    );
    for missing in ["none.exr", "none.rad"] {
        let [_, err] = run(folder.path(), &format!("room --compare {missing}"), 1);
        assert!(
            err.starts_with(&format!("display: error: {missing}: ")),
            "{err}"
        );
    }
}

#[test]
fn a_path_makes_frames() {
    let folder = folder();
    std::fs::write(
        folder.path().join("walk.txt"),
        "0 0,1,4 0,1,0\n1 1,1,4 0,1,0 50\n",
    )
    .unwrap();
    for (name, last) in [
        ("w.gif", "w.gif"),
        ("w.apng", "w.apng"),
        ("w.png", "w-0003.png"),
    ] {
        let arguments = format!("room --path walk.txt --fps 2 --size 32x24 --out {name}");
        let [out, err] = run(folder.path(), &arguments, 0);
        assert_eq!(out, format!("{last}: 3 frames of 32x24, 2 a second\n"));
        assert!(err.is_empty(), "{err}");
        assert!(folder.path().join(last).exists());
    }
    std::fs::write(
        folder.path().join("bad.txt"),
        "0 0,1,4 0,1,0\n0 1,1,4 0,1,0\n",
    )
    .unwrap();
    let [_, err] = run(folder.path(), "room --path bad.txt --out b.gif", 1);
    assert!(
        err.starts_with("display: error: bad.txt: line 2: "),
        "{err}"
    );
    assert!(!folder.path().join("b.gif").exists());
}

#[test]
fn hemicubes_and_maps_are_pictures() {
    let folder = folder();
    let [out, err] = run(
        folder.path(),
        "room --hemicube 7 --resolution 32 --out h.png",
        0,
    );
    assert!(
        out.contains("what patch 7 sees: irradiance") && err.is_empty(),
        "{out} {err}"
    );
    let [out, _] = run(folder.path(), "--maps --resolution 32 --out m.png", 0);
    assert!(out.contains("multiplier maps of 32 pixels"), "{out}");
    for name in ["h.png", "m.png"] {
        assert!(image::open(folder.path().join(name)).is_ok(), "{name}");
    }
    let [_, err] = run(folder.path(), "room --hemicube 9999 --out x.png", 1);
    assert!(
        err.contains("patch 9999: the scene has 2946 patches"),
        "{err}"
    );
    let [_, err] = run(folder.path(), "--maps --resolution 31 --out x.png", 1);
    assert!(err.contains("31") && err.contains("even"), "{err}");
}

#[test]
fn lamps_are_dimmed_by_name() {
    let folder = folder();
    let (scene, mut solution) = common::lit_room();
    let half: Vec<scene::Rgb> = solution.irradiance.iter().map(|&h| 0.5 * h).collect();
    let layer = |name: &str| scene::layers::Layer {
        name: name.to_owned(),
        lamp: None,
        irradiance: half.clone(),
        vertices: Vec::new(),
    };
    solution.layers = Some(scene::layers::Layers {
        kind: scene::layers::LayerKind::Bounces,
        layers: vec![layer("first"), layer("others")],
    });
    scene::file::save(&folder.path().join("layers"), &scene, Some(&solution)).unwrap();
    let by = |mix: &str| {
        let arguments = format!("layers --by object --quantity irradiance{mix}");
        let [out, _] = run(folder.path(), &arguments, 0);
        let row = out.lines().nth(1).unwrap().to_owned();
        let received: f64 = row.split_whitespace().nth(6).unwrap().parse().unwrap();
        received
    };
    let all = by("");
    // Four digits of each.
    for (mix, factor) in [
        (" --mix first=1", 1.0),
        (" --mix first=0", 0.5),
        (" --mix first=3,others=0", 1.5),
    ] {
        assert!((by(mix) / all - factor).abs() < 2e-3, "{mix}");
    }
    let [_, err] = run(folder.path(), "layers --mix second=1 --out a.png", 1);
    assert!(err.contains("there are \"first\", \"others\""), "{err}");
    let [_, err] = run(folder.path(), "room --mix first=1 --out a.png", 1);
    assert!(err.contains("no layers"), "{err}");
}

/// A series of pictures of one scene is as bright as the last of them.
#[test]
fn the_range_of_another_file_can_be_taken() {
    let folder = folder();
    std::fs::copy(folder.path().join("room"), folder.path().join("last.rad")).unwrap();
    let [own, _] = run(folder.path(), "room --out a.png --size 64x48", 0);
    let [taken, _] = run(
        folder.path(),
        "room --out a.png --size 64x48 --range last.rad",
        0,
    );
    assert_eq!(own, taken);
    let [_, err] = run(folder.path(), "room --out b.png --range missing.rad", 1);
    assert!(err.contains("missing.rad: cannot read"), "{err}");
    assert!(!folder.path().join("b.png").exists());
}

#[test]
fn a_picture_of_one_value_says_so() {
    let folder = folder();
    let scene = common::closed_cube(2);
    let solution = common::solution(&scene, |_| scene::Rgb::splat(3.0));
    scene::file::save(&folder.path().join("furnace"), &scene, Some(&solution)).unwrap();
    let arguments = "furnace --out a.png --size 64x48 --quantity reflectance";
    let [_, err] = run(folder.path(), arguments, 0);
    assert!(
        err.contains("all that the camera sees has one reflectance, 0.5"),
        "{err}"
    );
}

#[test]
fn a_transparent_picture_is_so_where_there_is_nothing() {
    let folder = folder();
    run(
        folder.path(),
        "room --out a.png --size 64x48 --transparent --eye 0,1,30",
        0,
    );
    let picture = image::open(folder.path().join("a.png"))
        .unwrap()
        .into_rgba8();
    let alphas: Vec<u8> = picture.pixels().map(|pixel| pixel.0[3]).collect();
    assert!(alphas.contains(&0) && alphas.contains(&255));
    run(
        folder.path(),
        "room --out b.png --size 64x48 --eye 0,1,30",
        0,
    );
    let opaque = image::open(folder.path().join("b.png"))
        .unwrap()
        .into_rgb8();
    for (pixel, opaque) in picture.pixels().zip(opaque.pixels()) {
        if pixel.0[3] == 255 {
            assert_eq!(pixel.0[..3], opaque.0);
        }
    }
}

#[test]
fn every_mode_and_format_works_from_the_command_line() {
    let folder = folder();
    for arguments in [
        "room s --out a.png --size 64x48 --mode linear",
        "room --out a.png --size 64x48 --mode false-color --quantity irradiance",
        "room c --out a.png --size 64x48 --cull-back",
        "room c --out a.png --size 64x48 --raw",
        "room --out a.png --size 64x48 --mode filmic --channel red",
        "room --out a.png --size 64x48 --quantity irradiance --luminous --contours 10,100",
        "room --out a.png --size 64x48 --quantity reflectance --mode linear --transparent",
        "room --out a.exr --size 64x48 --quantity radiance",
        "room --out a.exr --size 64x48 --mode false-color",
        "room --out a.png --size 64x48 --eye -1,1,4 --look-at -0.5,1,-3 --fov 50 --up y",
        "room --export a.ply",
        "room --export a.glb --mode false-color",
        "room --export a.obj",
    ] {
        let [out, err] = run(folder.path(), arguments, 0);
        let file = out.split(':').next().unwrap();
        assert!(
            std::fs::metadata(folder.path().join(file)).unwrap().len() > 100,
            "{arguments}"
        );
        assert!(err.is_empty(), "{err}");
    }
}

#[test]
fn file_without_a_solution_shows_its_emission_and_says_so() {
    let folder = folder();
    let [_, err] = run(folder.path(), "unsolved --out a.png --size 64x48", 0);
    assert!(
        err.starts_with("display: note: unsolved: no solution") && err.lines().count() == 1,
        "{err}"
    );
    let picture = image::open(folder.path().join("a.png")).unwrap().to_rgb8();
    assert!(picture.pixels().any(|p| p.0 == [255; 3]), "the lamp");
}

#[test]
fn same_arguments_give_the_same_bytes() {
    let folder = folder();
    let bytes = |name: &str| {
        run(
            folder.path(),
            &format!("room --out {name} --size 64x48 --smooth"),
            0,
        );
        std::fs::read(folder.path().join(name)).unwrap()
    };
    assert!(bytes("a.png") == bytes("b.png"));
}

/// The room turned inside out: every surface shows its back.
fn inside_out(folder: &Path) {
    let (scene, solution) = lit_room();
    let surfaces = scene.surfaces().iter().map(|s| {
        let [a, b, c] = s.corners;
        scene::Surface {
            corners: [b, a, c],
            ..*s
        }
    });
    let depths: Vec<u32> = scene.mesh().trees().iter().map(|t| t.depth).collect();
    let turned = scene::Scene::new(
        scene.materials().to_vec(),
        scene.objects().to_vec(),
        surfaces.collect(),
        &depths,
        scene.origin(),
    );
    scene::file::save(&folder.join("turned"), &turned.unwrap(), Some(&solution)).unwrap();
}

#[test]
fn picture_of_backs_or_of_nothing_says_what_to_do() {
    let folder = folder();
    inside_out(folder.path());
    let view = "--out a.png --size 64x48 --eye 0,1.5,4 --look-at 0,1.5,-5";
    for (file, more, said) in [
        ("room", "", ""),
        ("room", "--cull-back", ""),
        ("turned", "", "--cull-back"),
        ("turned", "--mode ids", "--cull-back"),
        (
            "turned",
            "--eye 0,1.5,-1 --look-at 0,3,-1 --cull-back",
            "no front",
        ),
        ("room", "--look-at 0,1.5,90", "no surface"),
    ] {
        // What is given again is left out of the view.
        let mut view = view.to_owned();
        for option in ["--eye 0,1.5,4", "--look-at 0,1.5,-5"] {
            if more.contains(&option[..5]) {
                view = view.replace(option, "");
            }
        }
        let [_, err] = run(folder.path(), &format!("{file} {view} {more}"), 0);
        assert_eq!(err.is_empty(), said.is_empty(), "{file} {more}: {err}");
        if !said.is_empty() {
            assert!(err.starts_with("display: note: a.png: "), "{err}");
            assert!(err.contains(said) && err.lines().count() == 1, "{err}");
        }
    }
}

#[test]
fn solution_that_is_not_finished_is_noted_where_it_is_shown() {
    let folder = folder();
    let (scene, good) = lit_room();
    let save = |name: &str, iterations: u64, residuals: &[f64], irradiance: Vec<scene::Rgb>| {
        let mut solution = good.clone();
        solution.irradiance = irradiance;
        solution.provenance.iterations = iterations;
        solution.provenance.residuals = residuals.to_vec();
        scene::file::save(&folder.path().join(name), &scene, Some(&solution)).unwrap();
    };
    let dark = scene::Solution::dark(&scene).irradiance;
    save("fresh", 0, &[], dark.clone());
    save("coarse", 2, &[0.5, 0.02], good.irradiance.clone());
    save("odd", 1, &[f64::NAN], good.irradiance.clone());
    save("good", 2, &[0.5, 1e-3], good.irradiance.clone());
    save("changed", 2, &[], good.irradiance.clone());
    for (file, said) in [
        ("unsolved", "no solution"),
        ("fresh", "0 iterations"),
        ("coarse", "the last residual 2.0e-2 is above 1e-3"),
        ("odd", "the last residual NaN"),
        ("good", ""),
        ("changed", ""),
    ] {
        for output in [
            "--out a.png --size 64x48",
            "--export a.csv",
            "--export a.ply",
        ] {
            let [_, err] = run(folder.path(), &format!("{file} {output}"), 0);
            assert_eq!(err.lines().count(), usize::from(!said.is_empty()), "{err}");
            if !said.is_empty() {
                let start = format!("display: note: {file}: ");
                assert!(err.starts_with(&start) && err.contains(said), "{err}");
            }
        }
        for output in [
            "c --out a.png --size 64x48",
            "--export a.obj",
            "c --export a.ply",
        ] {
            let [_, err] = run(folder.path(), &format!("{file} {output}"), 0);
            assert!(err.is_empty(), "{file} {output}: {err}");
        }
    }
}

#[test]
fn scene_that_nothing_lights_says_so() {
    let folder = folder();
    let mut builder = common::Builder::default();
    let wall = builder.material(0.7, 0.0);
    builder.quad(
        [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [1.0, 1.0, 0.0],
            [0.0, 1.0, 0.0],
        ],
        wall,
        0,
    );
    let scene = builder.scene();
    let solution = scene::Solution::dark(&scene);
    scene::file::save(&folder.path().join("dark"), &scene, Some(&solution)).unwrap();
    for output in [
        "--out a.png --size 64x48 --eye 0,0,4 --look-at 0,0,0",
        "--export a.csv",
    ] {
        let [_, err] = run(folder.path(), &format!("dark {output}"), 0);
        assert!(
            err.starts_with("display: note: dark: nothing emits"),
            "{err}"
        );
        assert_eq!(err.lines().count(), 1, "{err}");
    }
    let [_, err] = run(folder.path(), "dark --export a.obj", 0);
    assert!(err.is_empty(), "{err}");
}

/// A cube that faces outwards with a lamp in it: from outside all is black, and from inside too but for the lamp.
#[test]
fn a_lamp_that_shines_on_backs_is_told_in_one_line_and_the_picture_is_not_black() {
    let folder = folder();
    let mut builder = Builder::default();
    let (wall, lamp) = (builder.material(0.5, 0.0), builder.material(0.0, 5.0));
    builder.block(Vec3::NEG_ONE, Vec3::ONE, wall, 2);
    builder.quad(
        [
            [-0.3, -0.3, 0.8],
            [-0.3, 0.3, 0.8],
            [0.3, 0.3, 0.8],
            [0.3, -0.3, 0.8],
        ],
        lamp,
        0,
    );
    let scene = builder.scene();
    let mut solution = scene::Solution::dark(&scene);
    solution.provenance.iterations = 1;
    solution.provenance.residuals = vec![0.0];
    scene::file::save(&folder.path().join("cube"), &scene, Some(&solution)).unwrap();
    let [_, err] = run(folder.path(), "cube --out a.png --size 64x48", 0);
    assert_eq!(err.lines().count(), 1, "{err}");
    for part in [
        "cube: ",
        "backs of \"all\"",
        "genx --flip \"all\"",
        "--two-sided",
    ] {
        assert!(err.contains(part), "{part} is missing in {err}");
    }
    let picture = image::open(folder.path().join("a.png"))
        .unwrap()
        .into_rgb8();
    let lit = picture.pixels().filter(|pixel| pixel.0 != [0; 3]).count();
    assert!(lit > 64 * 48 / 10, "{lit}");
}

#[test]
fn materials_that_no_export_has_written_are_not_replaced() {
    let folder = folder();
    let mtl = folder.path().join("a.mtl");
    let [out, _] = run(folder.path(), "room --export a.obj", 0);
    assert_eq!(out, "a.obj: 2946 patches, materials in a.mtl\n");
    // Its own one it may replace.
    run(folder.path(), "room --export a.obj", 0);
    std::fs::write(&mtl, "newmtl mine\nKd 0.5 0.5 0.5\n").unwrap();
    std::fs::remove_file(folder.path().join("a.obj")).unwrap();
    let before = names(folder.path());
    let [out, err] = run(folder.path(), "room --export a.obj", 1);
    assert!(out.is_empty());
    assert!(
        err.starts_with("display: error: a.mtl: ") && err.contains("choose another name"),
        "{err}"
    );
    assert_eq!(names(folder.path()), before);
    assert!(std::fs::read_to_string(&mtl).unwrap().contains("mine"));
    // A scene may have any name.
    std::fs::rename(folder.path().join("room"), &mtl).unwrap();
    let scene = std::fs::read(&mtl).unwrap();
    run(folder.path(), "a.mtl --export a.obj", 1);
    assert_eq!(std::fs::read(&mtl).unwrap(), scene);
}

#[test]
fn output_that_is_the_input_by_another_name_is_refused() {
    let folder = folder();
    std::fs::rename(folder.path().join("room"), folder.path().join("room.csv")).unwrap();
    let before = std::fs::read(folder.path().join("room.csv")).unwrap();
    for other in ["./room.csv", "../X/room.csv"] {
        let name = folder.path().file_name().unwrap().to_str().unwrap();
        let other = other.replace('X', name);
        let [_, err] = run(folder.path(), &format!("room.csv --export {other}"), 2);
        assert!(err.contains("is the input"), "{err}");
    }
    assert_eq!(
        std::fs::read(folder.path().join("room.csv")).unwrap(),
        before
    );
}
