//! Laws of coarse sources and fine receivers.

mod common;

use common::{bits, folder, load, save, solve, solve_in_parts, stdout};
use compute::FormFactors;
use compute::certificate::CLOSURE_TOLERANCE;
use compute::form_factors::Needed;
use compute::problem::Problem;
use compute::row_cache::RowCache;
use compute::settings::{BackendChoice, Drawing, FormFactorSettings, MOST_ON_ONE_LEVEL};
use compute::solver::{Gather, Solver, Update};
use compute::sources::Sources;
use compute::two_levels::{self, GatherOnce, OnSources};
use scene::{Level, Rgb, Scene, Solution};

const RESOLUTION: u32 = 64;

/// Rows of `scene`'s patches among those of `sources`.
fn rows<'a>(scene: &'a Scene, sources: &'a Scene) -> RowCache<'a> {
    let drawing = Drawing {
        backend: BackendChoice::Cpu,
        memory_bytes: u64::MAX,
        ..Drawing::default()
    };
    let form_factors = FormFactors::new(scene, FormFactorSettings::new(RESOLUTION), drawing);
    let sources = Sources::coarse(scene, sources);
    form_factors.rows_to(sources, Needed::All).unwrap()
}

fn converged(solver: &mut dyn Solver, rows: &mut RowCache) {
    while solver.residual().is_none_or(|residual| residual > 1e-6) {
        solver.step(rows).unwrap();
    }
}

fn solver(scene: &Scene, start: Solution) -> Box<dyn Solver> {
    Box::new(Gather::new(Problem::new(scene), Update::AtOnce, start))
}

/// The scene's solution from sources of at most `area`, and the estimate of their error against the sources of
/// `coarser`, a solution of the scene.
fn two_levels(scene: &Scene, area: f64, coarser: Option<&Solution>) -> (Solution, Solution, f64) {
    let sources = two_levels::sources(scene, area);
    let mut among = rows(&sources, &sources);
    let make = |start| solver(&sources, start);
    let mut on_sources = OnSources::new(
        Sources::coarse(scene, &sources),
        area,
        Solution::dark(scene),
        make,
    );
    converged(&mut on_sources, &mut among);
    let solved = on_sources.snapshot();
    let estimate = coarser.map_or(f64::INFINITY, |coarser| {
        let coarser = on_sources.sources().restricted(&coarser.irradiance);
        let irradiance = on_sources.among_sources().irradiance;
        two_levels::estimated_error(&mut among, &irradiance, &coarser)
            .unwrap()
            .unwrap()
    });
    let mut rows = rows(scene, &sources);
    let mut gather = GatherOnce::new(rows.sources(), area, solved.clone());
    while !gather.step(&mut rows).unwrap().ends_iteration {}
    (gather.snapshot(), solved, estimate)
}

/// |a - b| / |b|, by area.
fn difference(scene: &Scene, a: &[Rgb], b: &[Rgb]) -> f64 {
    let (mut change, mut norm) = (0.0, 0.0);
    for ((area, a), b) in scene.patch_areas().iter().zip(a).zip(b) {
        change += area * (*a - *b).as_dvec3().length_squared();
        norm += area * b.as_dvec3().length_squared();
    }
    (change / norm).sqrt()
}

/// The estimate is half of a change, the error of order p in the sources' size 1 / (2^p - 1) of it: it may be 1.5 times
/// the estimate for p = 1.22. Found are 0.4 to 1.0 times.
const ESTIMATE_TOLERANCE: f64 = 1.5;

#[test]
fn sources_whose_error_is_estimated_to_be_small_give_the_one_level_solution() {
    for model in [genx::Model::Cornell, genx::Model::Cube] {
        let mut settings = genx::Settings::new(model.clone());
        let max_area = if model == genx::Model::Cornell {
            0.0005
        } else {
            0.25
        };
        settings.max_area = Some(max_area);
        let scene = genx::make(&settings).unwrap().scene;
        let mut one_level = solver(&scene, Solution::dark(&scene));
        converged(one_level.as_mut(), &mut rows(&scene, &scene));
        let one_level = one_level.snapshot();
        let mut coarser: Option<Solution> = None;
        let mut is_good = false;
        let mut before = 0;
        for area in [128.0, 32.0, 8.0, 2.0].map(|factor| factor * max_area) {
            let count = two_levels::sources(&scene, area).patch_count();
            if !two_levels::is_refinement(count, before) {
                continue;
            }
            before = count;
            let (solution, on_sources, estimate) = two_levels(&scene, area, coarser.as_ref());
            let error = difference(&scene, &solution.irradiance, &one_level.irradiance);
            println!("{model:?}, {count} sources: error {error:.5}, estimated {estimate:.5}");
            assert!(error <= ESTIMATE_TOLERANCE * estimate, "{model:?}");
            is_good |= estimate <= two_levels::MOST_ERROR;
            if estimate <= two_levels::MOST_ERROR {
                assert!(error <= two_levels::MOST_ERROR);
            }
            let radiosity = difference(
                &scene,
                &solution.radiosity(&scene),
                &one_level.radiosity(&scene),
            );
            assert!(radiosity < error);
            coarser = Some(on_sources);
        }
        assert!(is_good, "{model:?}: no sources were good enough");
    }
}

/// All patches of a furnace have the same radiosity, however coarse its sources are.
#[test]
fn in_a_furnace_any_sources_are_exact() {
    let (reflectance, emission) = (0.6, 2.0);
    let scene = common::furnace(reflectance, emission, 0.01);
    for area in [0.02, 0.2, f64::INFINITY] {
        let (solution, ..) = two_levels(&scene, area, None);
        let exact = emission / (1.0 - reflectance);
        for radiosity in solution.radiosity(&scene) {
            // The residual 1e-6 leaves 1e-6 rho / (1 - rho); f32 adds some 1e-7.
            assert!((radiosity.x / exact - 1.0).abs() < 2e-6, "{radiosity}");
        }
    }
}

/// Stopped among sources, and while patches gather.
#[test]
fn stopped_by_time_and_continued_is_as_never_stopped() {
    let folder = folder();
    save(folder.path(), "in.rad", &common::colourful_room(0.1));
    for (solver, memory) in [
        ("jacobi", "1GiB"),
        ("gauss-seidel", "0B"),
        ("shooting", "1GiB"),
    ] {
        let settings = [
            &["64", "--source-area", "0.4", "--memory", memory][..],
            &["--solver", solver, "--tolerance", "1e-2"],
        ]
        .concat();
        solve(
            folder.path(),
            &[&["in.rad", "whole.rad"], &settings[..]].concat(),
        );
        let whole = load(folder.path(), "whole.rad");
        assert_eq!(whole.provenance.level, Level::Patches);
        let stopped = solve_in_parts(folder.path(), &settings, 6.0);
        let levels = stopped.iter().map(|solution| &solution.provenance.level);
        let (mut among_sources, mut gathering) = (0, 0);
        for level in levels {
            if let Some(area) = level.source_area() {
                assert_eq!(area.to_bits(), 0.4_f64.to_bits());
            }
            among_sources += u32::from(matches!(level, Level::Sources { .. }));
            gathering += u32::from(matches!(level, Level::Gathering { .. }));
        }
        println!("{solver}: {among_sources} runs stopped among sources, {gathering} in gathering");
        assert!(among_sources > 0 && gathering > 0, "{solver}");
        let parts = load(folder.path(), "part.rad");
        assert!(
            bits(&parts.irradiance) == bits(&whole.irradiance),
            "{solver}"
        );
        assert_eq!(parts.provenance, whole.provenance);
    }
}

#[test]
fn a_result_of_two_levels_is_not_solved_again() {
    let folder = folder();
    save(folder.path(), "in.rad", &common::colourful_room(0.1));
    let arguments = ["out.rad", "out.rad", "32", "--source-area", "0.4"];
    solve(folder.path(), &[&["in.rad"], &arguments[1..]].concat());
    let first = load(folder.path(), "out.rad");
    let output = solve(folder.path(), &arguments);
    assert!(!stdout(&output).contains("hemicubes"), "{output:?}");
    assert!(load(folder.path(), "out.rad") == first);
    // A lower tolerance goes on from it.
    solve(
        folder.path(),
        &[&arguments[..], &["--tolerance", "1e-7"]].concat(),
    );
    let second = load(folder.path(), "out.rad").provenance;
    assert!(second.iterations > first.provenance.iterations);
    assert_eq!(second.level, Level::Patches);
}

/// More patches than are solved on one level, at few pixels. Of a solution among other sources only the irradiances
/// hold: a solver that took more from it would copy it, and find next to no error.
#[test]
fn the_largest_scenes_choose_their_sources() {
    let folder = folder();
    let scene = common::colourful_room(0.001);
    let patches = scene.patch_count();
    assert!(patches > MOST_ON_ONE_LEVEL);
    save(folder.path(), "in.rad", &scene);
    let mut errors = Vec::new();
    for solver in ["jacobi", "gauss-seidel", "shooting"] {
        let settings = ["16", "--points", "centroid", "--lamps", "off"];
        let files = ["in.rad", "out.rad", "--report", "r.json"];
        let limits = ["--solver", solver, "--tolerance", "1e-3"];
        solve(
            folder.path(),
            &[&files[..2], &settings, &files[2..], &limits].concat(),
        );
        let report = std::fs::read(folder.path().join("r.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        let sources = &report["sources"];
        println!("{solver}: {sources}, {} iterations", report["iterations"]);
        let count = sources["count"].as_u64().unwrap() as u32;
        assert!(count < patches / 2);
        errors.push(sources["estimated_error"].as_f64().unwrap());
        assert_eq!(sources["gathered_share"], 1.0);
        // Those of the sources that were tried before are counted too.
        assert!(report["hemicubes_drawn"].as_u64().unwrap() > u64::from(patches + count));
        assert_eq!(
            load(folder.path(), "out.rad").provenance.level,
            Level::Patches
        );
    }
    for error in &errors {
        assert!(*error <= two_levels::MOST_ERROR, "{errors:?}");
        assert!(*error >= 0.5 * errors[0], "{errors:?}");
    }
}

#[test]
fn form_factors_are_those_between_patches() {
    let folder = folder();
    save(folder.path(), "in.rad", &common::colourful_room(0.5));
    let files = ["one.csv", "two.csv"].map(|name| folder.path().join(name));
    for (area, file) in ["patches", "2"].into_iter().zip(&files) {
        let file = file.to_str().unwrap();
        let arguments = [
            "in.rad",
            "out.rad",
            "32",
            "--source-area",
            area,
            "--form-factors",
            file,
        ];
        solve(folder.path(), &arguments);
    }
    let [one, two] = files.map(|file| std::fs::read(file).unwrap());
    assert!(one == two && !one.is_empty());
}

#[test]
fn the_report_and_the_summary_tell_of_coarse_sources() {
    let folder = folder();
    let scene = common::colourful_room(0.5);
    save(folder.path(), "in.rad", &scene);
    let run = |area: &str| {
        let arguments = [
            "in.rad",
            "out.rad",
            "32",
            "--source-area",
            area,
            "--report",
            "r.json",
        ];
        let output = solve(folder.path(), &arguments);
        let report = std::fs::read(folder.path().join("r.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        (stdout(&output), report)
    };
    let (said, report) = run("inf");
    assert_eq!(report["sources"]["count"], scene.surfaces().len());
    assert_eq!(report["sources"]["gathered_share"], 1.0);
    assert_eq!(report["settings"]["source_area"], "inf");
    // No source is larger than all surfaces together.
    let told = format!(
        "{} of at most {:.3} m^2",
        scene.surfaces().len(),
        scene.area()
    );
    assert!(said.contains(&told), "{said}");
    // All patches and all sources have drawn, and rows sum to 1.
    assert!(report["closure"]["min"].as_f64().unwrap() > 1.0 - CLOSURE_TOLERANCE);
    for one_level in ["auto", "patches", "1e-9"] {
        let (said, report) = run(one_level);
        assert!(
            report["sources"].is_null() && !said.contains("sources"),
            "{said}"
        );
    }
}
