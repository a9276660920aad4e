//! How fast the back ends draw, on a machine whose GPU nobody has tried.
//!
//! `gpu_speed [--quick]` prints a JSON object: for the Cornell box and the hall, each with one hemicube of 128 pixels a
//! patch, the hemicubes that are drawn and merged in a second by the CPU on all threads, and by the best adapter with
//! each of its rasters. Lamps have no views of their own here. `--quick` only shows that it works. The exit code is 1
//! where something does not draw.

use std::process::ExitCode;
use std::sync::Arc;
use std::time::Duration;

use compute::backend::trial;
use compute::cpu::CpuRows;
use compute::gpu::{GpuRows, Raster};
use compute::hemicubes::Hemicubes;
use compute::rows::{BackendError, RowSource};
use compute::settings::{AdapterChoice, FormFactorSettings, Points};
use genx::{Model, Settings};
use serde_json::{Value, json};

/// Pixels along a face, the program's default.
const PIXELS: u32 = 128;
/// The same of a quick run.
const QUICK_PIXELS: u32 = 16;

/// How long each is measured.
const MEASURED: Duration = Duration::from_secs(3);
/// The same of a quick run.
const QUICK_MEASURED: Duration = Duration::from_millis(50);

fn main() -> anyhow::Result<ExitCode> {
    let is_quick = match std::env::args().skip(1).collect::<Vec<_>>().as_slice() {
        [] => false,
        [only] if only == "--quick" => true,
        _ => anyhow::bail!("usage: gpu_speed [--quick]"),
    };
    let (pixels, measured) = if is_quick {
        (QUICK_PIXELS, QUICK_MEASURED)
    } else {
        (PIXELS, MEASURED)
    };
    let settings = FormFactorSettings {
        points: Points::CENTROID,
        ..FormFactorSettings::new(pixels)
    };
    let mut results = Vec::new();
    let mut do_all_draw = true;
    for (name, model) in [("cornell", Model::Cornell), ("hall", Model::Hall)] {
        let scene = genx::make(&Settings::new(model))?.scene;
        let hemicubes = Arc::new(Hemicubes::new(&scene, settings));
        for who in [None, Some(Raster::Pipeline), Some(Raster::Compute)] {
            let result = speed(&hemicubes, who, measured);
            do_all_draw &= result.is_ok();
            let (told, speed, error) = match result {
                Ok((told, speed)) => (Some(told), Some(speed), None),
                Err(error) => (None, None, Some(error.to_string())),
            };
            results.push(json!({
                "scene": name,
                "patches": scene.patch_count(),
                "backend": if who.is_none() { "cpu" } else { "gpu" },
                "raster": who.map(Raster::describe),
                "adapter": told,
                "hemicubes_per_second": speed,
                "error": error,
            }));
        }
    }
    let told: Value = json!({ "pixels": pixels, "results": results });
    println!("{told:#}");
    Ok(if do_all_draw {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}

/// What it calls itself, and its hemicubes a second: the CPU's, or the GPU's with a raster.
fn speed(
    hemicubes: &Arc<Hemicubes>,
    raster: Option<Raster>,
    measured: Duration,
) -> Result<(String, f64), BackendError> {
    let mut source: Box<dyn RowSource> = match raster {
        None => Box::new(CpuRows::new(hemicubes)),
        raster => Box::new(GpuRows::with_raster(hemicubes, AdapterChoice::Any, raster)?),
    };
    // Not counted: there a back end finds out how to draw.
    trial::speed(hemicubes, &mut *source, measured / 10)?;
    let speed = trial::speed(hemicubes, &mut *source, measured)?;
    Ok((source.describe(), speed))
}
