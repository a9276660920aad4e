//! All values of all patches as a table (RFC 4180, lines end in LF).

use std::borrow::Cow;
use std::path::Path;

use super::patches;
use crate::file::{FileError, write_atomically};
use crate::{Rgb, Scene, Solution};

/// The first line.
pub const HEADER: &str = "patch,surface,material,cx,cy,cz,area,nx,ny,nz,\
    rho_r,rho_g,rho_b,emission_r,emission_g,emission_b,\
    irradiance_r,irradiance_g,irradiance_b,radiosity_r,radiosity_g,radiosity_b,face,object,inside,error";

/// Writes one row a patch, in patch order.
///
/// The centroid is in the model's own coordinates, metres, the area in m^2, the normal a unit
/// vector, reflectance dimensionless, the rest W/m^2. Every number has the digits that lead back to
/// the same value: f64 for centroid and area, f32 for all else. Without a solution the irradiance
/// is 0. The face is the triangle of the imported file that the patch lies in, see
/// [`Scene::with_faces`], the object its name; inside is 1 where the patch is known to lie inside of a solid, else 0, see
/// [`Scene::with_inside`]; error the estimate of that of the radiosity, W/m^2, see [`Solution::error`], and empty where there is
/// none.
pub fn save(path: &Path, scene: &Scene, solution: Option<&Solution>) -> Result<(), FileError> {
    let dark;
    let solution = if let Some(solution) = solution {
        solution
    } else {
        dark = Solution::dark(scene);
        &dark
    };
    solution.validate(scene).map_err(|error| FileError {
        path: path.to_owned(),
        fault: error.into(),
    })?;
    let irradiance = solution.mean_irradiance(scene);
    let radiosity = solution.mean_radiosity(scene);
    let is_inside = scene.is_inside();
    let error = solution.error();
    write_atomically(path, |out| {
        writeln!(out, "{HEADER}")?;
        let values = irradiance.iter().zip(&radiosity);
        for ((index, patch), (irradiance, radiosity)) in patches(scene).enumerate().zip(values) {
            let surface = scene.surface(patch.surface);
            let material = scene.material(surface.material);
            let center = scene.to_model(patch.centroid());
            let normal = surface.normal().as_vec3();
            write!(
                out,
                "{index},{},{},{},{},{},{}",
                patch.surface.0,
                quoted(&material.name),
                center.x,
                center.y,
                center.z,
                patch.area
            )?;
            for Rgb { x, y, z } in [
                normal,
                material.reflectance,
                material.emission,
                *irradiance,
                *radiosity,
            ] {
                write!(out, ",{x},{y},{z}")?;
            }
            let face = scene.faces()[patch.surface.index()];
            let object = quoted(scene.object(surface.object));
            write!(out, ",{face},{object},{},", u8::from(is_inside[index]))?;
            match error {
                Some(error) => writeln!(out, "{}", error[index])?,
                None => writeln!(out)?,
            }
        }
        Ok(())
    })
}

/// A field, in quotes where it needs them.
pub fn quoted(field: &str) -> Cow<'_, str> {
    if field.contains([',', '"', '\n', '\r']) {
        Cow::Owned(format!("\"{}\"", field.replace('"', "\"\"")))
    } else {
        Cow::Borrowed(field)
    }
}
