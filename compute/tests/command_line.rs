//! The program by its command line: usage, bad input, and outputs that cannot be written.

mod common;

use common::{
    compute, failure, files, folder, folder_with_room, program, save, solve, stderr, stdout,
};

/// A usage error leaves nothing behind; the message is given back.
#[track_caller]
fn usage_error(arguments: &[&str]) -> String {
    let folder = folder();
    save(folder.path(), "in.rad", &common::furnace(0.5, 1.0, 0.5));
    let output = compute(folder.path(), arguments);
    assert_eq!(output.status.code(), Some(2), "{arguments:?}: {output:?}");
    assert_eq!(output.stdout, b"");
    assert_eq!(files(folder.path()), ["in.rad"], "{arguments:?}");
    stderr(&output)
}

#[test]
fn without_arguments_the_usage_is_printed() {
    let message = usage_error(&[]);
    assert!(message.contains("Usage: compute"), "{message}");
    assert!(usage_error(&["in.rad"]).contains("OUT"));
}

#[test]
fn help_names_every_argument_and_is_no_error() {
    let output = solve(&std::env::temp_dir(), &["--help"]);
    let help = stdout(&output);
    for word in [
        "<IN>",
        "<OUT>",
        "[RESOLUTION]",
        "--backend",
        "auto",
        "cpu",
        "gpu",
        "--solver",
        "jacobi",
        "gauss-seidel",
        "shooting",
        "--maps",
        "exact",
        "thesis",
        "--points",
        "centroid",
        "vertices",
        "--iterations",
        "--tolerance",
        "--time-limit",
        "--checkpoint-every",
        "--threads",
        "--memory",
        "--rows-file-limit",
        "--keep-rows",
        "--report",
        "--form-factors",
        "--view-factors",
        "--strict",
        "130",
    ] {
        assert!(help.contains(word), "{word} is missing in {help}");
    }
    let version = solve(&std::env::temp_dir(), &["--version"]);
    assert!(stdout(&version).starts_with("compute "), "{version:?}");
}

#[test]
fn wrong_values_are_usage_errors_that_name_value_and_limit_or_choices() {
    for (arguments, words) in [
        (&["0"][..], &["0", "even number from 2 to 4096"][..]),
        (&["7"], &["7", "even number from 2 to 4096"]),
        (&["4098"], &["4098", "even number from 2 to 4096"]),
        (&["abc"], &["abc", "whole number"]),
        (&["-2"], &["-2"]),
        (&["--backend", "cuda"], &["cuda", "auto, cpu, gpu"]),
        (
            &["--solver", "magic"],
            &["magic", "jacobi, gauss-seidel, shooting"],
        ),
        (&["--maps", "wrong"], &["wrong", "exact, thesis"]),
        (
            &["--points", "middle"],
            &["middle", "centroid, vertices", "1024"],
        ),
        (&["--points", "5"], &["5", "power of two"]),
        (&["--points", "0"], &["0", "power of two"]),
        (&["--points", "2048"], &["2048", "1024"]),
        (&["--iterations", "-1"], &["-1"]),
        (&["--iterations", "many"], &["many"]),
        (&["--tolerance", "-0.5"], &["-0.5", ">= 0"]),
        (&["--tolerance", "nan"], &["nan", ">= 0"]),
        (&["--tolerance", "inf"], &["inf", "finite"]),
        (&["--time-limit", "90"], &["90", "ms, s, min, h", "90s"]),
        (&["--time-limit", "soon"], &["soon", "ms, s, min, h"]),
        (&["--time-limit=-5s"], &["-5s", ">= 0"]),
        (&["--time-limit", "1e300h"], &["1e300h"]),
        (&["--checkpoint-every", "5"], &["5", "ms, s, min, h"]),
        (&["--memory", "4"], &["4", "KiB, MiB, GiB"]),
        (&["--memory", "4gib"], &["4gib", "4GiB"]),
        (&["--memory", "GiB"], &["GiB", "number"]),
        (&["--rows-file-limit", "8"], &["8", "KiB, MiB, GiB"]),
        (&["--threads", "0"], &["0", "1..=1024"]),
        (&["--threads", "2000"], &["2000", "1..=1024"]),
        (&["--colour", "red"], &["--colour"]),
        (&["128", "extra"], &["extra"]),
    ] {
        let message = usage_error(&[&["in.rad", "out.rad"], arguments].concat());
        for word in words {
            assert!(message.contains(word), "{word} is missing in {message}");
        }
    }
}

#[test]
fn a_report_or_form_factors_over_another_file_are_a_usage_error() {
    for (arguments, words) in [
        (
            &["--report", "in.rad"][..],
            "IN and --report are both in.rad",
        ),
        (
            &["--report", "./in.rad"],
            "IN and --report are both ./in.rad",
        ),
        (&["--form-factors", "out.rad"], "OUT and --form-factors"),
        (
            &["--report", "x", "--form-factors", "x"],
            "--report and --form-factors are both x",
        ),
    ] {
        let message = usage_error(&[&["in.rad", "out.rad"], arguments].concat());
        assert!(message.contains(words), "{message}");
    }
}

#[test]
fn bad_input_is_one_error_that_names_the_file() {
    let folder = folder_with_room();
    solve(
        folder.path(),
        &["in.rad", "solved.rad", "16", "--iterations", "2"],
    );
    let scene = std::fs::read(folder.path().join("in.rad")).unwrap();
    let solved = std::fs::read(folder.path().join("solved.rad")).unwrap();
    let mut flipped = solved.clone();
    let middle = flipped.len() / 2;
    flipped[middle] ^= 0x10;
    let mut version = scene.clone();
    version[8] = 99;
    let longer = [&scene[..], b"and more"].concat();
    for (contents, words) in [
        (&b""[..], "the file is empty"),
        (&scene[..1], "truncated"),
        (&scene[..63], "truncated"),
        (&scene[..64], "truncated"),
        (&scene[..scene.len() - 1], "truncated"),
        (&solved[..solved.len() / 2], "truncated"),
        (&flipped, "damaged"),
        (&version, "version 99"),
        (&longer, "follow the end"),
        (b"This is a letter, not a scene.", "not a radiosity file"),
        (&[0; 4096], "not a radiosity file"),
    ] {
        std::fs::write(folder.path().join("bad.rad"), contents).unwrap();
        let message = failure(folder.path(), &["bad.rad", "out.rad"]);
        assert!(
            message.contains("bad.rad: ") && message.contains(words),
            "{message}"
        );
        // The input is not lost where it is the output too.
        failure(folder.path(), &["bad.rad", "bad.rad"]);
        assert_eq!(
            std::fs::read(folder.path().join("bad.rad")).unwrap(),
            contents
        );
    }
    let message = failure(folder.path(), &["missing.rad", "out.rad"]);
    assert!(message.contains("missing.rad: cannot read: "), "{message}");
    std::fs::create_dir(folder.path().join("folder.rad")).unwrap();
    let message = failure(folder.path(), &["folder.rad", "out.rad"]);
    assert!(message.contains("folder.rad: cannot read: "), "{message}");
}

#[test]
fn an_output_that_is_a_folder_or_in_none_is_named() {
    let folder = folder_with_room();
    std::fs::create_dir(folder.path().join("folder")).unwrap();
    for output in ["nowhere/out.rad", "folder", ".", "in.rad/out.rad"] {
        let message = failure(folder.path(), &["in.rad", output, "16"]);
        assert!(
            message.contains(&format!("{output}: cannot write: ")),
            "{message}"
        );
    }
    for option in ["--report", "--form-factors"] {
        let message = failure(
            folder.path(),
            &["in.rad", "out.rad", "16", option, "nowhere/x"],
        );
        assert!(message.contains("nowhere/x: cannot write: "), "{message}");
    }
}

#[cfg(unix)]
#[test]
fn an_output_in_a_read_only_folder_is_named() {
    let folder = folder_with_room();
    let closed = test_needs::closed_folder(folder.path());
    let output = closed.join("out.rad");
    let output = output.to_str().unwrap();
    let message = failure(folder.path(), &["in.rad", output, "16"]);
    assert!(
        message.contains(&format!("{output}: cannot write: ")),
        "{message}"
    );
}

/// Only Vulkan's adapters can be hidden.
#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_gpu_is_an_error_and_auto_is_the_cpu() {
    let folder = folder_with_room();
    let run = |backend: &str| {
        program(
            folder.path(),
            &["in.rad", "out.rad", "16", "--backend", backend],
        )
        // The Vulkan loader's own variables: no driver at all.
        .env("VK_ICD_FILENAMES", "/nonexistent")
        .env("VK_DRIVER_FILES", "/nonexistent")
        .env_remove("VK_ADD_DRIVER_FILES")
        .output()
        .unwrap()
    };
    let output = run("gpu");
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let message = stderr(&output);
    assert!(
        message.starts_with("compute: error: no GPU adapter was found")
            && message.contains("--backend cpu"),
        "{message}"
    );
    assert_eq!(message.lines().count(), 1, "{message}");
    assert_eq!(files(folder.path()), ["in.rad"]);
    let output = run("auto");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(stdout(&output).contains("(cpu, "), "{output:?}");
}

/// Standard output is for the summary alone; progress is for standard error, without a bar's control
/// characters where that is no terminal.
#[test]
fn standard_output_is_the_summary_and_nothing_is_drawn_without_a_terminal() {
    let folder = folder_with_room();
    let output = solve(folder.path(), &["in.rad", "out.rad", "16"]);
    assert_eq!(stderr(&output), "");
    let summary = stdout(&output);
    assert!(!summary.contains(['\u{1b}', '\r']), "{summary}");
    let labels: Vec<&str> = summary.lines().map(|line| line[..15].trim()).collect();
    let expected = [
        "output",
        "scene",
        "back end",
        "time",
        "hemicubes",
        "emitted power",
        "power balance",
        "row sums",
        "certificate",
        "result",
    ];
    assert_eq!(labels, expected, "{summary}");
    assert!(
        summary
            .lines()
            .last()
            .unwrap()
            .contains("converged to the tolerance"),
        "{summary}"
    );
}

#[test]
fn regression_radiosities_beyond_f32_are_an_error() {
    let folder = common::folder();
    common::save(folder.path(), "in.rad", &common::furnace(0.9, 3e38, 0.5));
    for solver in ["jacobi", "gauss-seidel", "shooting"] {
        let output = compute(
            folder.path(),
            &["in.rad", "out.rad", "16", "--solver", solver],
        );
        assert_eq!(output.status.code(), Some(1), "{solver}: {output:?}");
        assert!(
            stderr(&output).contains("lower the emission"),
            "{solver}: {output:?}"
        );
    }
}

#[test]
fn regression_two_names_of_one_new_file_are_wrong_usage() {
    let folder = common::folder_with_room();
    let output = compute(
        folder.path(),
        &["in.rad", "out.rad", "--report", "./out.rad"],
    );
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    assert!(
        stderr(&output).contains("choose another name"),
        "{output:?}"
    );
}

/// Not `/dev/null`, which a test must not risk.
#[cfg(unix)]
#[test]
fn regression_the_report_can_go_into_a_pipe() {
    let folder = common::folder_with_room();
    let pipe = folder.path().join("pipe");
    let made = std::process::Command::new("mkfifo")
        .arg(&pipe)
        .status()
        .unwrap();
    assert!(made.success());
    // Another process reads, so that a run that never opens the pipe does not leave the test waiting.
    let mut reader = std::process::Command::new("cat");
    let mut reader = reader
        .arg(&pipe)
        .stdout(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let run = compute(
        folder.path(),
        &["in.rad", "out.rad", "8", "--report", "pipe"],
    );
    if run.status.code() != Some(0) {
        reader.kill().unwrap();
    }
    let report = reader.wait_with_output().unwrap().stdout;
    assert_eq!(run.status.code(), Some(0), "{run:?}");
    assert!(serde_json::from_slice::<serde_json::Value>(&report).unwrap()["patches"].is_u64());
}
