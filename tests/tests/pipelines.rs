//! Whole pipelines by the command lines: genx, compute, display, for every model.

use image::GenericImageView;
use tempfile::TempDir;
use tests::{data, folder, patches, run, workspace};

/// The models, and what follows them on the command line of genx: as few patches as show something.
const MODELS: [(&str, &[&str]); 5] = [
    ("1", &["2.5", "0.5", "100000"]),
    ("2", &["--max-area", "200"]),
    ("3", &["--max-area", "1"]),
    ("cornell", &["--max-area", "0.01"]),
    ("furnace", &["--max-area", "0.1"]),
];

/// The picture shows something: colours that are not black over a good part, and more than a few.
#[track_caller]
fn assert_shows_something(folder: &TempDir, name: &str, colours_at_least: usize) {
    let picture = image::open(folder.path().join(name)).unwrap();
    assert_eq!(picture.dimensions(), (160, 120), "{name}");
    let mut colours: Vec<[u8; 3]> = picture.to_rgb8().pixels().map(|p| p.0).collect();
    let lit = colours.iter().filter(|c| c.iter().any(|&v| v > 8)).count();
    assert!(
        4 * lit > colours.len(),
        "{name}: {lit} of {} pixels are not black",
        colours.len()
    );
    colours.sort_unstable();
    colours.dedup();
    assert!(
        colours.len() >= colours_at_least,
        "{name}: {} colours",
        colours.len()
    );
}

#[test]
fn every_model_goes_through_all_programs() {
    for (model, arguments) in MODELS {
        let folder = folder();
        let made = run(&folder, "genx", &[&["a.rad", model], arguments].concat());
        let patches_line = made
            .lines()
            .find(|line| line.starts_with("patches "))
            .unwrap();
        let count: usize = patches_line["patches".len()..].trim().parse().unwrap();
        let settings = [
            "--backend",
            "cpu",
            "--report",
            "report.json",
            "--tolerance",
            "1e-3",
        ];
        let said = run(
            &folder,
            "compute",
            &[&["a.rad", "b.rad", "32"][..], &settings].concat(),
        );
        assert!(
            said.contains("converged to the tolerance"),
            "{model}: {said}"
        );
        assert!(
            said.contains(&format!("{count} patches on ")),
            "{model}: {said}"
        );

        let size = ["--size", "160x120"];
        // Everything in the furnace has one radiosity.
        let colours = if model == "furnace" { 1 } else { 30 };
        for (name, mode) in [("log.png", "log"), ("false.png", "false-color")] {
            run(
                &folder,
                "display",
                &[&["b.rad", "--out", name, "--mode", mode][..], &size].concat(),
            );
            assert_shows_something(&folder, name, colours);
        }
        run(
            &folder,
            "display",
            &[&["b.rad", "c", "--out", "ids.png"][..], &size].concat(),
        );
        assert_shows_something(&folder, "ids.png", 8);

        for export in ["x.csv", "x.ply", "x.glb", "x.obj"] {
            run(&folder, "display", &["b.rad", "--export", export]);
            assert!(
                std::fs::metadata(folder.path().join(export)).unwrap().len() > 100,
                "{export}"
            );
        }
        let csv = std::fs::read_to_string(folder.path().join("x.csv")).unwrap();
        assert_eq!(csv.lines().count(), count + 1, "{model}");
        assert!(csv.ends_with('\n'));

        let report = std::fs::read(folder.path().join("report.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        assert_eq!(report["patches"], count, "{model}");
        let number = |path| {
            report
                .pointer(path)
                .and_then(serde_json::Value::as_f64)
                .unwrap()
        };
        // No crack, no wrong winding: rounding at edges may show a pixel or two of a back in millions.
        assert!(number("/back_face_share") < 1e-4, "{model}: {report}");
        // Only the Cornell box has an opening.
        if model != "cornell" {
            assert!(number("/closure/min") > 1.0 - 1e-3, "{model}: {report}");
        }
        // Form factors are rounded to half of 2^-24 of themselves.
        assert!(number("/closure/max") < 1.0 + 6e-8, "{model}: {report}");
    }
}

/// Radiosity in a file, B = E + rho H, is one sum of f32s.
#[test]
fn exported_radiosity_is_emission_plus_reflected_irradiance() {
    let folder = folder();
    run(&folder, "genx", &["a.rad", "cornell", "--max-area", "0.01"]);
    run(
        &folder,
        "compute",
        &["a.rad", "a.rad", "32", "--backend", "cpu"],
    );
    for patch in patches(&folder, "a.rad") {
        let expected = patch.emission + patch.reflectance * patch.irradiance;
        let error = (patch.radiosity - expected).abs().max_element();
        // Product and sum are rounded to f32.
        assert!(
            error <= expected.max_element() * 2.0 / f64::from(1 << 24),
            "{patch:?}"
        );
    }
}

/// Beyond the obstacle, which ends at x = 4.8 m: the flattest ray from the window at z = 0, x < 3 m passes
/// the obstacle's corner at x = 3 m, z = 6 m and meets the end wall at x = 4.5 m.
#[test]
fn second_leg_of_model_3_is_lit_by_reflections_alone() {
    let folder = folder();
    run(&folder, "genx", &["a.rad", "3", "--max-area", "0.5"]);
    let after = |iterations: &str| {
        let settings = ["--backend", "cpu", "--iterations", iterations];
        run(
            &folder,
            "compute",
            &[&["a.rad", "b.rad", "64"][..], &settings].concat(),
        );
        patches(&folder, "b.rad")
    };
    let (first, second, last) = (after("1"), after("2"), after("8"));
    let shaded: Vec<usize> = (0..first.len())
        .filter(|&i| first[i].centroid.x > 4.8)
        .collect();
    let area: f64 = shaded.iter().map(|&i| first[i].area).sum();
    assert!(
        3.0 * area > first.iter().map(|p| p.area).sum(),
        "{area} m^2"
    );
    let lit = |patches: &[tests::PatchRow]| {
        let is_lit = |&&i: &&usize| patches[i].irradiance.min_element() > 0.0;
        shaded.iter().filter(is_lit).count()
    };
    assert_eq!(lit(&first), 0);
    assert!(lit(&second) > 0);
    assert_eq!(lit(&last), shaded.len());
    assert!(first.iter().any(|p| p.irradiance.x > 0.0));
}

/// Lengths are rounded to f32, so areas agree to some 1e-7.
#[test]
fn built_in_cornell_box_has_the_published_area_and_power() {
    let folder = folder();
    let published = workspace().join("genx/tests/data/cornell_coarse.obj");
    run(&folder, "genx", &["a.rad", "cornell", "--max-area", "inf"]);
    run(
        &folder,
        "genx",
        &["b.rad", published.to_str().unwrap(), "--max-area", "inf"],
    );
    let fine = data("cornell.obj");
    run(
        &folder,
        "genx",
        &["c.rad", fine.to_str().unwrap(), "--max-area", "inf"],
    );
    let load = |name: &str| scene::file::load(&folder.path().join(name)).unwrap().0;
    let built_in = load("a.rad");
    for name in ["b.rad", "c.rad"] {
        let other = load(name);
        assert!(
            (built_in.area() / other.area() - 1.0).abs() < 1e-6,
            "{name}"
        );
        let ratio = built_in.emitted_power() / other.emitted_power();
        assert!((ratio - 1.0).abs().max_element() < 1e-6, "{name}: {ratio}");
    }
}
