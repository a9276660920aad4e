//! Models as people have them, each of which shows a kind of fault (`data/cases`): what comes out of all programs is right.

use std::path::{Path, PathBuf};

use tempfile::TempDir;
use tests::{PatchRow, folder, output, patches, run};

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data/cases")
        .join(format!("{name}.obj"))
}

/// A solved case: some 6,000 patches, at 32 pixels.
fn solved(name: &str) -> TempDir {
    let folder = folder();
    let obj = case(name);
    run(&folder, "genx", &["a.rad", obj.to_str().unwrap()]);
    let settings = [
        "a.rad",
        "a.rad",
        "32",
        "--quality",
        "mesh",
        "--backend",
        "cpu",
        "--report",
        "report.json",
    ];
    run(&folder, "compute", &settings);
    folder
}

/// Mean irradiance of an object, W/m^2.
fn irradiance(rows: &[PatchRow], is_part: impl Fn(&PatchRow) -> bool) -> f64 {
    let part = rows.iter().filter(|row| is_part(row));
    let (received, area) = part.fold((0.0, 0.0), |(received, area), row| {
        (received + row.area * row.irradiance.x, area + row.area)
    });
    received / area
}

/// As much is absorbed as is emitted, in the red channel, but for errors of form factors, which even out.
#[track_caller]
fn assert_all_is_absorbed(rows: &[PatchRow]) {
    let absorbed = |row: &PatchRow| row.area * (1.0 - row.reflectance.x) * row.irradiance.x;
    let absorbed: f64 = rows.iter().map(absorbed).sum();
    let emitted: f64 = rows.iter().map(|row| row.area * row.emission.x).sum();
    assert!(
        (absorbed / emitted - 1.0).abs() < 0.005,
        "{absorbed}, {emitted}"
    );
}

/// A lamp in the plane of its ceiling, before or after it in the file, is as one in a hole of the ceiling. On the floor, 1 m
/// below, the lamp is exact views; patches differ around it, which is a share of their indirect light.
#[test]
fn a_lamp_in_the_plane_of_its_ceiling_is_as_one_in_a_hole() {
    let floors = ["before", "after", "cut"].map(|order| {
        let folder = solved(&format!("lamp_in_ceiling_{order}"));
        let rows = patches(&folder, "a.rad");
        assert_all_is_absorbed(&rows);
        irradiance(&rows, |row| row.centroid.z < 1e-6)
    });
    let [before, after, cut] = floors;
    for floor in [before, after] {
        assert!((floor / cut - 1.0).abs() < 0.002, "{floor}, {cut}");
    }
}

#[test]
fn a_rug_on_its_floor_makes_no_light() {
    let folder = solved("rug_partial");
    let rows = patches(&folder, "a.rad");
    assert_all_is_absorbed(&rows);
    // No floor is left below the rug, whose area it has.
    let area: f64 = rows
        .iter()
        .filter(|row| row.centroid.z < 1e-6)
        .map(|row| row.area)
        .sum();
    assert!((area - 1.0).abs() < 1e-5, "{area}");
}

/// A wall of two sides that stands on a floor without being cut into it, with a lamp on one side.
#[test]
fn no_light_gets_below_a_wall() {
    let folder = solved("two_rooms");
    let rows = patches(&folder, "a.rad");
    let lit = irradiance(&rows, |row| row.centroid.x < 3.0);
    let dark = irradiance(&rows, |row| row.centroid.x > 3.1);
    assert!(dark < 1e-4 * lit, "{dark}, {lit}");
    // A patch has three hemicubes and more beside the wall, of which one may look through a crack of a rounding.
    let most = rows
        .iter()
        .filter(|row| row.centroid.x > 3.1)
        .map(|row| row.irradiance.x);
    let most = most.fold(0.0, f64::max);
    assert!(most < 2e-3 * lit, "{most}, {lit}");
}

/// A wall with two sides a hand's breadth apart hides all, even where floor and ceiling run on below it.
#[test]
fn no_light_gets_through_a_thick_wall() {
    let folder = solved("two_rooms_thick_wall");
    let rows = patches(&folder, "a.rad");
    let dark = irradiance(&rows, |row| row.centroid.x > 3.1);
    assert!(dark <= 0.0, "{dark}");
}

/// A sheet of two sides: from either side its front is what one sees, and both halves are as bright.
#[test]
fn a_sheet_of_two_sides_shows_fronts_alone() {
    let folder = folder();
    let obj = case("two_sided_partition");
    // Small patches beside a sheet see it nearly edge-on.
    let made = ["a.rad", obj.to_str().unwrap(), "--max-area", "0.001"];
    run(&folder, "genx", &made);
    let settings = ["a.rad", "b.rad", "64", "--backend", "cpu"];
    let solved = output(&folder, "compute", &settings);
    assert!(solved.status.success(), "{solved:?}");
    let warnings = String::from_utf8_lossy(&solved.stderr);
    assert!(!warnings.contains("backs of surfaces"), "{warnings}");
    let rows = patches(&folder, "b.rad");
    let [left, right] = [true, false].map(|is_left| {
        irradiance(&rows, |row| {
            row.centroid.z == 0.0 && (row.centroid.x < 1.0) == is_left
        })
    });
    // Hemicubes of the halves are turned by chance, each its own way: 1 % a patch at 64 pixels, 1,000 patches.
    assert!((left / right - 1.0).abs() < 1e-3, "{left}, {right}");
}
