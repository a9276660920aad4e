//! `compute --dry-run`: what a run would take, from a few rows of it.

use std::io::Write;
use std::process::ExitCode;
use std::time::Duration;

use anyhow::Context;
use scene::file;
use scene::{Scene, Solution};

use super::{Settings, run};
use crate::cancel::CancelToken;
use crate::form_factors::{FormFactors, Levels, Needed, area_of_function_sources};
use crate::quantity::{show_duration, show_size};
use crate::settings::Target;
use crate::sources::Sources;
use crate::stand_in::StandIn;
use crate::two_levels;

/// Places, evenly over the scene, where rows are drawn to tell what all take.
const PLACES: u32 = 8;

/// Vertices for which the time is told.
const VERTICES: f64 = 1000.0;

/// Tells what was asked for would take. Nothing is written.
///
/// # Errors
/// Files that cannot be read, and a back end that does not open.
pub(super) fn tell(settings: &Settings, cancel: &CancelToken) -> anyhow::Result<ExitCode> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads.unwrap_or(0))
        .build()
        .context("the threads could not be started")?;
    let text = pool.install(|| text(settings, cancel))?;
    writeln!(std::io::stdout(), "{text}").ok();
    Ok(ExitCode::SUCCESS)
}

fn text(settings: &Settings, cancel: &CancelToken) -> anyhow::Result<String> {
    let (scene, before) = file::load(&settings.input)?;
    let settings = &run::of_scene(settings, &scene, before.as_ref());
    let solve = settings.solve;
    let form_factors =
        FormFactors::new(&scene, solve.solution.form_factors, solve.drawing).with_cancel(cancel);
    let source_area = solve.solution.source_area;
    let levels = match solve.function() {
        Some(target) => form_factors.levels_of_function(source_area, target),
        None => form_factors.levels(source_area),
    };
    let stand_in = StandIn::to_solve(&scene, &solve);
    let area = match (&stand_in, levels) {
        (Some((_, target)), _) => Some(area_of_function_sources(&scene, *target)),
        (None, Levels::Patches) => None,
        (None, Levels::Sources(area)) => Some(area),
        (None, Levels::Automatic) => two_levels::areas_to_try(&scene).next(),
    };
    let coarse = area.filter(|_| stand_in.is_none());
    let coarse = coarse.map(|area| two_levels::sources(&scene, area));
    let sources = match &stand_in {
        Some((stand_in, _)) => stand_in.scene(),
        None => coarse.as_ref().unwrap_or(&scene),
    };
    let rows = Rows::of(&form_factors.of_scene(sources), sources, settings)?;
    let mut lines = vec![format!(
        "scene          {} patches on {} surfaces",
        scene.patch_count(),
        scene.surfaces().len()
    )];
    if let Some(area) = area {
        let at_first = if levels == Levels::Automatic {
            " at first"
        } else {
            ""
        };
        lines.push(format!(
            "sources        {}{at_first}, of at most {area:.3} m^2",
            sources.patch_count()
        ));
    }
    lines.push(format!("back end       {}", rows.back_end));
    lines.push(format!(
        "rows           {}, about {} hemicubes; drawing them takes about {}",
        rows.count,
        rows.hemicubes,
        show_duration(rows.each.mul_f64(f64::from(rows.count)))
    ));
    let bytes = show_size(rows.bytes);
    let is_too_much = rows.bytes > solve.drawing.memory_bytes;
    let missing = if is_too_much {
        ": more than --memory, so that some are drawn again in each iteration"
    } else {
        ""
    };
    lines.push(format!(
        "memory         about {bytes} of form factors{missing}"
    ));
    lines.push(format!(
        "disk           {bytes} at most in OUT.rows, in runs of more than {}",
        show_duration(solve.checkpoint_every)
    ));
    lines.extend(rows.light(solve.function(), &scene, area.is_some()));
    Ok(lines.join("\n"))
}

/// What is known of the rows of sources to each other.
struct Rows {
    back_end: String,
    count: u32,
    hemicubes: u64,
    bytes: u64,
    /// Time to draw one.
    each: Duration,
}

impl Rows {
    /// Draws a few of them.
    fn of(
        form_factors: &FormFactors,
        sources: &Scene,
        settings: &Settings,
    ) -> anyhow::Result<Self> {
        let dark = Solution::dark(sources);
        let needed = if settings.solve.all_rows {
            Needed::All
        } else {
            Needed::Lit(&dark)
        };
        let mut rows = form_factors.rows_to(Sources::patches_of(form_factors.scene()), needed)?;
        let count = rows.lit_count();
        for place in 0..PLACES {
            let at = u64::from(place) * u64::from(sources.patch_count()) / u64::from(PLACES);
            if rows.unlit().get(at as usize) == Some(&false) {
                rows.batch_with(at as u32)?;
            }
        }
        let statistics = rows.statistics();
        let drawn = statistics.drawn_rows.max(1);
        Ok(Self {
            back_end: format!("{} ({})", rows.backend(), rows.describe_source()),
            count,
            hemicubes: statistics.hemicubes * u64::from(count) / drawn,
            bytes: statistics.bytes_of_all(count),
            each: statistics.duration.div_f64(drawn as f64),
        })
    }

    /// What comes after the iterations.
    fn light(&self, target: Option<Target>, scene: &Scene, is_coarse: bool) -> Option<String> {
        let all = |count: f64| show_duration(self.each.mul_f64(count));
        match target {
            Some(_) => Some(format!(
                "light          then gathers at vertices until its error is as small as asked for; each thousand takes about {}",
                all(VERTICES)
            )),
            None => is_coarse.then(|| {
                let patches = f64::from(scene.patch_count());
                format!(
                    "light          then gathers at all patches, which takes about {}",
                    all(patches)
                )
            }),
        }
    }
}
