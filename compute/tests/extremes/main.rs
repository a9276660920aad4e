//! Extreme conditions on the cpu back end: each test is a law, with its expectation and tolerance derived.

#[path = "../common/mod.rs"]
mod common;

mod emission;
mod reflectance;
mod scale;

use compute::cpu::CpuRows;
use compute::rows::{RowBatch, RowSource};
use compute::settings::{FormFactorSettings, Maps, Points};
use scene::Scene;

/// One hemicube a patch.
fn settings(resolution: u32) -> FormFactorSettings {
    FormFactorSettings {
        resolution,
        maps: Maps::Exact,
        points: Points::CENTROID,
    }
}

fn all_rows(scene: &Scene, resolution: u32) -> RowBatch {
    CpuRows::new(scene, settings(resolution))
        .draw_rows(0..scene.patch_count())
        .unwrap()
}
