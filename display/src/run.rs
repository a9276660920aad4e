//! The program, from its settings on.

use std::io::Write;
use std::path::Path;

use anyhow::{Context, Result};
use scene::{Rgb, Scene, Solution, export};

use crate::dark;
use crate::number;
use crate::output::{save_exr, save_png};
use crate::picture::{patch_colors, render};
use crate::settings::{
    ExportFormat, ImageFormat, Mode, Quantity, RenderSettings, Settings, SettingsError,
};
use crate::shade::Seen;
use crate::tone::Tone;

/// The last residual, dimensionless, from which on a solution is called converged: what is left
/// then is below what a picture of 8 bits shows.
const CONVERGED: f64 = 1e-3;

/// Writes the picture and the export that are asked for, and prints a line for each.
pub fn run(settings: &Settings) -> Result<()> {
    settings.validate()?;
    let (scene, solution) = scene::file::load(&settings.input)?;
    let has_error = solution.as_ref().is_some_and(|s| s.error().is_some());
    if settings.render.quantity == Quantity::Error && !has_error {
        return Err(SettingsError::NoError).with_context(|| settings.input.display().to_string());
    }
    if shows_solution(settings)
        && let Some(trouble) = trouble(&scene, solution.as_ref(), &settings.render)
    {
        note(&format!("{}: {trouble}", settings.input.display()));
    }
    if let Some((path, format)) = &settings.out {
        write_picture(path, *format, &scene, solution.as_ref(), &settings.render)?;
    }
    if let Some((path, format)) = &settings.export {
        write_export(path, *format, &scene, solution.as_ref(), &settings.render)?;
    }
    Ok(())
}

/// Whether something of what is asked for comes from the solution.
fn shows_solution(settings: &Settings) -> bool {
    let is_colored = settings.render.mode != Mode::Ids;
    let export = settings.export.as_ref().map(|(_, format)| format);
    let is_exported = match export {
        Some(ExportFormat::Csv) => true,
        Some(ExportFormat::Ply | ExportFormat::Glb) => is_colored,
        Some(ExportFormat::Obj) | None => false,
    };
    is_exported || (settings.out.is_some() && is_colored)
}

/// What keeps a solution from being one, or from showing anything, and what to do.
fn trouble(
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Option<String> {
    if !scene
        .surfaces()
        .iter()
        .any(|s| scene.material(s.material).is_emitter())
    {
        return Some("nothing emits, so all is black; give a material an emission".into());
    }
    let shown = match settings.quantity {
        Quantity::Radiosity => "the radiosity shown is the emission alone",
        Quantity::Irradiance => "the irradiance shown is 0",
        // Which is an error of its own without a solution.
        Quantity::Error => "the error shown is 0",
    };
    let Some(solution) = solution else {
        return Some(format!("no solution, {shown}; make one with compute"));
    };
    let is_dark = || solution.irradiance.iter().all(|&h| h == Rgb::ZERO);
    if solution.provenance.iterations == 0 && is_dark() {
        return Some(format!(
            "the solution has had 0 iterations, {shown}; go on with compute"
        ));
    }
    if let Some(object) = lit_from_behind(scene, Some(solution), settings) {
        return Some(format!(
            "most of the light of the strongest lamp falls on backs of \"{object}\", which are black: does it face the wrong way? \
             genx --flip \"{object}\" turns it, --two-sided \"{object}\" gives it both sides"
        ));
    }
    let residual = *solution.provenance.residuals.last()?;
    // A NaN is no convergence either.
    let is_converged = residual <= CONVERGED;
    (!is_converged).then(|| {
        format!(
            "not converged, the last residual {residual:.1e} is above {CONVERGED:e}; go on with compute"
        )
    })
}

/// The object that has its backs to the light, where the camera, which nobody has placed, is not to blame.
fn lit_from_behind<'s>(
    scene: &'s Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Option<&'s str> {
    let solution = solution.filter(|_| settings.eye.is_none())?;
    dark::lit_from_behind(scene, &solution.irradiance)
}

/// What a user should know of what the camera sees, and what to do.
fn sight(seen: Seen, culls_backs: bool) -> Option<String> {
    match seen.back_share() {
        None if culls_backs => Some(
            "the camera sees no front of a surface, and backs are left out; move it with --eye and --look-at".into(),
        ),
        None => Some("the camera sees no surface; move it with --eye and --look-at".into()),
        Some(share) if share > 0.5 => Some(format!(
            "{:.0}% of what the camera sees are backs of surfaces, which are black; look from the other side (--eye), leave backs out (--cull-back), or turn the model's faces round (counter-clockwise corners are the front)",
            // Not 100 as long as there is a front.
            (100.0 * share).floor()
        )),
        Some(_) => None,
    }
}

/// One line that is no failure.
fn note(what: &str) {
    eprintln!("display: note: {what}");
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
    // Where a lamp shines on backs, that has been told.
    if let Some(sight) = sight(picture.seen, settings.cull_back_faces)
        && lit_from_behind(scene, solution, settings).is_none()
    {
        note(&format!("{}: {sight}", path.display()));
    }
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
    let patches = format!("{} patches", scene.patch_count());
    report(
        path,
        &match format {
            ExportFormat::Obj => {
                let materials = export::obj::material_path(path);
                format!("{patches}, materials in {}", materials.display())
            }
            _ => patches,
        },
    );
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
    let [low, high] = number::ends(tone.scale().range());
    format!(
        "{} {}, {low} to {high} W/m^2",
        settings.mode, settings.quantity
    )
}
