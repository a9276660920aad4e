//! Laws of output files: one program writes one at a time, and leaves nothing else behind.

mod common;

use std::time::{Duration, Instant};

use common::{
    assert_same, compute, files, folder, load, save, signal, solve, start_endless, stderr,
    wait_for_lock,
};
use scene::Scene;

/// About 900 patches.
fn room() -> Scene {
    common::colourful_room(0.1)
}

#[test]
fn a_second_run_with_the_same_output_fails_and_the_first_goes_on() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    let mut first = start_endless(folder.path(), "in.rad", "out.rad", &[]);
    wait_for_lock(folder.path(), "out.rad");
    let start = Instant::now();
    let second = compute(folder.path(), &["in.rad", "out.rad", "32"]);
    assert!(
        start.elapsed() < Duration::from_secs(5),
        "{:?}",
        start.elapsed()
    );
    assert_eq!(second.status.code(), Some(1), "{second:?}");
    let message = stderr(&second);
    assert!(
        message.starts_with("compute: error: out.rad: another program is writing this file"),
        "{message}"
    );
    assert!(first.try_wait().unwrap().is_none());
    // The second has not taken the first's lock away with it.
    let third = compute(folder.path(), &["in.rad", "out.rad", "32"]);
    assert_eq!(third.status.code(), Some(1), "{third:?}");
    // Another output is free.
    solve(
        folder.path(),
        &["in.rad", "other.rad", "32", "--iterations", "1"],
    );
    signal(&first, "INT");
    assert_eq!(first.wait().unwrap().code(), Some(130));
    // What it wrote goes on as if nobody had come.
    let stopped = load(folder.path(), "out.rad").provenance.iterations;
    let iterations = (stopped + 1).to_string();
    let limits = ["32", "--iterations", &iterations, "--tolerance", "0"];
    let go_on = |input, output| {
        solve(folder.path(), &[&[input, output][..], &limits].concat());
        load(folder.path(), output)
    };
    let (on, alone) = (go_on("out.rad", "out.rad"), go_on("in.rad", "whole.rad"));
    assert_same(&on, &alone, "interrupted");
}

#[test]
fn a_report_that_another_run_writes_is_not_written_twice() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    let first = start_endless(
        folder.path(),
        "in.rad",
        "a.rad",
        &["--report", "report.json"],
    );
    wait_for_lock(folder.path(), "report.json");
    let second = compute(
        folder.path(),
        &["in.rad", "b.rad", "32", "--report", "report.json"],
    );
    assert_eq!(second.status.code(), Some(1), "{second:?}");
    assert!(
        stderr(&second).contains("report.json: another program"),
        "{second:?}"
    );
    signal(&first, "INT");
    first.wait_with_output().unwrap();
}

#[test]
fn an_output_without_checkpoints_appears_whole_at_the_end_and_alone() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    solve(
        folder.path(),
        &["in.rad", "out.rad", "32", "--checkpoint-every", "0s"],
    );
    assert_eq!(files(folder.path()), ["in.rad", "out.rad"]);
}
