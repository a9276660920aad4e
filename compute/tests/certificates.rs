//! What runs certify about themselves.

mod common;

use std::path::Path;

use common::{PIXELS, folder_with, grid, walls};
use common::{block, compute, folder, load, save, solve, stderr, stdout};
use glam::Vec3;
use scene::{ObjectId, Opening, State, Surface};
use serde_json::Value;

fn turned(surface: &Surface) -> Surface {
    let [a, b, c] = surface.corners;
    Surface {
        corners: [a, c, b],
        ..*surface
    }
}

fn report(folder: &Path) -> Value {
    let text = std::fs::read(folder.join("report.json")).unwrap();
    serde_json::from_slice(&text).unwrap()
}

/// A strict run with a report: exit code, standard error, the report's certificate. The result is
/// written whatever the code.
#[track_caller]
fn strict(folder: &Path, more: &[&str]) -> (Option<i32>, String, Value) {
    let arguments = [
        "in.rad",
        "out.rad",
        PIXELS,
        "--strict",
        "--report",
        "report.json",
    ];
    let output = compute(folder, &[&arguments[..], more].concat());
    let state = load(folder, "out.rad").state;
    assert!(!matches!(state, State::Unfinished { .. }));
    assert!(stdout(&output).contains("\ncertificate    "), "{output:?}");
    let certificate = report(folder)["certificate"].clone();
    (output.status.code(), stderr(&output), certificate)
}

#[track_caller]
fn assert_passes(folder: &Path, more: &[&str]) -> Value {
    let (code, said, certificate) = strict(folder, more);
    assert_eq!((code, said.as_str()), (Some(0), ""), "{certificate}");
    assert_eq!(certificate["violations"], Value::Array(Vec::new()));
    certificate
}

/// Exit code 1 and one line that has these words.
#[track_caller]
fn assert_fails(folder: &Path, more: &[&str], words: &[&str]) -> Value {
    let (code, said, certificate) = strict(folder, more);
    assert_eq!(code, Some(1), "{said}");
    assert!(
        said.starts_with("compute: error: out.rad is written, but "),
        "{said}"
    );
    assert_eq!(said.lines().count(), 1, "{said}");
    for word in words {
        assert!(said.contains(word), "{word} is missing in {said}");
    }
    certificate
}

#[test]
fn a_furnace_passes() {
    let folder = folder_with(&walls(Vec3::ONE), 0.02);
    let certificate = assert_passes(folder.path(), &[]);
    assert_eq!(certificate["open_share"], 0.0);
    assert_eq!(certificate["back_face_share"], 0.0);
    assert!(certificate["closure_error"].as_f64().unwrap() < common::methods::ROUNDING);
    assert_eq!(certificate["hidden_patches"], 0);
    assert_eq!(certificate["looks_closed"], true);
    assert!(certificate["opening"].is_null() && certificate["back_faces"].is_null());
}

#[test]
fn what_is_not_converged_fails() {
    let folder = folder_with(&walls(Vec3::ONE), 0.1);
    // After one iteration B = E + rho H with H = E: of E a half was absorbed, a half is on its way.
    let words = ["50.0 % of the emitted power", "at most 1.00 %", "residual"];
    let certificate = assert_fails(folder.path(), &["--iterations", "1"], &words);
    // Radiosities are f32, row sums exact.
    let imbalance = certificate["imbalance"].as_f64().unwrap();
    assert!((imbalance - 0.5).abs() < 1e-6, "{imbalance}");
}

/// Then there is no light yet whose balance could be judged, and nothing amiss to be told.
#[test]
fn form_factors_alone_are_certified() {
    let folder = folder_with(&walls(Vec3::ONE), 0.1);
    let certificate = assert_passes(folder.path(), &["--iterations", "0"]);
    assert_eq!(certificate["imbalance"], 1.0);
    assert!(certificate["reciprocity"]["rms"].as_f64().unwrap() > 0.0);
}

/// Every other wall sees the flipped one, whose front nobody sees: four adjacent ones a fraction of
/// 0.200044, the opposite one 0.199825 of it, 0.2000 in the mean.
#[test]
fn a_flipped_wall_is_named() {
    let mut walls = walls(Vec3::ONE);
    walls[3].1 = walls[3].1.iter().map(turned).collect();
    let folder = folder_with(&walls, 0.02);
    let certificate = assert_fails(
        folder.path(),
        &[],
        &["backs of surfaces, mostly of \"north\"", "at most 0.100 %"],
    );
    let share = certificate["back_face_share"].as_f64().unwrap();
    // Centroids miss the mean of a triangle of legs h = 0.2 by less than h^2/18 times the curvature of
    // the view over a wall, which is below 5; that is far more than pixels of 1/32 make of the mean of 320.
    assert!((share - 0.2).abs() < 0.2 * 0.2 / 18.0 * 5.0, "{share}");
    assert_eq!(certificate["back_faces"]["culprit"], "north");
    assert_ne!(certificate["back_faces"]["worst_object"], "north");
    // A wall of area 1 has 2 triangles of 2^5 patches of 1/64.
    assert_eq!(certificate["hidden_patches"], 64);

    // Without --strict it is a warning.
    let output = solve(folder.path(), &["in.rad", "out.rad", PIXELS]);
    let said = stderr(&output);
    assert!(said.starts_with("compute: warning: "), "{said}");
    assert!(said.contains("mostly of \"north\""), "{said}");
    assert!(stdout(&output).contains("beyond tolerances"), "{output:?}");
}

#[test]
fn a_missing_triangle_is_named() {
    let mut walls = walls(Vec3::ONE);
    // From inside, north (y = 1) has x from right to left.
    walls[3].1 = grid(Vec3::ONE, -Vec3::X, -Vec3::Z, 4);
    let complete = folder_with(&walls, 0.05);
    // A grid of corners beside two large triangles: T-junctions leak nothing either.
    assert_passes(complete.path(), &[]);
    walls[3].1.remove(13);
    let folder = folder_with(&walls, 0.05);
    let words = [
        "is an opening",
        "beside the surfaces of \"north\"",
        "looks closed",
    ];
    let certificate = assert_fails(folder.path(), &[], &words);
    assert_eq!(certificate["opening"]["culprit"], "north");
    assert_ne!(certificate["opening"]["worst_object"], "north");
    // By reciprocity the five other walls see of a hole of area 1/32 what it would see of them: all
    // that is not north, and north is flat. So the mean over the remaining area is 1/32 over it, within
    // what few pixels on a small hole are good for.
    let expected = 1.0 / 32.0 / (6.0 - 1.0 / 32.0);
    let share = certificate["open_share"].as_f64().unwrap();
    assert!((share / expected - 1.0).abs() < 0.1, "{share} {expected}");
}

/// The corners of a quarter of north, as two triangles, are taken out on purpose, whichever way they were wound: by
/// reciprocity the mean share of the rest that sees them is 1/4 over its area, and none of it is held against the scene.
#[test]
fn openings_that_are_meant_pass() {
    let mut walls = walls(Vec3::ONE);
    walls[3].1 = grid(Vec3::ONE, -Vec3::X, -Vec3::Z, 4);
    let window: Vec<Surface> = [0, 1, 4, 5]
        .iter()
        .flat_map(|&k| walls[3].1[2 * k..2 * k + 2].to_vec())
        .collect();
    walls[3].1.retain(|surface| !window.contains(surface));
    let openings: Vec<Opening> = window
        .iter()
        .flat_map(|surface| [*surface, turned(surface)])
        .map(|Surface { corners, .. }| Opening {
            corners,
            object: ObjectId(3),
        })
        .collect();
    let with = |walls: &[(&str, Vec<Surface>)]| {
        let scene = common::named(walls, 0.05).with_openings(openings.clone());
        let folder = folder();
        save(folder.path(), "in.rad", &scene.unwrap());
        folder
    };
    let certificate = assert_passes(with(&walls).path(), &[]);
    let share = |name: &str| certificate[name].as_f64().unwrap();
    let expected = 0.25 / 5.75;
    // A patch counts its pixels of it to some percent; some 300 patches even out.
    assert!((share("open_share") / expected - 1.0).abs() < 0.02);
    assert_eq!(certificate["meant_open_share"], certificate["open_share"]);
    assert_eq!(certificate["looks_closed"], true);
    assert!(certificate["opening"].is_null(), "{certificate}");

    // A triangle that is missing as well is told, and not the window that patches see more of.
    let floor = grid(Vec3::ZERO, Vec3::X, Vec3::Y, 4);
    walls[0].1 = floor[1..].to_vec();
    let words = ["is an opening", "beside the surfaces of \"floor\""];
    let certificate = assert_fails(with(&walls).path(), &[], &words);
    let share = |name: &str| certificate[name].as_f64().unwrap();
    let hole = 1.0 / 32.0 / (5.75 - 1.0 / 32.0);
    let unmeant = share("open_share") - share("meant_open_share");
    // What sees both is allowed a tenth more of the window than it sees, and some pixels.
    assert!(
        unmeant < hole && unmeant > 0.5 * hole,
        "{unmeant} of {hole}"
    );
}

#[test]
fn an_open_scene_passes() {
    let mut walls = walls(Vec3::ONE);
    walls.remove(3);
    let folder = folder_with(&walls, 0.02);
    let certificate = assert_passes(folder.path(), &["--points", "4"]);
    assert_eq!(certificate["looks_closed"], false);
    assert!(certificate["open_share"].as_f64().unwrap() > 0.1);
}

/// The floor under a block without a bottom sees the block's backs, and the block hides it: nothing is
/// wrong.
#[test]
fn what_nobody_sees_does_not_count() {
    let third = 1.0 / 3.0;
    let mut objects = walls(Vec3::ONE);
    objects[0].1 = grid(Vec3::ZERO, Vec3::X, Vec3::Y, 3);
    let stand = objects[0].1[8].corners;
    let (low, high) = (stand[0], stand[2] + third * Vec3::Z);
    let bottomless = block(low, high, true, 0)[2..].to_vec();
    objects.push(("block", bottomless));
    let folder = folder_with(&objects, 0.01);
    let certificate = assert_passes(folder.path(), &["--points", "4"]);
    // The floor's middle ninth: two triangles of 1/18, bisected three times.
    assert_eq!(certificate["hidden_patches"], 16);
    assert_eq!(certificate["back_face_share"], 0.0);
    let report = report(folder.path());
    let all = report["back_face_share"].as_f64().unwrap();
    assert!(all > 0.01, "{all}");
}

/// From the centroid of a triangle of area 8 a square of area 1 close above it fills most of the
/// sky, but only a small part of all that leaves the triangle can reach it.
#[test]
fn one_point_of_a_large_patch_misses_reciprocity() {
    let floor = grid(Vec3::ZERO, 4.0 * Vec3::X, 4.0 * Vec3::Y, 1);
    let [a, b, c] = floor[0].corners;
    let corner = (a + b + c) / 3.0 + Vec3::new(-0.5, -0.5, 0.2);
    let plate = grid(corner + Vec3::Y, Vec3::X, -Vec3::Y, 1);
    let folder = folder_with(&[("floor", floor), ("plate", plate)], f64::INFINITY);
    let misses = ["miss reciprocity", "at most 5.00 %"];
    let certificate = assert_fails(folder.path(), &["--points", "centroid"], &misses);
    assert!(
        certificate["reciprocity"]["rms"].as_f64().unwrap() > 0.5,
        "{certificate}"
    );
    assert_passes(folder.path(), &["--points", "96"]);
}

#[test]
fn certificates_do_not_depend_on_threads_memory_or_order() {
    let folder = folder();
    save(folder.path(), "in.rad", &common::colourful_room(0.2));
    let reciprocity = |more: &[&str]| {
        let (_, _, certificate) = strict(folder.path(), more);
        assert!(certificate["reciprocity"]["rms"].as_f64().unwrap() > 0.0);
        certificate["reciprocity"].clone()
    };
    let expected = reciprocity(&["--threads", "1"]);
    for more in [
        &["--threads", "3"][..],
        &["--memory", "0KiB", "--iterations", "3"],
        &[
            "--solver",
            "shooting",
            "--iterations",
            "20",
            "--threads",
            "2",
        ],
        &["--iterations", "0"],
    ] {
        assert_eq!(reciprocity(more), expected, "{more:?}");
    }
}

#[test]
fn a_result_can_be_certified_later() {
    let folder = folder_with(&walls(Vec3::ONE), 0.1);
    solve(folder.path(), &["in.rad", "in.rad", PIXELS]);
    let arguments = [
        "in.rad",
        "out.rad",
        PIXELS,
        "--iterations",
        "1",
        "--report",
        "report.json",
    ];
    solve(folder.path(), &arguments);
    let certificate = &report(folder.path())["certificate"];
    assert_eq!(certificate["rows_drawn"], 0);
    for unknown in ["reciprocity", "open_share", "hidden_patches", "imbalance"] {
        assert!(certificate[unknown].is_null(), "{certificate}");
    }
    let (code, said, certificate) = strict(folder.path(), &["--iterations", "1"]);
    assert_eq!(code, Some(0), "{said}");
    assert_eq!(certificate["rows_drawn"], report(folder.path())["patches"]);
}

#[test]
fn help_states_the_tolerances() {
    use ::compute::certificate as c;
    let help = stdout(&solve(&std::env::temp_dir(), &["--help"]));
    for (name, value) in [
        ("openings", c::OPEN_SHARE_TOLERANCE),
        ("back faces", c::BACK_FACE_SHARE_TOLERANCE),
        ("power balance", c::IMBALANCE_TOLERANCE),
        ("reciprocity", c::RECIPROCITY_TOLERANCE),
        ("closure", c::CLOSURE_TOLERANCE),
    ] {
        let line = help
            .lines()
            .find(|line| line.starts_with(&format!("  {name}  ")));
        let line = line.unwrap_or_else(|| panic!("{name} is missing in {help}"));
        let stated = [
            format!(" {value:e} "),
            format!(" {value:e}:"),
            format!(" {} percent", 100.0 * value),
        ];
        assert!(stated.iter().any(|text| line.contains(text)), "{line}");
    }
    assert!(help.contains(&format!(
        "less than {} percent open",
        100.0 * c::LOOKS_CLOSED
    )));
}
