//! Import of Wavefront OBJ models with their MTL materials.
//!
//! # What is taken
//! - Vertices and polygons. Polygons are fanned from their first corner, or where that overlaps, as
//!   in most concave ones, cut by their ears (`polygon.rs`); triangles come in file order. The winding decides the front;
//!   normals only say where a minority of faces is wound the wrong way (`import/repairs.rs`).
//! - Names of materials and objects, byte by byte; those that differ anywhere are different (`lines.rs`). What follows a `#`
//!   behind a material's name is a comment only where the library has no such name without cutting it.
//! - `o` and `g` alike name objects; equal names are one object. Without any, the materials are the objects.
//! - `Kd` is the reflectance, `Ke` the emission (exitance, W/m^2); of two definitions of a name the first counts. A
//!   reflectance of 1 or more is 0.95. Where a material, its `Kd` or its file is missing, the reflectance is a grey of 0.5.
//!   Only materials that faces use are kept, in the order of their first use.
//! - `map_Kd`: a triangle reflects `Kd` times the mean of its part of the picture (`import/texture.rs`), which makes as many
//!   materials of one name as there are means.
//!
//! What is left out, and which origin positions have, [`crate::import`] says; wholly transparent is `d 0`.
//!
//! A polygon counts as non-planar if a corner lies farther than 1e-4 of the polygon's extent from
//! its mean plane. It is fanned all the same, as is one that crosses itself; a warning counts
//! those whose triangles overlap.
//!
//! # How
//! [`tobj`] resolves groups, materials and vertices. It panics on some inputs (a texture index far below zero), takes polylines
//! for polygons, knows no names but UTF-8 and does not say where an error is, so `screen.rs` checks every line first and
//! passes on a plain form of what is used, with numbers for names. MTL files are read here (`mtl.rs`).

mod build;
mod error;
mod files;
mod lines;
mod mtl;
mod polygon;
mod screen;

use std::path::Path;

pub use error::{ObjError, ObjFault};

use crate::import::{ImportOptions, ImportReport, ImportedModel};
use mtl::Library;

/// Reads an OBJ file and the MTL files it names.
///
/// # Errors
/// Name the file, and the line, vertex or material at fault; see [`ObjFault`].
pub fn load(path: &Path) -> Result<ImportedModel, ObjError> {
    load_with(path, &ImportOptions::default())
}

/// The same, as the options say.
///
/// # Errors
/// As [`load`].
pub fn load_with(path: &Path, options: &ImportOptions) -> Result<ImportedModel, ObjError> {
    let bytes =
        std::fs::read(path).map_err(|source| ObjError::new(path, ObjFault::Io { source }))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    build(path, &bytes, options, |libraries, warnings| {
        Library::load(folder, libraries, warnings)
    })
}

/// Reads the text of an OBJ file and that of the one MTL file that it may name. `name` is what errors call them.
///
/// # Errors
/// As [`load`].
pub fn parse(name: &Path, obj: &[u8], mtl: &[u8]) -> Result<ImportedModel, ObjError> {
    build(name, obj, &ImportOptions::default(), |_, warnings| {
        let mut library = Library::default();
        library.add(name, mtl, warnings)?;
        Ok(library)
    })
}

/// The model of a text, with the materials of the libraries that it names.
fn build(
    path: &Path,
    bytes: &[u8],
    options: &ImportOptions,
    library: impl FnOnce(&[Vec<u8>], &mut Vec<String>) -> Result<Library, ObjError>,
) -> Result<ImportedModel, ObjError> {
    let fail = |fault| ObjError::new(path, fault);
    let screened = screen::screen(bytes).map_err(fail)?;
    let mut report = ImportReport {
        faces: screened.faces.len(),
        points_and_lines_ignored: screened.points_and_lines,
        ..ImportReport::default()
    };
    if let Some(line) = screened.first_short_face {
        report.warnings.push(format!(
            "{} of {} faces have fewer than three corners (the first in line {line}); these are left out",
            screened.short_faces,
            report.faces + screened.short_faces,
        ));
    }
    if let Some(line) = screened.first_bad_number {
        report.warnings.push(format!(
            "{} normals or texture coordinates are no finite numbers (the first in line {line}); they are left out",
            screened.bad_numbers
        ));
    }
    let library = library(&screened.libraries, &mut report.warnings)?;
    let materials = library.materials_for(&screened.materials, options, &mut report.warnings)?;
    let mut model = build::build(&screened, materials, options, report).map_err(fail)?;
    model.files.extend(library.into_files());
    Ok(model)
}
