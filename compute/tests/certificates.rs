//! What runs certify about themselves, and view factors between objects.

mod common;

use std::collections::BTreeMap;
use std::path::Path;

use common::{block, compute, folder, load, material, quad, save, solve, stderr, stdout};
use glam::{DVec3, Vec3};
use scene::{MaterialId, ObjectId, Scene, Surface};
use serde_json::Value;
use tempfile::TempDir;

/// Pixels along a face in these tests, where the number does not matter.
const PIXELS: &str = "64";

/// A scene of named objects whose materials reflect half and emit 1, in a folder, as `in.rad`.
fn folder_with(objects: &[(&str, Vec<Surface>)], max_area: f64) -> TempDir {
    let folder = folder();
    save(folder.path(), "in.rad", &named(objects, max_area));
    folder
}

fn named(objects: &[(&str, Vec<Surface>)], max_area: f64) -> Scene {
    let names = objects.iter().map(|(name, _)| (*name).to_owned()).collect();
    let mut surfaces = Vec::new();
    for (object, (_, of_object)) in objects.iter().enumerate() {
        surfaces.extend(of_object.iter().map(|&surface| Surface {
            object: ObjectId(object as u32),
            material: MaterialId(0),
            ..surface
        }));
    }
    let materials = vec![material(0.5, 1.0)];
    Scene::with_max_area(materials, names, surfaces, max_area, DVec3::ZERO).unwrap()
}

const WALLS: [&str; 6] = ["floor", "ceiling", "south", "north", "west", "east"];

/// A box's walls, one object each, seen from inside.
fn walls(size: Vec3) -> Vec<(&'static str, Vec<Surface>)> {
    let surfaces = block(Vec3::ZERO, size, false, 0);
    let pairs = surfaces.chunks(2).map(<[Surface]>::to_vec);
    WALLS.into_iter().zip(pairs).collect()
}

/// A wall of n x n quadrilaterals from one corner along two edges, seen from along x across.
fn grid(corner: Vec3, along: Vec3, across: Vec3, n: usize) -> Vec<Surface> {
    let at =
        |i: usize, j: usize| corner + i as f32 / n as f32 * along + j as f32 / n as f32 * across;
    (0..n * n)
        .flat_map(|k| {
            let (i, j) = (k % n, k / n);
            quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], 0)
        })
        .collect()
}

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
    assert_eq!(load(folder, "out.rad").unfinished, None);
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

/// A line of a view factor file.
#[derive(Clone, Debug)]
struct Line {
    view_factor: f64,
    area_from: f64,
    area_to: f64,
    row_sum_from: f64,
    reciprocity_error: f64,
}

/// The view factors of `in.rad` by from and to.
#[track_caller]
fn view_factors(folder: &Path, more: &[&str]) -> BTreeMap<(String, String), Line> {
    let arguments = [
        "in.rad",
        "out.rad",
        "--iterations",
        "0",
        "--view-factors",
        "v.csv",
    ];
    solve(folder, &[&arguments[..], more].concat());
    let text = std::fs::read_to_string(folder.join("v.csv")).unwrap();
    let mut lines = text.lines();
    let header = "from,to,view_factor,area_from,area_to,row_sum_from,reciprocity_error";
    assert_eq!(lines.next(), Some(header));
    lines
        .map(|line| {
            let fields = fields(line);
            let [from, to, numbers @ ..] = &fields[..] else {
                panic!("{line}");
            };
            let numbers: Vec<f64> = numbers.iter().map(|n| n.parse().unwrap()).collect();
            let line = Line {
                view_factor: numbers[0],
                area_from: numbers[1],
                area_to: numbers[2],
                row_sum_from: numbers[3],
                reciprocity_error: numbers[4],
            };
            assert_eq!(numbers.len(), 5);
            ((from.clone(), to.clone()), line)
        })
        .collect()
}

/// The fields of a line of RFC 4180 without line breaks in quotes.
fn fields(line: &str) -> Vec<String> {
    let mut fields = vec![String::new()];
    let mut quoted = false;
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        let field = fields.last_mut().unwrap();
        match c {
            '"' if quoted && characters.peek() == Some(&'"') => {
                characters.next();
                field.push('"');
            }
            '"' => quoted = !quoted,
            ',' if !quoted => fields.push(String::new()),
            _ => field.push(c),
        }
    }
    fields
}

/// f64 rounding of sums over a few thousand patches.
const ROUNDING: f64 = 1e-12;

/// Two unit squares facing each other, to be of 512 patches each.
fn facing_squares(distance: f32) -> [(&'static str, Vec<Surface>); 2] {
    let low = grid(Vec3::ZERO, Vec3::X, Vec3::Y, 1);
    let high = grid(Vec3::new(0.0, 1.0, distance), Vec3::X, -Vec3::Y, 1);
    [("low, \"square\"", low), ("high", high)]
}

/// At distance 1.
const FACING_SQUARES: f64 = 0.199_824_895_698;

/// Mesh: over a right triangle of legs h the centroid misses the mean of f by at most
/// (|f_xx| + |f_yy|)/2 h^2/18. f is a kernel 1/(pi (1 + r^2)^2) integrated over a unit square, whose second
/// derivatives are at most 4/pi; h^2 is 1/256. Pixels: an edge of length 1 that lies along the pixels of
/// side 2/R moves f by up to a pixel's half, 1/(pi R), evenly distributed; four edges have a
/// deviation of 2/(sqrt(3) pi R), and the mean of 512 hemicubes turned differently one of
/// sqrt(512) less, of which four are taken.
fn facing_squares_tolerance(resolution: f64) -> f64 {
    let pi = std::f64::consts::PI;
    4.0 / pi / 256.0 / 18.0 + 4.0 * 2.0 / (3_f64.sqrt() * pi * resolution) / 512_f64.sqrt()
}

#[test]
fn facing_squares_have_the_closed_form_view_factor() {
    let folder = folder_with(&facing_squares(1.0), 1.0 / 512.0);
    let found = view_factors(folder.path(), &["256"]);
    // Neither sees itself: no line for what is zero.
    assert_eq!(found.len(), 2, "{found:?}");
    let tolerance = facing_squares_tolerance(256.0);
    for line in found.values() {
        assert!(
            (line.view_factor - FACING_SQUARES).abs() < tolerance,
            "{line:?}"
        );
        assert!((line.area_from - 1.0).abs() < ROUNDING, "{line:?}");
        assert!((line.area_to - 1.0).abs() < ROUNDING, "{line:?}");
        assert!(
            (line.row_sum_from - line.view_factor).abs() < ROUNDING,
            "{line:?}"
        );
        assert!(
            line.reciprocity_error < 2.0 * tolerance / FACING_SQUARES,
            "{line:?}"
        );
    }
    let name = "low, \"square\"".to_owned();
    assert!(
        found.contains_key(&(name.clone(), "high".into())),
        "{found:?}"
    );
    assert!(found.contains_key(&("high".into(), name)), "{found:?}");
}

/// The tolerance is narrow enough to tell a distance that is wrong by a hundredth.
#[test]
fn squares_a_little_further_apart_miss_it() {
    let folder = folder_with(&facing_squares(1.01), 1.0 / 512.0);
    for line in view_factors(folder.path(), &["256"]).values() {
        let error = (line.view_factor - FACING_SQUARES).abs();
        assert!(error > 2.0 * facing_squares_tolerance(256.0), "{line:?}");
    }
}

#[test]
fn a_closed_box_has_view_factors_that_sum_to_one_and_know_their_reciprocity() {
    let folder = folder_with(&walls(Vec3::new(3.0, 2.0, 1.0)), 0.2);
    let found = view_factors(folder.path(), &["64"]);
    // Every wall sees the five others, and not itself.
    assert_eq!(found.len(), 30);
    for wall in WALLS {
        let of_wall: Vec<_> = found.iter().filter(|((from, _), _)| from == wall).collect();
        let sum: f64 = of_wall.iter().map(|(_, line)| line.view_factor).sum();
        assert!(
            (sum - 1.0).abs() < common::methods::ROUNDING,
            "{wall}: {sum}"
        );
        for ((from, to), line) in of_wall {
            let back = &found[&(to.clone(), from.clone())];
            assert_eq!(
                (back.area_from, back.area_to),
                (line.area_to, line.area_from)
            );
            assert!(
                (line.row_sum_from - 1.0).abs() < common::methods::ROUNDING,
                "{line:?}"
            );
            let (there, back_again) = (
                line.area_from * line.view_factor,
                back.area_from * back.view_factor,
            );
            let error = (there - back_again).abs() / there.max(back_again);
            assert!(
                (line.reciprocity_error - error).abs() < ROUNDING,
                "{line:?}"
            );
            assert!(
                (back.reciprocity_error - error).abs() < ROUNDING,
                "{back:?}"
            );
        }
    }
    // Not by being zero everywhere.
    assert!(found.values().any(|line| line.reciprocity_error > 1e-4));
}

#[test]
fn view_factors_are_means_of_form_factors() {
    let folder = folder_with(&walls(Vec3::new(3.0, 2.0, 1.0)), 0.5);
    let found = view_factors(folder.path(), &["32", "--form-factors", "f.csv"]);
    let scene = scene::file::load(&folder.path().join("in.rad")).unwrap().0;
    let areas = scene.patch_areas();
    let object = |patch: usize| {
        let surface = scene.mesh().surface_of(scene::PatchId(patch as u32));
        scene.object(scene.surface(surface).object).to_owned()
    };
    let mut expected: BTreeMap<(String, String), f64> = BTreeMap::new();
    let text = std::fs::read_to_string(folder.path().join("f.csv")).unwrap();
    for line in text.lines().skip(1) {
        let fields: Vec<&str> = line.split(',').collect();
        let [from, to] = [0, 1].map(|k| fields[k].parse::<usize>().unwrap());
        let form_factor: f64 = fields[2].parse().unwrap();
        *expected.entry((object(from), object(to))).or_default() += areas[from] * form_factor;
    }
    assert_eq!(found.len(), expected.len());
    for (pair, line) in found {
        let view_factor = expected[&pair] / line.area_from;
        assert!(
            (line.view_factor - view_factor).abs() < ROUNDING,
            "{pair:?} {line:?}"
        );
    }
}

#[test]
fn view_factors_over_another_file_are_a_usage_error() {
    let folder = folder_with(&walls(Vec3::ONE), 1.0);
    for (other, more) in [
        ("IN", ["--view-factors", "in.rad"].as_slice()),
        ("OUT", &["--view-factors", "out.rad"]),
        (
            "--form-factors",
            &["--view-factors", "f.csv", "--form-factors", "f.csv"],
        ),
    ] {
        let output = compute(folder.path(), &[&["in.rad", "out.rad"], more].concat());
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        let said = stderr(&output);
        assert!(
            said.contains(other) && said.contains("--view-factors"),
            "{said}"
        );
        assert_eq!(common::files(folder.path()), ["in.rad"]);
    }
}
