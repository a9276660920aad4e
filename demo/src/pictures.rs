//! The pictures of one scene.

use std::path::Path;

use display::{Mode, Picture, RenderSettings, Size};
use scene::Scene;

use crate::solve::Steps;

/// Width over height of the pictures.
const ASPECT: f64 = 4.0 / 3.0;

/// Writes a log map and false colours of each state, and the patch IDs.
pub fn write(
    folder: &Path,
    name: &str,
    scene: &Scene,
    solved: &Steps,
    height: u32,
) -> anyhow::Result<()> {
    let width = (f64::from(height) * ASPECT).round() as u32;
    let save = |picture: &Picture, what: &str| {
        display::output::save_png(&folder.join(format!("{name}-{what}.png")), picture)
    };
    for mode in [Mode::Log, Mode::FalseColor] {
        let mut settings = RenderSettings {
            mode,
            smooth: mode == Mode::Log,
            size: Some(Size { width, height }),
            ..RenderSettings::default()
        };
        let count = solved.states.len();
        // The last state comes first: its range is that of all, so that the pictures compare.
        for (k, state) in solved.states.iter().enumerate().rev() {
            let picture = display::render(scene, Some(state), &settings)?;
            settings.range = settings
                .range
                .or(picture.tone.as_ref().map(|tone| tone.scale().range()));
            let step = if k + 1 == count {
                "final".to_owned()
            } else {
                (k + 1).to_string()
            };
            save(&picture, &format!("{mode}-{step}"))?;
        }
    }
    let settings = RenderSettings {
        mode: Mode::Ids,
        size: Some(Size { width, height }),
        ..RenderSettings::default()
    };
    save(&display::render(scene, None, &settings)?, "ids")?;
    Ok(())
}
