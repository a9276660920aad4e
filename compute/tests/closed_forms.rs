//! Convex enclosures: formulas instead of hemicubes, and the same answers.

mod common;

use std::path::Path;
use std::sync::Arc;

use common::methods::ROUNDING;
use common::{block, folder, furnace, furnished_room, load, material, quad, save, scene, solve};
use compute::convex::ConvexRows;
use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::polygon_form_factor::point_to_triangle;
use compute::receivers::ReceiverId;
use compute::rows::{RowBatch, RowSource, UNITS_PER_ONE};
use compute::settings::{FormFactorSettings, Maps, Points};
use glam::{EulerRot, Quat, Vec3};
use scene::{MaterialId, PatchId, Scene, Surface};
use serde_json::Value;

const ONE: f64 = UNITS_PER_ONE as f64;

fn settings(resolution: u32, points: Points) -> FormFactorSettings {
    FormFactorSettings {
        points,
        ..FormFactorSettings::new(resolution)
    }
}

fn closed_rows(scene: &Scene, settings: FormFactorSettings) -> Option<RowBatch> {
    let hemicubes = Arc::new(Hemicubes::new(scene, settings));
    let mut rows = ConvexRows::new(&hemicubes)?;
    Some(rows.draw_rows(0..scene.patch_count()).unwrap())
}

fn are_closed_forms(surfaces: Vec<Surface>) -> bool {
    let materials = vec![material(0.5, 1.0), material(0.3, 0.0)];
    let scene = scene(materials, surfaces, 0.5);
    closed_rows(&scene, settings(128, Points::CENTROID)).is_some()
}

/// Turned and moved, so that no plane's coordinates are round.
fn moved(mut surfaces: Vec<Surface>) -> Vec<Surface> {
    let turn = Quat::from_euler(EulerRot::XYZ, 0.3, 0.7, 1.1);
    for surface in &mut surfaces {
        let place = |p| turn * p + Vec3::new(7.0, -3.0, 5.0);
        surface.corners = surface.corners.map(place);
    }
    surfaces
}

fn room() -> Vec<Surface> {
    block(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.5), false, 0)
}

/// Every factor against Lambert's formula for each triangle on its own, clipped at the horizon, in the
/// hemicube's axes.
#[test]
fn rows_are_lamberts_formula_at_the_hemicubes_points() {
    let scene = scene(vec![material(0.5, 1.0)], moved(room()), 0.5);
    let points = Points::ThreePoint { bisections: 0 };
    let hemicubes = Hemicubes::new(&scene, settings(128, points));
    let rows = closed_rows(&scene, settings(128, points)).unwrap();
    let normal = |patch: u32| {
        scene
            .surface(scene.mesh().surface_of(PatchId(patch)))
            .normal()
    };
    for from in (0..scene.patch_count()).step_by(7) {
        let frames = hemicubes.receivers().frames(ReceiverId(from));
        let mut row = rows.row(from as usize).iter().peekable();
        for to in 0..scene.patch_count() {
            let entry = row.next_if(|entry| entry.source == to);
            if normal(from).dot(normal(to)) > 0.5 {
                assert!(entry.is_none(), "{from} and {to} are in one plane");
                continue;
            }
            let units = entry.map_or(0.0, |entry| f64::from(entry.units));
            let corners = scene.patch(PatchId(to)).corners.map(Vec3::as_dvec3);
            let sum: f64 = frames
                .iter()
                .map(|frame| point_to_triangle(corners.map(|p| frame.to_local(p))))
                .sum();
            let expected = sum / frames.len() as f64;
            // An entry is rounded to f32. What is below the horizon only by the rounding of corners, 2^-24 of 13 m,
            // from a distance of 0.1 m, is seen edge-on: by the square of that angle at most.
            let error = (units / ONE - expected).abs();
            let most = ROUNDING * expected + (13.0 * ROUNDING / 0.1_f64).powi(2);
            assert!(error <= most, "{from} {to}: {error:e} {expected:e}");
        }
        assert!(row.next().is_none());
    }
}

#[test]
fn rows_of_a_closed_room_sum_to_one() {
    for surfaces in [room(), moved(room())] {
        let scene = scene(vec![material(0.5, 1.0)], surfaces, 0.2);
        let rows = closed_rows(&scene, settings(128, Points::Auto)).unwrap();
        for k in 0..scene.patch_count() as usize {
            let sum: f64 = rows.row(k).iter().map(|e| f64::from(e.units)).sum();
            // Each entry is rounded to f32; walls whose corners are rounded to f32 share these corners,
            // so nothing leaks, and what is below a horizon by rounding sees it edge-on.
            assert!((sum / ONE - 1.0).abs() <= 2.0 * ROUNDING, "{k}: {sum}");
            assert!(f64::from(rows.unseen(k).open) <= 2.0 * ROUNDING * ONE);
            assert_eq!(rows.unseen(k).back_face, 0);
        }
    }
}

/// Howell, catalogue of radiation configuration factors, C-11, equal squares at a distance of their side:
/// 0.19982. The rule of three points is right for what is quadratic, and what is of third order cancels between the two
/// triangles of a square. Left are terms of fourth order, h^4 = 2^-12 for the legs that six bisections leave, over
/// 4! and more of a factor that changes by less than its half over the square: 2^-6 of that at most.
#[test]
fn parallel_squares_are_the_catalogues() {
    let square =
        |z: f32| [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(|[x, y]| Vec3::new(x, y, z));
    let mut above = square(1.0);
    above.reverse();
    let surfaces = [quad(square(0.0), 0), quad(above, 0)].concat();
    let scene = scene(vec![material(0.5, 1.0)], surfaces, 1.0);
    let points = Points::ThreePoint { bisections: 6 };
    let rows = closed_rows(&scene, settings(128, points)).unwrap();
    let x: f64 = 1.0;
    let root = (1.0 + x * x).sqrt();
    let expected = 2.0 / (std::f64::consts::PI * x * x)
        * (((1.0 + x * x).powi(2) / (1.0 + 2.0 * x * x)).sqrt().ln()
            + 2.0 * x * root * (x / root).atan()
            - 2.0 * x * x.atan());
    let sums: Vec<f64> = (0..4)
        .map(|k| rows.row(k).iter().map(|e| f64::from(e.units)).sum::<f64>() / ONE)
        .collect();
    let mean = sums.iter().sum::<f64>() / 4.0;
    assert!(
        (mean - expected).abs() < 0.25_f64.powi(9),
        "{mean} {expected}"
    );
    for (k, sum) in sums.iter().enumerate() {
        let open = f64::from(rows.unseen(k).open) / ONE;
        assert!(
            (sum + open - 1.0).abs() <= 2.0 * ROUNDING,
            "{k}: {sum} {open}"
        );
    }
}

/// What a patch sees of another one by pixels differs by what pixels get wrong at its edges, which falls with their
/// size: by more than their side, since such errors have either sign.
#[test]
fn hemicubes_come_nearer_with_smaller_pixels() {
    let scene = scene(vec![material(0.5, 1.0)], moved(room()), 0.5);
    let rms = |resolution| {
        let settings = settings(resolution, Points::CENTROID);
        let hemicubes = Arc::new(Hemicubes::new(&scene, settings));
        let count = scene.patch_count();
        let drawn = CpuRows::new(&hemicubes).draw_rows(0..count).unwrap();
        let closed = closed_rows(&scene, settings).unwrap();
        let mut squares = 0.0;
        for k in 0..count as usize {
            let mut difference = vec![0.0; count as usize];
            for entry in drawn.row(k) {
                difference[entry.source as usize] += f64::from(entry.units) / ONE;
            }
            for entry in closed.row(k) {
                difference[entry.source as usize] -= f64::from(entry.units) / ONE;
            }
            squares += difference.iter().map(|d| d * d).sum::<f64>();
        }
        (squares / f64::from(count).powi(2)).sqrt()
    };
    let (coarse, fine) = (rms(128), rms(512));
    assert!(fine < coarse / 4.0 && fine > 0.0, "{coarse:e} {fine:e}");
}

#[test]
fn only_where_nothing_hides_anything() {
    let high = Vec3::new(4.0, 3.0, 2.5);
    assert!(are_closed_forms(room()));
    assert!(are_closed_forms(moved(room())));
    // Without a wall, and with a lamp that lies in the ceiling's plane beside the ceiling.
    assert!(are_closed_forms(room()[2..].to_vec()));
    let mut lamp = room();
    lamp[2].material = MaterialId(1);
    assert!(are_closed_forms(lamp));

    // Something in the room, in a corner of it, or behind its wall.
    for low in [Vec3::ONE, Vec3::ZERO, Vec3::new(4.5, 0.0, 0.0)] {
        let mut surfaces = room();
        surfaces.extend(block(low, low + 0.5, true, 0));
        assert!(!are_closed_forms(surfaces), "{low}");
    }
    // Two rooms, of which neither sees the other.
    let mut surfaces = room();
    surfaces.extend(block(high, high + 1.0, false, 0));
    assert!(!are_closed_forms(surfaces));
    // A solid body, from outside.
    assert!(!are_closed_forms(block(Vec3::ZERO, high, true, 0)));
    // The same wall twice, in part, and of another material.
    let wall = |shift: f32, material| {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let corners = corners.map(|[x, y]| Vec3::new(x + shift, y + 0.5, 0.0));
        quad(corners, material)
    };
    for material in [0, 1] {
        let mut surfaces = room();
        surfaces.extend(wall(0.7, material));
        assert!(!are_closed_forms(surfaces));
    }
    assert!(!are_closed_forms([wall(0.0, 0), wall(0.5, 1)].concat()));
    // Walls that touch do not overlap, turned or not.
    let side_by_side = [wall(0.0, 0), wall(1.0, 1)].concat();
    assert!(are_closed_forms(side_by_side.clone()));
    assert!(are_closed_forms(moved(side_by_side)));
}

#[test]
fn only_where_they_cost_less_and_never_for_the_thesiss_maps() {
    let scene = furnace(0.5, 1.0, 0.01);
    assert!(closed_rows(&scene, settings(128, Points::CENTROID)).is_some());
    assert!(closed_rows(&scene, settings(32, Points::CENTROID)).is_none());
    let thesis = FormFactorSettings {
        maps: Maps::Thesis,
        ..settings(128, Points::CENTROID)
    };
    assert!(closed_rows(&scene, thesis).is_none());
}

fn report(folder: &Path, arguments: &[&str]) -> Value {
    solve(folder, &[arguments, &["--report", "report.json"]].concat());
    serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap()
}

/// A room whose ceiling is a lamp.
fn lit_room() -> Scene {
    let mut surfaces = moved(room());
    for surface in &mut surfaces[2..4] {
        surface.material = MaterialId(1);
    }
    scene(vec![material(0.6, 0.0), material(0.2, 9.0)], surfaces, 0.2)
}

/// Between patches of which some touch, pixels of 1/256 make errors of less than a percent in a factor, of either sign,
/// and a patch gathers from a thousand others: 1e-3 rms is much more than hemicubes and formulas may differ
/// by at the same points.
#[test]
fn the_answer_does_not_change() {
    let folder = folder();
    save(folder.path(), "in.rad", &lit_room());
    let run = |out: &str, more: &[&str]| {
        let arguments = ["in.rad", out, "512", "--tolerance", "1e-6"];
        report(folder.path(), &[&arguments[..], more].concat())
    };
    let closed = run("closed.rad", &["--backend", "auto"]);
    let drawn = run("drawn.rad", &["--backend", "cpu"]);
    assert_eq!(closed["hemicubes_drawn"], 0);
    assert_eq!(closed["settings"]["closed_forms"], "auto");
    let adapter = closed["backend"]["adapter"].as_str().unwrap();
    assert!(adapter.starts_with("closed forms"), "{adapter}");
    assert!(drawn["hemicubes_drawn"].as_u64() > Some(0));
    let [closed, drawn] =
        ["closed.rad", "drawn.rad"].map(|name| load(folder.path(), name).irradiance);
    let squares: f64 = closed
        .iter()
        .zip(&drawn)
        .map(|(a, b)| f64::from((a.x - b.x) / b.x).powi(2))
        .sum();
    let rms = (squares / drawn.len() as f64).sqrt();
    assert!(rms < 1e-3, "{rms:e}");
}

#[test]
fn off_means_hemicubes() {
    let folder = folder();
    save(folder.path(), "in.rad", &lit_room());
    let arguments = ["in.rad", "out.rad", "32", "--backend", "auto"];
    let report = report(
        folder.path(),
        &[&arguments[..], &["--closed-forms", "off"]].concat(),
    );
    assert!(report["hemicubes_drawn"].as_u64() > Some(0));
    assert_eq!(report["settings"]["closed_forms"], "off");
}

#[test]
fn a_run_that_goes_on_has_the_same_bits() {
    let folder = folder();
    save(folder.path(), "in.rad", &lit_room());
    for solver in ["jacobi", "gauss-seidel", "shooting"] {
        let run = |input: &str, out: &str, iterations: &str, threads: &str| {
            let arguments = [input, out, "128", "--backend", "auto", "--solver", solver];
            let limits = ["--iterations", iterations, "--threads", threads];
            report(folder.path(), &[&arguments[..], &limits].concat())
        };
        run("in.rad", "whole.rad", "6", "1");
        run("in.rad", "part.rad", "2", "2");
        assert_eq!(run("part.rad", "part.rad", "6", "3")["hemicubes_drawn"], 0);
        let [whole, part] = ["whole.rad", "part.rad"].map(|name| load(folder.path(), name));
        assert_eq!(whole, part, "{solver}");
    }
}

/// Two blocks hide each other.
#[test]
fn a_furnished_room_is_drawn() {
    let folder = folder();
    save(folder.path(), "in.rad", &furnished_room(0.5));
    let arguments = ["in.rad", "out.rad", "128", "--backend", "auto"];
    let report = report(folder.path(), &arguments);
    assert!(report["hemicubes_drawn"].as_u64() > Some(0));
}
