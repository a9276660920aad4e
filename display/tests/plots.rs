//! Charts of reports, read back.

use std::path::PathBuf;

use display::plot::plot;
use serde_json::{Value, json};
use tempfile::{TempDir, tempdir};

/// The colours of bars of power errors, of visible errors and of seconds.
const POWER: &str = "#1f77b4";
const VISIBLE: &str = "#ff7f0e";
const SECONDS: &str = "#2ca02c";

fn report() -> Value {
    json!({
        "version": "0.1.0",
        "input": "cornell.rad",
        "iterations": 8,
        "residuals": [0.5, 0.11, 0.023, 4.9e-3, 1.1e-3, 2.2e-4, 4.6e-5, 9.8e-6],
        "convergence": { "rate": 0.21, "estimated_error": 2.7e-6, "rounding_error": 1e-7 },
        "seconds": { "load": 0.01, "open": 0.0, "draw": 1.93, "solve": 0.42, "write": 0.03, "total": 2.39 },
        "function": {
            "vertices": 2044,
            "error": {
                "total": { "power": 0.0081, "visible": 0.021 },
                "mesh": { "power": 0.0052, "visible": 0.017 },
                "sources": { "power": 0.0032, "visible": 0.0061 },
                "pixels": { "power": 0.0041, "visible": 0.0102 },
                "iterations": { "power": 2e-6, "visible": 2e-6 },
                "sampling": { "power": 0.0, "visible": 0.0 },
            },
        },
    })
}

fn files(report: &str) -> (TempDir, PathBuf, PathBuf) {
    let folder = tempdir().unwrap();
    let [input, out] = ["report.json", "charts.svg"].map(|name| folder.path().join(name));
    std::fs::write(&input, report).unwrap();
    (folder, input, out)
}

/// The SVG of a report, which has been found to be XML.
fn svg_of(report: &Value) -> String {
    let (_folder, input, out) = files(&report.to_string());
    plot(&input, &out).unwrap();
    let svg = std::fs::read_to_string(out).unwrap();
    check_xml(&svg);
    svg
}

fn error_of(report: &str) -> String {
    let (folder, input, out) = files(report);
    let message = plot(&input, &out).unwrap_err().to_string();
    assert!(message.contains("report.json"), "{message}");
    assert_eq!(
        std::fs::read_dir(folder.path()).unwrap().count(),
        1,
        "{message}"
    );
    message
}

/// Panics unless the text is well-formed XML 1.0, as far as SVGs without a document type use it.
fn check_xml(text: &str) {
    let is_char = |c: char| matches!(c, '\t' | '\n' | '\r' | '\u{20}'..='\u{fffd}' | '\u{10000}'..);
    assert!(text.chars().all(is_char), "a character that XML has not");
    let mut open: Vec<&str> = Vec::new();
    let mut roots = 0;
    let mut rest = text;
    while let Some(start) = rest.find('<') {
        check_text(&rest[..start]);
        rest = &rest[start..];
        if let Some(comment) = rest.strip_prefix("<!--") {
            let end = comment.find("--").expect("the end of a comment");
            rest = comment[end + 2..]
                .strip_prefix('>')
                .expect("no -- in a comment");
            continue;
        }
        let end = rest.find('>').expect("the end of a tag");
        let tag = &rest[1..end];
        rest = &rest[end + 1..];
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name.trim_end()));
            continue;
        }
        let (inner, is_empty) = tag
            .strip_suffix('/')
            .map_or((tag, false), |tag| (tag, true));
        let (name, attributes) = inner.split_once(' ').unwrap_or((inner, ""));
        assert!(
            name.chars().all(char::is_alphanumeric) && !name.is_empty(),
            "<{tag}>"
        );
        check_attributes(attributes);
        roots += usize::from(open.is_empty());
        if !is_empty {
            open.push(name);
        }
    }
    assert!(rest.trim().is_empty(), "{rest}");
    assert!(
        open.is_empty() && roots == 1,
        "{open:?} left open, {roots} roots"
    );
}

fn check_attributes(text: &str) {
    let mut names = Vec::new();
    let mut rest = text.trim();
    while !rest.is_empty() {
        let (name, value) = rest.split_once("=\"").expect("NAME=\"VALUE\"");
        let (value, after) = value.split_once('"').expect("the end of a value");
        assert!(
            !name.contains(char::is_whitespace) && !names.contains(&name),
            "{text}"
        );
        assert!(after.is_empty() || after.starts_with(' '), "{text}");
        check_text(value);
        names.push(name);
        rest = after.trim();
    }
}

/// No character that begins something else, and no entity that XML has not.
fn check_text(text: &str) {
    assert!(!text.contains('<'), "{text}");
    for entity in text.split('&').skip(1) {
        let known = ["amp;", "lt;", "gt;", "quot;", "apos;", "#"];
        assert!(
            known.iter().any(|known| entity.starts_with(known)),
            "&{entity}"
        );
    }
}

/// The tags of a kind, their attributes included.
fn tags<'s>(svg: &'s str, start: &str) -> Vec<&'s str> {
    let from = svg.match_indices(start).map(|(at, _)| &svg[at..]);
    from.map(|tag| &tag[..=tag.find('>').unwrap()]).collect()
}

/// How many rectangles have a colour.
fn rectangles(svg: &str, colour: &str) -> usize {
    let fill = format!("fill=\"{colour}\"");
    tags(svg, "<rect")
        .iter()
        .filter(|tag| tag.contains(&fill))
        .count()
}

/// How many points the line of residuals has.
fn points(svg: &str) -> usize {
    let lines = tags(svg, "<path")
        .into_iter()
        .filter(|tag| tag.contains(POWER));
    lines.map(|tag| tag.matches(['M', 'L']).count()).sum()
}

#[test]
fn every_cause_and_every_stage_has_its_bars_and_every_iteration_its_point() {
    let svg = svg_of(&report());
    // One of each colour is the legend's.
    assert_eq!(rectangles(&svg, POWER), 6 + 1);
    assert_eq!(rectangles(&svg, VISIBLE), 6 + 1);
    assert_eq!(rectangles(&svg, SECONDS), 6);
    assert_eq!(points(&svg), 8);
    for text in [
        "cornell.rad",
        "mesh",
        "sampling",
        "draw",
        "error by cause",
        "seconds by stage",
        "2.7e-6",
    ] {
        assert!(svg.contains(text), "{text}");
    }
}

#[test]
fn parts_that_a_report_lacks_have_no_chart() {
    for (part, value) in [
        ("function", Value::Null),
        ("function", json!({ "error": null })),
        ("residuals", json!([])),
        ("residuals", json!([null, 0.0])),
    ] {
        let mut report = report();
        report[part] = value;
        let svg = svg_of(&report);
        assert_eq!(svg.contains("error by cause"), part != "function");
        assert_eq!(svg.contains("residual by iteration"), part != "residuals");
        assert_eq!(rectangles(&svg, SECONDS), 6);
    }
    let least = svg_of(&json!({ "seconds": { "total": 0.0 } }));
    assert_eq!(rectangles(&least, SECONDS), 1);
}

#[test]
fn numbers_that_are_unknown_are_called_so() {
    let mut report = report();
    report["residuals"] = json!([0.5, null, 0.02, 1e-3]);
    report["convergence"] = Value::Null;
    report["function"]["error"]["mesh"]["visible"] = Value::Null;
    report["seconds"]["draw"] = Value::Null;
    let svg = svg_of(&report);
    assert_eq!(points(&svg), 3);
    assert_eq!((rectangles(&svg, POWER), rectangles(&svg, VISIBLE)), (7, 7));
    assert!(svg.contains("mesh: unknown") && svg.contains("draw: unknown"));
    assert!(!svg.contains("sources: unknown") && !svg.contains("estimated error"));
}

#[test]
fn thousands_of_iterations_are_500_points_from_the_first_to_the_last() {
    let mut report = report();
    let residuals: Vec<f64> = (0..123_457)
        .map(|k| (-f64::from(k) / 5000.0).exp())
        .collect();
    report["residuals"] = json!(residuals);
    report["iterations"] = json!(123_457);
    let svg = svg_of(&report);
    assert_eq!(points(&svg), 500);
    assert!(svg.len() < 200_000, "{} bytes", svg.len());
}

#[test]
fn residuals_axis_is_logarithmic_at_any_size() {
    // Heights of points that are each a decade below the one before.
    for exponents in [-3..1, -14..-9, -25..-1] {
        let mut report = report();
        let residuals: Vec<f64> = exponents.rev().map(|e| 10.0_f64.powi(e)).collect();
        report["residuals"] = json!(residuals);
        let svg = svg_of(&report);
        let marks = tags(&svg, "<circle");
        let heights: Vec<f64> = marks
            .iter()
            .map(|tag| {
                let (_, height) = tag.split_once("cy=\"").unwrap();
                height.split('"').next().unwrap().parse().unwrap()
            })
            .collect();
        assert_eq!(heights.len(), residuals.len());
        let steps: Vec<f64> = heights.windows(2).map(|pair| pair[1] - pair[0]).collect();
        for step in &steps {
            // Coordinates are written in hundredths.
            assert!(*step > 1.0 && (step - steps[0]).abs() < 0.03, "{steps:?}");
        }
    }
}

#[test]
fn numbers_of_any_size_make_a_chart() {
    for (low, high) in [
        (1e-30, 1e12),
        (1e-300, 1e-300),
        (0.0, 0.0),
        (1e12, 1e12),
        (1.0, 1.0),
    ] {
        let mut report = report();
        report["residuals"] = json!([high, low]);
        report["seconds"] = json!({ "draw": low, "total": high });
        report["function"]["error"] = json!({ "mesh": { "power": low, "visible": high } });
        let svg = svg_of(&report);
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{low} {high}");
        assert_eq!(rectangles(&svg, VISIBLE), 2);
    }
}

#[test]
fn names_are_text_whatever_they_are() {
    let name = "</text><script>\"&\u{1}\u{0}\n$x^2$ \\$ $";
    let mut report = report();
    report["input"] = json!(name);
    report["seconds"] = json!({ "total": 1.0, name: 2.0, "]]>": 1.0 });
    report["function"]["error"] = json!({ name: { "power": 0.1, "visible": 0.2 }, "x": {} });
    let svg = svg_of(&report);
    assert!(!svg.contains("<script>"));
    assert!(svg.contains("&lt;/text&gt;&lt;script&gt;&quot;&amp;\u{fffd}\u{fffd}\u{fffd}$x^2$"));
    report["input"] = json!("é".repeat(5000) + "end.rad");
    let svg = svg_of(&report);
    assert!(svg.contains("ééend.rad<") && !svg.contains(&"é".repeat(40)));
}

#[test]
fn file_that_is_no_report_is_told_with_what_it_lacks() {
    for (report, part) in [
        ("", "no JSON"),
        ("{ \"seconds\": ", "no JSON"),
        ("[1, 2]", "no JSON object"),
        ("{}", "no \"seconds\""),
        ("{ \"seconds\": 3 }", "\"seconds\" is no object"),
        ("{ \"seconds\": {} }", "\"seconds\" are empty"),
        (
            "{ \"seconds\": { \"draw\": \"long\" } }",
            "\"draw\" has \"long\"",
        ),
        ("{ \"seconds\": { \"draw\": -1 } }", "\"draw\" has -1"),
        (
            "{ \"seconds\": { \"draw\": 1e300 } }",
            "\"draw\" has 1e+300",
        ),
        (
            "{ \"seconds\": { \"draw\": 1 }, \"residuals\": 1 }",
            "\"residuals\" are no array",
        ),
        (
            "{ \"seconds\": { \"draw\": 1 }, \"residuals\": [[]] }",
            "\"residuals\" has []",
        ),
        (
            "{ \"seconds\": { \"draw\": 1 }, \"function\": 1 }",
            "\"function\" is no object",
        ),
        (
            "{ \"seconds\": { \"draw\": 1 }, \"function\": { \"error\": { \"mesh\": 2 } } }",
            "\"mesh\" is no object",
        ),
    ] {
        let message = error_of(report);
        assert!(message.contains(part), "{report}: {message}");
    }
}

#[test]
fn report_that_is_not_there_or_is_the_output_is_told() {
    let (folder, input, out) = files(&report().to_string());
    let message = plot(&folder.path().join("none.json"), &out)
        .unwrap_err()
        .to_string();
    assert!(message.contains("none.json: cannot read"), "{message}");
    let before = std::fs::read(&input).unwrap();
    let message = plot(&input, &input).unwrap_err().to_string();
    assert!(message.contains("is the report"), "{message}");
    assert_eq!(std::fs::read(&input).unwrap(), before);
}

#[test]
#[should_panic(expected = "left open")]
fn check_of_xml_can_fail() {
    check_xml("<svg><g></g>");
}
