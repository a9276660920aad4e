//! Studies of what settings cost.

mod common;

use common::{compute, folder, save, solve, stderr, stdout};
use glam::Vec3;
use test_scenes::{colourful_room, material, quad, scene as room_of};

/// A run that is asked for is in the table with errors against the reference, its stated ones, plots and a document; the
/// same command again has nothing to do.
#[test]
fn a_study_goes_on_with_what_is_missing() {
    let folder = folder();
    save(folder.path(), "in.rad", &colourful_room(0.05));
    solve(
        folder.path(),
        &["in.rad", "right.rad", "--target-error", "1%"],
    );
    let arguments = [
        "study",
        "in.rad",
        "--out",
        "s",
        "--reference",
        "right.rad",
        "--only",
        "--quality draft",
    ];
    let output = solve(folder.path(), &arguments);
    assert!(
        stderr(&output).contains("in: --quality draft"),
        "{output:?}"
    );
    assert!(stdout(&output).contains("--quality draft"), "{output:?}");
    let read = |name: &str| std::fs::read_to_string(folder.path().join("s").join(name)).unwrap();
    let table = read("study.csv");
    let rows: serde_json::Value = serde_json::from_str(&read("study.json")).unwrap();
    let row = &rows[0];
    assert_eq!(rows.as_array().unwrap().len(), 1);
    for kind in ["power", "visible"] {
        let [found, stated] =
            [kind.to_owned(), format!("stated_{kind}")].map(|name| row[&name].as_f64().unwrap());
        assert!(found > 0.0 && found < 0.2 && stated > 0.0, "{row}");
    }
    assert_eq!(row["is_on_power_front"], true);
    assert!(read("study.md").contains("| `--quality draft` |"));
    assert!(read("pictures/in-power.svg").starts_with("<svg"));
    let again = solve(folder.path(), &arguments);
    assert!(!stderr(&again).contains("in: --quality"), "{again:?}");
    assert_eq!(read("study.csv"), table);
}

/// What cannot be studied is told: a scene without light, a reference without a solution, a table that is none.
#[test]
fn what_cannot_be_studied_is_told() {
    let folder = folder();
    let dark = room_of(
        vec![material(0.5, 0.0)],
        quad([Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y], 0).to_vec(),
        1.0,
    );
    save(folder.path(), "dark.rad", &dark);
    let failed = |more: &[&str], expected: &str| {
        let output = compute(
            folder.path(),
            &[&["study", "dark.rad", "--out", "s"], more].concat(),
        );
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        assert!(stderr(&output).contains(expected), "{output:?}");
    };
    failed(&[], "dark.rad: nothing emits");
    failed(
        &["--reference", "dark.rad"],
        "dark.rad: the reference is not solved",
    );
    std::fs::write(folder.path().join("s/study.csv"), "a,b\n1,2\n").unwrap();
    failed(&[], "is no table of a study");
}
