//! The gpu back end on the adapter there is, beside the cpu.

use std::time::Duration;

use compute::backend::{self, Drawer, trial};
use genx::{Model, Settings};
use scene::Scene;

use crate::arguments::{Plan, Section, command_of};
use crate::measure::one_a_patch;
use crate::text::{count, heading, table};

/// Pixels, the program's default.
const PIXELS: u32 = 128;

/// The section.
pub fn section(plan: &Plan) -> anyhow::Result<String> {
    let models = [
        ("Cornell box", Model::Cornell),
        ("model 2, the hall", Model::Hall),
    ];
    let mut rows = Vec::new();
    for (name, model) in models {
        let scene = genx::make(&Settings::new(model))?.scene;
        for drawer in [Drawer::Gpu, Drawer::Cpu] {
            eprintln!("performance: back ends, {name}, {drawer:?}");
            let mut row = vec![name.to_owned(), count(scene.patch_count().into())];
            row.extend(match speed(plan, &scene, drawer) {
                Ok((back_end, speed)) => [back_end, count(speed.round() as u64)],
                Err(error) => [format!("none: {error:#}"), String::new()],
            });
            rows.push(row);
        }
    }
    Ok(format!(
        "{}Rows of one hemicube a patch of {PIXELS} pixels, without views of lamps, by each back end on all threads \
         ({}). A software adapter draws on the same cores as the cpu back end, and tells nothing of a graphics \
         card.\n\n{}",
        heading("Back ends"),
        command_of(Section::Gpu),
        table(
            &["scene", "patches", "back end", "hemicubes a second"],
            1,
            &rows
        )
    ))
}

/// What a back end calls itself, and how many hemicubes it draws and merges in a second.
fn speed(plan: &Plan, scene: &Scene, drawer: Drawer) -> anyhow::Result<(String, f64)> {
    let hemicubes = one_a_patch(scene, PIXELS);
    let mut source = backend::open_again(&hemicubes, drawer)?.source;
    // Not counted: there a back end finds out how to draw.
    trial::speed(&hemicubes, &mut *source, Duration::ZERO)?;
    let least = Duration::from_secs_f64(plan.choose(0.2, 4.0));
    let speed = trial::speed(&hemicubes, &mut *source, least)?;
    Ok((source.describe(), speed))
}
