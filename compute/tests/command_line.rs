//! The program by its command line: usage, bad input, and outputs that cannot be written.

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::{
    compute, files, folder, folder_with_room, load, program, save, solve, stderr, stdout,
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

/// A failure says so in one line and leaves the folder as it was; the message is given back.
#[track_caller]
fn failure(folder: &Path, arguments: &[&str]) -> String {
    let before = files(folder);
    let output = compute(folder, arguments);
    assert_eq!(output.status.code(), Some(1), "{arguments:?}: {output:?}");
    assert_eq!(output.stdout, b"");
    assert_eq!(files(folder), before, "{arguments:?}");
    let message = stderr(&output);
    assert!(message.starts_with("compute: error: "), "{message}");
    assert_eq!(message.lines().count(), 1, "{message}");
    assert!(!message.trim_end().ends_with('.'), "{message}");
    message
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

/// A small file system in memory over a folder, until the end of the test.
struct SmallDisk(PathBuf);

impl SmallDisk {
    /// `None`, and a line that says so, where this user may not mount.
    fn new(folder: &Path, size: &str) -> Option<Self> {
        let path = folder.join("disk");
        std::fs::create_dir(&path).unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={size}"), "none"])
            .arg(&path)
            .output();
        if mounted.is_ok_and(|output| output.status.success()) {
            Some(Self(path))
        } else {
            eprintln!("skipped: a small disk needs the right to mount");
            None
        }
    }

    fn make_read_only(&self) {
        let remounted = Command::new("mount")
            .args(["-o", "remount,ro"])
            .arg(&self.0)
            .status();
        assert!(remounted.unwrap().success());
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        Command::new("umount").arg(&self.0).status().ok();
    }
}

#[test]
fn an_output_on_a_read_only_disk_is_named_and_stays() {
    let folder = folder_with_room();
    let Some(disk) = SmallDisk::new(folder.path(), "1m") else {
        return;
    };
    std::fs::copy(folder.path().join("in.rad"), disk.0.join("out.rad")).unwrap();
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
    assert_eq!(files(&disk.0), ["out.rad"]);
    // It is good enough to read from.
    solve(folder.path(), &["disk/out.rad", "here.rad", "16"]);
}

#[cfg(unix)]
#[test]
fn an_output_in_a_read_only_folder_is_named() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder_with_room();
    let closed = folder.path().join("closed");
    std::fs::create_dir(&closed).unwrap();
    std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o555)).unwrap();
    if std::fs::write(closed.join("probe"), "").is_ok() {
        eprintln!("skipped: permissions do not bind this user");
        return;
    }
    let message = failure(folder.path(), &["in.rad", "closed/out.rad", "16"]);
    assert!(
        message.contains("closed/out.rad: cannot write: "),
        "{message}"
    );
}

#[test]
fn on_a_full_disk_the_output_stays_as_it_was() {
    let folder = folder_with_room();
    let Some(disk) = SmallDisk::new(folder.path(), "64k") else {
        return;
    };
    std::fs::copy(folder.path().join("in.rad"), disk.0.join("out.rad")).unwrap();
    let before = std::fs::read(disk.0.join("out.rad")).unwrap();
    let mut filler = std::fs::File::create(disk.0.join("filler")).unwrap();
    while std::io::Write::write(&mut filler, &[1; 4096]).is_ok() {}
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
        assert_eq!(std::fs::read(disk.0.join("out.rad")).unwrap(), before);
        assert_eq!(
            files(&disk.0),
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
    if cfg!(target_os = "linux") {
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
    } else {
        eprintln!("skipped: only Vulkan's adapters can be hidden");
    }
    let output = run("auto");
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert!(
        cfg!(not(target_os = "linux")) || stdout(&output).contains("(cpu, "),
        "{output:?}"
    );
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
