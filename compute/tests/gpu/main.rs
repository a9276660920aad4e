//! Laws of the gpu back end, and its agreement with its twin on the cpu.
//!
//! Without an adapter every test that needs one prints that it is skipped; with `REQUIRE_GPU=1` it
//! fails.

mod closure;
mod model;
mod rasters;
mod rows;
mod twins;

use std::sync::Arc;

use compute::gpu::{GpuRows, Raster};
use compute::hemicubes::Hemicubes;
use compute::rows::BackendError;
use compute::settings::AdapterChoice;
use compute::settings::{FormFactorSettings, Points};
use scene::Scene;

fn settings(resolution: u32) -> FormFactorSettings {
    FormFactorSettings {
        points: Points::CENTROID,
        ..FormFactorSettings::new(resolution)
    }
}

/// A back end, or `None` where there is no adapter and none is required.
fn open(scene: &Scene, settings: FormFactorSettings) -> Option<GpuRows<'_>> {
    open_with(scene, settings, None)
}

/// The same with a raster of one's own choice, where one is given.
fn open_with(
    scene: &Scene,
    settings: FormFactorSettings,
    raster: Option<Raster>,
) -> Option<GpuRows<'_>> {
    let hemicubes = Arc::new(Hemicubes::new(scene, settings));
    match GpuRows::with_raster(&hemicubes, AdapterChoice::Any, raster) {
        Ok(rows) => Some(rows),
        Err(BackendError::NoAdapter)
            if std::env::var_os("REQUIRE_GPU").is_none_or(|v| v != "1") =>
        {
            eprintln!("skipped: there is no GPU adapter");
            None
        }
        Err(error) => panic!("{error}"),
    }
}
