//! Spheres around surfaces, for quick answers to what is near.

use glam::{DVec3, Vec3};
use scene::Surface;

/// A sphere around a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sphere {
    /// Metres, relative to the scene's origin.
    pub centre: DVec3,
    /// Metres.
    pub radius: f64,
}

impl Sphere {
    /// A sphere through the corner that is farthest from the centroid.
    pub fn around(surface: &Surface) -> Self {
        let corners = surface.corners.map(Vec3::as_dvec3);
        let centre = corners.iter().sum::<DVec3>() / 3.0;
        let radius = corners
            .iter()
            .map(|p| p.distance(centre))
            .fold(0.0, f64::max);
        Self { centre, radius }
    }

    /// False only where all of the sphere is farther than `distance` from the point, metres.
    pub fn is_within(&self, distance: f64, point: DVec3) -> bool {
        let reach = distance + self.radius;
        self.centre.distance_squared(point) <= reach * reach
    }
}
