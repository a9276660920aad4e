//! Extreme conditions on the cpu back end: each test is a law, with its expectation and tolerance derived.

#[path = "../common/mod.rs"]
mod common;

mod corners;
mod emission;
mod lamps;
mod overlaps;
mod reflectance;
mod scale;
mod shapes;
mod sizes;
mod stated;
mod threads;

use std::sync::Arc;

use common::methods::ROUNDING;
use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::receivers::ReceiverId;
use compute::row_cache::RowCache;
use compute::rows::{RowBatch, RowSource, UNITS_PER_ONE, Unseen};
use compute::settings::{FormFactorSettings, Points};
use scene::Scene;
use visibility::Frame;

/// One hemicube a patch.
fn settings(resolution: u32) -> FormFactorSettings {
    FormFactorSettings {
        points: Points::CENTROID,
        ..FormFactorSettings::new(resolution)
    }
}

/// No rows yet, kept as they come.
fn cache(scene: &Scene, resolution: u32) -> RowCache<'_> {
    let hemicubes = Arc::new(Hemicubes::new(scene, settings(resolution)));
    let source = Box::new(CpuRows::new(&hemicubes));
    RowCache::new(&hemicubes, source, u64::MAX)
}

fn all_rows(scene: &Scene, resolution: u32) -> RowBatch {
    CpuRows::new(&Arc::new(Hemicubes::new(scene, settings(resolution))))
        .draw_rows(0..scene.patch_count())
        .unwrap()
}

/// A patch's one hemicube.
fn frame(scene: &Scene, patch: u32) -> Frame {
    Hemicubes::new(scene, settings(2))
        .receivers()
        .frames(ReceiverId(patch))[0]
}

/// The sum of a row's form factors, dimensionless.
fn row_sum(rows: &RowBatch, k: usize) -> f64 {
    let units: f64 = rows.row(k).iter().map(|e| f64::from(e.units)).sum();
    units / f64::from(UNITS_PER_ONE)
}

/// A row sums to 1, but for each entry's rounding to half of 2^-24 of itself.
#[track_caller]
fn assert_sums_to_one(rows: &RowBatch, k: usize, what: &str) {
    let error = row_sum(rows, k) - 1.0;
    assert!(error.abs() < ROUNDING, "{what}: {error}");
}

/// Every row sums to 1, and nothing is lost through openings or to back faces.
#[track_caller]
fn assert_closed(scene: &Scene, resolution: u32, what: &str) {
    let rows = all_rows(scene, resolution);
    for k in 0..scene.patch_count() as usize {
        let at = format!("{what}, {resolution} pixels, patch {k}");
        assert_eq!(rows.unseen(k), Unseen::default(), "{at}");
        assert_sums_to_one(&rows, k, &at);
    }
}

/// How far a form factor may be from the exact one, dimensionless, because a hemicube counts whole pixels
/// along the `edges` straight sides of what is seen, and along the `upright` ones, which are parallel to
/// its axis.
///
/// Where a side crosses a row of pixels, or a column if it is flatter, the last pixel is counted all or
/// not, which is wrong by half of it at most and even between. A side crosses at most R of the top's
/// and R/2 of each of two half faces, 2 R in all; a pixel is at most (2/R)^2 / pi. Hemicubes are turned,
/// so that one crossing knows nothing of the next: six times the root of 2 R / 12 pixels squared.
///
/// An upright side is a column's border whatever the turn: its errors add up, to half a column of at most
/// (2/R) times the integral of z / (pi (1 + z^2)^2) over z from 0 to 1, which is 1 / (4 pi).
fn counting_error(resolution: u32, edges: usize, upright: usize) -> f64 {
    let size = f64::from(resolution);
    let pi = std::f64::consts::PI;
    let pixel = 4.0 / (size * size * pi);
    6.0 * (2.0 * size * edges as f64 / 12.0).sqrt() * pixel + upright as f64 / (4.0 * pi * size)
}
