//! Import of Wavefront OBJ models with their MTL materials.
//!
//! # What is taken
//! - Vertices and polygons. Polygons are fanned from their first corner, or where that overlaps, as
//!   in most concave ones, cut by their ears (`polygon.rs`); triangles come in file order. Normals and texture coordinates are ignored: the winding decides the front.
//! - A name ends before a `#` that follows a space; inside a word it is part of the name.
//! - `o` and `g` alike name objects; equal names are one object.
//! - `Kd` is the reflectance, `Ke` the emission (exitance, W/m^2). Where a material, its `Kd` or
//!   its file is missing, the reflectance is a grey of 0.5, and a warning names what is missing.
//!   Only materials that faces use are kept, in the order of their first use.
//!
//! # What is reported
//! - A polygon counts as non-planar if a corner lies farther than 1e-4 of the polygon's extent from
//!   its mean plane. It is fanned all the same, as is one that crosses itself; a warning counts
//!   those whose triangles overlap.
//! - Triangles without area beyond f32 rounding are dropped and counted.
//!
//! # Positions
//! Positions are f64 until the origin is subtracted, then f32. The origin is the middle of the
//! bounding box of all faces, rounded by axis to a multiple of a power of two q which is at least
//! the largest extent. So a model that has a corner at or surrounds zero keeps its coordinates
//! bit for bit, no coordinate exceeds q, and what is exported imports to the same origin.
//!
//! # How
//! [`tobj`] resolves groups, materials and vertices. It panics on some inputs (an MTL colour of two
//! numbers, a texture index far below zero), takes polylines for polygons and does not say where
//! an error is, so `screen.rs` and `mtl.rs` check every line first and pass on a plain form of
//! what is used.

mod build;
mod error;
mod mtl;
mod polygon;
mod screen;

use std::path::Path;

use glam::DVec3;

pub use error::{ObjError, ObjFault};
pub(crate) use screen::comment_start;

use crate::{Material, Scene, SceneError, Surface};

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
    /// What was noticed.
    pub report: ImportReport,
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
            ..
        } = self;
        Scene::with_max_area(materials, objects, surfaces, max_area, origin)?.with_faces(faces)
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
    load_with(path, None)
}

/// Reads an OBJ file and the MTL files it names, with one reflectance (dimensionless, in [0, 1))
/// for all materials that do not emit, whatever their `Kd`.
///
/// # Errors
/// As [`load`]; of the materials that do not emit, only the emission is judged.
pub fn load_with_reflectance(path: &Path, reflectance: f32) -> Result<ObjModel, ObjError> {
    load_with(path, Some(reflectance))
}

/// Reads the text of an OBJ file and that of the one MTL file that it may name. `name` is what errors call them.
///
/// # Errors
/// As [`load`].
pub fn parse(name: &Path, obj: &[u8], mtl: &[u8]) -> Result<ObjModel, ObjError> {
    build(name, obj, None, |_, _| mtl::Library::of(name, mtl))
}

fn load_with(path: &Path, reflectance: Option<f32>) -> Result<ObjModel, ObjError> {
    let bytes =
        std::fs::read(path).map_err(|source| ObjError::new(path, ObjFault::Io { source }))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    build(path, &bytes, reflectance, |libraries, warnings| {
        mtl::Library::load(folder, libraries, warnings)
    })
}

/// The model of a text, with the materials of the libraries that it names.
fn build(
    path: &Path,
    bytes: &[u8],
    reflectance: Option<f32>,
    library: impl FnOnce(&[String], &mut Vec<String>) -> Result<mtl::Library, ObjError>,
) -> Result<ObjModel, ObjError> {
    let fail = |fault| ObjError::new(path, fault);
    let screened = screen::screen(bytes).map_err(fail)?;

    let mut report = ImportReport {
        faces: screened.face_lines.len(),
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
    let library = library(&screened.libraries, &mut report.warnings)?;
    let mut materials =
        library.materials_for(&screened.used_materials, reflectance, &mut report.warnings)?;
    if screened.faces_without_material > 0 {
        let grey = reflectance.unwrap_or(mtl::GREY);
        report.warnings.push(format!(
            "{} of {} faces have no material; they are grey with reflectance {}",
            screened.faces_without_material, report.faces, grey
        ));
        materials.push(mtl::grey("default", grey));
    }

    let models = screened.parse().map_err(|e| fail(ObjFault::Parser(e)))?;
    build::build(&models, &screened.face_lines, materials, report).map_err(fail)
}
