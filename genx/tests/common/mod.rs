//! What the tests of the models share: reproducible random numbers and a brute-force ray caster.

#![allow(dead_code)] // each test binary uses its part

pub mod program;

use glam::{DVec2, DVec3, Vec3};
use scene::{Scene, Surface, SurfaceId};

/// Distance by which a ray starts off the surface it leaves, metres, as a share of the model's size.
/// f32 corners put a surface off its ideal place by 6e-8 of the size; this is well above that, and
/// well below the smallest thing in any model (35 mm of 0.56 m).
pub const START_OFFSET: f64 = 1e-5;

/// SplitMix64 (Steele, Lea and Flood, 2014).
pub struct Random(pub u64);

impl Random {
    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    /// Uniform on the triangle.
    pub fn point_on(&mut self, surface: &Surface) -> DVec3 {
        let [p0, p1, p2] = surface.corners.map(Vec3::as_dvec3);
        let root = self.unit().sqrt();
        let share = self.unit();
        p0 * (1.0 - root) + p1 * (root * (1.0 - share)) + p2 * (root * share)
    }

    /// Uniform on the half of the unit sphere around the normal.
    pub fn direction_about(&mut self, normal: DVec3) -> DVec3 {
        loop {
            let v = 2.0 * DVec3::new(self.unit(), self.unit(), self.unit()) - DVec3::ONE;
            if (1e-3..1.0).contains(&v.length()) && v.dot(normal).abs() > 1e-3 * v.length() {
                return v.normalize() * v.dot(normal).signum();
            }
        }
    }
}

/// What a ray meets first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    pub surface: SurfaceId,
    /// Along the ray, in lengths of its direction.
    pub distance: f64,
    pub is_front: bool,
}

/// Distance to a triangle along a ray; the triangle's border belongs to it.
fn intersect(surface: &Surface, from: DVec3, direction: DVec3) -> Option<f64> {
    let [p0, p1, p2] = surface.corners.map(|p| p.as_dvec3() - from);
    // Signed volumes over the edges depend on the two corners alone, up to the sign, so a ray that
    // passes exactly along an edge cannot slip between the two triangles that share it.
    let volumes = [p1.cross(p2), p2.cross(p0), p0.cross(p1)].map(|v| v.dot(direction));
    let inside = volumes.iter().all(|&v| v >= 0.0) || volumes.iter().all(|&v| v <= 0.0);
    let normal = (p1 - p0).cross(p2 - p0);
    let cosine = normal.dot(direction);
    (inside && cosine != 0.0).then(|| normal.dot(p0) / cosine)
}

/// The first surface that a ray meets.
pub fn cast(scene: &Scene, from: DVec3, direction: DVec3) -> Option<Hit> {
    let mut first: Option<Hit> = None;
    for (index, surface) in scene.surfaces().iter().enumerate() {
        if let Some(distance) = intersect(surface, from, direction)
            && distance > 0.0
            && first.is_none_or(|hit| distance < hit.distance)
        {
            first = Some(Hit {
                surface: SurfaceId(index as u32),
                distance,
                is_front: surface.normal().dot(direction) < 0.0,
            });
        }
    }
    first
}

/// Largest extent of the model, metres.
pub fn size(scene: &Scene) -> f64 {
    let [low, high] = scene.bounds();
    f64::from((high - low).max_element())
}

/// Rays that start just in front of the surfaces, `count` from each, in all directions in front.
pub fn rays_from_surfaces(scene: &Scene, count: usize, random: &mut Random) -> Vec<(DVec3, DVec3)> {
    let offset = START_OFFSET * size(scene);
    let mut rays = Vec::new();
    for surface in scene.surfaces() {
        for _ in 0..count {
            let from = random.point_on(surface) + offset * surface.normal();
            rays.push((from, random.direction_about(surface.normal())));
        }
    }
    rays
}

/// Whether a point of a surface's plane lies in the surface; `slack` is a distance, metres.
pub fn contains(surface: &Surface, point: DVec3, slack: f64) -> bool {
    let normal = surface.normal();
    let corners = surface.corners.map(Vec3::as_dvec3);
    (point - corners[0]).dot(normal).abs() <= slack
        && (0..3).all(|k| {
            let side = corners[(k + 1) % 3] - corners[k];
            normal.cross(side.normalize()).dot(point - corners[k]) >= -slack
        })
}

/// Whether the point lies in the rectangle between two corners, borders included.
pub fn in_rectangle(point: DVec2, low: DVec2, high: DVec2) -> bool {
    point.cmpge(low).all() && point.cmple(high).all()
}
