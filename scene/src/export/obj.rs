//! The patches as a Wavefront OBJ with its MTL, for other radiosity programs and for a new import.
//!
//! `Kd` is the reflectance, `Ke` the emission (exitance, W/m^2), as [`crate::obj`] reads them.
//! Imported again without subdivision, face i is patch i with the same corners, materials and
//! objects. Irradiances have no place in this format: see [`super::csv`].

use std::collections::HashSet;
use std::ffi::OsStr;
use std::io::Read;
use std::path::{Path, PathBuf};

use glam::DVec3;

use super::{original, patches};
use crate::Scene;
use crate::file::{FileError, FileFault, write_atomically};
use crate::weld::Vertices;

/// The first line of a material file, by which an export knows those that it may replace.
const MARK: &str = "# materials of a radiosity export";

/// The material file of an OBJ: the same name ending in `.mtl`.
pub fn material_path(path: &Path) -> PathBuf {
    path.with_extension("mtl")
}

/// Writes one face a patch, in patch order, and the materials to [`material_path`].
///
/// A material file that no export has written is not replaced: then nothing is written.
///
/// Positions are the model's own coordinates, metres, with all digits of the f64. Names that would
/// not survive the format are changed: outer spaces go, line breaks become `_`, and a material or an object whose
/// name another one has gets a number.
pub fn save(path: &Path, scene: &Scene) -> Result<(), FileError> {
    let material_path = material_path(path);
    if !is_free(&material_path) {
        let fault = FileFault::ForeignMaterials;
        return Err(FileError::new(&material_path, fault));
    }
    let names = scene.materials().iter().map(|material| &material.name[..]);
    let names = unique(names, "material");
    let objects = unique(scene.objects().iter().map(String::as_str), "object");
    // First, so that an OBJ never names an MTL that is not there.
    write_atomically(&material_path, |out| {
        writeln!(out, "{MARK}")?;
        for (material, name) in scene.materials().iter().zip(&names) {
            let (rho, emission) = (material.reflectance, material.emission);
            writeln!(out, "newmtl {name}")?;
            writeln!(out, "Kd {} {} {}", rho.x, rho.y, rho.z)?;
            writeln!(out, "Ke {} {} {}", emission.x, emission.y, emission.z)?;
        }
        Ok(())
    })?;
    write_atomically(path, |out| {
        let library = material_path.file_name().map(OsStr::to_string_lossy);
        writeln!(out, "mtllib {}", library.unwrap_or_default())?;
        // Those written so far, so that neighbours share theirs.
        let mut vertices = Vertices::default();
        let (mut object, mut material) = (None, None);
        for patch in patches(scene) {
            let surface = scene.surface(patch.surface);
            if object.replace(surface.object) != Some(surface.object) {
                writeln!(out, "o {}", objects[surface.object.index()])?;
            }
            if material.replace(surface.material) != Some(surface.material) {
                writeln!(out, "usemtl {}", names[surface.material.index()])?;
            }
            let mut face = [0; 3];
            for (index, corner) in face.iter_mut().zip(patch.corners) {
                let count = vertices.count();
                let vertex = vertices.index(corner);
                if vertex == count {
                    let DVec3 { x, y, z } = original(scene, corner);
                    writeln!(out, "v {x} {y} {z}")?;
                }
                // Counted from 1.
                *index = vertex + 1;
            }
            writeln!(out, "f {} {} {}", face[0], face[1], face[2])?;
        }
        Ok(())
    })
}

/// Whether there is no such file, an empty one, or one of an earlier export.
fn is_free(material_path: &Path) -> bool {
    let mut start = Vec::new();
    match std::fs::File::open(material_path) {
        Ok(file) => {
            let read = file.take(MARK.len() as u64).read_to_end(&mut start);
            read.is_ok() && (start.is_empty() || start == MARK.as_bytes())
        }
        Err(error) => error.kind() == std::io::ErrorKind::NotFound,
    }
}

/// Names that an OBJ file can hold, all different.
fn unique<'a>(names: impl Iterator<Item = &'a str>, if_empty: &str) -> Vec<String> {
    let mut taken = HashSet::new();
    names
        .map(|name| {
            let base = plain(name, if_empty);
            let mut name = base.clone();
            let mut number = 1;
            while !taken.insert(name.clone()) {
                number += 1;
                name = format!("{base}_{number}");
            }
            name
        })
        .collect()
}

/// A name that a line of an OBJ file can hold.
fn plain(name: &str, if_empty: &str) -> String {
    let trimmed = name.trim();
    if trimmed.is_empty() {
        return if_empty.to_owned();
    }
    trimmed.replace(char::is_control, "_")
}
