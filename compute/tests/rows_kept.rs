//! Laws of rows that are kept in a file: a run that goes on draws what is missing, and nothing else changes.

mod common;

use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use common::{
    assert_same, files, folder, load, save, signal, solve, start, stderr, stdout, wait_until,
};
use scene::Scene;
use serde_json::Value;

/// About 900 patches, each with so many hemicubes that drawing them takes many checkpoint intervals.
fn room() -> Scene {
    common::colourful_room(0.1)
}

/// Arguments of a run that draws long enough, and keeps rows as soon as it may.
const SLOWLY: [&str; 5] = ["64", "--points", "4", "--checkpoint-every", "50ms"];

/// Hemicubes that a patch has by them.
const POINTS: u64 = 4;

/// Rows that are drawn at a time on one thread, at most: those under way when a run is stopped by kill -9 are lost, and
/// so are those of a block that is not full.
const BATCH: u64 = 64;

fn arguments<'a>(input: &'a str, output: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[input, output][..], &SLOWLY, more].concat()
}

/// What a program said, without how far it was, which a busy machine has it say.
fn told(output: &std::process::Output) -> String {
    let said = stderr(output);
    let lines = said.split_inclusive('\n');
    lines
        .filter(|line| !line.starts_with("compute: iteration "))
        .collect()
}

/// Runs the program to a good end: its report, and what it said.
#[track_caller]
fn run(folder: &Path, input: &str, output: &str, more: &[&str]) -> (Value, String) {
    let report = ["--report", "report.json"];
    let output = solve(folder, &arguments(input, output, &[more, &report].concat()));
    let report = std::fs::read(folder.join("report.json")).unwrap();
    std::fs::remove_file(folder.join("report.json")).unwrap();
    (serde_json::from_slice(&report).unwrap(), told(&output))
}

fn hemicubes(report: &Value) -> u64 {
    report["hemicubes_drawn"].as_u64().unwrap()
}

fn read(report: &Value) -> u64 {
    report["rows"]["read"].as_u64().unwrap()
}

/// A run that never stops: its report. The solution is in `whole.rad`.
fn whole(folder: &Path, more: &[&str]) -> Value {
    save(folder, "in.rad", &room());
    let (report, said) = run(folder, "in.rad", "whole.rad", more);
    assert_eq!(said, "");
    assert_eq!(files(folder), ["in.rad", "whole.rad"]);
    report
}

/// Starts a run of one thread, and stops it by a signal once its file of rows is as long as `bytes`.
fn stop(folder: &Path, input: &str, output: &str, bytes: u64, signal_name: &str, more: &[&str]) {
    let threads = [more, &["--threads", "1"]].concat();
    let mut child = start(folder, &arguments(input, output, &threads));
    let rows = rows_of(folder, output);
    wait_until(|| {
        rows.metadata()
            .is_ok_and(|metadata| metadata.len() >= bytes)
    });
    signal(&child, signal_name);
    let code = child.wait().unwrap().code();
    assert_eq!(code, (signal_name == "INT").then_some(130));
}

fn rows_of(folder: &Path, output: &str) -> PathBuf {
    folder.join(format!("{output}.rows"))
}

fn length(path: &Path) -> u64 {
    path.metadata().map_or(0, |metadata| metadata.len())
}

/// About half of what the rows take.
const HALF: u64 = 700_000;

#[test]
fn stopped_and_continued_it_draws_what_is_missing_and_is_as_never_stopped() {
    for solver in ["jacobi", "gauss-seidel", "shooting"] {
        for memory in ["1GiB", "0B"] {
            let folder = folder();
            let limits = if solver == "shooting" {
                ["--iterations", "3000"]
            } else {
                ["--iterations", "3"]
            };
            let settings = [&["--solver", solver, "--memory", memory][..], &limits].concat();
            save(folder.path(), "in.rad", &room());
            let (unbroken, _) = run(
                folder.path(),
                "in.rad",
                "whole.rad",
                &[&settings[..], &["--rows-file-limit", "0B"]].concat(),
            );
            // Shooting takes rows here and there.
            let bytes = if solver == "shooting" { 1000 } else { HALF };
            stop(folder.path(), "in.rad", "out.rad", bytes, "INT", &settings);
            let written = length(&rows_of(folder.path(), "out.rad"));
            assert!(written >= bytes);
            let (report, said) = run(folder.path(), "out.rad", "out.rad", &settings);
            let what = format!("{solver}, {memory}: {said}");
            assert_same(
                &load(folder.path(), "out.rad"),
                &load(folder.path(), "whole.rad"),
                "",
            );
            assert!(read(&report) > 0, "{what}");
            if memory == "1GiB" {
                assert_eq!(said, "", "{what}");
                assert!(hemicubes(&report) < hemicubes(&unbroken), "{what}");
                if solver != "shooting" {
                    assert_eq!(report["certificate"], unbroken["certificate"], "{what}");
                    assert_eq!(report["energy"], unbroken["energy"], "{what}");
                }
            }
        }
    }
}

#[test]
fn both_runs_together_draw_each_row_once() {
    let folder = folder();
    let unbroken = whole(folder.path(), &[]);
    let patches = u64::from(room().patch_count());
    assert_eq!(hemicubes(&unbroken), POINTS * patches);
    // What the first run has drawn it tells itself: it writes a report when it is stopped.
    let report = ["--report", "first.json"];
    stop(folder.path(), "in.rad", "out.rad", HALF, "INT", &report);
    let first = std::fs::read(folder.path().join("first.json")).unwrap();
    let first: Value = serde_json::from_slice(&first).unwrap();
    assert!(hemicubes(&first) < POINTS * patches);
    let rows_first = hemicubes(&first) / POINTS;
    let (second, said) = run(folder.path(), "out.rad", "out.rad", &["--threads", "2"]);
    assert_eq!(said, "");
    assert_eq!(hemicubes(&first) + hemicubes(&second), POINTS * patches);
    assert_eq!(read(&second), rows_first);
    assert_same(
        &load(folder.path(), "out.rad"),
        &load(folder.path(), "whole.rad"),
        "",
    );
    for part in ["certificate", "closure", "energy", "back_face_share"] {
        assert_eq!(second[part], unbroken[part], "{part}");
    }
    // A run that has ended by its tolerance takes its rows with it.
    assert!(!rows_of(folder.path(), "out.rad").exists());
}

#[test]
fn killed_at_any_moment_its_rows_are_used_and_the_bits_are_the_same() {
    let folder = folder();
    let unbroken = whole(folder.path(), &[]);
    // Without a checkpoint before the first kill there would be no OUT to go on with.
    std::fs::copy(folder.path().join("in.rad"), folder.path().join("out.rad")).unwrap();
    let mut before = 0;
    for round in 0..3 {
        let more = ["--threads", ["1", "2"][round % 2]];
        let mut child = start(folder.path(), &arguments("out.rad", "out.rad", &more));
        let rows = rows_of(folder.path(), "out.rad");
        wait_until(|| length(&rows) > before || child.try_wait().unwrap().is_some());
        sleep(Duration::from_millis(7 * round as u64));
        child.kill().unwrap();
        child.wait().unwrap();
        before = length(&rows);
    }
    let (report, said) = run(folder.path(), "out.rad", "out.rad", &[]);
    assert_eq!(said, "");
    assert!(read(&report) >= BATCH, "{report}");
    assert!(hemicubes(&report) < hemicubes(&unbroken));
    assert_same(
        &load(folder.path(), "out.rad"),
        &load(folder.path(), "whole.rad"),
        "",
    );
    assert_eq!(report["certificate"], unbroken["certificate"]);
    // What was killed while it wrote a solution may leave that.
    let names = files(folder.path());
    assert!(
        !names.iter().any(|name| name.contains(".rows")),
        "{names:?}"
    );
}

#[test]
fn kept_rows_serve_other_solvers_outputs_and_tables() {
    let folder = folder();
    let unbroken = whole(folder.path(), &["--keep-rows", "--rows-file-limit", "0B"]);
    let (report, said) = run(folder.path(), "in.rad", "out.rad", &["--keep-rows"]);
    assert_eq!((said.as_str(), read(&report)), ("", 0));
    let rows = rows_of(folder.path(), "out.rad");
    let kept = std::fs::read(&rows).unwrap();

    // Another output, another solver, another start: the input's rows.
    let other = [
        "--solver",
        "gauss-seidel",
        "--keep-rows",
        "--form-factors",
        "f.csv",
    ];
    let (report, said) = run(folder.path(), "out.rad", "other.rad", &other);
    assert!(
        said.contains("was solved with solver jacobi, now gauss-seidel"),
        "{said}"
    );
    assert_eq!(hemicubes(&report), 0);
    assert_eq!(read(&report), u64::from(room().patch_count()));
    assert_eq!(report["closure"], unbroken["closure"]);
    // They have become the other output's too, where the run was long enough; the input's stay.
    assert!(std::fs::read(&rows).unwrap() == kept);

    // The same table as a run that draws, and the summary tells why nothing was drawn.
    let table = |output: &str, input: &str| {
        let arguments = arguments(
            input,
            output,
            &["--iterations", "0", "--form-factors", "g.csv"],
        );
        let output = stdout(&solve(folder.path(), &arguments));
        (std::fs::read(folder.path().join("g.csv")).unwrap(), output)
    };
    let (read, said) = table("out.rad", "out.rad");
    assert!(said.contains(" read from files instead of drawn"), "{said}");
    assert!(!said.contains("hemicubes "), "{said}");
    let (drawn, said) = table("new.rad", "in.rad");
    assert!(said.contains("hemicubes "), "{said}");
    assert!(read == drawn);
    assert!(std::fs::read(folder.path().join("f.csv")).unwrap() == drawn);

    // Without --keep-rows they go, though this run had nothing to do with them.
    run(folder.path(), "out.rad", "out.rad", &[]);
    assert!(!rows.exists());
}

/// The file is of the sources among which iterations go, not of the patches that gather once.
#[test]
fn rows_of_coarse_sources_are_kept_and_those_of_gathering_patches_are_not() {
    let folder = folder();
    save(folder.path(), "in.rad", &common::colourful_room(0.05));
    let sources = ["--source-area", "0.1"];
    let (unbroken, _) = run(folder.path(), "in.rad", "whole.rad", &sources);
    let among_sources = POINTS * u64::from(room().patch_count());
    let gathering = hemicubes(&unbroken) - among_sources;
    assert!(gathering > among_sources, "{unbroken}");
    stop(folder.path(), "in.rad", "out.rad", HALF, "INT", &sources);
    let more = [&sources[..], &["--keep-rows"]].concat();
    let (report, said) = run(folder.path(), "out.rad", "out.rad", &more);
    assert_eq!(said, "");
    assert!(read(&report) > 0 && hemicubes(&report) < hemicubes(&unbroken));
    assert_same(
        &load(folder.path(), "out.rad"),
        &load(folder.path(), "whole.rad"),
        "",
    );
    assert_eq!(report["certificate"], unbroken["certificate"]);
    let (report, _) = run(folder.path(), "in.rad", "out.rad", &more);
    assert_eq!(hemicubes(&report), gathering);
}

#[test]
fn interrupted_while_writing_form_factors_it_keeps_their_rows() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    let table = ["--form-factors", "f.csv"];
    stop(folder.path(), "in.rad", "out.rad", HALF, "INT", &table);
    let (report, _) = run(folder.path(), "out.rad", "out.rad", &table);
    assert!(read(&report) > 0);
    assert!(hemicubes(&report) < POINTS * u64::from(room().patch_count()));
}

#[test]
fn rows_of_another_run_are_not_used_and_what_differs_is_said() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    run(folder.path(), "in.rad", "out.rad", &["--keep-rows"]);
    let all = POINTS * u64::from(room().patch_count());
    let (report, said) = run(
        folder.path(),
        "in.rad",
        "out.rad",
        &["--seed", "7", "--keep-rows"],
    );
    assert_eq!(
        said,
        "compute: out.rad.rows: its rows are of another run: this one has seed 7 instead of 0; rows are drawn again\n"
    );
    assert_eq!((hemicubes(&report), read(&report)), (all, 0));
    // From then on they are those of the other seed.
    let (report, said) = run(
        folder.path(),
        "in.rad",
        "out.rad",
        &["--seed", "7", "--keep-rows"],
    );
    assert_eq!((hemicubes(&report), said.as_str()), (0, ""));

    save(folder.path(), "in.rad", &common::colourful_room(0.2));
    let (_, said) = run(folder.path(), "in.rad", "out.rad", &["--seed", "7"]);
    assert!(said.contains("this one has other receivers ("), "{said}");
    assert_eq!(said.lines().count(), 1, "{said}");
    assert!(!rows_of(folder.path(), "out.rad").exists());
}

#[test]
fn what_is_no_file_of_rows_is_left_alone() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    let rows = rows_of(folder.path(), "out.rad");
    std::fs::write(&rows, "my rows").unwrap();
    let (_, said) = run(folder.path(), "in.rad", "out.rad", &[]);
    assert!(
        said.starts_with("compute: warning: out.rad.rows: not a file of form factor rows"),
        "{said}"
    );
    assert_eq!(said.lines().count(), 1, "{said}");
    assert_eq!(std::fs::read(&rows).unwrap(), b"my rows");
}

#[test]
fn the_file_of_rows_keeps_to_its_limit_and_says_so_once() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    let rows = rows_of(folder.path(), "out.rad");
    for (limit, least) in [("0B", 0), ("100B", 0), ("300KiB", 200 << 10)] {
        let more = ["--keep-rows", "--rows-file-limit", limit];
        let (_, said) = run(folder.path(), "in.rad", "out.rad", &more);
        if limit == "0B" {
            assert_eq!(said, "");
        } else {
            assert!(
                said.starts_with("compute: warning: out.rad.rows has reached its limit of "),
                "{said}"
            );
            assert_eq!(said.lines().count(), 1, "{said}");
        }
        assert_eq!(rows.exists(), least > 0);
        assert!((least..=300 << 10).contains(&length(&rows)));
    }
    // What is there serves.
    let (report, _) = run(folder.path(), "in.rad", "out.rad", &[]);
    assert!(read(&report) > 0);
}

#[test]
fn a_run_shorter_than_a_checkpoint_interval_writes_no_rows() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    solve(
        folder.path(),
        &[
            "in.rad",
            "out.rad",
            "32",
            "--iterations",
            "2",
            "--keep-rows",
        ],
    );
    assert_eq!(files(folder.path()), ["in.rad", "out.rad"]);
}
