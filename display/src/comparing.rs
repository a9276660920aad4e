//! `--compare`: how far a picture of the input is from another one, or from one of another solution.
//!
//! Without a mask, pixels count in whose middle one sees the front of a surface that does not emit: emission is known, and lamps
//! would outshine every error.

use std::path::Path;

use anyhow::{Context, Result};
use scene::{PatchId, Rgb, Scene, Solution};
use visibility::Cull;

use crate::by_position::ByPosition;
use crate::compare::Comparison;
use crate::difference::DifferenceMap;
use crate::input::{read_exr, read_mask};
use crate::output::save_image;
use crate::picture::{Picture, render};
use crate::settings::{Comparing, Mode, RenderSettings, Size};
use crate::shade;
use crate::told::report;

/// Compares a picture of a scene, prints what differs, and writes the map of it where it is asked for.
pub fn compare(
    comparing: &Comparing,
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
    map: Option<&Path>,
) -> Result<()> {
    let other = &comparing.with;
    let mut settings = RenderSettings {
        mode: Mode::Linear,
        contours: Vec::new(),
        ..settings.clone()
    };
    let (picture, right) = if is_picture(other) {
        let right = read_exr(other)?;
        settings.size = settings.size.or(Some(right.size));
        let picture = render(scene, solution, &settings)?;
        right.expect_size(picture.view)?;
        (picture, right.linear)
    } else {
        let (other_scene, other_solution) = scene::file::load(other)?;
        let picture = render(scene, solution, &settings)?;
        let same_view = seen_from(scene, &picture, &settings);
        let right = render(&other_scene, other_solution.as_ref(), &same_view);
        let right = right.with_context(|| other.display().to_string())?;
        if let (Some(solution), Some(other)) = (solution, &other_solution) {
            let by_position = ByPosition::new((scene, solution), (&other_scene, other));
            let by_area = by_position.errors_by_area().describe(scene);
            report(&comparing.with, &format!("by area: {by_area}"));
        }
        (picture, right.linear)
    };
    let mask = match &comparing.mask {
        Some(mask) => read_mask(mask, picture.view)?,
        None => reflecting(scene, &picture, settings.cull_back_faces),
    };
    let found = Comparison::new(picture.view, &picture.linear, &right, &mask);
    report(other, &format!("in the picture: {}", found.describe()));
    if let Some(path) = map {
        let map = DifferenceMap::new(picture.view, &picture.linear, &right, &mask);
        save_image(path, &map.image())?;
        let Size { width, height } = picture.view;
        report(
            path,
            &format!(
                "{width}x{height}, the difference, up to {} W/m^2 to both sides",
                map.range.high
            ),
        );
    }
    Ok(())
}

/// Whether a file is a picture by its name.
fn is_picture(path: &Path) -> bool {
    let extension = path.extension();
    extension.is_some_and(|extension| extension.eq_ignore_ascii_case("exr"))
}

/// The same settings with the camera of a picture of this scene, in the model's own coordinates.
fn seen_from(scene: &Scene, picture: &Picture, settings: &RenderSettings) -> RenderSettings {
    let camera = picture.camera;
    RenderSettings {
        size: Some(picture.view),
        eye: Some(scene.to_model(camera.eye)),
        look_at: Some(scene.to_model(camera.eye + camera.forward)),
        fov_degrees: Some(camera.fov_degrees),
        up: settings.up,
        ..settings.clone()
    }
}

/// Which pixels see the front of what does not emit.
fn reflecting(scene: &Scene, picture: &Picture, culls_backs: bool) -> Vec<bool> {
    let cull = if culls_backs {
        Cull::BackFaces
    } else {
        Cull::Nothing
    };
    let (ids, _) = shade::ids(scene, &picture.camera, picture.view, cull);
    let emissions: Vec<Rgb> = scene.patch_emissions();
    let reflects = |id: Option<PatchId>| id.is_some_and(|id| emissions[id.index()] == Rgb::ZERO);
    ids.into_iter().map(reflects).collect()
}
