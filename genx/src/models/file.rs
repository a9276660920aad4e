//! Import of files.

use std::path::Path;

use glam::DVec3;
use scene::Surface;
use scene::import::ImportedModel;

use super::override_materials;
use crate::changes::Parts;
use crate::{Format, GenxError, Imported, Made, Settings};
use crate::{cut, extent, openings};

/// The default area threshold is the model's area over this: at least so many patches, enough to
/// show light and shadow in a small model, and no change to one that is finer already.
const DEFAULT_PATCHES: f64 = 4000.0;

pub fn import(format: Format, path: &Path, settings: &Settings) -> Result<Made, GenxError> {
    let options = settings.import();
    let mut model = match format {
        Format::Obj => scene::obj::load_with(path, &options)?,
        Format::Gltf => scene::gltf::load_with(path, &options)?,
    };
    override_materials(&mut model.materials, settings);
    let mut parts = parts_of(&mut model);
    parts.change(&settings.changes)?;
    let opening = openings::mark(&mut parts, &settings.openings)?;
    let uncut = cut::Uncut::new(parts.surfaces);
    let overlaps = cut::put_in_order(
        cut::Model {
            surfaces: &mut model.surfaces,
            faces: &mut model.faces,
            materials: &model.materials,
            objects: &model.objects,
            opening,
        },
        settings.cut,
    )?;
    let openings = openings::take_out(&mut parts_of(&mut model), opening);
    let max_area = settings.max_area.unwrap_or_else(|| {
        let area: f64 = model.surfaces.iter().map(Surface::area).sum();
        area / DEFAULT_PATCHES
    });
    let report = std::mem::take(&mut model.report);
    let mut files = std::mem::take(&mut model.files);
    files.push(path.to_owned());
    let scene = match uncut.bisections(&model.surfaces, max_area) {
        Some(depths) => model.into_scene_of_depths(&depths)?,
        None => model.into_scene(max_area)?,
    }
    .with_openings(openings)?;
    extent::check(&scene)?;
    let mut warnings = report.warnings;
    warnings.extend(overlaps);
    let extent = extent::of(&scene);
    if settings.unit.is_none()
        && let Some(unit) = extent::likely_unit(extent)
    {
        let DVec3 { x, y, z } = extent;
        warnings.push(format!(
            "the model is {x:.0} x {y:.0} x {z:.0} m large: are its coordinates in {unit}? then give --unit {unit}"
        ));
    }
    Ok(Made {
        scene,
        warnings,
        imported: Some(Imported {
            faces: report.faces,
            polygons: report.polygons,
        }),
        files,
    })
}

/// What of a model may still change.
fn parts_of(model: &mut ImportedModel) -> Parts<'_> {
    Parts {
        materials: &mut model.materials,
        objects: &model.objects,
        surfaces: &mut model.surfaces,
        faces: Some(&mut model.faces),
    }
}
