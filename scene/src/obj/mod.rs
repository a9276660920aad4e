//! Import of Wavefront OBJ models with their MTL materials.
//!
//! # What is taken
//! - Vertices and polygons. Polygons are fanned from their first corner, or where that overlaps, as
//!   in most concave ones, cut by their ears (`polygon.rs`); triangles come in file order. The winding decides the front;
//!   normals only say where a minority of faces is wound the wrong way (`repairs.rs`).
//! - Names of materials and objects, byte by byte; those that differ anywhere are different (`lines.rs`). What follows a `#`
//!   behind a material's name is a comment only where the library has no such name without cutting it.
//! - `o` and `g` alike name objects; equal names are one object. Without any, the materials are the objects.
//! - `Kd` is the reflectance, `Ke` the emission (exitance, W/m^2); of two definitions of a name the first counts. A
//!   reflectance of 1 or more is 0.95. Where a material, its `Kd` or its file is missing, the reflectance is a grey of 0.5.
//!   Only materials that faces use are kept, in the order of their first use.
//! - `map_Kd`: a triangle reflects `Kd` times the mean of its part of the picture (`texture.rs`), which makes as many
//!   materials of one name as there are means.
//!
//! # What is left out
//! - Triangles without area beyond f32 rounding, and those that lie where another one lies and face the same way: the
//!   brightest lamp stays, whatever the order.
//! - Faces of materials that are wholly transparent (`d 0`).
//! - All other optical properties; each material's are told in one line.
//!
//! A polygon counts as non-planar if a corner lies farther than 1e-4 of the polygon's extent from
//! its mean plane. It is fanned all the same, as is one that crosses itself; a warning counts
//! those whose triangles overlap.
//!
//! # Positions
//! Positions are f64, multiplied by their unit, until the origin is subtracted, then f32. The origin is the middle of the
//! bounding box of all faces, rounded by axis to a multiple of a power of two q which is at least
//! the largest extent. So a model that has a corner at or surrounds zero keeps its coordinates
//! bit for bit, no coordinate exceeds q, and what is exported imports to the same origin.
//!
//! # How
//! [`tobj`] resolves groups, materials and vertices. It panics on some inputs (a texture index far below zero), takes polylines
//! for polygons, knows no names but UTF-8 and does not say where an error is, so `screen.rs` checks every line first and
//! passes on a plain form of what is used, with numbers for names. MTL files are read here (`mtl.rs`).

mod build;
mod error;
mod files;
mod lines;
mod looks;
mod mtl;
mod polygon;
mod repairs;
mod screen;
mod texture;

use std::path::{Path, PathBuf};

use glam::DVec3;

pub use error::{ObjError, ObjFault};

use crate::{Material, ModelAxes, Scene, SceneError, Surface};
use mtl::Library;

/// An imported model, ready for [`crate::Scene::with_max_area`] and [`crate::Scene::with_faces`].
#[derive(Clone, Debug, PartialEq)]
pub struct ObjModel {
    /// Materials that faces use, by first use.
    pub materials: Vec<Material>,
    /// Names of all objects that have faces, by first use.
    pub objects: Vec<String>,
    /// Triangles in file order, relative to `origin`.
    pub surfaces: Vec<Surface>,
    /// Which of the file's triangles each surface is, from 0, those counted that were dropped; one per surface.
    pub faces: Vec<u32>,
    /// What was subtracted from the file's coordinates, metres.
    pub origin: DVec3,
    /// What these coordinates are.
    pub axes: ModelAxes,
    /// What was noticed.
    pub report: ImportReport,
    /// All files that were read, or asked for, beside the OBJ file.
    pub files: Vec<PathBuf>,
}

/// How a model is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// One reflectance, dimensionless, in [0, 1), for all materials that do not emit, whatever their `Kd`.
    pub reflectance: Option<f32>,
    /// The largest reflectance, dimensionless, in [0, 1); where it is not given, what is 1 or more, which no surface can
    /// reflect, is taken as 0.95, and all else as it is.
    pub max_reflectance: Option<f32>,
    /// Which side of a face is its front.
    pub orient: Orient,
    /// What the file's coordinates are.
    pub axes: ModelAxes,
}

/// Which side of a face is its front.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Orient {
    /// That from which it is wound counter-clockwise, but where a minority of the file's area is wound against the file's
    /// own normals, these are right.
    #[default]
    Auto,
    /// That on which the file's own normals are; without normals, as it is wound.
    Normals,
    /// That from which it is wound counter-clockwise.
    Winding,
}

impl ObjModel {
    /// The scene of this model, each of whose surfaces is bisected until its patches have at most `max_area`, m^2;
    /// infinity keeps every triangle as one patch.
    ///
    /// # Errors
    /// More patches than a scene may have, and an area that is not above 0.
    pub fn into_scene(self, max_area: f64) -> Result<Scene, SceneError> {
        let Self {
            materials,
            objects,
            surfaces,
            faces,
            origin,
            axes,
            ..
        } = self;
        Scene::with_max_area(materials, objects, surfaces, max_area, origin)?
            .with_faces(faces)?
            .with_axes(axes)
    }
}

/// What an import did and what it left out.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ImportReport {
    /// Faces with three or more corners.
    pub faces: usize,
    /// Faces with four or more corners.
    pub polygons: usize,
    /// Those among them that are not planar.
    pub non_planar_polygons: usize,
    /// Triangles that were dropped for want of area.
    pub degenerate_dropped: usize,
    /// Triangles that were dropped for another one in their place.
    pub repeated_dropped: usize,
    /// Triangles that were turned to the file's own normals.
    pub turned: usize,
    /// Statements that draw points or lines.
    pub points_and_lines_ignored: usize,
    /// Messages for the user, without the file's name.
    pub warnings: Vec<String>,
}

/// Reads an OBJ file and the MTL files it names.
///
/// # Errors
/// Name the file, and the line, vertex or material at fault; see [`ObjFault`].
pub fn load(path: &Path) -> Result<ObjModel, ObjError> {
    load_with(path, &ImportOptions::default())
}

/// The same, as the options say.
///
/// # Errors
/// As [`load`].
pub fn load_with(path: &Path, options: &ImportOptions) -> Result<ObjModel, ObjError> {
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
pub fn parse(name: &Path, obj: &[u8], mtl: &[u8]) -> Result<ObjModel, ObjError> {
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
) -> Result<ObjModel, ObjError> {
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
