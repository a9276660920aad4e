//! `compute verify`: its lines, its formats, its exit codes, and that a wrong answer is found.

mod common;

use common::{compute, folder, solve, stderr, stdout};
use compute::settings::{FormFactorSettings, LampViews, Points};
use compute::verify::case::{Case, Expected};
use compute::verify::{Backends, Format, Settings, run_cases, select};
use serde_json::Value;

const FURNACE: &str = "furnace, reflectance 0.5";
const SQUARES: &str = "coaxial unit squares, separation 1";

fn settings() -> Settings {
    Settings {
        form_factors: FormFactorSettings {
            points: Points::CENTROID,
            lamps: LampViews::Off,
            ..FormFactorSettings::new(32)
        },
        backends: Backends::Cpu,
        case: None,
        format: Format::Text,
    }
}

/// What is printed, and whether all cases hold.
fn run(cases: &[Case], settings: &Settings) -> (String, bool) {
    let mut out = Vec::new();
    let holds = run_cases(cases, settings, &mut out).unwrap();
    (String::from_utf8(out).unwrap(), holds)
}

#[test]
fn a_case_is_a_line_with_everything_about_it() {
    let output = solve(folder().path(), &["verify", "--case", FURNACE]);
    let text = stdout(&output);
    assert_eq!(text.lines().count(), 3, "{text}");
    let line = text.lines().nth(1).unwrap();
    for part in [FURNACE, "2.0000000", "E / (1 - rho)", "cpu", "%", "ok"] {
        assert!(line.contains(part), "{part} is missing in {line}");
    }
    assert!(text.contains("1 of 1 within their tolerances"), "{text}");
}

/// In a convex room a run has formulas by default.
#[test]
fn by_default_a_case_goes_the_way_of_a_run() {
    let arguments = ["verify", "--case", FURNACE, "--backend", "auto"];
    let text = stdout(&solve(folder().path(), &arguments));
    assert!(text.lines().nth(1).unwrap().contains("formula"), "{text}");
}

#[test]
fn a_case_that_misses_is_exit_code_1() {
    let arguments = ["verify", "--case", SQUARES, "--maps", "thesis"];
    let output = compute(folder().path(), &arguments);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    assert!(stdout(&output).contains("miss"), "{output:?}");
    assert_eq!(stderr(&output), "");
}

#[test]
fn a_sabotaged_expectation_is_found() {
    for name in [
        FURNACE,
        "a room with two floating blocks",
        "cube in a cube, small to large",
        "unit squares distance 1, fully blocked by a 3x3 plate",
    ] {
        let mut cases = select(Some(name)).unwrap();
        let (text, holds) = run(&cases, &settings());
        assert!(holds, "{text}");
        let Expected::Value(value) = cases[0].expected else {
            panic!("{name} has no value")
        };
        let off = 2.0 * cases[0].tolerance.relative + 1e-9;
        cases[0].expected = Expected::Value(value * (1.0 + off) + off);
        let (text, holds) = run(&cases, &settings());
        assert!(!holds, "{text}");
        assert!(text.contains("miss"), "{text}");
    }
}

#[test]
fn json_has_one_object_a_case() {
    let mut settings = settings();
    settings.format = Format::Json;
    let cases = select(Some("furnace")).unwrap();
    let (text, holds) = run(&cases, &settings);
    let Value::Array(objects) = serde_json::from_str(&text).unwrap() else {
        panic!("no array: {text}")
    };
    assert!(holds, "{text}");
    assert_eq!(objects.len(), cases.len());
    assert_eq!(objects[0]["name"], cases[0].name);
    assert_eq!(objects[0]["backend"], "cpu");
    assert_eq!(objects[0]["resolution"], 32);
    assert_eq!(objects[0]["verdict"], "ok");
    for key in ["expected", "computed", "error", "tolerance"] {
        assert!(objects[0][key].is_number(), "{key}: {text}");
    }
}

#[test]
fn an_unknown_case_is_a_usage_error_that_lists_the_names() {
    let output = compute(folder().path(), &["verify", "--case", "no such case"]);
    assert_eq!(output.status.code(), Some(2), "{output:?}");
    let message = stderr(&output);
    for part in ["no such case", FURNACE, SQUARES] {
        assert!(message.contains(part), "{part} is missing in {message}");
    }
}

#[test]
fn part_of_a_name_selects_every_case_that_has_it() {
    let cases = select(Some("COAXIAL UNIT squares")).unwrap();
    assert_eq!(cases.len(), 5);
    // A whole name selects that case alone, though it is a part of others.
    assert_eq!(select(Some("furnace, reflectance 0.9")).unwrap().len(), 1);
    assert!(select(None).unwrap().len() > 60);
}

#[test]
fn wrong_arguments_are_usage_errors() {
    for arguments in [
        &["verify", "7"][..],
        &["verify", "--backend", "cuda"],
        &["verify", "--points", "5"],
        &["verify", "--json", "--markdown"],
        &["verify", "64", "--solver", "jacobi"],
        &["verify", "64", "128"],
    ] {
        let output = compute(folder().path(), arguments);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {output:?}");
        assert_eq!(stdout(&output), "");
    }
}

#[test]
fn markdown_has_the_cases_and_what_the_thesis_makes_of_them() {
    let mut settings = settings();
    settings.format = Format::Markdown;
    let cases = select(Some(SQUARES)).unwrap();
    let (text, _) = run(&cases, &settings);
    for part in [
        "# Accuracy",
        "compute verify --markdown",
        "## Cases, cpu",
        "## Tolerances",
        "## The thesis's multipliers",
        "## Error against resolution and points",
    ] {
        assert!(text.contains(part), "{part} is missing in {text}");
    }
    assert!(text.contains(&format!("| {SQUARES} |")), "{text}");
}
