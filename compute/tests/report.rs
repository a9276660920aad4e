//! What the program tells of its work: the report and the table of form factors.

mod common;

use std::path::Path;

use common::methods::ROUNDING;
use common::{folder, folder_with_room, load, save, solve, stdout};
use glam::Vec3;
use serde_json::Value;

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
        ("/settings/seed", "0"),
        ("/settings/lamps", "auto"),
        ("/settings/closed_forms", "auto"),
        ("/settings/source_area", "auto"),
        ("/settings/solver", "gauss-seidel"),
        ("/backend/name", "cpu"),
        ("/backend/adapter", "cpu, 2 threads"),
        ("/stopped_by", "iterations"),
        ("/version", env!("CARGO_PKG_VERSION")),
    ] {
        let found = report.pointer(path).and_then(Value::as_str);
        assert_eq!(found, Some(expected), "{path}");
    }
    assert_eq!(report.pointer("/backend/trial"), Some(&Value::Null));
    // What decides the solution is in its file too, in the same words, and who drew.
    let recorded = load(folder.path(), "out.rad").provenance.settings;
    let recorded = serde_json::to_value(recorded).unwrap();
    let recorded = recorded.as_object().unwrap();
    assert_eq!(recorded.len(), 9);
    for (name, value) in recorded {
        let told = match name.as_str() {
            "backend" => &report["backend"]["name"],
            _ => &report["settings"][name],
        };
        assert_eq!(told, value, "{name}");
    }
    assert!(number(&report, "/rows/kept_bytes") > 8.0 * patches);
    assert!((2.0..8.0).contains(&number(&report, "/rows/bytes_per_entry")));
    assert!(report.get("ambient_radiosity").is_none());
    // Less than a room of a hundred patches takes no program.
    assert!(
        (1e6..4e9).contains(&number(&report, "/peak_memory_bytes"))
            || cfg!(not(target_os = "linux"))
    );
    assert_eq!(numbers(&report["residuals"]).len(), 3);
    for path in ["rate", "estimated_error", "rounding_error"] {
        let share = number(&report, &format!("/convergence/{path}"));
        assert!((0.0..1.0).contains(&share), "{path} is {share}");
    }
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
        // Form factors are rounded to half of 2^-24 of themselves.
        assert!((number(&report, path) - 1.0).abs() < ROUNDING, "{path}");
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
    assert_eq!(report["iterations"], residuals.len());
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
    assert!(number(&report, "/closure/max") - 1.0 < ROUNDING);
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

/// Next to reflectance 1 radiosities hardly change long before they are right; the summary says so.
#[test]
fn summary_tells_what_is_within_the_tolerance_and_far_from_the_solution() {
    let folder = folder();
    for (reflectance, is_converged) in [(0.5, true), (0.9995, false)] {
        let materials = vec![common::material(reflectance, 1.0)];
        let walls = common::block(Vec3::ZERO, Vec3::ONE, false, 0);
        save(
            folder.path(),
            "in.rad",
            &common::scene(materials, walls, 9.0),
        );
        let said = solve(
            folder.path(),
            &["in.rad", "out.rad", "8", "--tolerance", "1e-3"],
        );
        let said = stdout(&said);
        assert!(said.contains("converged to the tolerance"), "{said}");
        let says_not = said.contains(", but not to the solution");
        assert_eq!(says_not, !is_converged, "{said}");
    }
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
            assert!(
                (sum - 1.0).abs() < ROUNDING,
                "{points}, patch {patch}: {sum}"
            );
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
