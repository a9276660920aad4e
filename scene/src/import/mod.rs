//! What imports of all formats have in common: the model that they yield, what can be asked of them, and what is done to
//! triangles whatever file they come from.
//!
//! # Positions
//! Positions are f64, multiplied by their unit, until the origin is subtracted, then f32. The origin is the middle of the
//! bounding box of all faces, rounded by axis to a multiple of a power of two q which is at least
//! the largest extent. So a model that has a corner at or surrounds zero keeps its coordinates
//! bit for bit, no coordinate exceeds q, and what is exported imports to the same origin.
//!
//! # What is left out
//! - Triangles without area beyond f32 rounding, and those that lie where another one lies and face the same way: the
//!   brightest lamp stays, whatever the order.
//! - Faces of materials that are wholly transparent.
//! - All optical properties but diffuse reflectance and emission; each material's are told in one line.

mod draft;
pub(crate) mod files;
mod looks;
pub(crate) mod origin;
mod part;
mod reflectance;
mod repairs;
mod terms;
mod texels;
mod texture;
mod texture_mean;
mod wrap;

use std::path::PathBuf;

use glam::DVec3;

pub(crate) use draft::{Draft, Piece};
pub(crate) use looks::{Coordinates, Looks, Place, Taken, Textured, left_out};
pub(crate) use reflectance::{GREY, check};
pub(crate) use terms::Terms;
pub(crate) use texture::Picture;
pub(crate) use wrap::Wrap;

use crate::{Material, ModelAxes, Scene, SceneError, Surface};

/// An imported model, ready for [`crate::Scene::with_max_area`] and [`crate::Scene::with_faces`].
#[derive(Clone, Debug, PartialEq)]
pub struct ImportedModel {
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
    /// All files that were read, or asked for, beside the model's own.
    pub files: Vec<PathBuf>,
}

/// How a model is taken.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImportOptions {
    /// One reflectance, dimensionless, in [0, 1), for all materials that do not emit, whatever the file says.
    pub reflectance: Option<f32>,
    /// The largest reflectance, dimensionless, in [0, 1); where it is not given, what is 1 or more, which no surface can
    /// reflect, is taken as 0.95, and all else as it is.
    pub max_reflectance: Option<f32>,
    /// Names of materials whose reflectances the caller replaces: what is taken for theirs is not told.
    pub repainted: Vec<String>,
    /// Which side of a face is its front.
    pub orient: Orient,
    /// What the file's coordinates are.
    pub axes: ModelAxes,
    /// The radius of the bodies that stand in for lights without extent, metres, finite and above 0; where it is not given,
    /// 0.01. OBJ files have no such lights.
    pub light_radius: Option<f64>,
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

impl ImportedModel {
    /// The scene of this model, whose surfaces are bisected until patches have at most `max_area`, m^2; infinity keeps
    /// every triangle as one patch.
    ///
    /// # Errors
    /// More patches than a scene may have, and an area that is not above 0.
    pub fn into_scene(self, max_area: f64) -> Result<Scene, SceneError> {
        self.meshed(|materials, objects, surfaces, origin| {
            Scene::with_max_area(materials, objects, surfaces, max_area, origin)
        })
    }

    /// The scene of this model, each of whose surfaces is bisected as often as `depths` says.
    ///
    /// # Errors
    /// More patches than a scene may have, a surface that is bisected too often, and another number of depths.
    pub fn into_scene_of_depths(self, depths: &[u32]) -> Result<Scene, SceneError> {
        self.meshed(|materials, objects, surfaces, origin| {
            Scene::new(materials, objects, surfaces, depths, origin)
        })
    }

    fn meshed(
        self,
        mesh: impl FnOnce(Vec<Material>, Vec<String>, Vec<Surface>, DVec3) -> Result<Scene, SceneError>,
    ) -> Result<Scene, SceneError> {
        mesh(self.materials, self.objects, self.surfaces, self.origin)?
            .with_faces(self.faces)?
            .with_axes(self.axes)
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
    /// Statements or primitives that draw points or lines.
    pub points_and_lines_ignored: usize,
    /// Messages for the user, without the file's name.
    pub warnings: Vec<String>,
}
