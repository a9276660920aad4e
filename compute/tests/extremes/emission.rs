//! Emissions from nothing to next to what f32 holds.

use glam::Vec3;
use scene::{Material, Scene, Solution};
use serde_json::Value;

use crate::common::methods::{
    METHODS, Method, ROUNDING, ROUNDINGS_PER_RADIOSITY, converge, iterate, largest_reflectance,
    radiosity, relative_difference, rows, solver,
};
use crate::common::{self, bits, folder, save, solve};

/// The colourful room with its emissions times a factor.
fn room(factor: f32) -> Scene {
    let scene = common::colourful_room(0.8);
    let materials = scene
        .materials()
        .iter()
        .map(|m| Material {
            emission: factor * m.emission,
            ..m.clone()
        })
        .collect();
    common::scene(materials, scene.surfaces().to_vec(), 0.8)
}

fn solved(method: Method, scene: &Scene, iterations: u64) -> Solution {
    let mut rows = rows(scene, u64::MAX);
    let mut solver = solver(method, scene, Solution::dark(scene));
    iterate(solver.as_mut(), &mut rows, iterations);
    solver.snapshot()
}

/// The equation is linear, and a power of two changes no digit: 2^100 = 1.3e30 and 2^-97 = 6e-30, from
/// where the smallest irradiances, a millionth of it, are far above 2^-126, below which f32 loses
/// digits.
#[test]
fn emission_times_a_power_of_two_is_radiosity_times_it_to_the_bit() {
    for method in METHODS {
        let one = solved(method, &room(1.0), 12);
        for exponent in [100, -97] {
            let factor = 2.0_f32.powi(exponent);
            let scaled = solved(method, &room(factor), 12);
            let expected: Vec<Vec3> = one.irradiance.iter().map(|&h| factor * h).collect();
            assert_eq!(
                bits(&scaled.irradiance),
                bits(&expected),
                "{method:?} 2^{exponent}"
            );
            assert_eq!(
                scaled.provenance.residuals, one.provenance.residuals,
                "{method:?} 2^{exponent}"
            );
        }
    }
}

/// 1e30 and 1e-30 round each emission once, and then each radiosity in other places: three roundings an
/// iteration, times 1 / (1 - rho), on either side. Shooting rounds what is unshot twice a shot instead,
/// as `error_bound` of the common methods has it: with residuals summing to at most their number.
#[test]
fn emission_times_any_factor_is_radiosity_times_it() {
    for method in METHODS {
        let iterations = 50;
        let one = room(1.0);
        let reference = radiosity(&one, &solved(method, &one, iterations));
        for factor in [1e30_f32, 1e-30] {
            let scene = room(factor);
            let found: Vec<_> = radiosity(&scene, &solved(method, &scene, iterations))
                .into_iter()
                .map(|b| b / f64::from(factor))
                .collect();
            let error = relative_difference(method, &scene, &found, &reference);
            let roundings = match method {
                Method::Shooting => 2.0 * iterations as f64 + ROUNDINGS_PER_RADIOSITY,
                _ => ROUNDINGS_PER_RADIOSITY,
            };
            let bound = (2.0 * roundings + 1.0) * ROUNDING / (1.0 - largest_reflectance(&scene));
            assert!(
                error <= bound,
                "{method:?} {factor:e}: {error:e} > {bound:e}"
            );
        }
    }
}

/// Two lamps sixty orders of magnitude apart: the weak one is lost in the rounding of the strong one's
/// light, and nothing else is.
#[test]
fn a_lamp_beside_one_1e60_times_as_bright_changes_nothing() {
    let lit = |weak: f32| {
        let materials = vec![common::material(0.5, weak), common::material(0.5, 1e30)];
        common::scene(materials, common::furnished_room_surfaces(), 0.8)
    };
    for method in [Method::Jacobi, Method::GaussSeidel] {
        let (with, without) = (lit(1e-30), lit(0.0));
        assert_eq!(
            bits(&solved(method, &with, 10).irradiance),
            bits(&solved(method, &without, 10).irradiance),
            "{method:?}"
        );
    }
}

/// All numbers of a report, by their paths; JSON writes what is not finite as null.
fn assert_finite(report: &Value, path: &str, null_is_right: &dyn Fn(&str) -> bool) {
    match report {
        Value::Null => assert!(null_is_right(path), "{path} is null"),
        Value::Array(values) => {
            for (k, value) in values.iter().enumerate() {
                assert_finite(value, &format!("{path}/{k}"), null_is_right);
            }
        }
        Value::Object(fields) => {
            for (name, value) in fields {
                assert_finite(value, &format!("{path}/{name}"), null_is_right);
            }
        }
        _ => {}
    }
}

/// The whole program on emissions of nothing, 1e-30 and 1e30: it converges, and the report holds nothing
/// that is not a number. Without emission nothing can be said of the power balance.
#[test]
fn the_program_solves_the_darkest_and_the_brightest() {
    let folder = folder();
    for (factor, name) in [(0.0, "dark"), (1e-31, "dim"), (1e29, "bright")] {
        for (solver, more) in [
            ("jacobi", &[][..]),
            ("gauss-seidel", &["--target-error", "10%"]),
            ("shooting", &[]),
        ] {
            save(folder.path(), "in.rad", &room(factor));
            let arguments = ["in.rad", "out.rad", "16", "--solver", solver];
            let tail = ["--tolerance", "1e-3", "--report", "report.json"];
            solve(folder.path(), &[&arguments[..], &tail, more].concat());
            let text = std::fs::read(folder.path().join("report.json")).unwrap();
            let report: Value = serde_json::from_slice(&text).unwrap();
            assert_eq!(report["stopped_by"], "tolerance", "{name} {solver}");
            assert_finite(&report, "", &|path| {
                let unset = [
                    "iterations",
                    "time_limit_seconds",
                    "opening",
                    "meant_open_share",
                    "back_faces",
                    "/backend/trial",
                    // Told where patches gather from sources.
                    "/sources/estimated_error",
                    "/sources/gathered_share",
                ]
                .iter()
                .any(|unset| path.ends_with(unset));
                let shots = solver == "shooting"
                    && (path.starts_with("/certificate") || path.starts_with("/energy"));
                let nothing =
                    factor == 0.0 && (path.ends_with("imbalance") || path == "/convergence");
                // Where nothing emits no row is drawn.
                let undrawn = factor == 0.0
                    && (["/closure", "/back_face_share", "/rows/bytes_per_entry"].contains(&path)
                        || path.starts_with("/certificate"));
                // Nor has it a function where none is asked for or nothing emits.
                let no_function = (more.is_empty() || factor == 0.0) && path == "/function";
                undrawn || unset || shots || nothing || no_function
            });
        }
    }
}

/// Without light the first iteration is the last: nothing moves, and nothing is not a number.
#[test]
fn nothing_emitted_is_nothing_after_one_iteration() {
    let scene = room(0.0);
    for method in METHODS {
        let mut rows = rows(&scene, u64::MAX);
        let mut solver = solver(method, &scene, Solution::dark(&scene));
        assert_eq!(converge(solver.as_mut(), &mut rows, 0.0), 1, "{method:?}");
        let dark = Solution::dark(&scene).irradiance;
        assert_eq!(bits(&solver.snapshot().irradiance), bits(&dark));
    }
}
