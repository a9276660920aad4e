//! The models, and what they have in common.

mod bend;
mod cornell;
mod cornell_mesh;
mod cube;
mod file;
mod furnace;
mod hall;

use scene::{Material, ModelAxes, Rgb};

use crate::builder::Builder;
use crate::{Format, GenxError, Made, Model, Settings, openings};

/// Reflectance of the models that have no colours of their own, dimensionless.
const DEFAULT_REFLECTANCE: f32 = 0.5;

/// Exitance of the lamps of the models 1 to 3, W/m^2. Bright enough that reflected light reads as
/// whole numbers; every quantity is proportional to it.
const DEFAULT_LIGHT_POWER: f32 = 1000.0;

/// Makes what the settings ask for.
///
/// # Errors
/// Settings outside their ranges, a file that cannot be used, or more patches than a scene
/// can have.
pub fn make(settings: &Settings) -> Result<Made, GenxError> {
    settings.validate()?;
    let mut made = match &settings.model {
        Model::Cube => generated(cube::build(settings), cube::MAX_AREA, settings)?,
        Model::Hall => generated(hall::build(settings), hall::MAX_AREA, settings)?,
        Model::Bend => generated(bend::build(settings), bend::MAX_AREA, settings)?,
        Model::Cornell => generated(cornell::build(settings), cornell::MAX_AREA, settings)?,
        Model::Furnace => generated(furnace::build(settings), furnace::MAX_AREA, settings)?,
        Model::File { format, path } => file::import(*format, path, settings)?,
    };
    if made.scene.emitted_power().max_element() <= 0.0 {
        made.warnings.push(
            "nothing emits, so every solution is black; give a material an emission (MTL: Ke, glTF: emissiveFactor), or a material or object a light: --light NAME=R,G,B"
                .to_owned(),
        );
    }
    let has_lights = matches!(
        settings.model,
        Model::File {
            format: Format::Gltf,
            ..
        }
    );
    if settings.light_radius.is_some() && !has_lights {
        made.warnings.push(
            "--light-radius changes nothing here: only glTF files have lights without extent"
                .to_owned(),
        );
    }
    Ok(made)
}

fn generated(mut builder: Builder, max_area: f64, settings: &Settings) -> Result<Made, GenxError> {
    let mut parts = builder.parts();
    parts.change(&settings.changes)?;
    let opening = openings::mark(&mut parts, &settings.openings)?;
    let openings = openings::take_out(&mut parts, opening);
    let scene = builder
        .finish(settings.max_area.unwrap_or(max_area))?
        .with_openings(openings)?;
    // The program's own models are in metres.
    let axes = ModelAxes {
        up: settings.up,
        ..ModelAxes::default()
    };
    Ok(Made {
        scene: scene.with_axes(axes)?,
        warnings: Vec::new(),
        imported: None,
        files: Vec::new(),
    })
}

/// The colour of a surface: its own, unless the settings make everything grey.
fn reflectance_or(settings: &Settings, own: Rgb) -> Rgb {
    settings.reflectance.map_or(own, Rgb::splat)
}

/// The exitance of a lamp: the default power in its own tint, unless the settings give one.
fn emission_or(settings: &Settings, tint: Rgb) -> Rgb {
    settings
        .light_power
        .map_or(tint * DEFAULT_LIGHT_POWER, Rgb::splat)
}

/// Applies the settings to materials that have reflectances and emissions already.
fn override_materials(materials: &mut [Material], settings: &Settings) {
    if let Some(reflectance) = settings.reflectance {
        for material in materials.iter_mut().filter(|m| !m.is_emitter()) {
            material.reflectance = Rgb::splat(reflectance);
        }
    }
    let brightest = materials
        .iter()
        .map(|m| m.emission.max_element())
        .fold(0.0, f32::max);
    if let Some(power) = settings.light_power
        && brightest > 0.0
    {
        for material in materials {
            // In f64 no product overflows, and the brightest channel becomes exactly the power.
            material.emission = (material.emission.as_dvec3()
                * (f64::from(power) / f64::from(brightest)))
            .as_vec3();
        }
    }
}
