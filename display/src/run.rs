//! The program, from its settings on.

use std::io::Write;
use std::path::Path;
use std::process::ExitCode;

use anyhow::{Context, Result};
use scene::{PatchId, Rgb, Scene, Solution, export};

use crate::comparing::compare;
use crate::dark;
use crate::hemicube_picture::{self, HemicubeSettings};
use crate::maps_picture::maps_picture;
use crate::mix::mixed;
use crate::moving::film;
use crate::number;
use crate::output::{save_exr, save_image, save_png};
use crate::picture::{Extent, Picture, patch_colors, range_of, render};
use crate::plot::plot;
use crate::quantity::{Quantity, Shown};
use crate::settings::{
    ExportFormat, ImageFormat, Job, Mode, RenderSettings, Rows, Settings, SettingsError,
};
use crate::shade::Seen;
use crate::table;
use crate::told::{note, report};
use crate::tone::Tone;
use crate::window;

/// The last residual, dimensionless, from which on a solution is called converged: what is left
/// then is below what a picture of 8 bits shows.
const CONVERGED: f64 = 1e-3;

/// Luminances that differ by less, relative, are one: a step of 8 bits is 40 times as large.
const UNIFORM: f64 = 1e-4;

/// Does what is asked for, prints a line for each file that is written, and says how the process is to end.
pub fn run(job: &Job) -> Result<ExitCode> {
    match job {
        Job::Show(settings) if settings.is_window() => return Ok(window::open(&settings.input)?),
        Job::Show(settings) => show(settings)?,
        Job::Maps { resolution, out } => {
            let image = maps_picture(*resolution)?;
            let size = format!("{}x{}", image.width(), image.height());
            save_image(out, &image.into())?;
            report(
                out,
                &format!("{size}, multiplier maps of {resolution} pixels"),
            );
        }
        Job::Plot { report: of, out } => {
            plot(of, out)?;
            report(out, &format!("charts of {}", of.display()));
        }
    }
    Ok(ExitCode::SUCCESS)
}

/// Writes the picture and the export that are asked for.
fn show(settings: &Settings) -> Result<()> {
    settings.validate()?;
    let (scene, solution) = scene::file::load(&settings.input)?;
    let naming = |error| naming(error, &settings.input);
    let of_input = |error: SettingsError| naming(error.into());
    let mut render = settings.render.clone();
    if let Some(path) = &settings.range_of {
        let (scene, solution) = scene::file::load(path)?;
        let range = range_of(&scene, solution.as_ref(), &render);
        render.range = Some(range.with_context(|| path.display().to_string())?);
    }
    let (scene, solution) = match &settings.mix {
        None => (scene, solution),
        Some(mix) => {
            if render.range.is_none() && render.mode != Mode::Ids {
                render.range =
                    Some(range_of(&scene, solution.as_ref(), &render).map_err(of_input)?);
            }
            let mixed = mixed(&scene, solution.as_ref(), mix);
            let (scene, solution) = mixed.with_context(|| settings.input.display().to_string())?;
            (scene, Some(solution))
        }
    };
    let render = &render;
    let trouble = shows_solution(settings).then(|| trouble(&scene, solution.as_ref(), render));
    let trouble = trouble.flatten();
    if let Some(trouble) = &trouble {
        note(&format!("{}: {trouble}", settings.input.display()));
    }
    let out = settings.out.as_ref();
    if let Some(comparing) = &settings.comparing {
        let map = out.map(|(path, _)| path.as_path());
        compare(comparing, &scene, solution.as_ref(), render, map).map_err(naming)?;
    } else if let (Some((patch, resolution)), Some((path, _))) = (settings.hemicube, out) {
        write_hemicube(path, (patch, resolution), &scene, solution.as_ref(), render)
            .map_err(naming)?;
    } else if let Some(moving) = &settings.moving {
        film(moving, &scene, solution.as_ref(), render).map_err(naming)?;
    } else if let Some((path, format)) = out {
        let picture = write_picture(path, *format, &scene, solution.as_ref(), render);
        let picture = picture.map_err(naming)?;
        // Where something is wrong, that has been told.
        if trouble.is_none()
            && let Some(told) = uniform(&picture, render)
        {
            note(&format!("{}: {told}", path.display()));
        }
    }
    if let Some((path, format)) = &settings.export {
        write_export(path, *format, &scene, solution.as_ref(), render)?;
    }
    if let Some(by) = settings.table {
        print_table(by, &scene, solution.as_ref(), render).map_err(naming)?;
    }
    Ok(())
}

/// The same error, which names the input where that is not what is asked of it; others name their files.
fn naming(error: anyhow::Error, input: &Path) -> anyhow::Error {
    if error.is::<SettingsError>() {
        error.context(input.display().to_string())
    } else {
        error
    }
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
    let is_pictured = settings.out.is_some() || settings.moving.is_some();
    is_exported || settings.table.is_some() || (is_pictured && is_colored)
}

/// What keeps a solution from being one, or from showing anything, and what to do.
fn trouble(
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Option<String> {
    let is_of_materials = matches!(
        settings.shown.quantity,
        Quantity::Emission | Quantity::Reflectance
    );
    if is_of_materials {
        return None;
    }
    if !scene
        .surfaces()
        .iter()
        .any(|s| scene.material(s.material).is_emitter())
    {
        return Some("nothing emits, so all is black; give a material an emission".into());
    }
    let shown = match settings.shown.quantity {
        Quantity::Radiosity | Quantity::Radiance => "the radiosity shown is the emission alone",
        Quantity::Irradiance => "the irradiance shown is 0",
        // Which are errors of their own without a solution.
        Quantity::Direct | Quantity::Indirect => "the light shown is 0",
        Quantity::Error => "the error shown is 0",
        Quantity::Emission | Quantity::Reflectance => return None,
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

fn write_picture(
    path: &Path,
    format: ImageFormat,
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<Picture> {
    // An EXR is not mapped, so a mode's legend would only take its place from the view.
    let mode = if format == ImageFormat::Exr {
        Mode::Linear
    } else {
        settings.mode
    };
    let settings = &RenderSettings {
        mode,
        ..settings.clone()
    };
    let picture = render(scene, solution, settings)?;
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
            let Shown { quantity, .. } = settings.shown;
            match settings.shown.plain_unit() {
                unit if unit.is_empty() => format!("{quantity}, unmapped"),
                unit => format!("{} in {unit}, unmapped", settings.shown.name()),
            }
        }
    };
    report(path, &format!("{width}x{height}, {description}"));
    Ok(picture)
}

/// Writes what a patch sees.
fn write_hemicube(
    path: &Path,
    (patch, resolution): (PatchId, u32),
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<()> {
    let settings = HemicubeSettings {
        resolution,
        mode: settings.mode,
        range: settings.range,
        flat: settings.flat,
        ..HemicubeSettings::default()
    };
    let picture = hemicube_picture::render(scene, solution, patch, &settings)?;
    let size = format!("{}x{}", picture.image.width(), picture.image.height());
    save_image(path, &picture.image.into())?;
    let irradiance = picture
        .irradiance
        .to_array()
        .map(|h| number::with_digits(f64::from(h), 4));
    let [r, g, b] = irradiance;
    report(
        path,
        &format!(
            "{size}, what patch {} sees: irradiance {r}, {g}, {b} W/m^2",
            patch.0
        ),
    );
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

/// What to say of a picture that shows one value everywhere, which may be right, as in a furnace.
fn uniform(picture: &Picture, settings: &RenderSettings) -> Option<String> {
    let Extent { least, most } = picture.visible?;
    (least > 0.0 && most <= (1.0 + UNIFORM) * least).then(|| {
        format!(
            "all that the camera sees has one {}, {} {}",
            settings.shown.name(),
            number::with_digits(most, 4),
            settings.shown.plain_unit()
        )
    })
}

/// A table on standard output. Nobody to read it is no failure.
fn print_table(
    by: Rows,
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<()> {
    let shown = settings.shown;
    let values = shown.of_patches(scene, solution)?;
    let rows = table::rows(scene, solution, shown, &values, by);
    write!(std::io::stdout(), "{}", table::text(&rows, shown, by)).ok();
    Ok(())
}

/// What a mapped picture shows.
fn description(settings: &RenderSettings, tone: Option<&Tone>) -> String {
    let Some(tone) = tone else {
        return "patch IDs".into();
    };
    let [low, high] = number::ends(tone.scale().range());
    let mode = match settings.mode {
        Mode::FalseColor => format!("{} ({})", settings.mode, tone.scale().kind()),
        mode => mode.to_string(),
    };
    let described = format!(
        "{mode} {}, {low} to {high} {}",
        settings.shown.name(),
        settings.shown.plain_unit()
    );
    described.trim_end().to_owned()
}
