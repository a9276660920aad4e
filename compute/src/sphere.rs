//! Spheres around surfaces, for quick answers to what is near.
//!
//! Surfaces that follow each other mostly lie near each other, so spheres around runs of them, and around runs of those,
//! answer for many.

use std::ops::Range;

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

    /// A sphere around some others, of which there is one at least.
    pub fn around_all(spheres: &[Self]) -> Self {
        let count = spheres.len() as f64;
        let centre = spheres.iter().map(|s| s.centre).sum::<DVec3>() / count;
        let radius = spheres
            .iter()
            .map(|s| s.centre.distance(centre) + s.radius)
            .fold(0.0, f64::max);
        Self { centre, radius }
    }

    /// False only where all of the sphere is farther than `distance` from the point, metres.
    pub fn is_within(&self, distance: f64, point: DVec3) -> bool {
        let reach = distance + self.radius;
        self.centre.distance_squared(point) <= reach * reach
    }
}

/// Surfaces, or spheres of the level below, that one sphere is around.
const RUN: usize = 8;

/// Spheres around surfaces, and around runs of those.
#[derive(Clone, Debug)]
pub(crate) struct Spheres {
    /// From the surfaces' own to the last level, which has no more than one run.
    levels: Vec<Vec<Sphere>>,
}

impl Spheres {
    /// Those of some surfaces.
    pub fn new(surfaces: &[Surface]) -> Self {
        let mut levels: Vec<Vec<Sphere>> = vec![surfaces.iter().map(Sphere::around).collect()];
        while let Some(last) = levels.last().filter(|last| last.len() > RUN) {
            levels.push(last.chunks(RUN).map(Sphere::around_all).collect());
        }
        Self { levels }
    }

    /// Hands out the numbers of surfaces that may be within a distance of a point, metres, in their order; what is
    /// handed back is the distance from then on.
    pub fn for_each_within(
        &self,
        distance: f64,
        point: DVec3,
        mut take: impl FnMut(usize, &Sphere) -> f64,
    ) {
        let top = self.levels.len() - 1;
        let mut distance = distance;
        self.visit(
            top,
            0..self.levels[top].len(),
            point,
            &mut distance,
            &mut take,
        );
    }

    fn visit(
        &self,
        level: usize,
        range: Range<usize>,
        point: DVec3,
        distance: &mut f64,
        take: &mut impl FnMut(usize, &Sphere) -> f64,
    ) {
        for index in range {
            let sphere = &self.levels[level][index];
            if !sphere.is_within(*distance, point) {
                continue;
            }
            if level == 0 {
                *distance = take(index, sphere);
            } else {
                let end = (RUN * (index + 1)).min(self.levels[level - 1].len());
                self.visit(level - 1, RUN * index..end, point, distance, take);
            }
        }
    }
}
