//! Surfaces as seen from one eye, set up once for all windows.
//!
//! # Theory
//! Let q0, q1, q2 be a triangle's corners relative to the eye. The ray along d meets the
//! triangle's plane where its barycentric coordinates are in the proportion of
//! e_k(d) = (q_{k+1} x q_{k+2}) . d, k = 0, 1, 2 (homogeneous rasterisation: Olano and Greer,
//! "Triangle scan conversion using 2D homogeneous coordinates", Graphics Hardware 1997). It hits
//! the triangle where all three have the sign of the determinant det(q0, q1, q2), at the depth w
//! with 1/w = (e_0 + e_1 + e_2) / det. All of these are linear in d, hence in the pixel: there is no
//! division in a pixel, no clipping and no near plane, and a triangle that passes beside or
//! behind the eye needs no care. The patch follows from the proportion of the e_k alone,
//! see [`scene::bisection`].
//!
//! # Practice
//! The vectors are f64. Two triangles that share an edge have the same vector for it, with opposite
//! signs, so that no pixel between them is missed.

// Functions that a vectorised caller needs must be inlined into it: compiled on their own they would
// be for the baseline instruction set.
#![allow(clippy::inline_always)]

use glam::{DVec3, Vec3};
use scene::{Scene, Surface, SurfaceId};

use crate::hemicube::{Frame, Window};

/// Back faces are drawn this much too deep, so that a pixel on the silhouette of a solid, where a
/// front and a back face meet at equal depth, sees the front: well above the rounding of an f32
/// depth (2^-24) and of its steps along a row, well below any wall's thickness.
const BACK_FACE_RETREAT: f64 = 1.0 - 1.0 / (1 << 19) as f64;

/// What is done about the backs of surfaces, which are one-sided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cull {
    /// They occlude, and are seen as [`super::Sample::BackFace`].
    Nothing,
    /// They are not there.
    BackFaces,
}

/// A surface as seen from one eye, in the eye's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Projected {
    /// e_k(d) = edges[k] . d; at least 0 inside, k-th barycentric coordinate up to a factor.
    pub edges: [DVec3; 3],
    /// How far below 0 each e_k may be inside, for directions d no longer than sqrt(3).
    pub margins: [f64; 3],
    /// 1/w = inverse_depth . d, 1/m.
    pub inverse_depth: DVec3,
    /// Relative to the eye, metres.
    pub corners: [DVec3; 3],
    pub surface: SurfaceId,
    /// Its bisection tree's first patch and depth.
    pub first_patch: u32,
    pub depth: u32,
    /// True where the eye is behind it.
    pub is_back_face: bool,
}

/// All surfaces that an eye can see, set up for drawing into any window of its frame.
#[derive(Clone, Debug, Default)]
pub struct Projection {
    pub(super) surfaces: Vec<Projected>,
}

/// Units in the last place (2^-24 relative) by which f32 coordinates are taken to be uncertain.
pub const COORDINATE_ULPS: f64 = 4.0 / (1 << 24) as f64;

/// A point's distance from a plane through others like it is uncertain by at most about this, metres: by
/// some units in the last place of the scene's largest coordinate. Where it matters
/// [`is_in_plane`] is sharper.
pub fn plane_tolerance(scene: &Scene) -> f64 {
    let [low, high] = scene.bounds();
    f64::from(low.abs().max(high.abs()).max_element()) * COORDINATE_ULPS
}

/// True where a distance of `height` metres from a plane is no more than rounding: `tolerance`, which is
/// [`plane_tolerance`], and what the coordinates themselves are uncertain by, each along its own axis.
/// In a scene with things far away the second is far less for all the others. `normal` is the plane's,
/// a unit vector; `reach` is the largest magnitude of the coordinates, metres.
pub fn is_in_plane(height: f64, tolerance: f64, normal: DVec3, reach: DVec3) -> bool {
    height <= tolerance && height <= COORDINATE_ULPS * normal.abs().dot(reach)
}

/// Largest magnitude of a surface's coordinates, by axis, metres.
pub fn reach(surface: &Surface) -> DVec3 {
    let [p0, p1, p2] = surface.corners.map(Vec3::abs);
    p0.max(p1).max(p2).as_dvec3()
}

impl Projection {
    /// Sets up all surfaces but `own`, which the eye lies on. `tolerance` is [`plane_tolerance`]: surfaces
    /// at or below the horizon (z = 0 in the frame, if `horizon`) or edge-on within rounding
    /// ([`is_in_plane`]) are left out.
    pub fn set(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        own: Option<SurfaceId>,
        horizon: bool,
        cull: Cull,
        tolerance: f64,
    ) {
        let all = (0..scene.surfaces().len() as u32)
            .map(SurfaceId)
            .filter(|&id| own != Some(id));
        self.set_some(scene, frame, own, all, horizon, cull, tolerance);
    }

    /// The same for some surfaces only; `own` is the eye's.
    #[expect(clippy::too_many_arguments, reason = "each is a fact about one eye")]
    pub fn set_some(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        own: Option<SurfaceId>,
        surfaces: impl Iterator<Item = SurfaceId>,
        horizon: bool,
        cull: Cull,
        tolerance: f64,
    ) {
        self.surfaces.clear();
        let eye_reach = own.map_or(frame.position.abs(), |own| reach(scene.surface(own)));
        for id in surfaces {
            let surface = scene.surface(id);
            let [q0, q1, q2] = surface.corners.map(|p| frame.to_local(p.as_dvec3()));
            let in_plane = |height: f64, normal: DVec3| {
                is_in_plane(height, tolerance, normal, reach(surface).max(eye_reach))
            };
            let height = q0.z.max(q1.z).max(q2.z);
            if horizon && (height <= 0.0 || in_plane(height, frame.normal)) {
                continue;
            }
            let mut edges = [q1.cross(q2), q2.cross(q0), q0.cross(q1)];
            // Twice the area times the normal; its product with any corner is the determinant.
            let normal = (q1 - q0).cross(q2 - q0);
            let mut determinant = normal.dot(q0);
            let distance = determinant.abs() / normal.length();
            if distance <= tolerance && in_plane(distance, surface.normal()) {
                continue;
            }
            // The eye is in front of a counter-clockwise triangle when the determinant is negative.
            let is_back_face = determinant > 0.0;
            if is_back_face && cull == Cull::BackFaces {
                continue;
            }
            if determinant < 0.0 {
                edges = edges.map(|edge| -edge);
                determinant = -determinant;
            }
            let tree = scene.mesh().tree(id);
            self.surfaces.push(Projected {
                edges,
                margins: if is_back_face {
                    [0.0; 3]
                } else {
                    margins(surface, frame, [q0, q1, q2], &edges)
                },
                inverse_depth: if is_back_face {
                    BACK_FACE_RETREAT * normal
                } else {
                    -normal
                } / determinant,
                corners: [q0, q1, q2],
                surface: id,
                first_patch: tree.first_patch.0,
                depth: tree.depth,
                is_back_face,
            });
        }
    }
}

/// Margins of a front, so that a ray between surfaces whose common corners are the same but for rounding
/// meets one of them. A corner that is off by s across an edge's plane q_i x q_j moves that plane by s times
/// the other corner's length at most; no ray through a hemicube's pixel is longer than sqrt(3).
fn margins(surface: &Surface, frame: &Frame, corners: [DVec3; 3], edges: &[DVec3; 3]) -> [f64; 3] {
    let ray = 3.0_f64.sqrt();
    let lengths = corners.map(DVec3::length);
    let reaches = surface.corners.map(|p| p.abs().as_dvec3());
    [(0, 1, 2), (1, 2, 0), (2, 0, 1)].map(|(k, i, j)| {
        let across = frame.to_scene(edges[k].normalize_or_zero()).abs();
        let off = |i: usize| COORDINATE_ULPS * across.dot(reaches[i]);
        ray * (off(i) * lengths[j] + off(j) * lengths[i])
    })
}

/// A value that is linear over a window's pixels: its coefficients of i, of j and of 1.
pub(super) type OverPixels = [f64; 3];

/// The value v . d, linear over the pixels' centres, as the coefficients of i, of j and of 1.
#[inline(always)]
pub(super) fn over_pixels(v: DVec3, window: &Window) -> OverPixels {
    let (x, y) = (v.dot(window.right), v.dot(window.up));
    let c = v.dot(window.forward)
        + x * (window.left + 0.5 * window.pixel)
        + y * (window.bottom + 0.5 * window.pixel);
    [x * window.pixel, y * window.pixel, c]
}
