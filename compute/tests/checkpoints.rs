//! Laws of stopping and going on: by limits, by Ctrl-C, by kill -9.

mod common;

use std::thread::sleep;
use std::time::Duration;

use common::{
    assert_same, files, folder, load, save, signal, solve, solve_in_parts, start, start_endless,
    stderr, stdout, wait_for_lock,
};
use compute::settings::MOST_ON_ONE_LEVEL;
use scene::{Level, Scene, Solution, State};
use tempfile::TempDir;

const SOLVERS: [&str; 3] = ["jacobi", "gauss-seidel", "shooting"];

/// About 900 patches: 15 batches an iteration on one thread.
fn room() -> Scene {
    common::colourful_room(0.1)
}

#[test]
fn stopped_by_iterations_and_continued_is_as_never_stopped() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    for solver in SOLVERS {
        let solve = |input, output, n, memory, threads| {
            let limits = ["--iterations", n, "--memory", memory, "--threads", threads];
            solve(
                folder.path(),
                &[&[input, output, "32", "--solver", solver][..], &limits].concat(),
            );
            load(folder.path(), output)
        };
        let whole = solve("in.rad", "whole.rad", "7", "1GiB", "2");
        solve("in.rad", "part.rad", "1", "1GiB", "1");
        solve("part.rad", "part.rad", "3", "0B", "5");
        solve("part.rad", "other.rad", "4", "100KiB", "2");
        let parts = solve("other.rad", "part.rad", "7", "1GiB", "3");
        assert_same(&parts, &whole, solver);
        assert_eq!(whole.provenance.residuals.len(), 7);
    }
}

/// Whether an iteration, or the gathering of all patches from sources, was stopped on its way.
fn is_unfinished(solution: &Solution) -> bool {
    matches!(solution.state, State::Unfinished { .. })
        || matches!(solution.provenance.level, Level::Gathering { .. })
}

#[test]
fn stopped_by_time_in_mid_iteration_and_continued_is_as_never_stopped() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    for (solver, iterations) in [("jacobi", "3"), ("gauss-seidel", "3"), ("shooting", "12")] {
        for memory in ["1GiB", "0B"] {
            let settings = [
                "--solver",
                solver,
                "--iterations",
                iterations,
                "--memory",
                memory,
            ];
            solve(
                folder.path(),
                &[&["in.rad", "whole.rad", "64"][..], &settings].concat(),
            );
            let whole = load(folder.path(), "whole.rad");

            let stopped = solve_in_parts(folder.path(), &[&["64"], &settings[..]].concat(), 4.0);
            let unfinished = stopped.iter().filter(|s| is_unfinished(s)).count();
            let runs = stopped.len();
            println!("{solver}, {memory}: {runs} runs stopped, {unfinished} in mid-iteration");
            assert!(runs > 0, "{solver}, {memory}: never stopped");
            assert!(
                unfinished > 0 || solver == "shooting",
                "{solver}: not in mid-iteration"
            );
            let what = format!("{solver}, {memory}");
            assert_same(&load(folder.path(), "part.rad"), &whole, &what);
        }
    }
}

/// The fewest hemicubes a patch. Views of lamps take ten times as long as all else and are made row by row.
const QUICK: [&str; 4] = ["--points", "centroid", "--lamps", "off"];

/// More patches than are solved on one level by default, in `in.rad`: files large enough that writing them takes a part of
/// the time.
fn folder_with_large_scene() -> TempDir {
    let folder = folder();
    let scene = common::colourful_room(0.001);
    assert!(scene.patch_count() > MOST_ON_ONE_LEVEL);
    save(folder.path(), "in.rad", &scene);
    folder
}

/// Stopped while sources are solved, while the error that they bring is estimated, and while patches gather, or, with so
/// few pixels that no sources are good enough, among the patches.
#[test]
fn stopped_among_sources_that_are_being_chosen_and_continued_is_as_never_stopped() {
    let folder = folder_with_large_scene();
    for (resolution, tolerance) in [("8", "1e-2"), ("2", "1e-1")] {
        // As often, so that rows are kept in a file, of one sources after the other's.
        let often = ["--tolerance", tolerance, "--checkpoint-every", "50ms"];
        let settings = [&[resolution][..], &QUICK, &often].concat();
        let whole = [&["in.rad", "whole.rad"], &settings[..]].concat();
        let output = stdout(&solve(folder.path(), &whole));
        let stopped = solve_in_parts(folder.path(), &settings, 60.0);
        let unfinished = stopped.iter().filter(|s| is_unfinished(s)).count();
        let runs = stopped.len();
        println!("{resolution}: {runs} runs stopped, {unfinished} in mid-iteration\n{output}");
        assert!(runs > 1 && unfinished > 0, "{resolution}");
        let [whole, part] = ["whole.rad", "part.rad"].map(|name| load(folder.path(), name));
        assert_same(&part, &whole, resolution);
    }
}

/// A limit of iterations ends the solving among sources, and all patches gather: so do they after some iterations more,
/// and all of them count.
#[test]
fn iterations_among_sources_count_when_a_gathered_solution_goes_on() {
    let folder = folder_with_large_scene();
    let mut done = 0;
    for (input, iterations) in [("in.rad", 3), ("out.rad", 5)] {
        let limit = iterations.to_string();
        let limits = ["--tolerance", "0", "--iterations", &limit];
        let arguments = [&[input, "out.rad", "8"][..], &QUICK, &limits].concat();
        let output = stdout(&solve(folder.path(), &arguments));
        assert!(
            output.contains("100.0 % of the patches have gathered"),
            "{output}"
        );
        let solution = load(folder.path(), "out.rad");
        assert_eq!(solution.provenance.iterations, iterations, "{output}");
        assert_eq!(solution.provenance.level, Level::Patches);
        // Of iterations among sources that are solved anew nothing else is known.
        done += solution.provenance.residuals.len() as u64;
        assert_eq!(done, iterations, "{output}");
    }
}

/// Rounds of: start, wait for a moment that nothing has chosen, kill -9. OUT is IN and starts as a
/// good file; it must be one after each round, and be on its way to the same bits. Among the patches alone: how far sources
/// are solved depends on the limit of iterations, which those that are killed do not have.
#[test]
fn killed_at_any_moment_the_output_is_a_whole_file_and_goes_on() {
    let folder = folder_with_large_scene();
    let limits = ["--tolerance", "0", "--source-area", "patches"];
    let arguments = [&["2"][..], &QUICK, &limits].concat();
    std::fs::copy(folder.path().join("in.rad"), folder.path().join("out.rad")).unwrap();
    let (mut shortest_ms, mut delay_ms) = (60, 60);
    let (mut round, mut checkpoints) = (0, 0);
    while checkpoints < 8 {
        assert!(round < 100, "OUT is never written");
        round += 1;
        let before = std::fs::read(folder.path().join("out.rad")).unwrap();
        let more = ["--memory", "0KiB", "--checkpoint-every", "0.05s"];
        let mut child = start(
            folder.path(),
            &[&["out.rad", "out.rad"], &arguments[..], &more].concat(),
        );
        wait_for_lock(folder.path(), "out.rad");
        sleep(Duration::from_millis(delay_ms));
        child.kill().unwrap();
        child.wait().unwrap();
        // The killed program cannot have removed it; it must not be in the next round's way.
        assert!(files(folder.path()).contains(&".out.rad.lock".to_owned()));
        let after = std::fs::read(folder.path().join("out.rad")).unwrap();
        scene::file::from_bytes(&after).unwrap_or_else(|error| panic!("round {round}: {error}"));
        if after == before {
            // A busy machine has not come to its first checkpoint.
            shortest_ms += 20;
        } else {
            checkpoints += 1;
        }
        // Up to 180 ms more, in no step with the checkpoints.
        delay_ms = shortest_ms + (delay_ms * 37 + 11) % 180;
    }
    let done = load(folder.path(), "out.rad").provenance.iterations;
    let iterations = (done + 1).to_string();
    let solve = |input, output| {
        let limit = ["--iterations", &iterations];
        let arguments = [&[input, output], &arguments[..], &limit].concat();
        solve(folder.path(), &arguments);
        load(folder.path(), output)
    };
    let whole = solve("in.rad", "whole.rad");
    assert_same(&solve("out.rad", "out.rad"), &whole, "killed");
    // A run that ends takes its lock file with it, an earlier one's included.
    let files = files(folder.path());
    assert!(
        !files.iter().any(|name| name.contains(".lock")),
        "{files:?}"
    );
}

#[test]
fn interrupted_it_writes_the_output_exits_130_and_goes_on() {
    for (solver, signal_name) in [
        ("jacobi", "INT"),
        ("gauss-seidel", "TERM"),
        ("shooting", "INT"),
    ] {
        let folder = folder();
        save(folder.path(), "in.rad", &room());
        let arguments = ["--solver", solver, "--report", "report.json"];
        let child = start_endless(folder.path(), "in.rad", "out.rad", &arguments);
        wait_for_lock(folder.path(), "out.rad");
        // Somewhere among some iterations, which take tens of milliseconds.
        sleep(Duration::from_millis(300));
        assert!(
            !folder.path().join("out.rad").exists(),
            "no checkpoint is due"
        );
        signal(&child, signal_name);
        let output = child.wait_with_output().unwrap();
        assert_eq!(output.status.code(), Some(130), "{output:?}");
        assert!(
            stdout(&output).contains("interrupted, not converged"),
            "{output:?}"
        );
        let stopped = load(folder.path(), "out.rad");
        let report = std::fs::read_to_string(folder.path().join("report.json")).unwrap();
        assert!(report.contains("\"stopped_by\": \"interrupt\""), "{report}");

        let iterations = (stopped.provenance.iterations + 2).to_string();
        let solve = |input, output| {
            let settings = [
                "--solver",
                solver,
                "--iterations",
                &iterations,
                "--tolerance",
                "0",
            ];
            solve(
                folder.path(),
                &[&[input, output, "32"][..], &settings].concat(),
            );
            load(folder.path(), output)
        };
        let whole = solve("in.rad", "whole.rad");
        assert_same(&solve("out.rad", "out.rad"), &whole, solver);
    }
}

/// Form factors are drawn before anything is solved.
#[test]
fn interrupted_while_writing_form_factors_it_writes_the_output_and_no_half_table() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    let arguments = ["--points", "32", "--form-factors", "f.csv"];
    let child = start(
        folder.path(),
        &[&["in.rad", "out.rad", "128"][..], &arguments].concat(),
    );
    wait_for_lock(folder.path(), "f.csv");
    sleep(Duration::from_millis(200));
    signal(&child, "INT");
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(130), "{output:?}");
    assert!(
        stderr(&output).contains("f.csv: cannot write: "),
        "{output:?}"
    );
    assert_eq!(load(folder.path(), "out.rad").provenance.iterations, 0);
    assert_eq!(files(folder.path()), ["in.rad", "out.rad"]);
}

#[test]
fn iterations_already_reached_leave_the_solution_as_it_is() {
    let folder = folder();
    save(folder.path(), "in.rad", &room());
    for solver in SOLVERS {
        solve(
            folder.path(),
            &[
                "in.rad",
                "five.rad",
                "32",
                "--solver",
                solver,
                "--iterations",
                "5",
            ],
        );
        // Whatever the other settings are: they do nothing.
        for (n, resolution, other) in [
            ("5", "32", solver),
            ("3", "32", solver),
            ("5", "16", "jacobi"),
        ] {
            let arguments = [
                "five.rad",
                "out.rad",
                resolution,
                "--iterations",
                n,
                "--solver",
                other,
            ];
            let output = solve(folder.path(), &arguments);
            let said = stderr(&output);
            assert!(
                said.contains("nothing to do: five.rad has had 5 iterations"),
                "{said}"
            );
            assert!(
                stdout(&output).contains("stopped by --iterations"),
                "{output:?}"
            );
            let bytes = |name: &str| std::fs::read(folder.path().join(name)).unwrap();
            assert!(bytes("out.rad") == bytes("five.rad"), "{arguments:?}");
        }
    }
}

#[test]
fn a_converged_solution_stays_as_it_is() {
    let folder = folder();
    save(folder.path(), "in.rad", &common::furnace(0.5, 1.0, 0.1));
    for solver in SOLVERS {
        solve(
            folder.path(),
            &["in.rad", "a.rad", "32", "--solver", solver],
        );
        let output = solve(folder.path(), &["a.rad", "b.rad", "32", "--solver", solver]);
        assert!(
            stdout(&output).contains("converged to the tolerance"),
            "{output:?}"
        );
        assert_same(
            &load(folder.path(), "b.rad"),
            &load(folder.path(), "a.rad"),
            solver,
        );
        // A smaller tolerance goes on.
        let more = ["--solver", solver, "--tolerance", "1e-6"];
        solve(
            folder.path(),
            &[&["a.rad", "b.rad", "32"][..], &more].concat(),
        );
        let iterations = |name| load(folder.path(), name).provenance.iterations;
        assert!(iterations("b.rad") > iterations("a.rad"), "{solver}");
    }
}
