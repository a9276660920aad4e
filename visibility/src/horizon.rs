//! The regions that rise above a horizon: all that the hemicubes on one surface can see.
//!
//! They are found once for all of these hemicubes, so that none of them sets up a piece below its horizon. Only spans
//! need the list: specks leave out whole clusters below the horizon, and rays go up only.

#[cfg(test)]
mod tests;

use glam::DVec3;

use crate::Frame;
use crate::geometry::Geometry;
use crate::rounding::{COORDINATE_ULPS, is_in_plane};

/// Regions that an eye may see. That of the last horizon is kept for the next hemicube with the same.
#[derive(Clone, Debug, Default)]
pub(crate) struct Horizon {
    /// Its plane: a unit vector, its product with the points of the plane and the largest magnitudes of
    /// the coordinates by which it is known, both in metres. `None` where there is no horizon.
    plane: Option<(DVec3, f64, DVec3)>,
    /// Ascending.
    regions: Vec<u32>,
}

impl Horizon {
    /// The regions, ascending.
    pub fn regions(&self) -> &[u32] {
        &self.regions
    }

    /// All regions: an eye that looks down too.
    pub fn open(&mut self, geometry: &Geometry) {
        if self.plane.take().is_some() || self.regions.is_empty() {
            self.regions.clear();
            self.regions.extend(0..geometry.facts.len() as u32);
        }
    }

    /// The regions above a frame's horizon; [`Projection::set`](super::Projection::set) would leave out all others.
    /// `eye_reach` is the largest magnitude of the coordinates by which the horizon is known, metres.
    pub fn find(&mut self, geometry: &Geometry, frame: &Frame, eye_reach: DVec3) {
        let normal = frame.normal;
        let offset = normal.dot(frame.position);
        let rounding = COORDINATE_ULPS * normal.abs().dot(eye_reach);
        if let Some((last_normal, last_offset, last_reach)) = self.plane
            && (last_normal, last_reach) == (normal, eye_reach)
            && (last_offset - offset).abs() <= 0.25 * rounding
        {
            return;
        }
        self.plane = Some((normal, offset, eye_reach));
        self.regions.clear();
        let regions = &geometry.regions;
        let [x, y, z] = &geometry.vertices;
        // Half of what is taken for rounding: the horizons of other eyes in the plane are up to a quarter lower.
        let is_above = |vertex: u32, reach: DVec3| {
            let vertex = vertex as usize;
            let p = DVec3::new(x[vertex], y[vertex], z[vertex]);
            let height = 2.0 * frame.to_local(p).z;
            height > 0.0 && !is_in_plane(height, geometry.plane_tolerance, normal, reach)
        };
        for (id, (region, facts)) in (0..).zip(regions.regions().iter().zip(&geometry.facts)) {
            let reach = facts.reach.max(eye_reach);
            let pieces = region.pieces.clone();
            let mut corners = pieces.flat_map(|piece| regions.corners(piece as usize));
            if corners.any(|&vertex| is_above(vertex, reach)) {
                self.regions.push(id);
            }
        }
    }
}
