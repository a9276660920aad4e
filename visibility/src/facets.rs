//! What item buffers draw, as planes with corners: which of it can see which.

use glam::DVec3;

use crate::COORDINATE_ULPS;
use crate::drawable::Drawable;

/// A region of [`crate::regions`] and its plane.
#[derive(Clone, Debug)]
pub struct Facet {
    /// Unit vector, on the front side.
    pub normal: DVec3,
    /// A point of the plane, metres.
    through: DVec3,
    /// Of all its pieces, one after the other, metres.
    pub corners: Vec<DVec3>,
    /// What its own corners may be off its plane by, at most, metres ([`crate::is_in_plane`]).
    pub tolerance: f64,
}

impl Facet {
    /// How far a point is in front of the plane, metres.
    pub fn height(&self, point: DVec3) -> f64 {
        (point - self.through).dot(self.normal)
    }

    /// True where light may go between this and the other one, unless something hides it: each has a part in
    /// front of the other's plane.
    pub fn sees(&self, other: &Self) -> bool {
        self.has_in_front(other) && other.has_in_front(self)
    }

    /// True where a part of the other one is in front of this one's plane, by more than half the rounding that
    /// item buffers allow: nearer than that they draw nothing.
    fn has_in_front(&self, other: &Self) -> bool {
        let least = 0.5 * self.tolerance;
        other.corners.iter().any(|&p| self.height(p) > least)
    }

    /// True where a part of the other one is behind this one's plane by more than rounding.
    pub fn has_behind(&self, other: &Self) -> bool {
        let mut corners = other.corners.iter();
        corners.any(|&p| -self.height(p) > self.tolerance_at(p))
    }

    /// True where all of the other one is in this one's plane, within rounding.
    pub fn is_in_plane(&self, other: &Self) -> bool {
        let mut corners = other.corners.iter();
        corners.all(|&p| self.height(p).abs() <= self.tolerance_at(p))
    }

    /// What a point of the plane may be off it by, metres.
    fn tolerance_at(&self, point: DVec3) -> f64 {
        let own = COORDINATE_ULPS * self.normal.abs().dot(point.abs());
        own.max(self.tolerance)
    }
}

/// The facets of a scene, one per region.
pub fn facets(drawable: &Drawable) -> Vec<Facet> {
    let regions = drawable.regions();
    let facet = |region: &crate::regions::Region| {
        let pieces = region.pieces.clone();
        let corners: Vec<DVec3> = pieces
            .flat_map(|piece| regions.corners(piece as usize))
            .map(|&vertex| regions.vertices()[vertex as usize].as_dvec3())
            .collect();
        let reach = corners
            .iter()
            .fold(DVec3::ZERO, |most, p| most.max(p.abs()));
        let rounding = COORDINATE_ULPS * region.normal.abs().dot(reach);
        Facet {
            normal: region.normal,
            through: region.reference[0],
            corners,
            tolerance: rounding.min(drawable.plane_tolerance()),
        }
    };
    regions.regions().iter().map(facet).collect()
}
