//! Outputs on disks that are read-only or full. Ignored where this user cannot mount any.

mod common;

use common::{bits, compute, failure, files, folder, folder_with_room, load, save, solve, stderr};
use test_needs::{ExitCode, SmallDisk, laws, run};

fn an_output_on_a_read_only_disk_is_named_and_stays() {
    let folder = folder_with_room();
    let disk = SmallDisk::mount(folder.path(), "1m");
    std::fs::copy(folder.path().join("in.rad"), disk.path().join("out.rad")).unwrap();
    disk.make_read_only();
    for (input, output) in [
        ("in.rad", "disk/out.rad"),
        ("in.rad", "disk/new.rad"),
        ("disk/out.rad", "disk/out.rad"),
    ] {
        let message = failure(folder.path(), &[input, output, "16"]);
        assert!(
            message.contains(&format!("{output}: cannot write: ")),
            "{message}"
        );
    }
    assert_eq!(files(disk.path()), ["out.rad"]);
    // It is good enough to read from.
    solve(folder.path(), &["disk/out.rad", "here.rad", "16"]);
}

fn on_a_full_disk_the_output_stays_as_it_was() {
    let folder = folder_with_room();
    let disk = SmallDisk::mount(folder.path(), "64k");
    std::fs::copy(folder.path().join("in.rad"), disk.path().join("out.rad")).unwrap();
    let before = std::fs::read(disk.path().join("out.rad")).unwrap();
    disk.fill();
    for input in ["in.rad", "disk/out.rad"] {
        let output = compute(
            folder.path(),
            &[input, "disk/out.rad", "16", "--checkpoint-every", "0s"],
        );
        assert_eq!(output.status.code(), Some(1), "{output:?}");
        let message = stderr(&output);
        let last = message.lines().last().unwrap();
        assert!(
            last.starts_with("compute: error: disk/out.rad: cannot "),
            "{message}"
        );
        assert_eq!(std::fs::read(disk.path().join("out.rad")).unwrap(), before);
        assert_eq!(
            files(disk.path()),
            ["filler", "out.rad"],
            "something is left behind"
        );
    }
    // The result is not lost for a report that finds no room.
    let output = compute(
        folder.path(),
        &["in.rad", "here.rad", "16", "--report", "disk/report.json"],
    );
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(
        stderr(&output).contains("disk/report.json: cannot "),
        "{output:?}"
    );
    load(folder.path(), "here.rad");
}

fn a_disk_that_rows_fill_costs_a_warning_and_not_the_result() {
    let folder = folder();
    save(folder.path(), "in.rad", &common::colourful_room(0.1));
    // Many hemicubes a patch, so that drawing takes many checkpoint intervals.
    let settings = ["64", "--points", "4", "--checkpoint-every", "50ms"];
    let arguments = |output| [&["in.rad", output][..], &settings].concat();
    solve(folder.path(), &arguments("whole.rad"));

    let disk = SmallDisk::mount(folder.path(), "256k");
    let output = compute(
        folder.path(),
        &[&arguments("disk/out.rad")[..], &["--keep-rows"]].concat(),
    );
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    let said = stderr(&output);
    // How far it is, a busy machine has it say too.
    let said: Vec<_> = said
        .lines()
        .filter(|line| !line.starts_with("compute: iteration "))
        .collect();
    assert!(
        said.iter()
            .all(|line| line.starts_with("compute: warning: disk/out.rad.rows")),
        "{said:?}"
    );
    // Either rows find no room, or they have left none for the result, or one after the other.
    let is_of_rows = |line: &str| line.contains("cannot write: ");
    let is_of_result = |line: &str| line.contains("removed, since there is no room for the result");
    assert!(
        match said[..] {
            [line] => is_of_rows(line) || is_of_result(line),
            [first, second] => is_of_rows(first) && is_of_result(second),
            _ => false,
        },
        "{said:?}"
    );
    // What was kept of the rows may stay.
    assert!(files(disk.path()).contains(&"out.rad".to_owned()));
    let [here, there] = [(folder.path(), "whole.rad"), (disk.path(), "out.rad")]
        .map(|(folder, name)| load(folder, name));
    assert!(bits(&there.irradiance) == bits(&here.irradiance));
    assert_eq!(there.provenance, here.provenance);
}

fn main() -> ExitCode {
    run(laws![SmallDisk::can_be_mounted =>
        an_output_on_a_read_only_disk_is_named_and_stays,
        on_a_full_disk_the_output_stays_as_it_was,
        a_disk_that_rows_fill_costs_a_warning_and_not_the_result,
    ])
}
