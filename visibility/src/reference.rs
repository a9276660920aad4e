//! The reference: one ray a pixel against every surface, in f64. It takes minutes where the [strategies](crate::Strategy)
//! take a second, knows no margins, and is short enough to be checked by reading.
//!
//! # Theory
//! Let q0, q1, q2 be a triangle's corners relative to the eye, and d the direction of a ray. With the edge functions
//! e_k = (q_{k+1} x q_{k+2}) . d the ray meets the triangle's plane at the barycentric coordinates e_k / (e_0 + e_1 + e_2),
//! at the depth w with 1/w = (e_0 + e_1 + e_2) / det(q0, q1, q2). It meets the triangle where no e_k has another sign than
//! the others and w is positive. The determinant is negative where the eye is in front.
//!
//! # Differences
//! A ray through an edge, exactly, may meet both neighbours or neither; strategies draw fronts larger by a hair, so that
//! it meets one of them.

use glam::{DVec3, Vec3};
use scene::{Scene, Surface, SurfaceId};

use crate::eye::{Cull, Eye};
use crate::hemicube::{pixel_count, windows};
use crate::item_buffer::{BACK_FACE, NOTHING};
use crate::rounding::{is_in_plane, plane_tolerance, reach};
use crate::{Frame, Window};

/// Backs count as this much farther away, so that of a front and a back at equal depth the front is seen.
const BACK_FACE_RETREAT: f64 = 1.0 - 1e-6;

/// An eye that looks for the nearest surface along a ray.
#[derive(Clone, Debug)]
pub struct Reference<'a> {
    scene: &'a Scene,
    eye: Eye,
    /// What it may see: not what it lies in, nor what is below its horizon, both within rounding.
    surfaces: Vec<SurfaceId>,
}

impl<'a> Reference<'a> {
    /// An eye in a scene.
    pub fn new(scene: &'a Scene, eye: &Eye) -> Self {
        let tolerance = plane_tolerance(scene);
        let position = eye.frame.position;
        let eye_reach = eye
            .own
            .map_or(position.abs(), |own| reach(scene.surface(own)));
        let is_seen = |surface: &Surface| {
            let corners = surface.corners.map(Vec3::as_dvec3);
            let reach = reach(surface).max(eye_reach);
            let distance = (corners[0] - position).dot(surface.normal()).abs();
            let height = corners
                .map(|corner| eye.frame.to_local(corner).z)
                .into_iter()
                .fold(f64::MIN, f64::max);
            let is_edge_on = is_in_plane(distance, tolerance, surface.normal(), reach);
            let is_low = is_in_plane(height, tolerance, eye.frame.normal, reach);
            !(is_edge_on || eye.has_horizon && is_low)
        };
        let ids = (0..scene.surfaces().len() as u32).map(SurfaceId);
        Self {
            scene,
            eye: *eye,
            surfaces: ids.filter(|&id| is_seen(scene.surface(id))).collect(),
        }
    }

    /// The patch along a direction in the eye's frame, [`NOTHING`] or [`BACK_FACE`].
    pub fn along(&self, direction: DVec3) -> u32 {
        let direction = self.eye.frame.to_scene(direction);
        let mut nearest = 0.0;
        let mut seen = NOTHING;
        for &id in &self.surfaces {
            let surface = self.scene.surface(id);
            let [q0, q1, q2] = surface
                .corners
                .map(|corner| corner.as_dvec3() - self.eye.frame.position);
            let determinant = q0.cross(q1).dot(q2);
            let e = [q1.cross(q2), q2.cross(q0), q0.cross(q1)].map(|across| across.dot(direction));
            let is_back = determinant > 0.0;
            let is_met = if is_back {
                e.iter().all(|&e| e >= 0.0)
            } else {
                e.iter().all(|&e| e <= 0.0)
            };
            if !is_met || is_back && self.eye.cull == Cull::BackFaces {
                continue;
            }
            let sum = e[0] + e[1] + e[2];
            let retreat = if is_back { BACK_FACE_RETREAT } else { 1.0 };
            let inverse_depth = retreat * sum / determinant;
            if inverse_depth > nearest {
                nearest = inverse_depth;
                let barycentric = e.map(|e| (e / sum) as f32);
                seen = if is_back {
                    BACK_FACE
                } else {
                    self.scene.mesh().locate(id, barycentric).0.0
                };
            }
        }
        seen
    }

    /// What the pixels of a window see, row by row.
    pub fn picture(&self, window: &Window) -> Vec<u32> {
        let pixels = (0..window.height).flat_map(|j| (0..window.width).map(move |i| (i, j)));
        pixels
            .map(|(i, j)| self.along(window.direction(i, j)))
            .collect()
    }
}

/// The item buffer of a hemicube in the layout of [`crate::hemicube`].
pub fn item_buffer(scene: &Scene, own: SurfaceId, frame: &Frame, resolution: u32) -> Vec<u32> {
    let reference = Reference::new(scene, &Eye::with_horizon(frame, own));
    let mut ids = Vec::with_capacity(pixel_count(resolution));
    for window in windows(resolution) {
        ids.extend(reference.picture(&window));
    }
    ids
}
