//! The program, from its settings on.

use std::io::Write;
use std::path::Path;

use anyhow::Result;
use scene::{Scene, Solution, export};

use crate::output::{save_exr, save_png};
use crate::picture::{patch_colors, render};
use crate::settings::{ExportFormat, ImageFormat, Mode, Quantity, Range, RenderSettings, Settings};
use crate::tone::Tone;

/// Writes the picture and the export that are asked for, and prints a line for each.
pub fn run(settings: &Settings) -> Result<()> {
    settings.validate()?;
    let (scene, solution) = scene::file::load(&settings.input)?;
    if solution.is_none() && settings.render.mode != Mode::Ids {
        let shown = match settings.render.quantity {
            Quantity::Radiosity => "the radiosity shown is the emission alone",
            Quantity::Irradiance => "the irradiance shown is 0",
        };
        eprintln!(
            "{}: no solution, {shown}; make one with compute",
            settings.input.display()
        );
    }
    if let Some((path, format)) = &settings.out {
        write_picture(path, *format, &scene, solution.as_ref(), &settings.render)?;
    }
    if let Some((path, format)) = &settings.export {
        write_export(path, *format, &scene, solution.as_ref(), &settings.render)?;
    }
    Ok(())
}

fn write_picture(
    path: &Path,
    format: ImageFormat,
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<()> {
    // An EXR is not mapped, so a mode's legend would only take its place from the view.
    let mode = if format == ImageFormat::Exr {
        Mode::Linear
    } else {
        settings.mode
    };
    let picture = render(scene, solution, &RenderSettings { mode, ..*settings })?;
    let (width, height) = (picture.mapped.width(), picture.mapped.height());
    let description = match format {
        ImageFormat::Png => {
            save_png(path, &picture)?;
            description(settings, picture.tone.as_ref())
        }
        ImageFormat::Exr => {
            save_exr(path, &picture)?;
            format!("{} in W/m^2, unmapped", settings.quantity)
        }
    };
    report(path, &format!("{width}x{height}, {description}"));
    Ok(())
}

fn write_export(
    path: &Path,
    format: ExportFormat,
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<()> {
    let colors = || patch_colors(scene, solution, settings);
    match format {
        ExportFormat::Csv => export::csv::save(path, scene, solution)?,
        ExportFormat::Obj => export::obj::save(path, scene)?,
        ExportFormat::Ply => export::ply::save(path, scene, &colors()?)?,
        ExportFormat::Glb => export::glb::save(path, scene, &colors()?)?,
    }
    report(path, &format!("{} patches", scene.patch_count()));
    Ok(())
}

/// One line about a file that was written. Nobody to read it is no failure: the file is there.
fn report(path: &Path, what: &str) {
    writeln!(std::io::stdout(), "{}: {what}", path.display()).ok();
}

/// What a mapped picture shows.
fn description(settings: &RenderSettings, tone: Option<&Tone>) -> String {
    let Some(tone) = tone else {
        return "patch IDs".into();
    };
    let Range { low, high } = tone.scale().range();
    format!(
        "{} {}, {low} to {high} W/m^2",
        settings.mode, settings.quantity
    )
}
