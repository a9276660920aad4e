//! Surfaces: the input triangles, which alone decide what occludes what.

use glam::{DVec3, Vec3};

use crate::{MaterialId, ObjectId};

/// Twice the area over the squared longest side, below which a triangle counts as degenerate. Its
/// corners are f32, so a height under 2^-23 of the longest side is rounding, not shape.
const DEGENERATE_HEIGHT_RATIO: f64 = 1.0 / (1 << 23) as f64;

/// A one-sided planar triangle; counter-clockwise corners are seen from its front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Surface {
    /// Corners in metres, relative to the scene's origin. In a scene the longest side, which is
    /// the first reference edge of the bisection tree, runs from corner 0 to corner 1.
    pub corners: [Vec3; 3],
    /// What it is made of.
    pub material: MaterialId,
    /// What it is part of.
    pub object: ObjectId,
}

impl Surface {
    /// Twice the area times the unit normal, m^2.
    fn double_area_normal(&self) -> DVec3 {
        let [p0, p1, p2] = self.corners.map(Vec3::as_dvec3);
        (p1 - p0).cross(p2 - p0)
    }

    /// Area, m^2.
    pub fn area(&self) -> f64 {
        0.5 * self.double_area_normal().length()
    }

    /// Unit normal, on the front side.
    pub fn normal(&self) -> DVec3 {
        self.double_area_normal().normalize_or_zero()
    }

    /// Lengths of the sides from corner 0 to 1, 1 to 2 and 2 to 0, metres.
    pub fn side_lengths(&self) -> [f64; 3] {
        let [p0, p1, p2] = self.corners.map(Vec3::as_dvec3);
        [p0.distance(p1), p1.distance(p2), p2.distance(p0)]
    }

    /// True where the triangle has no area beyond rounding, whichever corner comes first.
    pub fn is_degenerate(&self) -> bool {
        // The cross product rounds differently from another corner; a scene that was accepted
        // must be accepted again when its rotated corners are read back.
        let rotated = self.with_longest_side_first();
        let longest = rotated.side_lengths()[0];
        let double_area = rotated.double_area_normal().length();
        double_area.is_nan() || double_area <= longest * longest * DEGENERATE_HEIGHT_RATIO
    }

    /// The same triangle with its corners rotated so that the longest side comes first.
    #[must_use]
    pub fn with_longest_side_first(self) -> Self {
        let [s0, s1, s2] = self.side_lengths();
        let [p0, p1, p2] = self.corners;
        let corners = if s0 >= s1 && s0 >= s2 {
            [p0, p1, p2]
        } else if s1 >= s2 {
            [p1, p2, p0]
        } else {
            [p2, p0, p1]
        };
        Self { corners, ..self }
    }
}
