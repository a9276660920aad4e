//! `--path`: a picture of each frame along key frames.

use anyhow::Result;
use scene::{Scene, Solution};

use crate::animation::{self, AnimationFormat, frame_path};
use crate::camera_path::{CameraPath, Pose};
use crate::picture::{range_of, render};
use crate::settings::{Mode, Moving, RenderSettings};
use crate::told::report;

/// Writes the frames. One range serves all of them, so that light does not pulse.
pub fn film(
    moving: &Moving,
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<()> {
    let path = CameraPath::read(&moving.path)?;
    let mut settings = settings.clone();
    if settings.range.is_none() && settings.mode != Mode::Ids {
        settings.range = Some(range_of(scene, solution, &settings)?);
    }
    let mut size = [0, 0];
    let frames = path.frames(moving.frames_per_second);
    let count = frames.len();
    let frames = frames.map(
        |Pose {
             eye,
             look_at,
             fov_degrees,
         }| {
            let settings = RenderSettings {
                eye: Some(eye),
                look_at: Some(look_at),
                fov_degrees: fov_degrees.or(settings.fov_degrees),
                ..settings.clone()
            };
            let picture = render(scene, solution, &settings)?;
            size = [picture.mapped.width(), picture.mapped.height()];
            anyhow::Ok(picture.mapped.to_rgb8())
        },
    );
    animation::save(&moving.out, moving.format, moving.frames_per_second, frames)?;
    let [width, height] = size;
    let last = match moving.format {
        AnimationFormat::Numbered => frame_path(&moving.out, count, count),
        AnimationFormat::Apng | AnimationFormat::Gif => moving.out.clone(),
    };
    let rate = moving.frames_per_second;
    report(
        &last,
        &format!("{count} frames of {width}x{height}, {rate} a second"),
    );
    Ok(())
}
