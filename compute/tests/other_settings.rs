//! A file that goes on with other settings than its own, or from an older version: what it keeps, and what it says.

mod common;

use std::path::Path;

use common::{assert_same, bits, folder, load, save, solve, stderr};
use scene::Scene;

/// About 900 patches: 15 batches an iteration on one thread.
fn room() -> Scene {
    common::colourful_room(0.1)
}

#[test]
fn other_settings_keep_the_radiosities_as_the_start_and_say_so() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    solve(folder.path(), &["in.rad", "coarse.rad", "32"]);
    let coarse = load(folder.path(), "coarse.rad");
    let before = coarse.provenance.iterations;

    let output = solve(folder.path(), &["coarse.rad", "fine.rad", "64"]);
    assert_eq!(
        stderr(&output),
        "compute: coarse.rad was solved with resolution 32, now 64; its radiosities are the start\n"
    );
    let fine = load(folder.path(), "fine.rad");
    solve(folder.path(), &["in.rad", "from_dark.rad", "64"]);
    let from_dark = load(folder.path(), "from_dark.rad").provenance.iterations;
    let more = fine.provenance.iterations - before;
    assert!(
        (1..from_dark).contains(&more),
        "{more} iterations, {from_dark} from the dark"
    );
    assert_eq!(fine.provenance.residuals.len() as u64, more);

    // One iteration from there is one gather of the coarse radiosities, at 64 pixels.
    let n = (before + 1).to_string();
    let said = stderr(&solve(
        folder.path(),
        &["fine.rad", "again.rad", "64", "--tolerance", "1e-6"],
    ));
    assert_eq!(said, "", "the same settings are nothing to mention");
    solve(
        folder.path(),
        &["coarse.rad", "one.rad", "64", "--iterations", &n],
    );
    let one = load(folder.path(), "one.rad");
    assert_ne!(bits(&one.irradiance), bits(&coarse.irradiance));
    // The walls' light moves by what 32 pixels mistake, a few percent; from the dark it would be
    // the lamps' alone, half of it or less.
    for (a, b) in one.irradiance.iter().zip(&coarse.irradiance) {
        assert!(
            (*a - *b).abs().max_element() < 0.3 * b.max_element(),
            "{a} {b}"
        );
    }
}

/// A file whose settings were changed, stopped before they had done one iteration, is not done.
#[test]
fn regression_residuals_of_other_settings_end_nothing() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    solve(folder.path(), &["in.rad", "coarse.rad", "32"]);
    let before = load(folder.path(), "coarse.rad").provenance.iterations;
    for settings in [
        &["64"][..],
        &["32", "--solver", "shooting"],
        &["32", "--solver", "gauss-seidel"],
    ] {
        let run = |input, output, more: &[&str]| {
            solve(
                folder.path(),
                &[&[input, output][..], settings, more].concat(),
            );
            load(folder.path(), output)
        };
        let whole = run("coarse.rad", "whole.rad", &["--tolerance", "1e-3"]);
        let stopped = run("coarse.rad", "out.rad", &["--time-limit", "0s"]);
        assert_eq!(stopped.provenance.iterations, before);
        let continued = run("out.rad", "out.rad", &["--tolerance", "1e-3"]);
        assert!(continued.provenance.iterations > before, "{settings:?}");
        assert_same(&continued, &whole, &format!("{settings:?}"));
    }
}

#[test]
fn all_settings_that_differ_are_named_and_no_others() {
    let folder = folder();
    save(folder.path(), "in.rad", &common::furnace(0.5, 1.0, 0.5));
    let first = ["in.rad", "a.rad", "8", "--points", "centroid"];
    solve(folder.path(), &first);
    for (settings, told) in [
        (&["--points", "1", "--source-area", "patches"][..], None),
        (
            &["--seed", "7", "--threads", "1", "--tolerance", "1e-3"],
            Some("points centroid and seed 0, now auto and 7"),
        ),
        (
            &[
                "--points",
                "centroid",
                "--maps",
                "thesis",
                "--solver",
                "shooting",
                "--lamps",
                "off",
                "--closed-forms",
                "off",
                "--source-area",
                "0.5",
            ],
            Some(
                "closed_forms auto, lamps auto, maps exact, solver jacobi and source_area auto, now off, off, thesis, \
                 shooting and 0.5",
            ),
        ),
    ] {
        let output = solve(
            folder.path(),
            &[&["a.rad", "b.rad", "8"][..], settings].concat(),
        );
        let told = told.map_or_else(String::new, |told| {
            format!("compute: a.rad was solved with {told}; its radiosities are the start\n")
        });
        assert_eq!(stderr(&output), told);
    }
}

#[test]
fn file_of_version_1_is_a_start_and_says_so() {
    let folder = folder();
    let version_1 = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scene/tests/data/version-1.rad");
    std::fs::copy(version_1, folder.path().join("old.rad")).unwrap();
    let start = load(folder.path(), "old.rad");
    assert_eq!(start.provenance.iterations, 3);
    // Its solver was shooting, which could go on if the file said so.
    let arguments = ["old.rad", "new.rad", "8", "--solver", "shooting"];
    let said = stderr(&solve(
        folder.path(),
        &[&arguments[..], &["--time-limit", "0s"]].concat(),
    ));
    assert_eq!(
        said,
        "compute: old.rad is of an older version, which does not say how it was solved; its radiosities are the start\n"
    );
    let stopped = load(folder.path(), "new.rad");
    assert_eq!(bits(&stopped.irradiance), bits(&start.irradiance));
    assert_eq!(stopped.provenance.iterations, 3);
    // From then on it is a file like others.
    let output = solve(
        folder.path(),
        &["new.rad", "new.rad", "8", "--solver", "shooting"],
    );
    assert_eq!(stderr(&output), "");
    assert!(load(folder.path(), "new.rad").provenance.iterations > 3);
}
