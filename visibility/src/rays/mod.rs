//! Rays through the centres of pixels. The strategy of windows that have far fewer pixels than the scene has pieces:
//! views of lamps and small pictures in dense scenes.
//!
//! # Theory
//! Drawing costs something for every piece of the scene, seen or not; a ray through a hierarchy of boxes costs by
//! their number's logarithm. A ray along d meets a piece by the same products (q_k x q_{k+1}) . d, in f64, by which it is
//! drawn ([`crate::spans`]), so both give the same picture but for pixels that lie on an edge or see two
//! pieces at the same depth, within rounding.
//!
//! # Practice
//! Rays of 4 x 2 neighbouring pixels go together (Wald, Slusallek, Benthin, Wagner, "Interactive rendering with coherent
//! ray tracing", Eurographics 2001). They go down to the nearer box first and leave out boxes farther than what
//! all of them have met. A triangle in a leaf is first tested in f32, with room for rounding; only where that does not
//! rule it out is it met. Of pieces at equal depth the one comes first that is the first in the scene, as if drawn.

mod bvh;

use std::cmp::Ordering;

use fearless_simd::{Simd, f32x8, mask32x8, prelude::*};
use fearless_simd_macros::simd;
use glam::{DVec3, Vec3};

pub(crate) use bvh::Bvh;

use crate::Window;
use crate::buffer::{NONE, PADDING, Seen};
use crate::eye::{Cull, Standpoint};
use crate::rounding::{
    COORDINATE_ULPS, FRONT_FACE_OUTSET, MOST_MARGIN, is_in_plane, margin, retreat,
};
use bvh::{Node, Pair, Triangle};

/// Pixels that go together along a row, rows, and both.
const ALONG: usize = 4;
const ROWS: usize = 2;
const LANES: usize = ALONG * ROWS;

/// How much an f32 product of three factors may be off, relative to the factors' largest: some roundings of 2^-24,
/// and the margins by which fronts are larger ([`COORDINATE_ULPS`]).
const ROUNDING: f32 = 64.0 / (1 << 24) as f32;

/// The same for corners that are rounded to f32 relative to the scene's origin, in plane tolerances.
const PLANE_TOLERANCES: f64 = 16.0;

/// What is behind what was met by less than this, relative, may be as near.
const DEPTH_ROUNDING: f32 = 1e-5;

/// Ratio of depths from which on a triangle is behind what was met, when both are f32.
const FAR_BEHIND: f32 = 1.01;

/// Below this square of the sine of the angle at which a triangle is seen, its depth in f32 is not to be relied on.
const EDGE_ON: f32 = 1e-5;

/// A direction's smallest component, so that it has an inverse.
const LEAST_COMPONENT: f64 = 1e-20;

/// What all rays from an eye through a window have in common, in the scene's axes.
struct Caster<'p> {
    bvh: &'p Bvh,
    /// The region that it lies on, if any.
    own: Option<u32>,
    has_horizon: bool,
    cull: Cull,
    /// Metres.
    position: DVec3,
    /// The frame's normal.
    up: DVec3,
    /// From one pixel to the next, along rows and columns.
    right: DVec3,
    upward: DVec3,
    /// Through the centre of pixel (0, 0), 1 along the window's forward vector.
    first: DVec3,
    /// See [`Standpoint::reach`], metres.
    reach: DVec3,
    plane_tolerance: f64,
    /// What lengths are multiplied by in a first look, 1/m, and room for what is rounded there.
    scale: f64,
    room: f32,
}

/// The bit of a triangle of which a ray meets the back.
const BACK: u32 = 1 << 31;

/// What a code that is not [`NONE`] says.
pub(crate) fn seen(bvh: &Bvh, code: u32) -> Seen {
    Seen {
        region: bvh.triangles[(code & !BACK) as usize].region,
        is_back_face: code & BACK != 0,
    }
}

/// A box to be entered, and the depths at which rays enter it.
type Entry = (Node, [f32; LANES]);

/// What rays of neighbouring pixels have met.
struct Met {
    /// 1/depth, 1/m.
    inverse_depth: [f32; LANES],
    /// Indices into [`Bvh::triangles`], with [`BACK`] where that is what is seen, or [`NONE`].
    triangles: [u32; LANES],
    /// Depth beyond which nothing matters, metres; negative for a ray that is none.
    depth: [f32; LANES],
}

/// Casts a ray through each pixel of a window. The codes are indices into the hierarchy's triangles, with [`BACK`] where
/// that is what is seen, or [`NONE`]: see [`seen`].
#[simd]
pub(crate) fn cast<S: Simd>(
    simd: S,
    at: &Standpoint,
    bvh: &Bvh,
    window: &Window,
    codes: &mut [u32],
) {
    let geometry = at.geometry;
    let frame = &at.frame;
    let [right, upward, forward] =
        [window.right, window.up, window.forward].map(|v| frame.to_scene(v));
    // Products of three lengths stay within what an f32 holds.
    let scale = COORDINATE_ULPS / geometry.plane_tolerance.max(f64::MIN_POSITIVE);
    let caster = Caster {
        bvh,
        own: at.own,
        has_horizon: at.has_horizon,
        cull: at.cull,
        position: frame.position,
        up: frame.normal,
        right: window.pixel * right,
        upward: window.pixel * upward,
        first: forward
            + (window.left + 0.5 * window.pixel) * right
            + (window.bottom + 0.5 * window.pixel) * upward,
        reach: at.reach,
        plane_tolerance: geometry.plane_tolerance,
        scale,
        room: (PLANE_TOLERANCES * geometry.plane_tolerance * scale) as f32,
    };
    let stride = window.width + PADDING;
    let mut stack = Vec::with_capacity(64);
    let end = [window.width, window.height];
    for j in (0..window.height).step_by(ROWS) {
        for i in (0..window.width).step_by(ALONG) {
            let met = caster.trace(simd, [i, j], end, &mut stack);
            for lane in 0..LANES {
                let (i, j) = (i + lane % ALONG, j + lane / ALONG);
                if i < window.width && j < window.height {
                    codes[j * stride + i] = met.triangles[lane];
                }
            }
        }
    }
}

impl Caster<'_> {
    /// Finds what the rays of some pixels meet.
    #[inline(always)]
    fn trace<S: Simd>(
        &self,
        simd: S,
        pixel: [usize; 2],
        end: [usize; 2],
        stack: &mut Vec<Entry>,
    ) -> Met {
        let mut met = Met {
            inverse_depth: [0.0; LANES],
            triangles: [NONE; LANES],
            depth: [f32::INFINITY; LANES],
        };
        let mut directions = [[0.0; LANES]; 3];
        let mut inverses = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let d = self.direction(pixel, lane).to_array();
            for axis in 0..3 {
                directions[axis][lane] = d[axis] as f32;
                let component = if d[axis].abs() < LEAST_COMPONENT {
                    LEAST_COMPONENT
                } else {
                    d[axis]
                };
                inverses[axis][lane] = (1.0 / component) as f32;
            }
            if pixel[0] + lane % ALONG >= end[0] || pixel[1] + lane / ALONG >= end[1] {
                met.depth[lane] = -1.0;
            }
        }
        let directions = [
            f32x8::from_slice(simd, &directions[0]),
            f32x8::from_slice(simd, &directions[1]),
            f32x8::from_slice(simd, &directions[2]),
        ];
        let inverses = [
            f32x8::from_slice(simd, &inverses[0]),
            f32x8::from_slice(simd, &inverses[1]),
            f32x8::from_slice(simd, &inverses[2]),
        ];
        let Bvh {
            root,
            pairs,
            triangles,
        } = self.bvh;
        stack.clear();
        stack.push((*root, [0.0; LANES]));
        while let Some((mut node, nearest)) = stack.pop() {
            let depth = f32x8::from_slice(simd, &met.depth);
            if !f32x8::from_slice(simd, &nearest).simd_le(depth).any_true() {
                continue;
            }
            while node.count == 0 {
                let Pair([left, right]) = &pairs[node.first as usize];
                let (near_left, in_left) = self.enter(simd, left, &inverses, depth);
                let (near_right, in_right) = self.enter(simd, right, &inverses, depth);
                match (in_left.any_true(), in_right.any_true()) {
                    (false, false) => break,
                    (true, false) => node = *left,
                    (false, true) => node = *right,
                    (true, true) => {
                        let mut nearest = [0.0; LANES];
                        // The first ray's order is mostly that of all.
                        if near_left[0] <= near_right[0] {
                            near_right.store_slice(&mut nearest);
                            stack.push((*right, nearest));
                            node = *left;
                        } else {
                            near_left.store_slice(&mut nearest);
                            stack.push((*left, nearest));
                            node = *right;
                        }
                    }
                }
            }
            for index in node.first..node.first + node.count {
                let triangle = &triangles[index as usize];
                let depth = f32x8::from_slice(simd, &met.depth);
                let candidates = self.may_meet(simd, triangle, &directions, depth);
                let candidates = candidates.to_bitmask() as u32;
                if candidates != 0 {
                    self.meet(index, pixel, candidates, &mut met);
                }
            }
        }
        met
    }

    /// The ray of one of the pixels from `pixel` on, 1 along the window's forward vector.
    #[inline(always)]
    fn direction(&self, [i, j]: [usize; 2], lane: usize) -> DVec3 {
        let (i, j) = (i + lane % ALONG, j + lane / ALONG);
        self.first + i as f64 * self.right + j as f64 * self.upward
    }

    /// The depths at which rays enter a box, and the rays that do before `depth`.
    #[inline(always)]
    fn enter<S: Simd>(
        &self,
        simd: S,
        node: &Node,
        inverses: &[f32x8<S>; 3],
        depth: f32x8<S>,
    ) -> (f32x8<S>, mask32x8<S>) {
        let eye = self.position.as_vec3().to_array();
        let mut near = f32x8::splat(simd, 0.0);
        let mut far = depth;
        for axis in 0..3 {
            let low = inverses[axis] * (node.low[axis] - eye[axis]);
            let high = inverses[axis] * (node.high[axis] - eye[axis]);
            near = near.max(low.min(high));
            far = far.min(low.max(high));
        }
        (near, near.simd_le(far))
    }

    /// The rays that a triangle cannot be shown to miss: a first look, in f32.
    #[inline(always)]
    fn may_meet<S: Simd>(
        &self,
        simd: S,
        triangle: &Triangle,
        [x, y, z]: &[f32x8<S>; 3],
        depth: f32x8<S>,
    ) -> mask32x8<S> {
        let eye = self.position;
        let [a, b, c] = triangle.corners;
        let a = (self.scale * (Vec3::from(a).as_dvec3() - eye)).as_vec3();
        let b = (self.scale * (Vec3::from(b).as_dvec3() - eye)).as_vec3();
        let c = (self.scale * (Vec3::from(c).as_dvec3() - eye)).as_vec3();
        let longest = a
            .length_squared()
            .max(b.length_squared())
            .max(c.length_squared());
        let room = ROUNDING * longest + self.room * longest.sqrt();
        let (ab, bc, ca) = (a.cross(b), b.cross(c), c.cross(a));
        let e0 = *x * ab.x + *y * ab.y + *z * ab.z;
        let e1 = *x * bc.x + *y * bc.y + *z * bc.z;
        let e2 = *x * ca.x + *y * ca.y + *z * ca.z;
        let lowest = e0.min(e1).min(e2);
        let highest = e0.max(e1).max(e2);
        let is_ray = depth.simd_ge(f32x8::splat(simd, 0.0));
        // What is behind what a ray has met by far; edge-on, an f32 does not tell.
        let normal = (b - a).cross(c - a);
        let distance = normal.dot(a);
        let limit = if distance * distance > EDGE_ON * longest * normal.length_squared() {
            FAR_BEHIND
        } else {
            f32::INFINITY
        };
        let along = *x * normal.x + *y * normal.y + *z * normal.z;
        let limit = limit * self.scale as f32;
        let is_before = (f32x8::splat(simd, distance) / along).simd_le(depth * limit);
        (lowest.simd_ge(f32x8::splat(simd, -room)) | highest.simd_le(f32x8::splat(simd, room)))
            & is_ray
            & is_before
    }

    /// Takes a triangle where some of the rays meet it before all that they have met; `candidates` has a bit for each
    /// ray to be tested.
    #[inline(always)]
    fn meet(&self, index: u32, pixel: [usize; 2], mut candidates: u32, met: &mut Met) {
        let triangle = &self.bvh.triangles[index as usize];
        if self.own == Some(triangle.region) {
            return;
        }
        let [a, b, c] = triangle.corners;
        let a = Vec3::from(a).as_dvec3();
        let b = Vec3::from(b).as_dvec3();
        let c = Vec3::from(c).as_dvec3();
        let (p, q, r) = (a - self.position, b - self.position, c - self.position);
        let across = [p.cross(q), q.cross(r), r.cross(p)];
        // The normal, as long as twice the area, and the eye's distance times that.
        let normal = across[0] + across[1] + across[2];
        let distance = normal.dot(p);
        // A triangle that is a line, or edge-on.
        if distance == 0.0 {
            return;
        }
        let is_back_face = distance > 0.0;
        if is_back_face && self.cull == Cull::BackFaces
            || self.is_left_out([a, b, c], normal, distance)
        {
            return;
        }
        let sign = if is_back_face { 1.0 } else { -1.0 };
        let scale = retreat(is_back_face) / distance;
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            let direction = self.direction(pixel, lane);
            let inverse_depth = (normal.dot(direction) * scale) as f32;
            let is_nearer = match inverse_depth.total_cmp(&met.inverse_depth[lane]) {
                Ordering::Greater => true,
                Ordering::Equal => self.is_before(triangle, met.triangles[lane]),
                Ordering::Less => false,
            };
            if !is_nearer {
                continue;
            }
            let e = [
                sign * across[0].dot(direction),
                sign * across[1].dot(direction),
                sign * across[2].dot(direction),
            ];
            let is_inside = e[0].min(e[1]).min(e[2]) >= 0.0;
            if is_inside || !is_back_face && self.is_in_margin([a, b, c], across, e) {
                met.inverse_depth[lane] = inverse_depth;
                met.triangles[lane] = index | if is_back_face { BACK } else { 0 };
                met.depth[lane] = (1.0 + DEPTH_ROUNDING) / inverse_depth;
            }
        }
    }

    /// True where a ray that is outside of some of a front's edges is no farther than that is drawn too large.
    #[cold]
    fn is_in_margin(&self, corners: [DVec3; 3], across: [DVec3; 3], e: [f64; 3]) -> bool {
        (0..3).all(|k| {
            let (from, to) = (corners[k], corners[(k + 1) % 3]);
            // By how much e changes from one pixel to the next.
            let step = across[k].dot(self.right).abs() + across[k].dot(self.upward).abs();
            let (p, q) = (from - self.position, to - self.position);
            let margin = margin(across[k], across[k], (p, from.abs()), (q, to.abs()));
            e[k] >= -(margin.min(MOST_MARGIN * step) + FRONT_FACE_OUTSET * step)
        })
    }

    /// True where a triangle is part of a piece before that of another one, which may be [`NONE`].
    fn is_before(&self, triangle: &Triangle, other: u32) -> bool {
        let other = self.bvh.triangles.get((other & !BACK) as usize);
        other.is_none_or(|other| triangle.piece < other.piece)
    }

    /// True for what is edge-on or at the horizon within rounding, as [`Standpoint`] has it. The normal and the
    /// eye's distance from the plane have a common factor.
    #[inline(always)]
    fn is_left_out(&self, corners: [DVec3; 3], normal: DVec3, distance: f64) -> bool {
        let tolerance = self.plane_tolerance;
        let length = normal.length();
        let [a, b, c] = corners;
        let height = (a - self.position)
            .dot(self.up)
            .max((b - self.position).dot(self.up))
            .max((c - self.position).dot(self.up));
        let distance = distance.abs();
        // Nearly all are far from both planes.
        if distance > tolerance * length && (height > tolerance || !self.has_horizon) {
            return false;
        }
        let reach = a.abs().max(b.abs()).max(c.abs()).max(self.reach);
        is_in_plane(distance / length, tolerance, normal / length, reach)
            || self.has_horizon && is_in_plane(height, tolerance, self.up, reach)
    }
}
