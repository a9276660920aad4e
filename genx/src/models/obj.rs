//! Import of OBJ files.

use std::path::Path;

use scene::obj::ObjFault;
use scene::{Scene, SceneError, Surface};

use super::override_materials;
use crate::{GenxError, Imported, Made, Settings};

/// The default area threshold is the model's area over this: at least so many patches, enough to
/// show light and shadow in a small model, and no change to one that is finer already.
const DEFAULT_PATCHES: f64 = 4000.0;

pub fn import(path: &Path, settings: &Settings) -> Result<Made, GenxError> {
    let scene::obj::ObjModel {
        mut materials,
        objects,
        surfaces,
        faces,
        origin,
        report,
    } = match settings.reflectance {
        Some(reflectance) => scene::obj::load_with_reflectance(path, reflectance)?,
        None => scene::obj::load(path).map_err(|error| match error.fault {
            ObjFault::Material(SceneError::Reflectance { .. }) => GenxError::Reflectance(error),
            _ => error.into(),
        })?,
    };
    override_materials(&mut materials, settings);
    let max_area = settings
        .max_area
        .unwrap_or_else(|| surfaces.iter().map(Surface::area).sum::<f64>() / DEFAULT_PATCHES);
    let scene = Scene::with_max_area(materials, objects, surfaces, max_area, origin)?;
    Ok(Made {
        scene: scene.with_faces(faces)?,
        warnings: report.warnings,
        imported: Some(Imported {
            faces: report.faces,
            polygons: report.polygons,
        }),
    })
}
