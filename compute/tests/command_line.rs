//! The program by its command line: usage, bad input, outputs that cannot be written, and what it
//! reports.

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::{compute, files, folder, load, program, save, solve, stderr, stdout};
use serde_json::Value;
use tempfile::TempDir;

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

/// A folder with a closed room in `in.rad`.
fn folder_with_room() -> TempDir {
    let folder = folder();
    save(folder.path(), "in.rad", &common::colourful_room(0.5));
    folder
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
        "--report",
        "--form-factors",
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
        (&["--points", "3"], &["3", "power of two"]),
        (&["--points", "0"], &["0", "power of two"]),
        (&["--points", "2048"], &["2048", "1024"]),
        (&["--iterations", "-1"], &["-1"]),
        (&["--iterations", "many"], &["many"]),
        (&["--tolerance", "-1e-5"], &["-1e-5"]),
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

fn report(folder: &Path, arguments: &[&str]) -> Value {
    solve(folder, &[arguments, &["--report", "report.json"]].concat());
    serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|v| v.as_f64().unwrap())
        .collect()
}

/// The number of a path such as `/seconds/total`.
#[track_caller]
fn number(report: &Value, path: &str) -> f64 {
    let value = report
        .pointer(path)
        .unwrap_or_else(|| panic!("{path} is missing"));
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{path} is {value}"))
}

#[test]
fn report_has_every_field_of_the_contract() {
    let folder = folder_with_room();
    let report = report(
        folder.path(),
        &[
            "in.rad",
            "out.rad",
            "32",
            "--solver",
            "gauss-seidel",
            "--points",
            "2",
            "--iterations",
            "3",
            "--threads",
            "2",
            "--memory",
            "64MiB",
            "--time-limit",
            "5min",
            "--tolerance",
            "0",
        ],
    );
    let scene = common::colourful_room(0.5);
    let patches = f64::from(scene.patch_count());
    for (path, expected) in [
        ("/settings/resolution", 32.0),
        ("/settings/tolerance", 0.0),
        ("/settings/iterations", 3.0),
        ("/settings/time_limit_seconds", 300.0),
        ("/settings/threads", 2.0),
        ("/settings/memory_bytes", 67_108_864.0),
        ("/patches", patches),
        ("/surfaces", scene.surfaces().len() as f64),
        // Two points a patch, all rows kept.
        ("/hemicubes_drawn", 2.0 * patches),
        ("/rows/kept", patches),
        ("/iterations", 3.0),
        ("/iterations_before", 0.0),
    ] {
        let found = number(&report, path);
        assert!(
            found.to_bits() == expected.to_bits(),
            "{path} is {found}, not {expected}"
        );
    }
    for (path, expected) in [
        ("/input", "in.rad"),
        ("/output", "out.rad"),
        ("/settings/maps", "exact"),
        ("/settings/points", "2"),
        ("/settings/solver", "gauss-seidel"),
        ("/backend/name", "cpu"),
        ("/backend/adapter", "cpu, 2 threads"),
        ("/stopped_by", "iterations"),
        ("/version", env!("CARGO_PKG_VERSION")),
    ] {
        let found = report.pointer(path).and_then(Value::as_str);
        assert_eq!(found, Some(expected), "{path}");
    }
    assert!(number(&report, "/rows/kept_bytes") > 8.0 * patches);
    // Less than a room of a hundred patches takes no program.
    assert!(
        (1e6..4e9).contains(&number(&report, "/peak_memory_bytes"))
            || cfg!(not(target_os = "linux"))
    );
    assert_eq!(numbers(&report["residuals"]).len(), 3);
    let solution = load(folder.path(), "out.rad");
    assert_eq!(numbers(&report["residuals"]), solution.provenance.residuals);

    let stages = ["load", "open", "draw", "solve", "write"]
        .map(|s| number(&report, &format!("/seconds/{s}")));
    assert!(stages.iter().all(|&s| s >= 0.0), "{stages:?}");
    let total = number(&report, "/seconds/total");
    assert!(
        total > 0.0 && stages.iter().sum::<f64>() <= total * 1.001,
        "{stages:?} of {total}"
    );
}

/// In a closed room all rows sum to 1 and nothing is lost; what is emitted is absorbed, but for what
/// the hemicubes' reciprocity mistakes.
#[test]
fn reported_power_is_the_closed_rooms() {
    let folder = folder_with_room();
    let scene = common::colourful_room(0.5);
    let report = report(
        folder.path(),
        &["in.rad", "out.rad", "64", "--tolerance", "1e-7"],
    );
    for path in ["/closure/min", "/closure/mean", "/closure/max"] {
        // The mean is a sum of areas over a sum of areas, in f64.
        assert!((number(&report, path) - 1.0).abs() < 1e-12, "{path}");
    }
    assert!(number(&report, "/back_face_share").to_bits() == 0.0_f64.to_bits());
    let energy = |name: &str| numbers(&report["energy"][name]);
    let emitted = energy("emitted_w");
    let (areas, emission) = (scene.patch_areas(), scene.patch_emissions());
    for channel in 0..3 {
        let sum: f64 = areas
            .iter()
            .zip(&emission)
            .map(|(a, e)| a * f64::from(e[channel]))
            .sum();
        // f64 sums in another order.
        assert!(
            (emitted[channel] - sum).abs() < 1e-12 * sum,
            "{emitted:?}, {sum}"
        );
    }
    assert_eq!(energy("lost_w"), [0.0; 3]);
    assert_eq!(energy("back_faces_w"), [0.0; 3]);
    let (total, absorbed) = (
        emitted.iter().sum::<f64>(),
        energy("absorbed_w").iter().sum::<f64>(),
    );
    let imbalance = number(&report, "/energy/imbalance");
    assert!(
        ((total - absorbed) / total - imbalance).abs() < 1e-12,
        "{imbalance}"
    );
    // 64 pixels see a patch of a tenth of a metre, 2 metres away, with 3 pixels across: single
    // form factors are off by tens of percent, sums over hundreds of them by under two.
    assert!(imbalance.abs() < 0.02, "{imbalance}");
    // What the solution says is absorbed.
    let solution = load(folder.path(), "out.rad");
    let reflectance = scene.patch_reflectances();
    let by_hand: f64 = (0..areas.len())
        .map(|i| {
            let absorbed = (1.0 - reflectance[i].as_dvec3()) * solution.irradiance[i].as_dvec3();
            areas[i] * absorbed.element_sum()
        })
        .sum();
    assert!(
        (by_hand / absorbed - 1.0).abs() < 1e-9,
        "{by_hand} {absorbed}"
    );
    let residuals = numbers(&report["residuals"]);
    assert!(*residuals.last().unwrap() <= 1e-7);
    assert_eq!(residuals.len() as f64, number(&report, "/iterations"));
    assert_eq!(report["stopped_by"], "tolerance");
}

/// A cube without its lid, all black: of what the floor emits, what does not meet a wall leaves.
#[test]
fn reported_loss_is_what_leaves_by_the_opening() {
    let folder = folder();
    let mut surfaces = common::block(glam::Vec3::ZERO, glam::Vec3::ONE, false, 0);
    surfaces.truncate(2);
    surfaces.extend(common::block(glam::Vec3::ZERO, glam::Vec3::ONE, false, 1).split_off(4));
    let materials = vec![common::material(0.0, 3.0), common::material(0.0, 0.0)];
    save(
        folder.path(),
        "in.rad",
        &common::scene(materials, surfaces, 0.002),
    );
    let report = report(folder.path(), &["in.rad", "out.rad", "128"]);
    // Howell C-11: opposite squares of a cube see 0.199824895698 of each other. Errors as in
    // `opposite_walls_of_a_cube_see_a_fifth_of_each_other`: at most one in a thousand.
    let lost = numbers(&report["energy"]["lost_w"])[0];
    assert!(
        (lost / 3.0 / 0.199_824_895_698 - 1.0).abs() < 1e-3,
        "{lost}"
    );
    let absorbed = numbers(&report["energy"]["absorbed_w"])[0];
    let imbalance = number(&report, "/energy/imbalance");
    assert!(
        (absorbed + lost + 3.0 * imbalance - 3.0).abs() < 1e-6,
        "{absorbed} {lost} {imbalance}"
    );
    assert!(number(&report, "/closure/min") < number(&report, "/closure/mean"));
    assert!(number(&report, "/closure/max") < 1.0);
}

#[test]
fn reported_back_faces_are_those_in_view() {
    let folder = folder();
    // A block inside out hangs in the room.
    let mut surfaces = common::block(glam::Vec3::ZERO, glam::Vec3::splat(3.0), false, 0);
    surfaces.extend(common::block(
        glam::Vec3::splat(1.0),
        glam::Vec3::splat(2.0),
        false,
        0,
    ));
    save(
        folder.path(),
        "in.rad",
        &common::scene(vec![common::material(0.5, 1.0)], surfaces, 0.5),
    );
    let report = report(folder.path(), &["in.rad", "out.rad", "32"]);
    let share = number(&report, "/back_face_share");
    // The block's area is a tenth of all; from the walls it fills 6 / 54 of the view on average, and
    // inside the block nothing is seen of its back: by area 6/54 x 54/60.
    assert!((share - 0.1).abs() < 0.01, "{share}");
    assert!(numbers(&report["energy"]["back_faces_w"])[0] > 0.0);
    assert!(number(&report, "/closure/max") - 1.0 <= 0.0);
}

#[test]
fn what_a_run_has_not_drawn_is_null_in_its_report() {
    let folder = folder_with_room();
    solve(folder.path(), &["in.rad", "out.rad", "16"]);
    let report = report(folder.path(), &["out.rad", "out.rad", "16"]);
    assert_eq!(
        number(&report, "/hemicubes_drawn").to_bits(),
        0.0_f64.to_bits()
    );
    for path in [
        "/closure",
        "/back_face_share",
        "/energy/lost_w",
        "/energy/imbalance",
    ] {
        assert_eq!(report.pointer(path), Some(&Value::Null), "{path}");
    }
    assert!(numbers(&report["energy"]["absorbed_w"])[0] > 0.0);
}

#[test]
fn form_factors_are_written_in_patch_order_with_rows_that_sum_to_one() {
    let folder = folder_with_room();
    let patches = common::colourful_room(0.5).patch_count() as usize;
    for (points, memory) in [("centroid", "1GiB"), ("vertices", "0B")] {
        solve(
            folder.path(),
            &[
                "in.rad",
                "out.rad",
                "32",
                "--points",
                points,
                "--memory",
                memory,
                "--iterations",
                "1",
                "--form-factors",
                "f.csv",
            ],
        );
        let text = std::fs::read_to_string(folder.path().join("f.csv")).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("from,to,form_factor"));
        let mut sums = vec![0.0; patches];
        let mut last = None;
        let mut gathered = vec![glam::DVec3::ZERO; patches];
        let emission = common::colourful_room(0.5).patch_emissions();
        for line in lines {
            let fields: Vec<&str> = line.split(',').collect();
            let &[from, to, form_factor] = fields.as_slice() else {
                panic!("{line}")
            };
            let (from, to): (usize, usize) = (from.parse().unwrap(), to.parse().unwrap());
            let form_factor: f64 = form_factor.parse().unwrap();
            assert!(form_factor > 0.0 && form_factor <= 1.0, "{line}");
            assert!(last < Some((from, to)), "{line}");
            last = Some((from, to));
            sums[from] += form_factor;
            gathered[from] += form_factor * emission[to].as_dvec3();
        }
        for (patch, sum) in sums.iter().enumerate() {
            // Quotients of integers, each rounded to f64, some hundreds of them.
            assert!((sum - 1.0).abs() < 1e-13, "{points}, patch {patch}: {sum}");
        }
        // They are those that the solver has used: its first iteration, rounded to f32.
        for (found, expected) in load(folder.path(), "out.rad")
            .irradiance
            .iter()
            .zip(&gathered)
        {
            let difference = (found.as_dvec3() - *expected).abs().max_element();
            assert!(
                difference <= 1e-7 * expected.max_element(),
                "{found} {expected}"
            );
        }
    }
}
