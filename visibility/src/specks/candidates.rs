//! Candidates: pixels that may see a speck, tested against it one by one, several at a time.

#[cfg(test)]
mod tests;

use std::cmp::Ordering;

use fearless_simd::{Simd, f32x8, f64x4, prelude::*};
use glam::{DVec3, Vec3};

use super::clusters::LANES;
use super::hierarchical_depth::HierarchicalDepth;
use crate::Window;
use crate::buffer::{Buffer, NONE, PADDING, SPECK, SPECK_REGION, Seen};
use crate::eye::Standpoint;
use crate::rounding::{FRONT_FACE_OUTSET, MOST_MARGIN, margin, retreat};
use crate::spans::Projected;
use crate::vectors::Vectors;

/// Distances from a plane in plane tolerances from which on none can be rounding: twice what they are compared with.
const NEAR_TOLERANCES: f64 = 2.0;

/// The most pixels near a speck.
pub(crate) const MOST_PIXELS: i32 = 24;

/// A pixel is a candidate if its centre lies in the triangle grown by this much along both axes, in pixels: above the
/// margins of fronts ([`MOST_MARGIN`]) and the rounding of places to f32, 2^-8 where they are largest.
pub(crate) const GROWTH: f32 = 1.0 / 64.0;

/// Which pixels of a rectangle a triangle may hold the centres of, as bits, row by row; there are [`MOST_PIXELS`] at
/// most. The corners' places are relative to the first pixel's centre, in pixels.
#[inline(always)]
pub(crate) fn held<S: Simd>(simd: S, x: [f32; 3], y: [f32; 3], columns: i32, rows: i32) -> u32 {
    let count = columns * rows;
    let columns = columns as f32;
    let mut held = 0;
    for first in (0..count).step_by(LANES) {
        let pixel = f32x8::from_fn(simd, |lane| lane as f32) + first as f32;
        // Half a pixel more makes up for rounding.
        let j = ((pixel + 0.5) * (1.0 / columns)).floor();
        let i = pixel - j * columns;
        let mut is_left = u64::MAX;
        let mut is_right = u64::MAX;
        for k in 0..3 {
            let next = (k + 1) % 3;
            let (dx, dy) = (x[next] - x[k], y[next] - y[k]);
            let growth = GROWTH * (dx.abs() + dy.abs());
            let across = (j - y[k]) * dx - (i - x[k]) * dy;
            is_left &= across.simd_ge(-growth).to_bitmask();
            is_right &= across.simd_le(growth).to_bitmask();
        }
        held |= ((is_left | is_right) as u32) << first;
    }
    held & ((1 << count) - 1)
}

/// What specks are drawn into: a window in which pieces have been drawn.
#[derive(Debug)]
pub(crate) struct Target<'a> {
    pub at: &'a Standpoint<'a>,
    /// The pieces.
    pub drawn: &'a [Projected],
    pub buffer: &'a mut Buffer,
    pub depth: &'a mut HierarchicalDepth,
}

/// Pixels that specks may hold, a few at a time, and what is found of them.
#[derive(Clone, Debug)]
pub(crate) struct Candidates {
    pub window: Window,
    rays: Rays,
    count: usize,
    regions: [u32; LANES],
    /// Column and row.
    pixels: [[f32; LANES]; 2],
    /// By corner and axis, metres.
    corners: [[[f32; LANES]; 3]; 3],
    inverse_depth: [f32; LANES],
    /// Bits: it is seen from behind; the pixel's ray meets it, or may do so because it is drawn too large; it is
    /// neither edge-on nor at the horizon.
    is_back_face: u64,
    is_inside: u64,
    is_beside: u64,
    is_far: u64,
}

/// A window's first ray and the steps from pixel to pixel, in the frame.
#[derive(Clone, Copy, Debug)]
struct Rays {
    first: DVec3,
    right: DVec3,
    upward: DVec3,
}

impl Rays {
    /// By how much products with some vectors change from one pixel to the next at most.
    #[inline(always)]
    fn step<S: Simd>(&self, across: Vectors<S>) -> f64x4<S> {
        across.along(self.right).abs() + across.along(self.upward).abs()
    }
}

impl Candidates {
    /// No candidates in a window.
    pub fn new(window: &Window) -> Self {
        Self {
            window: *window,
            rays: Rays {
                first: window.forward
                    + (window.left + 0.5 * window.pixel) * window.right
                    + (window.bottom + 0.5 * window.pixel) * window.up,
                right: window.pixel * window.right,
                upward: window.pixel * window.up,
            },
            count: 0,
            regions: [0; LANES],
            pixels: [[0.0; LANES]; 2],
            corners: [[[0.0; LANES]; 3]; 3],
            inverse_depth: [0.0; LANES],
            is_back_face: 0,
            is_inside: 0,
            is_beside: 0,
            is_far: 0,
        }
    }

    /// A speck that pixel (i, j) may see; true where [`Self::draw`] is to be called before the next one.
    #[inline(always)]
    pub fn add(&mut self, region: u32, [i, j]: [u32; 2], corners: [Vec3; 3]) -> bool {
        let lane = self.count;
        self.regions[lane] = region;
        self.pixels[0][lane] = i as f32;
        self.pixels[1][lane] = j as f32;
        for (to, from) in self.corners.iter_mut().zip(corners) {
            to[0][lane] = from.x;
            to[1][lane] = from.y;
            to[2][lane] = from.z;
        }
        self.count += 1;
        self.count == LANES
    }

    /// Draws what has been added, and starts anew.
    #[inline(always)]
    pub fn draw<S: Simd>(&mut self, simd: S, target: &mut Target) {
        self.test(simd, target.at);
        self.take(target);
    }

    /// Tests all candidates.
    #[inline(always)]
    fn test<S: Simd>(&mut self, simd: S, at: &Standpoint) {
        let rays = self.rays;
        let frame = &at.frame;
        let near = NEAR_TOLERANCES * at.geometry.plane_tolerance;
        let zero = f64x4::splat(simd, 0.0);
        let mut corners = [[f32x8::splat(simd, 0.0); 3]; 3];
        for (to, from) in corners.iter_mut().zip(&self.corners) {
            for (to, from) in to.iter_mut().zip(from) {
                *to = f32x8::from_slice(simd, from);
            }
        }
        let columns = f32x8::from_slice(simd, &self.pixels[0]).widen();
        let rows = f32x8::from_slice(simd, &self.pixels[1]).widen();
        let mut depths = [zero; 2];
        let mut masks = [[0; 2]; 4];
        for half in 0..2 {
            let mut local = [Vectors {
                x: zero,
                y: zero,
                z: zero,
            }; 3];
            for (to, from) in local.iter_mut().zip(&corners) {
                let [x, y, z] = [from[0].widen(), from[1].widen(), from[2].widen()];
                let (x, y, z) = if half == 0 {
                    (x.0, y.0, z.0)
                } else {
                    (x.1, y.1, z.1)
                };
                *to = Vectors { x, y, z }.in_frame(frame);
            }
            let [a, b, c] = local;
            let (i, j) = if half == 0 {
                (columns.0, rows.0)
            } else {
                (columns.1, rows.1)
            };
            let direction = Vectors {
                x: i * rays.right.x + j * rays.upward.x + rays.first.x,
                y: i * rays.right.y + j * rays.upward.y + rays.first.y,
                z: i * rays.right.z + j * rays.upward.z + rays.first.z,
            };
            let (ab, bc, ca) = (a.cross(b), b.cross(c), c.cross(a));
            // The normal, as long as twice the area, and the eye's distance from the plane times that.
            let normal = b.minus(a).cross(c.minus(a));
            let distance = normal.dot(a);
            let is_back_face = distance.simd_gt(zero);
            let retreats = is_back_face.select(zero + retreat(true), zero + retreat(false));
            depths[half] = normal.dot(direction) * (retreats / distance);
            let height = a.z.max(b.z).max(c.z);
            // Of fronts what is inside is below 0.
            let (e, f, g) = (ab.dot(direction), bc.dot(direction), ca.dot(direction));
            let (lowest, highest) = (e.min(f).min(g), e.max(f).max(g));
            let is_inside = is_back_face.select(lowest, -highest).simd_ge(zero);
            // As much as margins are at most, see `rounding::margin`: 2 sqrt(3)^2 plane tolerances a metre of the
            // longer of two corners, and some of what they change by from one pixel to the next.
            let longest = a.dot(a).max(b.dot(b)).max(c.dot(c)).sqrt();
            let most = longest * (6.0 * at.geometry.plane_tolerance);
            let (step_e, step_f, step_g) = (rays.step(ab), rays.step(bc), rays.step(ca));
            let is_beside = (e - step_e * FRONT_FACE_OUTSET)
                .simd_le(most.min(step_e * MOST_MARGIN))
                & (f - step_f * FRONT_FACE_OUTSET).simd_le(most.min(step_f * MOST_MARGIN))
                & (g - step_g * FRONT_FACE_OUTSET).simd_le(most.min(step_g * MOST_MARGIN))
                & !is_back_face;
            let is_far = (distance * distance).simd_gt(normal.dot(normal) * (near * near))
                & height.simd_gt(near);
            masks[0][half] = is_back_face.to_bitmask();
            masks[1][half] = is_inside.to_bitmask();
            masks[2][half] = is_beside.to_bitmask();
            masks[3][half] = is_far.to_bitmask();
        }
        depths[0]
            .narrow(depths[1])
            .store_slice(&mut self.inverse_depth);
        let [back_face, inside, beside, far] = masks;
        self.is_back_face = back_face[0] | back_face[1] << 4;
        self.is_inside = inside[0] | inside[1] << 4;
        self.is_beside = beside[0] | beside[1] << 4;
        self.is_far = far[0] | far[1] << 4;
    }

    /// Writes what has been found, and starts anew.
    #[inline(always)]
    fn take(&mut self, target: &mut Target) {
        let stride = self.window.width + PADDING;
        let mut met = (self.is_inside | self.is_beside) & ((1 << self.count) - 1);
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            let has = |bits: u64| bits >> lane & 1 != 0;
            let (i, j) = (self.pixels[0][lane] as usize, self.pixels[1][lane] as usize);
            let (place, region) = (j * stride + i, self.regions[lane]);
            let depth = self.inverse_depth[lane];
            let is_nearer = match depth.total_cmp(&target.buffer.inverse_depth[place]) {
                Ordering::Greater => true,
                Ordering::Equal => region < region_of(target.drawn, target.buffer.codes[place]),
                Ordering::Less => false,
            };
            // What a ray meets behind the eye is no nearer than nothing.
            if is_nearer
                && depth > 0.0
                && (has(self.is_inside) || self.is_in_margin(lane, target.at))
                && (has(self.is_far) || !self.is_left_out(lane, target.at))
            {
                target.buffer.inverse_depth[place] = depth;
                target.depth.forget(i, j);
                let seen = Seen {
                    region,
                    is_back_face: has(self.is_back_face),
                };
                target.buffer.codes[place] = seen.speck();
            }
        }
        self.count = 0;
    }

    fn corners_of(&self, lane: usize) -> [Vec3; 3] {
        self.corners
            .map(|axes| Vec3::from(axes.map(|axis| axis[lane])))
    }

    /// True where a ray that is outside of some of a front's edges is no farther than that is drawn too large.
    #[cold]
    fn is_in_margin(&self, lane: usize, at: &Standpoint) -> bool {
        let rays = &self.rays;
        let frame = &at.frame;
        let corners = self.corners_of(lane);
        let [i, j] = self.pixels.map(|pixels| f64::from(pixels[lane]));
        let direction = rays.first + i * rays.right + j * rays.upward;
        (0..3).all(|k| {
            let [from, to] = [corners[k], corners[(k + 1) % 3]].map(|corner| {
                let corner = corner.as_dvec3();
                (frame.to_local(corner), corner.abs())
            });
            // As of a front.
            let across = to.0.cross(from.0);
            let step = across.dot(rays.right).abs() + across.dot(rays.upward).abs();
            let margin = margin(across, frame.to_scene(across), from, to);
            across.dot(direction) >= -(margin.min(MOST_MARGIN * step) + FRONT_FACE_OUTSET * step)
        })
    }

    /// True for what is edge-on or at the horizon within rounding.
    #[cold]
    fn is_left_out(&self, lane: usize, at: &Standpoint) -> bool {
        let corners = self.corners_of(lane);
        let height = |corner: Vec3| at.frame.to_local(corner.as_dvec3()).z;
        let [a, b, c] = corners.map(height);
        at.leaves_out(self.regions[lane], a.max(b).max(c))
    }
}

/// The region that a pixel sees; the greatest number where it sees none.
#[inline(always)]
fn region_of(drawn: &[Projected], code: u32) -> u32 {
    if code == NONE {
        NONE
    } else if code & SPECK != 0 {
        code & SPECK_REGION
    } else {
        drawn[code as usize].region
    }
}
