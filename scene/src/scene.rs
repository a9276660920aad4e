//! A scene: materials, objects, surfaces and the mesh of patches over them.

use glam::{DVec3, Vec3};

use crate::{
    MAX_PATCHES, Material, MaterialId, Mesh, ModelAxes, ObjectId, PatchId, SceneError, Surface,
    SurfaceId, bisection,
};

/// Linear RGB values: reflectances, or exitances in W/m^2.
pub type Rgb = Vec3;

/// A valid scene: every index in it exists, every number is finite and in its range.
#[derive(Clone, Debug, PartialEq)]
pub struct Scene {
    materials: Vec<Material>,
    objects: Vec<String>,
    surfaces: Vec<Surface>,
    /// One per surface.
    faces: Vec<u32>,
    origin: DVec3,
    axes: ModelAxes,
    mesh: Mesh,
    /// Ascending.
    inside: Vec<PatchId>,
    openings: Vec<Opening>,
}

/// A one-sided triangle that was taken out of a model on purpose: what looks through its front and sees nothing is meant to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Opening {
    /// Corners in metres, relative to the scene's origin, counter-clockwise from the front.
    pub corners: [Vec3; 3],
    /// What it was part of.
    pub object: ObjectId,
}

impl Opening {
    /// Area, m^2.
    pub fn area(&self) -> f64 {
        let [p0, p1, p2] = self.corners.map(Vec3::as_dvec3);
        0.5 * (p1 - p0).cross(p2 - p0).length()
    }
}

/// The geometry of one patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// The surface it is part of.
    pub surface: SurfaceId,
    /// Corners in metres, relative to the scene's origin, counter-clockwise from the front; its
    /// reference edge runs from corner 0 to corner 1.
    pub corners: [Vec3; 3],
    /// Area, m^2.
    pub area: f64,
}

impl Patch {
    /// Mean of the corners, metres.
    pub fn centroid(&self) -> DVec3 {
        self.corners.map(Vec3::as_dvec3).into_iter().sum::<DVec3>() / 3.0
    }
}

impl Scene {
    /// A scene in which each surface is bisected `depths[s]` times.
    ///
    /// The corners of each surface are rotated so that its longest side comes first. `origin` is
    /// what was subtracted from the model's coordinates, metres. The face of a surface is its number.
    pub fn new(
        materials: Vec<Material>,
        objects: Vec<String>,
        surfaces: Vec<Surface>,
        depths: &[u32],
        origin: DVec3,
    ) -> Result<Self, SceneError> {
        if surfaces.is_empty() {
            return Err(SceneError::NoSurfaces);
        }
        if !origin.is_finite() {
            return Err(SceneError::Origin { origin });
        }
        for material in &materials {
            material.validate()?;
        }
        for (index, surface) in surfaces.iter().enumerate() {
            let index = index as u32;
            for value in surface.corners.iter().flat_map(Vec3::to_array) {
                if !value.is_finite() {
                    return Err(SceneError::Coordinate {
                        surface: index,
                        value,
                    });
                }
            }
            if surface.is_degenerate() {
                return Err(SceneError::Degenerate {
                    surface: index,
                    area: surface.area(),
                });
            }
            if surface.material.index() >= materials.len() {
                return Err(SceneError::MaterialIndex {
                    surface: index,
                    material: surface.material.0,
                    count: materials.len(),
                });
            }
            if surface.object.index() >= objects.len() {
                return Err(SceneError::ObjectIndex {
                    surface: index,
                    object: surface.object.0,
                    count: objects.len(),
                });
            }
        }
        if depths.len() != surfaces.len() {
            return Err(SceneError::DepthCount {
                depths: depths.len(),
                surfaces: surfaces.len(),
            });
        }
        let mesh = Mesh::new(depths)?;
        let surfaces: Vec<Surface> = surfaces
            .into_iter()
            .map(Surface::with_longest_side_first)
            .collect();
        Ok(Self {
            materials,
            objects,
            faces: (0..surfaces.len() as u32).collect(),
            surfaces,
            origin,
            axes: ModelAxes::default(),
            mesh,
            inside: Vec::new(),
            openings: Vec::new(),
        })
    }

    /// A scene in which each surface is bisected until its patches have at most `max_area`, m^2;
    /// infinity keeps every surface as one patch.
    pub fn with_max_area(
        materials: Vec<Material>,
        objects: Vec<String>,
        surfaces: Vec<Surface>,
        max_area: f64,
        origin: DVec3,
    ) -> Result<Self, SceneError> {
        if max_area.is_nan() || max_area <= 0.0 {
            return Err(SceneError::AreaThreshold { value: max_area });
        }
        let depths: Option<Vec<u32>> = surfaces
            .iter()
            .map(|s| bisection::bisections_for(s.area(), max_area))
            .collect();
        let Some(depths) = depths else {
            let patches: f64 = surfaces
                .iter()
                .map(|s| (s.area() / max_area).max(1.0))
                .sum();
            return Err(SceneError::TooManyPatches {
                patches: (patches as u64).max(u64::from(MAX_PATCHES) + 1),
            });
        };
        Self::new(materials, objects, surfaces, &depths, origin)
    }

    /// The same scene with other materials, and of which each surface is.
    pub(crate) fn with_materials(
        &self,
        materials: Vec<Material>,
        of_surface: impl Fn(SurfaceId) -> MaterialId,
    ) -> Result<Self, SceneError> {
        for material in &materials {
            material.validate()?;
        }
        let mut scene = self.clone();
        scene.materials = materials;
        for (index, surface) in (0..).map(SurfaceId).zip(&mut scene.surfaces) {
            surface.material = of_surface(index);
            if surface.material.index() >= scene.materials.len() {
                return Err(SceneError::MaterialIndex {
                    surface: index.0,
                    material: surface.material.0,
                    count: scene.materials.len(),
                });
            }
        }
        Ok(scene)
    }

    /// The same scene, whose surfaces are these triangles of an imported file, one per surface, in surface order: polygons
    /// are cut, and all triangles counted from 0 in file order, those too that are no surface for want of area.
    pub fn with_faces(self, faces: Vec<u32>) -> Result<Self, SceneError> {
        if faces.len() != self.surfaces.len() {
            return Err(SceneError::FaceCount {
                faces: faces.len(),
                surfaces: self.surfaces.len(),
            });
        }
        Ok(Self { faces, ..self })
    }

    /// The same scene, of a model whose coordinates are these; so far they were metres.
    ///
    /// # Errors
    /// A unit that is none.
    pub fn with_axes(self, axes: ModelAxes) -> Result<Self, SceneError> {
        Ok(Self {
            axes: axes.validate()?,
            ..self
        })
    }

    /// The same scene with coarser patches: surface s is bisected `min(bisections(s), its own)` times, so that
    /// every patch of this scene is part of one of that.
    #[must_use]
    pub fn coarsened(&self, bisections: impl Fn(SurfaceId, u32) -> u32) -> Self {
        let ids = (0..).map(SurfaceId);
        let depths: Vec<u32> = ids
            .zip(self.mesh.trees())
            .map(|(id, tree)| bisections(id, tree.depth).min(tree.depth))
            .collect();
        Self {
            // With fewer patches than before it cannot fail.
            mesh: Mesh::new(&depths).unwrap_or_else(|_| self.mesh.clone()),
            inside: Vec::new(),
            ..self.clone()
        }
    }

    /// The same scene with finer patches: surface s is bisected `max(bisections(s, its own), its own)` times, so that every patch of
    /// that is one of this scene or several.
    ///
    /// # Errors
    /// More patches than there may be.
    pub fn refined(&self, bisections: impl Fn(SurfaceId, u32) -> u32) -> Result<Self, SceneError> {
        let ids = (0..).map(SurfaceId);
        let depths: Vec<u32> = ids
            .zip(self.mesh.trees())
            .map(|(id, tree)| bisections(id, tree.depth).max(tree.depth))
            .collect();
        Ok(Self {
            mesh: Mesh::new(&depths)?,
            inside: Vec::new(),
            ..self.clone()
        })
    }

    /// The same scene, of which it is known that these patches, ascending, lie inside of solids: they are never lit, nobody
    /// sees them, and they have no part in means, errors or interpolation. Without this none is known to.
    ///
    /// # Errors
    /// Patches that are none, or in another order.
    pub fn with_inside(self, inside: Vec<PatchId>) -> Result<Self, SceneError> {
        let patches = self.patch_count();
        let is_wrong = |&k: &usize| inside[k].0 >= patches || k > 0 && inside[k] <= inside[k - 1];
        match (0..inside.len()).find(is_wrong) {
            Some(k) => Err(SceneError::Inside {
                patch: inside[k].0,
                patches,
            }),
            None => Ok(Self { inside, ..self }),
        }
    }

    /// The same scene, whose holes in these places are meant. Without this none is known to be.
    ///
    /// # Errors
    /// Corners that are not finite, and objects that do not exist.
    pub fn with_openings(self, openings: Vec<Opening>) -> Result<Self, SceneError> {
        let is_wrong = |opening: &Opening| {
            let is_finite = opening.corners.iter().all(|corner| corner.is_finite());
            !is_finite || opening.object.index() >= self.objects.len()
        };
        match openings.iter().position(is_wrong) {
            Some(opening) => Err(SceneError::Opening {
                opening: opening as u32,
            }),
            None => Ok(Self { openings, ..self }),
        }
    }

    /// All materials.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// Names of all objects.
    pub fn objects(&self) -> &[String] {
        &self.objects
    }

    /// All surfaces.
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// The triangle of the imported file that each surface is, see [`Self::with_faces`]; the surface's number in a scene
    /// that is no import. One per surface.
    pub fn faces(&self) -> &[u32] {
        &self.faces
    }

    /// The patches that lie inside of solids, ascending, see [`Self::with_inside`].
    pub fn inside(&self) -> &[PatchId] {
        &self.inside
    }

    /// What was taken out of the model on purpose, see [`Self::with_openings`].
    pub fn openings(&self) -> &[Opening] {
        &self.openings
    }

    /// Whether each patch lies inside of a solid, one per patch.
    pub fn is_inside(&self) -> Vec<bool> {
        let mut is_inside = vec![false; self.patch_count() as usize];
        for patch in &self.inside {
            is_inside[patch.index()] = true;
        }
        is_inside
    }

    /// What was subtracted from the model's coordinates, metres.
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// What the model's own coordinates are.
    pub fn axes(&self) -> ModelAxes {
        self.axes
    }

    /// A place in the model's own coordinates, of one in the scene, metres.
    pub fn to_model(&self, place: DVec3) -> DVec3 {
        (place + self.origin) / self.axes.unit
    }

    /// A place in the scene, metres, of one in the model's own coordinates.
    pub fn to_scene(&self, place: DVec3) -> DVec3 {
        place * self.axes.unit - self.origin
    }

    /// The patches over the surfaces.
    pub fn mesh(&self) -> &Mesh {
        &self.mesh
    }

    /// Number of patches.
    pub fn patch_count(&self) -> u32 {
        self.mesh.patch_count()
    }

    /// One surface.
    pub fn surface(&self, surface: SurfaceId) -> &Surface {
        &self.surfaces[surface.index()]
    }

    /// One material.
    pub fn material(&self, material: MaterialId) -> &Material {
        &self.materials[material.index()]
    }

    /// Name of one object.
    pub fn object(&self, object: ObjectId) -> &str {
        &self.objects[object.index()]
    }

    /// The material of a patch.
    pub fn patch_material(&self, patch: PatchId) -> &Material {
        self.material(self.surface(self.mesh.surface_of(patch)).material)
    }

    /// Corners of a patch as barycentric coordinates in its surface, in the order of [`Patch::corners`]. They are
    /// dyadic fractions, hence exact.
    pub fn patch_in_surface(&self, patch: PatchId) -> [DVec3; 3] {
        let tree = self.mesh.tree(self.mesh.surface_of(patch));
        bisection::leaf_corners(tree.depth, patch.0 - tree.first_patch.0)
    }

    /// The geometry of a patch.
    pub fn patch(&self, patch: PatchId) -> Patch {
        let surface = self.mesh.surface_of(patch);
        let tree = self.mesh.tree(surface);
        let root = self.surface(surface);
        let corners = root.corners.map(Vec3::as_dvec3);
        Patch {
            surface,
            corners: bisection::leaf_corners(tree.depth, patch.0 - tree.first_patch.0)
                .map(|w| (w.x * corners[0] + w.y * corners[1] + w.z * corners[2]).as_vec3()),
            area: root.area() / f64::from(1_u32 << tree.depth),
        }
    }

    /// Areas of all patches, m^2.
    pub fn patch_areas(&self) -> Vec<f64> {
        self.per_patch(|surface, leaves| surface.area() / leaves)
    }

    /// Reflectances of all patches, dimensionless.
    pub fn patch_reflectances(&self) -> Vec<Rgb> {
        self.per_patch(|surface, _| self.material(surface.material).reflectance)
    }

    /// Emissions of all patches, W/m^2.
    pub fn patch_emissions(&self) -> Vec<Rgb> {
        self.per_patch(|surface, _| self.material(surface.material).emission)
    }

    /// One value per patch, the same for all patches of a surface.
    fn per_patch<T: Clone>(&self, value: impl Fn(&Surface, f64) -> T) -> Vec<T> {
        let mut values = Vec::with_capacity(self.patch_count() as usize);
        for (surface, tree) in self.surfaces.iter().zip(self.mesh.trees()) {
            let leaves = 1_usize << tree.depth;
            values.extend(std::iter::repeat_n(value(surface, leaves as f64), leaves));
        }
        values
    }

    /// Total area, m^2.
    pub fn area(&self) -> f64 {
        self.surfaces.iter().map(Surface::area).sum()
    }

    /// Emitted power by channel, W.
    pub fn emitted_power(&self) -> DVec3 {
        self.surfaces
            .iter()
            .map(|s| s.area() * self.material(s.material).emission.as_dvec3())
            .sum()
    }

    /// Smallest and largest corner coordinates, metres, relative to the origin.
    pub fn bounds(&self) -> [Vec3; 2] {
        self.surfaces
            .iter()
            .flat_map(|s| s.corners)
            .fold([Vec3::INFINITY, Vec3::NEG_INFINITY], |[low, high], p| {
                [low.min(p), high.max(p)]
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn regression_every_surface_needs_a_depth() {
        let wall = Material {
            name: "wall".into(),
            reflectance: Rgb::ZERO,
            emission: Rgb::ZERO,
        };
        let triangle = Surface {
            corners: [Vec3::ZERO, Vec3::X, Vec3::Y],
            material: MaterialId(0),
            object: ObjectId(0),
        };
        let scene = |depths: &[u32]| {
            let (walls, surfaces) = (vec![wall.clone()], vec![triangle; 2]);
            Scene::new(walls, vec!["all".into()], surfaces, depths, DVec3::ZERO)
        };
        assert!(scene(&[0, 3]).is_ok());
        for depths in [&[][..], &[0], &[0, 0, 0]] {
            assert!(matches!(
                scene(depths),
                Err(SceneError::DepthCount { surfaces: 2, .. })
            ));
        }
    }
}
