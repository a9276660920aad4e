//! Irradiance as a function over surfaces: values at the vertices of a mesh, linear between them.
//!
//! A patch's irradiance is one number. What an eye sees is a function, and this is it: continuous inside of a wall, with a step at
//! its edges, at contact lines and where materials change (Cohen and Wallace, "Radiosity and Realistic Image
//! Synthesis", 1993, chapter 3, linear elements). Surfaces without vertices, such as the small facets of curved bodies, have
//! what their patches have.

mod mesh;
mod refinement;

pub use mesh::{Node, VertexMesh};
pub use refinement::{NodeId, Refinement, VertexId};

use crate::{PatchId, Rgb, Scene, SceneError, SurfaceId};

/// The irradiance at every point of a scene's surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct IrradianceFunction {
    mesh: VertexMesh,
    /// One per vertex, W/m^2.
    irradiance: Vec<Rgb>,
    /// The part of it that comes from emitters without reflection, one per vertex, W/m^2.
    direct: Vec<Rgb>,
    /// See [`Self::error`].
    error: Vec<f32>,
}

impl IrradianceFunction {
    /// A function with these values at the vertices of a mesh, W/m^2.
    ///
    /// # Errors
    /// More or fewer values than vertices, and such as are negative or not finite.
    pub fn new(
        mesh: VertexMesh,
        irradiance: Vec<Rgb>,
        direct: Vec<Rgb>,
    ) -> Result<Self, SceneError> {
        let vertices = mesh.vertex_count();
        for values in [&irradiance, &direct] {
            if values.len() != vertices as usize {
                return Err(SceneError::VertexValues {
                    values: values.len(),
                    vertices,
                });
            }
            let is_wrong = |value: f32| !(value.is_finite() && value >= 0.0);
            for (vertex, value) in (0..).zip(values) {
                if let Some(value) = value.to_array().into_iter().find(|&value| is_wrong(value)) {
                    return Err(SceneError::VertexValue { vertex, value });
                }
            }
        }
        Ok(Self {
            mesh,
            irradiance,
            direct,
            error: Vec::new(),
        })
    }

    /// The same function with an estimate of its error, one per patch, see [`Self::error`].
    ///
    /// # Errors
    /// An estimate that is negative or not finite.
    pub fn with_error(self, error: Vec<f32>) -> Result<Self, SceneError> {
        let is_wrong = |value: f32| !(value.is_finite() && value >= 0.0);
        match (0..).zip(&error).find(|&(_, &value)| is_wrong(value)) {
            Some((patch, &value)) => Err(SceneError::PatchError { patch, value }),
            None => Ok(Self { error, ..self }),
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &VertexMesh {
        &self.mesh
    }

    /// Irradiance at the vertices, W/m^2.
    pub fn irradiance(&self) -> &[Rgb] {
        &self.irradiance
    }

    /// What of it comes from emitters without reflection, W/m^2.
    pub fn direct(&self) -> &[Rgb] {
        &self.direct
    }

    /// How far its reflected radiosity is estimated to be from what it should be, W/m^2: the root mean square over a patch and
    /// the channels, one per patch; empty where nobody has estimated it.
    pub fn error(&self) -> &[f32] {
        &self.error
    }

    /// The value that is linear between some values at the vertices, one per vertex, at barycentric coordinates in a
    /// surface, which sum to 1; `None` where the surface has what its patches have.
    #[inline]
    pub fn interpolate(
        &self,
        values: &[Rgb],
        surface: SurfaceId,
        barycentric: [f32; 3],
    ) -> Option<Rgb> {
        let (vertices, weights) = self.mesh.locate(surface, barycentric)?;
        Some(
            (0..3)
                .map(|k| weights[k] * values[vertices[k] as usize])
                .sum(),
        )
    }

    /// The mean over a patch of the function that is linear between some values at the vertices, one per vertex; `None`
    /// where the patch's surface has what its patches have.
    pub fn mean_over(&self, scene: &Scene, values: &[Rgb], patch: PatchId) -> Option<Rgb> {
        let surface = scene.mesh().surface_of(patch);
        let tree = scene.mesh().tree(surface);
        self.mesh
            .mean_over(values, surface, tree.depth, patch.0 - tree.first_patch.0)
    }
}
