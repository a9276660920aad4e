//! The surfaces of a scene, found by position.
//!
//! The place of a point is on the nearest surface that faces the same way, if that is near enough. The nearest point of a triangle is
//! the point's projection into its plane, or where that lies outside, the nearest one of its sides (Ericson, "Real-Time
//! Collision Detection", 2005, section 5.1.5). Surfaces are in an R-tree by their bounding boxes.

use glam::{DVec3, Vec3};
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use scene::{Scene, Surface, SurfaceId};

use crate::smooth::CREASE_DEGREES;

/// How far from its place a point may be, as a share of the diagonal of the scene's bounds. Model files round positions to about
/// this, and curved walls cut otherwise lie nearly as close.
const TOLERANCE: f64 = 1e-4;

/// Surfaces of a scene by position.
pub struct Places<'s> {
    scene: &'s Scene,
    tree: RTree<GeomWithData<Rectangle<[f64; 3]>, SurfaceId>>,
    /// Unit normals, one per surface.
    normals: Vec<DVec3>,
    /// How far from its place a point may be, metres.
    tolerance: f64,
}

/// A place on a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The surface.
    pub surface: SurfaceId,
    /// Barycentric coordinates in it, which sum to 1.
    pub within: [f32; 3],
}

impl<'s> Places<'s> {
    /// The surfaces of a scene.
    pub fn new(scene: &'s Scene) -> Self {
        let ids = (0..).map(SurfaceId);
        let boxes = ids.zip(scene.surfaces()).map(|(id, surface)| {
            let [a, b, c] = surface.corners;
            let corners = [a.min(b).min(c), a.max(b).max(c)];
            let [low, high] = corners.map(|corner| corner.as_dvec3().to_array());
            GeomWithData::new(Rectangle::from_corners(low, high), id)
        });
        let [low, high] = scene.bounds().map(Vec3::as_dvec3);
        Self {
            scene,
            tree: RTree::bulk_load(boxes.collect()),
            normals: scene.surfaces().iter().map(Surface::normal).collect(),
            tolerance: TOLERANCE * low.distance(high),
        }
    }

    /// The place of a point of a surface with this unit normal; `None` where the scene has none there. Of surfaces that
    /// are equally near it is on the first. `point` is in metres, relative to the scene's origin.
    pub fn of(&self, point: DVec3, normal: DVec3) -> Option<Place> {
        let least = CREASE_DEGREES.to_radians().cos();
        let reach = DVec3::splat(self.tolerance);
        let around = AABB::from_corners((point - reach).to_array(), (point + reach).to_array());
        let near = self.tree.locate_in_envelope_intersecting(around);
        let ids = near.map(|candidate| candidate.data);
        let facing = ids.filter(|id| self.normals[id.index()].dot(normal) >= least);
        let places = facing.map(|id| {
            let corners = self.scene.surface(id).corners.map(Vec3::as_dvec3);
            let within = nearest_in(corners, point);
            (point.distance(point_at(corners, within)), id, within)
        });
        let nearest = places.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let (_, surface, within) = nearest.filter(|&(distance, ..)| distance <= self.tolerance)?;
        Some(Place {
            surface,
            within: within.to_array().map(|weight| weight as f32),
        })
    }
}

/// The point at barycentric coordinates.
pub(crate) fn point_at([p, q, r]: [DVec3; 3], within: DVec3) -> DVec3 {
    within.x * p + within.y * q + within.z * r
}

/// Barycentric coordinates of the point of a triangle that is nearest to another point.
fn nearest_in(corners: [DVec3; 3], point: DVec3) -> DVec3 {
    let [p, q, r] = corners;
    let normal = (q - p).cross(r - p);
    let areas = DVec3::new(
        (r - q).cross(point - q).dot(normal),
        (p - r).cross(point - r).dot(normal),
        (q - p).cross(point - p).dot(normal),
    );
    let within = areas / areas.element_sum();
    if within.is_finite() && within.min_element() >= 0.0 {
        return within;
    }
    let on_side = |k: usize| {
        let (from, to) = (k, (k + 1) % 3);
        let side = corners[to] - corners[from];
        // A side without length divides by something all the same.
        let along =
            (point - corners[from]).dot(side) / side.length_squared().max(f64::MIN_POSITIVE);
        let along = along.clamp(0.0, 1.0);
        let mut within = DVec3::ZERO;
        within[from] = 1.0 - along;
        within[to] = along;
        within
    };
    let distance = |within: &DVec3| point.distance_squared(point_at(corners, *within));
    let sides = [on_side(0), on_side(1), on_side(2)];
    let nearest = sides
        .into_iter()
        .min_by(|a, b| distance(a).total_cmp(&distance(b)));
    nearest.unwrap_or(DVec3::X)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        /// No point of a grid over the triangle is nearer, by more than f64 rounding.
        #[test]
        fn nearest_point_of_a_triangle_is_in_it_and_none_is_nearer(
            at in point(), a in point(), b in point(), c in point()
        ) {
            let corners = [a, b, c];
            let within = nearest_in(corners, at);
            prop_assert!(within.min_element() >= 0.0);
            prop_assert!((within.element_sum() - 1.0).abs() < 1e-12);
            let distance = at.distance(point_at(corners, within));
            for i in 0..=32 {
                for j in 0..=32 - i {
                    let weights = DVec3::new(f64::from(i), f64::from(j), f64::from(32 - i - j)) / 32.0;
                    prop_assert!(at.distance(point_at(corners, weights)) >= distance - 1e-12);
                }
            }
        }
    }
}
