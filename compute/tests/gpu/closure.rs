//! Closed scenes leak nothing, and open ones what they should, wherever walls touch.

use std::sync::Arc;

use compute::cpu::CpuRows;
use compute::gpu::structs::FRONT_FACE_OUTSET;
use compute::hemicubes::Hemicubes;
use compute::rows::{RowBatch, RowSource, UNITS_PER_ONE};
use compute::settings::{FormFactorSettings, Points};
use glam::DVec3;
use scene::{Scene, SurfaceId};

use crate::model::{
    Model, ROOM, patchwork_room, room_with_block, room_with_column, tiles_in_a_block,
};
use crate::{open, settings};

/// Largest patch, m^2, in the closed rooms.
const MAX_AREA: f64 = 0.3;

/// Rooms whose walls touch along edges without sharing corners, by name.
fn rooms() -> [(&'static str, Model); 3] {
    [
        ("block", room_with_block()),
        ("column", room_with_column()),
        ("patchwork", patchwork_room()),
    ]
}

fn upright(model: &Model) -> Model {
    Model {
        is_upright: true,
        ..model.clone()
    }
}

/// The worst row: units that see nothing, and units that see backs.
fn worst_leaks(rows: &RowBatch) -> [u32; 2] {
    let mut worst = [0; 2];
    for k in 0..rows.receivers().len() {
        let unseen = rows.unseen(k);
        let seen: f64 = rows.row(k).iter().map(|e| f64::from(e.units)).sum();
        let all = seen + f64::from(unseen.open) + f64::from(unseen.back_face);
        // Each entry is rounded to half of 2^-24 of itself.
        let error = all / f64::from(UNITS_PER_ONE) - 1.0;
        assert!(error.abs() < 6e-8, "patch {k}: {error}");
        worst = [worst[0].max(unseen.open), worst[1].max(unseen.back_face)];
    }
    worst
}

fn assert_closed(name: &str, scene: &Scene, resolution: u32, points: Points) {
    let settings = FormFactorSettings {
        points,
        ..settings(resolution)
    };
    let mut gpu = open(scene, settings);
    let patches = scene.patch_count();
    assert!(patches >= 100, "{name}: {patches}");
    let rows = gpu.draw_rows(0..patches).unwrap();
    let leaks = worst_leaks(&rows);
    // No tolerance: the first that any ray meets is a front.
    assert_eq!(
        leaks, [0; 2],
        "{name}, {resolution} pixels, {points}, {patches} patches: units that see nothing and backs"
    );
}

pub fn walls_that_touch_without_sharing_corners_leak_nothing() {
    for (name, model) in rooms() {
        let scene = upright(&model).scene(MAX_AREA);
        for resolution in [2, 16, 100, 128] {
            assert_closed(name, &scene, resolution, Points::CENTROID);
        }
    }
}

/// Their corners are rounded to f32 after they are turned, so that they lie beside their neighbours'
/// edges by that much.
pub fn walls_that_touch_only_within_rounding_leak_nothing() {
    for (name, model) in rooms() {
        let scene = model.scene(MAX_AREA);
        for resolution in [2, 16, 100, 128] {
            assert_closed(name, &scene, resolution, Points::CENTROID);
        }
    }
}

/// Eyes near edges and near the planes of other walls, which are then seen at grazing angles.
pub fn walls_seen_from_near_their_edges_leak_nothing() {
    for (name, model) in rooms() {
        assert_closed(name, &model.scene(MAX_AREA), 100, Points::Vertices);
        assert_closed(name, &upright(&model).scene(0.1), 100, Points::Vertices);
    }
}

/// No ray passes between two triangles of a sheet whose back is seen.
pub fn backs_of_a_closed_body_hide_everything() {
    for is_upright in [true, false] {
        let model = Model {
            is_upright,
            ..tiles_in_a_block()
        };
        let scene = model.scene(2e-3);
        let end = scene.mesh().tree(SurfaceId(4)).first_patch.0;
        assert!(end >= 100, "{end}");
        for resolution in [2, 100, 128] {
            let settings = settings(resolution);
            let mut gpu = open(&scene, settings);
            let rows = gpu.draw_rows(0..end).unwrap();
            for k in 0..end as usize {
                let unseen = rows.unseen(k);
                let leaks = UNITS_PER_ONE - unseen.back_face;
                assert_eq!(leaks, 0, "{resolution} pixels, patch {k}: {unseen:?}");
            }
        }
    }
}

/// A room without a ceiling lets out what it should: fronts are drawn too large by d = sqrt(3) times
/// their outset, which seldom comes to a pixel. A rim of length l at a distance r hides d l / (pi r^2)
/// times two cosines more than on the cpu; the cosines over r^2 are below 1 / m^2 in the mean.
pub fn an_opening_is_as_large_as_the_cpu_sees_it() {
    let rim = 2.0 * (ROOM[1].x + ROOM[1].y);
    for is_upright in [true, false] {
        let mut model = Model {
            is_upright,
            ..room_with_block()
        };
        let ceiling = ROOM[1].z;
        let below = |p: &DVec3| p.z < ceiling;
        model.triangles.retain(|corners| corners.iter().any(below));
        let scene = model.scene(MAX_AREA);
        let [low, high] = scene.bounds();
        let reach = low.abs().max(high.abs()).max_element();
        let outset = 3.0_f64.sqrt() * f64::from(FRONT_FACE_OUTSET * reach);
        let tolerance = outset * rim / std::f64::consts::PI;
        for resolution in [16, 100, 128] {
            let settings = settings(resolution);
            let mut gpu = open(&scene, settings);
            let mut cpu = CpuRows::new(&Arc::new(Hemicubes::new(&scene, settings)));
            let patches = scene.patch_count();
            let (on_gpu, on_cpu) = (
                gpu.draw_rows(0..patches).unwrap(),
                cpu.draw_rows(0..patches).unwrap(),
            );
            let one = f64::from(UNITS_PER_ONE);
            let share = |units: u32| f64::from(units) / one / f64::from(patches);
            let (mut open, mut different) = (0.0, 0.0);
            for k in 0..patches as usize {
                let (a, b) = (on_gpu.unseen(k), on_cpu.unseen(k));
                assert_eq!([a.back_face, b.back_face], [0, 0], "patch {k}");
                open += share(b.open);
                different += share(a.open.abs_diff(b.open));
            }
            println!("{resolution} pixels, open {open:.3}: {different:.1e} of {tolerance:.1e}");
            assert!(open > 0.1, "{open}");
            assert!(different <= tolerance, "{resolution}: {different}");
        }
    }
}
