//! Where an eye stands, and how its axes lie in the scene.

use glam::{DVec3, Vec3};
use scene::Patch;

/// An orthonormal right-handed frame at a point of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The eye, metres, relative to the scene's origin.
    pub position: DVec3,
    /// Unit vector in the patch's plane.
    pub tangent: DVec3,
    /// normal x tangent.
    pub bitangent: DVec3,
    /// Unit normal of the patch, or of the wall that it is part of.
    pub normal: DVec3,
}

impl Frame {
    /// A frame at `position` on a patch, whose tangent is the patch's reference edge turned about the
    /// normal by `turn` radians: results do not depend on how the model lies in its coordinates.
    pub fn on_patch(patch: &Patch, normal: DVec3, position: DVec3, turn: f64) -> Self {
        let [p0, p1, _] = patch.corners.map(Vec3::as_dvec3);
        // A patch so small that its corners fall together in f32 has no edge to follow.
        let aligned = (p1 - p0)
            .reject_from_normalized(normal)
            .try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        Self::at(position, normal, aligned, turn)
    }

    /// A frame at `position` whose tangent is `aligned`, a unit vector across the normal, turned about the normal by
    /// `turn` radians.
    pub fn at(position: DVec3, normal: DVec3, aligned: DVec3, turn: f64) -> Self {
        let (sin, cos) = turn.sin_cos();
        let tangent = cos * aligned + sin * normal.cross(aligned);
        Self {
            position,
            tangent,
            bitangent: normal.cross(tangent),
            normal,
        }
    }

    /// A vector of this frame in the scene's axes.
    #[inline]
    pub fn to_scene(&self, vector: DVec3) -> DVec3 {
        vector.x * self.tangent + vector.y * self.bitangent + vector.z * self.normal
    }

    /// A vector of the scene in this frame.
    #[inline]
    pub fn vector_to_local(&self, vector: DVec3) -> DVec3 {
        DVec3::new(
            vector.dot(self.tangent),
            vector.dot(self.bitangent),
            vector.dot(self.normal),
        )
    }

    /// A point in this frame: along tangent, bitangent and normal, metres.
    #[inline]
    pub fn to_local(&self, point: DVec3) -> DVec3 {
        self.vector_to_local(point - self.position)
    }
}
