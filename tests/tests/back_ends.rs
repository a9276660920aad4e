//! Laws of every back end, by the three programs' command lines. Those that need a GPU are ignored without an adapter;
//! with `REQUIRE_GPU=1` they fail instead.

use std::sync::LazyLock;

use test_needs::{ExitCode, Need, laws, run as run_tests, test};
use tests::{PatchRow, folder, has_adapter, patches, reflected_error, run};

/// A law's name, and what holds a back end to it.
type Law = (&'static str, fn(&str));

fn main() -> ExitCode {
    let mut tests = laws![an_adapter => back_ends_agree_but_for_pixels_on_edges];
    let backends: [(&str, Need); 2] = [("cpu", nothing), ("gpu", an_adapter)];
    let laws: [Law; 2] = [
        (
            "furnace_radiosity_is_emission_over_one_minus_reflectance",
            furnace_radiosity_is_emission_over_one_minus_reflectance,
        ),
        (
            "shooting_fills_the_furnace_with_the_same_power",
            shooting_fills_the_furnace_with_the_same_power,
        ),
    ];
    for (backend, need) in backends {
        for (name, law) in laws {
            tests.push(test(format!("{backend}::{name}"), need, move || {
                law(backend);
            }));
        }
    }
    run_tests(tests)
}

#[allow(clippy::unnecessary_wraps)] // so that it is a need
fn nothing() -> Result<(), String> {
    Ok(())
}

fn an_adapter() -> Result<(), String> {
    static IS_THERE: LazyLock<bool> = LazyLock::new(has_adapter);
    test_needs::adapter(*IS_THERE)
}

/// Rows sum to exactly 1 on every back end, so B = E / (1 - rho) but for the residual r, which leaves at
/// most r rho / (1 - rho), and for three f32 roundings an iteration, which add up to three times
/// 2^-24 / (1 - rho).
fn furnace_radiosity_is_emission_over_one_minus_reflectance(backend: &str) {
    const RESIDUAL: f64 = 1e-6;
    for solver in ["jacobi", "gauss-seidel"] {
        for (reflectance, emission) in [("0", 2.5), ("0.5", 1.0), ("0.9", 100.0)] {
            let folder = folder();
            let power = emission.to_string();
            run(
                &folder,
                "genx",
                &["a.rad", "furnace", "0.05", reflectance, &power],
            );
            let settings = [
                "--backend",
                backend,
                "--solver",
                solver,
                "--tolerance",
                "1e-6",
            ];
            run(
                &folder,
                "compute",
                &[&["a.rad", "a.rad", "32"][..], &settings].concat(),
            );
            let rho = f64::from(reflectance.parse::<f32>().unwrap());
            let expected = emission / (1.0 - rho);
            let rounding = 3.0 / f64::from(1 << 24);
            // The residual is a mean over patches, of which none stands out where all are alike.
            let tolerance = (RESIDUAL * rho + rounding) / (1.0 - rho);
            for (i, patch) in patches(&folder, "a.rad").iter().enumerate() {
                for radiosity in patch.radiosity.to_array() {
                    let error = (radiosity / expected - 1.0).abs();
                    assert!(
                        error <= tolerance,
                        "{backend}, {solver}, {reflectance}, patch {i}: {error:e}"
                    );
                }
            }
        }
    }
}

/// Shooting distributes by reciprocity, whose errors even out: all power is there, patch by patch it
/// is not.
fn shooting_fills_the_furnace_with_the_same_power(backend: &str) {
    let folder = folder();
    run(&folder, "genx", &["a.rad", "furnace", "0.05", "0.5", "1"]);
    let settings = [
        "--backend",
        backend,
        "--solver",
        "shooting",
        "--tolerance",
        "1e-6",
    ];
    run(
        &folder,
        "compute",
        &[&["a.rad", "a.rad", "32"][..], &settings].concat(),
    );
    let patches = patches(&folder, "a.rad");
    let power: f64 = patches.iter().map(|p| p.area * p.radiosity.x).sum();
    // Six square metres at 2 W/m^2. Some thousand shots round three times each.
    assert!((power / 12.0 - 1.0).abs() < 1e-3, "{backend}: {power}");
}

/// By one hemicube a patch, without views of lamps, in which both back ends see the same. At 64 pixels the
/// lamp of the Cornell box has n = 46 on the floor's hemicubes (0.01365 m^2 over 0.5488^2 m^2 times 32^2), and a border of
/// 2 (a + b) / root(a b) root(n) = 27. Where the back ends round corners to 1/256 of a pixel, either way, a
/// pixel on the border changes sides with a chance of at most 1/128: the count's standard deviation is
/// root(27 / 128) = 0.46 pixels of 46.
const EDGE_PIXELS: f64 = 0.01;

fn back_ends_agree_but_for_pixels_on_edges() {
    let folder = folder();
    run(&folder, "genx", &["a.rad", "cornell", "--max-area", "0.01"]);
    let solve = |backend: &str, resolution: &str| {
        run(
            &folder,
            "compute",
            &[
                "a.rad",
                "b.rad",
                resolution,
                "--backend",
                backend,
                "--lamps",
                "off",
                "--quality",
                "mesh",
                "--points",
                "centroid",
            ],
        );
        patches(&folder, "b.rad")
    };
    let cpu = solve("cpu", "64");
    let error =
        |other: &[PatchRow]| reflected_error(&cpu, |i| other[i].irradiance, |i| cpu[i].irradiance);
    // What this can tell: half the resolution.
    let coarse = error(&solve("cpu", "32"));
    assert!(coarse > EDGE_PIXELS, "{coarse}");
    let difference = error(&solve("gpu", "64"));
    println!("cpu and gpu differ by {difference:.2e}, 64 and 32 pixels by {coarse:.2e}");
    assert!(difference <= EDGE_PIXELS, "{difference}");
}
