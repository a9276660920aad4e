//! Import of OBJ files.

use std::path::Path;

use scene::Surface;

use super::override_materials;
use crate::changes::Parts;
use crate::{GenxError, Imported, Made, Settings};

/// The default area threshold is the model's area over this: at least so many patches, enough to
/// show light and shadow in a small model, and no change to one that is finer already.
const DEFAULT_PATCHES: f64 = 4000.0;

pub fn import(path: &Path, settings: &Settings) -> Result<Made, GenxError> {
    let mut model = scene::obj::load_with(path, &settings.import())?;
    override_materials(&mut model.materials, settings);
    let mut parts = Parts {
        materials: &mut model.materials,
        objects: &model.objects,
        surfaces: &mut model.surfaces,
    };
    parts.change(&settings.changes)?;
    let max_area = settings.max_area.unwrap_or_else(|| {
        let area: f64 = model.surfaces.iter().map(Surface::area).sum();
        area / DEFAULT_PATCHES
    });
    let report = std::mem::take(&mut model.report);
    let mut files = std::mem::take(&mut model.files);
    files.push(path.to_owned());
    let scene = model.into_scene(max_area)?;
    Ok(Made {
        scene,
        warnings: report.warnings,
        imported: Some(Imported {
            faces: report.faces,
            polygons: report.polygons,
        }),
        files,
    })
}
