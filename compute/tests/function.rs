//! The irradiance function: what is known of it in rooms whose light is known, and that it is the same however it is made.

mod common;

use common::{compute, folder, load, save, solve, stderr, stdout, two_rooms};
use compute::function::FunctionEnd;
use compute::gather::Gathering;
use compute::receivers::Sensor;
use compute::settings::{BackendChoice, Points, Quality, SolveSettings, Target, Wanted};
use compute::solve::{Solved, StoppedBy};
use compute::{FormFactors, Solve};
use glam::Vec3;
use scene::function::IrradianceFunction;
use scene::{Scene, Surface};
use serde_json::Value;
use test_scenes::{colourful_room, furnace};

/// With hemicubes of 32 pixels at centroids.
fn settings(power: f64) -> SolveSettings {
    let mut settings = SolveSettings::default();
    settings.drawing.backend = BackendChoice::Cpu;
    settings.solution.form_factors.resolution = 32;
    settings.solution.form_factors.points = Points::CENTROID;
    settings.target = Some(Target {
        most_vertices: 1 << 16,
        ..Target::of(Some(power), None)
    });
    settings
}

fn solved(scene: &Scene, settings: SolveSettings) -> Solved {
    Solve::new(scene).settings(settings).run().unwrap()
}

fn function(solved: &Solved) -> &IrradianceFunction {
    solved.solution().function.as_ref().unwrap()
}

/// In a furnace H = E / (1 - rho) everywhere: rows sum to 1, so vertices gather it but for the residual, and neither the mesh
/// nor pixels nor the size of sources bring anything. Nothing is refined: 512 leaves or a few more have half as many vertices.
#[test]
fn a_furnace_is_one_value_and_needs_no_more_vertices() {
    let scene = furnace(0.5, 1.0, 0.01);
    let solved = solved(&scene, settings(0.001));
    for value in function(&solved).irradiance() {
        assert!((value.x - 2.0).abs() < 1e-4, "{value}");
    }
    for direct in function(&solved).direct() {
        assert!((direct.x - 1.0).abs() < 1e-5, "{direct}");
    }
    let report = solved.function.unwrap();
    let error = report.error.unwrap();
    assert!(report.is_reached && error.total.power < 2e-4, "{report:?}");
    assert!((report.covered - 1.0).abs() < 1e-6);
    // Six walls' corners, whose vertices are their own, and no more than leaves.
    assert!(
        report.vertices < 700 && report.triangles < 1100,
        "{report:?}"
    );
}

/// Bits do not depend on threads, nor on whether rows are kept.
#[test]
fn threads_and_memory_change_nothing() {
    let scene = colourful_room(0.1);
    let on = |threads: usize, memory_bytes: u64| {
        let mut settings = settings(0.05);
        settings.drawing.memory_bytes = memory_bytes;
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.unwrap()
            .install(|| function(&solved(&scene, settings)).clone())
    };
    let expected = on(1, 1 << 30);
    assert_eq!(on(3, 1 << 30), expected);
    assert_eq!(on(2, 0), expected);
}

/// What is asked for is reached by more vertices, and a limit of them is kept to within what the mesh needs to conform.
#[test]
fn smaller_errors_take_more_vertices() {
    let scene = colourful_room(0.05);
    let mut vertices = 0;
    for power in [0.05, 0.02, 0.005] {
        let report = solved(&scene, settings(power)).function.unwrap();
        assert!(report.is_reached, "{report:?}");
        assert!(report.error.unwrap().total.power <= power);
        assert!(report.vertices > vertices, "{report:?}");
        vertices = report.vertices;
    }
    let mut limited = settings(1e-6);
    limited.target.as_mut().unwrap().most_vertices = vertices;
    let report = solved(&scene, limited).function.unwrap();
    assert!(!report.is_reached);
    assert!(report.vertices < vertices + 100, "{report:?}");
}

/// The floor is one wall, but on either side of what stands on it vertices are apart: the dark side is dark up to the foot.
#[test]
fn light_does_not_pass_below_a_wall_by_interpolation() {
    let scene = two_rooms();
    let solved = solved(&scene, settings(0.02));
    let function = function(&solved);
    let vertices = function.mesh().vertices().iter().zip(function.irradiance());
    let lit = vertices.clone().filter(|(p, _)| p.x < 1.9 && p.z == 0.0);
    let mean = lit.clone().map(|(_, h)| h.x).sum::<f32>() / lit.count() as f32;
    assert!(mean > 0.5, "{mean}");
    // Each leaf lies on one side, and has vertices of its own there.
    for surface in (0..scene.surfaces().len() as u32).map(scene::SurfaceId) {
        for (corners, _) in function.mesh().leaves(surface) {
            let corners = corners.map(|v| v as usize);
            let is_dark = corners
                .iter()
                .all(|&v| function.mesh().vertices()[v].x >= 2.0)
                && corners
                    .iter()
                    .any(|&v| function.mesh().vertices()[v].x > 2.0);
            let most = corners
                .map(|v| function.irradiance()[v].x)
                .into_iter()
                .fold(0.0, f32::max);
            // A hemicube beside the wall may look through the crack of a rounding.
            assert!(!is_dark || most < 2e-3 * mean, "{most}");
        }
    }
}

/// A function belongs to the irradiances that it was gathered from: it stays while these do, and goes with them. They are what the
/// function says that patches receive, so that going on without it leads to where patches alone lead, to within the tolerance.
#[test]
fn a_function_stays_with_its_solution() {
    let folder = folder();
    save(folder.path(), "in.rad", &colourful_room(0.1));
    let output = solve(folder.path(), &["in.rad", "a.rad", "--target-error", "5%"]);
    assert!(stdout(&output).contains("\nerror          "), "{output:?}");
    let with = load(folder.path(), "a.rad");
    assert!(with.function.is_some());
    // Nothing to do: the same is written again.
    let common = ["32", "--points", "centroid"];
    solve(folder.path(), &[&["a.rad", "b.rad"], &common[..]].concat());
    assert_eq!(load(folder.path(), "b.rad"), with);
    // Another iteration, and another one from there.
    let more = ["--tolerance", "1e-7"];
    solve(
        folder.path(),
        &[&["a.rad", "b.rad"], &common[..], &more].concat(),
    );
    solve(
        folder.path(),
        &[&["in.rad", "c.rad"], &common[..], &more].concat(),
    );
    let (on, whole) = (load(folder.path(), "b.rad"), load(folder.path(), "c.rad"));
    assert_eq!(on.function, None);
    for (on, whole) in on.irradiance.iter().zip(&whole.irradiance) {
        // Half of the light of this room is reflected at most, so that what is left is at most what changed last.
        assert!(
            on.distance(*whole) <= 1e-5 * whole.max_element(),
            "{on} {whole}"
        );
    }
}

#[test]
fn what_cannot_be_reached_is_said_and_what_is_no_error_refused() {
    let folder = folder();
    save(folder.path(), "in.rad", &colourful_room(0.5));
    let arguments = [
        "in.rad",
        "a.rad",
        "8",
        "--target-error",
        "0.01%",
        "--report",
        "r.json",
    ];
    let output = solve(folder.path(), &arguments);
    assert!(
        stdout(&output).contains("more than was asked for"),
        "{output:?}"
    );
    let strict = compute(folder.path(), &[&arguments[..], &["--strict"]].concat());
    assert_eq!(strict.status.code(), Some(1));
    assert!(stderr(&strict).contains("its error is "), "{strict:?}");
    let report: Value =
        serde_json::from_slice(&std::fs::read(folder.path().join("r.json")).unwrap()).unwrap();
    let function = &report["function"];
    assert_eq!(function["is_reached"], false);
    for cause in ["total", "mesh", "sources", "pixels", "iterations"] {
        assert!(function["error"][cause]["power"].is_f64(), "{function}");
    }
    for wrong in ["2", "0%", "2%,3%", "5%lux"] {
        let output = compute(folder.path(), &["in.rad", "b.rad", "--target-error", wrong]);
        assert_eq!(output.status.code(), Some(2), "{output:?}");
        assert!(
            stderr(&output).contains("is no error such as 2%"),
            "{output:?}"
        );
    }
}

/// The time is over before the mesh has grown: what there is is a function all the same.
#[test]
fn a_function_is_whole_when_time_is_over() {
    let scene = colourful_room(0.1);
    let start = solved(
        &scene,
        SolveSettings {
            target: None,
            ..settings(1.0)
        },
    )
    .into_solution();
    let mut hurried = settings(1e-6);
    hurried.time_limit = Some(std::time::Duration::ZERO);
    // Its iterations are done.
    let done = start.provenance.iterations;
    let hurried = Solve::new(&scene)
        .settings(hurried)
        .start(Some(start))
        .iterations(done)
        .run()
        .unwrap();
    assert_ne!(hurried.stopped_by, StoppedBy::TimeLimit);
    let report = hurried.function.unwrap();
    assert!(!report.is_reached && report.error.is_some());
}

/// A scene of facets alone, of which none is large enough for vertices, has one value a patch. What that misses is stated as
/// for walls: not under what sensors find, one somewhere in each facet, by more than half, nor over it three times.
#[test]
fn facets_have_what_their_patches_have_and_a_stated_error() {
    let scene = test_scenes::stone(&test_scenes::bumpy_sphere(26), f64::INFINITY);
    let settings = settings(0.02);
    let solved = solved(&scene, settings);
    let report = solved.function.unwrap();
    assert_eq!(report.vertices, 0);
    let solution = solved.solution();
    assert_eq!(solution.mean_irradiance(&scene), solution.irradiance);

    let sensor = |(k, surface): (usize, &Surface)| {
        let [a, b, c] = surface.corners.map(Vec3::as_dvec3);
        // Steps by the golden ratio's powers are even in a square, of which half is turned onto the other.
        let [u, v] = [0.754_877_666, 0.569_840_291].map(|step| (k as f64 * step).fract());
        let [u, v] = if u + v > 1.0 {
            [1.0 - u, 1.0 - v]
        } else {
            [u, v]
        };
        Sensor {
            position: a + u * (b - a) + v * (c - a),
            normal: surface.normal(),
        }
    };
    let sensors: Vec<Sensor> = scene.surfaces().iter().enumerate().map(sensor).collect();
    let form_factors = FormFactors::new(&scene, settings.solution.form_factors, settings.drawing);
    let mut gathering = Gathering::new(&form_factors, solution, &sensors).unwrap();
    let (mut wrong, mut right, mut surfaces) = (0.0, 0.0, scene.surfaces().iter().enumerate());
    loop {
        let received = gathering.step().unwrap();
        if received.is_empty() {
            break;
        }
        for (received, (k, surface)) in received.iter().zip(&mut surfaces) {
            let found = f64::from(received.irradiance.x);
            wrong += surface.area() * (f64::from(solution.irradiance[k].x) - found).powi(2);
            right += surface.area() * found.powi(2);
        }
    }
    let (stated, found) = (report.error.unwrap().total.power, f64::sqrt(wrong / right));
    assert!(
        found < 1.5 * stated && stated < 3.0 * found,
        "{stated}, {found}"
    );
}

/// What is estimated patch by patch makes the total: what is between two vertices' values does not show in patches' means, so that
/// these are a little less bright in squares.
#[test]
fn errors_of_patches_make_that_of_all() {
    let scene = colourful_room(0.05);
    let solved = solved(&scene, settings(0.03));
    let stated = solved.function.unwrap().error.unwrap().total.power;
    let solution = solved.solution();
    let reflected = scene
        .patch_reflectances()
        .into_iter()
        .zip(solution.mean_irradiance(&scene));
    let (mut wrong, mut all) = (0.0, 0.0);
    for (patch, (rho, h)) in (0..).map(scene::PatchId).zip(reflected) {
        let area = scene.patch(patch).area;
        let error = f64::from(solution.error().unwrap()[patch.index()]);
        wrong += 3.0 * area * error.powi(2);
        all += area * (rho * h).as_dvec3().length_squared();
    }
    let of_patches = f64::sqrt(wrong / all);
    assert!(
        of_patches > 0.999 * stated && of_patches < 1.1 * stated,
        "{of_patches}, {stated}"
    );
}

/// With N iterations vertices gather what has been reflected less than N times: in a furnace 1 + rho + ... + rho^(N-1) times what
/// walls emit. The result of N has had them, so that asking for N again changes nothing, and for one more adds one; among patches and
/// among coarser sources.
#[test]
fn iterations_are_bounces() {
    for area in [0.05, 0.002] {
        let folder = folder();
        save(folder.path(), "in.rad", &furnace(0.5, 1.0, area));
        save(folder.path(), "on.rad", &furnace(0.5, 1.0, area));
        let mut expected = 0.0;
        for n in 1..=4 {
            expected = 1.0 + 0.5 * expected;
            let iterations = n.to_string();
            let common = ["--quality", "draft", "--iterations", &iterations];
            for (from, to) in [
                ("in.rad", "a.rad"),
                ("a.rad", "b.rad"),
                ("on.rad", "on.rad"),
            ] {
                solve(folder.path(), &[&[from, to], &common[..]].concat());
                let solution = load(folder.path(), to);
                assert_eq!(solution.provenance.iterations, n);
                for value in solution.function.as_ref().unwrap().irradiance() {
                    assert!(
                        (f64::from(value.x) - expected).abs() < 1e-4,
                        "{from} {n}: {value}"
                    );
                }
            }
        }
    }
}

/// Light is what it is whatever the patches, where they are finer than sources: the same bits.
#[test]
fn finer_patches_change_no_vertex() {
    let functions = [0.01, 0.002].map(|area| {
        let scene = colourful_room(area);
        let solved = solved(&scene, settings(0.05));
        assert!(solved.sources.unwrap().count < scene.patch_count() / 2);
        function(&solved).clone()
    });
    let [coarse, fine] = &functions;
    assert_eq!(coarse.mesh(), fine.mesh());
    assert_eq!(coarse.irradiance(), fine.irradiance());
}

/// Without options the light is gathered to the standard quality; where form factors are what is asked for, or all there is,
/// they are those of one value a patch.
#[test]
fn the_default_is_standard_where_there_is_light() {
    let folder = folder();
    save(folder.path(), "lit.rad", &colourful_room(0.5));
    save(folder.path(), "dark.rad", &furnace(0.5, 0.0, 0.5));
    // Not through the helper, which asks for patches.
    let run = |arguments: &str| {
        let status = std::process::Command::new(env!("CARGO_BIN_EXE_compute"))
            .args(arguments.split(' ').chain(["--backend", "cpu"]))
            .current_dir(folder.path())
            .output()
            .unwrap();
        assert!(status.status.success(), "{arguments}: {status:?}");
    };
    for (arguments, quality) in [
        ("lit.rad", "standard"),
        ("lit.rad --iterations 0", "mesh"),
        ("lit.rad --view-factors v.csv", "mesh"),
        ("dark.rad", "mesh"),
    ] {
        let (input, options) = arguments.split_once(' ').unwrap_or((arguments, ""));
        run(format!("{input} a.rad {options}").trim_end());
        run(format!("{input} b.rad --quality {quality} {options}").trim_end());
        let [a, b] = ["a.rad", "b.rad"].map(|name| load(folder.path(), name));
        assert_eq!(a, b, "{arguments}");
        assert_eq!(a.function.is_some(), quality == "standard", "{arguments}");
    }
}

/// What a run would take is told, and nothing is written.
#[test]
fn a_dry_run_tells_and_writes_nothing() {
    let folder = folder();
    save(folder.path(), "in.rad", &colourful_room(0.001));
    for (options, more) in [
        ("--quality mesh", "\nmemory "),
        ("--quality mesh --source-area 0.5", "at all patches"),
        ("--quality standard", "at vertices"),
    ] {
        let arguments = ["in.rad", "out.rad", "--dry-run"].into_iter();
        let arguments: Vec<&str> = arguments.chain(options.split(' ')).collect();
        let output = solve(folder.path(), &arguments);
        let told = stdout(&output);
        let words = [
            "scene  ",
            "back end  ",
            "rows  ",
            "memory  ",
            "disk  ",
            more,
        ];
        assert!(words.iter().all(|word| told.contains(word)), "{told}");
        assert!(!folder.path().join("out.rad").exists());
    }
}

/// A quality is what its options are, and options that are given count.
#[test]
fn qualities_are_names_for_options() {
    let folder = folder();
    save(folder.path(), "in.rad", &colourful_room(0.5));
    let thesis = "16 --maps thesis --points centroid --seed aligned --lamps off --closed-forms off --iterations 7 --tolerance 0";
    for (quality, options) in [
        ("16 --quality thesis", thesis),
        (
            "16 --quality thesis --iterations 3",
            &thesis.replace('7', "3")[..],
        ),
        (
            "--quality draft",
            "32 --points centroid --target-error 5%,10%visible",
        ),
        (
            "16 --quality draft --points 3",
            "16 --points 3 --target-error 10%visible,5%",
        ),
        ("24 --quality mesh", "24"),
    ] {
        let made = |arguments: &str, out: &str| {
            let arguments: Vec<&str> = arguments.split(' ').collect();
            solve(folder.path(), &[&["in.rad", out], &arguments[..]].concat());
            load(folder.path(), out)
        };
        assert_eq!(made(quality, "a.rad"), made(options, "b.rad"), "{quality}");
    }
    let both = [
        "in.rad",
        "c.rad",
        "--quality",
        "high",
        "--target-error",
        "1%",
    ];
    assert_eq!(compute(folder.path(), &both).status.code(), Some(2));
}

/// Means of patches: points that are given stay, else more gather where the error asks for it, by any number of threads the same ones.
#[test]
fn means_are_taken_at_as_many_points_as_their_error_asks_for() {
    let folder = folder();
    let scene = colourful_room(0.1);
    save(folder.path(), "in.rad", &scene);
    let points_and_end = |out: &str, arguments: &[&str]| {
        let all = ["in.rad", out, "--quality", "mesh", "--report", "r.json"];
        solve(folder.path(), &[&all, arguments].concat());
        let report = std::fs::read(folder.path().join("r.json")).unwrap();
        let report: Value = serde_json::from_slice(&report).unwrap();
        let function = &report["function"];
        let points = function["points"].as_u64().unwrap();
        let power = function["error"]["total"]["power"].as_f64().unwrap();
        (
            points,
            power,
            function["stopped_by"].as_str().unwrap().to_owned(),
        )
    };
    let patches = u64::from(scene.patch_count());
    let fixed = ["--target-error", "0.2%", "--points", "centroid"];
    let (points, error, end) = points_and_end("a.rad", &fixed);
    assert_eq!((points, end.as_str()), (patches, "other-causes"));
    assert!(error > 0.002, "{error}");
    let free = ["--target-error", "0.2%", "--threads", "1"];
    let (points, finer, _) = points_and_end("b.rad", &free);
    assert!(points > patches && finer < error, "{points} {finer}");
    points_and_end("c.rad", &["--target-error", "0.2%", "--threads", "3"]);
    let [one, three] = ["b.rad", "c.rad"].map(|name| load(folder.path(), name).irradiance);
    assert_eq!(one, three);
}

/// A patch has at most 48 points, and all of them are told; an error that is as small as was asked for is no other's fault.
#[test]
fn what_is_told_of_means_is_what_was_done() {
    let scene = colourful_room(0.5);
    let patches = u64::from(scene.patch_count());
    let solved = |error: f64, of| {
        let target = Target::of(Some(error), None);
        let mut settings = Quality::settings_for_means(target);
        settings.target = Some(Target { of, ..target });
        settings.drawing.backend = BackendChoice::Cpu;
        solved(&scene, settings).function.unwrap()
    };
    let unreachable = solved(1e-6, Wanted::Means);
    assert!(!unreachable.is_reached, "{unreachable:?}");
    let points = unreachable.points.unwrap();
    assert!(
        points > 12 * patches && points <= 48 * patches,
        "{points} of {patches}"
    );
    let error = solved(1e-6, Wanted::MeansAtPoints)
        .error
        .unwrap()
        .total
        .power;
    // A little more is reached, though a run that may take more points would go on.
    let reached = solved(1.02 * error, Wanted::MeansAtPoints);
    assert!(reached.is_reached, "{reached:?}");
    assert_eq!(reached.stopped_by, FunctionEnd::Error);
}
