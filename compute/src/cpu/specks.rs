//! Specks: triangles so small that a hemicube's face has few pixels' centres near them, or none.
//!
//! # Theory
//! Where triangles are as many as pixels, most of them hold no pixel's centre, and to set one up for drawing, edge by
//! edge, costs more than all its pixels. Vertices know their places in the hemicube's faces, so three look-ups
//! and a few comparisons tell that a triangle lies between the centres, or which few it may hold. Those are
//! tried one by one, by the same products by which pieces are drawn ([`super::projection`]): the picture is the same.
//!
//! # Practice
//! Only triangles that are regions by themselves and all in one face count as specks; others are drawn. What is done
//! for all vertices, all triangles and all tried pixels is done without branches, for several at a time.

// Functions that a vectorised caller needs must be inlined into it: compiled on their own they would
// be for the baseline instruction set. That goes for closures too.
#![allow(clippy::inline_always)]

use std::cmp::Ordering;
use std::sync::Arc;

use fearless_simd::{Simd, f32x4, f32x8, f64x4, i32x4, prelude::*};
use fearless_simd_macros::simd;
use glam::{DVec3, Vec3};
use scene::SurfaceId;

use super::projection::{Projection, retreat};
use super::raster::{FRONT_FACE_OUTSET, MOST_MARGIN, NONE, PADDING};
use super::regions::Regions;
use super::rounding::margin;
use super::vectors::Vectors;
use crate::hemicube::{Frame, MAX_RESOLUTION, Window};

/// The most pixels that are tried one by one.
const MOST_PIXELS: i32 = 24;

/// How far from a triangle's bounds, in pixels, a centre may be that the triangle holds: above the margins of fronts
/// ([`MOST_MARGIN`]) and the rounding of places to f32, 2^-8 where they are largest.
const ROOM: f32 = 1.0 / 64.0;

/// Marks a pixel that sees a speck, whose region is the lowest bits.
pub(super) const SPECK: u32 = 1 << 31;

/// And that it is the speck's back. There are 2^24 regions at most, so that no such number is [`NONE`].
pub(super) const SPECK_BACK: u32 = 1 << 30;

/// A region's number, of a pixel that sees a speck.
pub(super) const SPECK_REGION: u32 = SPECK_BACK - 1;

/// Distances from a plane in plane tolerances from which on none can be rounding: twice what they are compared with.
const NEAR_TOLERANCES: f64 = 2.0;

/// Faces lie side by side at these distances, in pixels, so that what is in two of them is at least as wide as [`MAX_RESOLUTION`].
/// After the last one is what lies below the horizon.
const FACE: i32 = 1 << 13;
const FACES: usize = 5;

/// Candidates for which there is room before they are looked at.
const CHUNK: usize = 1 << 10;

/// Vertices and pixels that are dealt with together.
const LANES: usize = 8;

/// A region of one triangle, which may be a speck, or of one quadrangle, which may at least not be seen.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    region: u32,
    surface: SurfaceId,
    /// A triangle's last one is there twice.
    vertices: [u32; 4],
    /// Where it has more pixels near it than this, it is drawn.
    most_pixels: i32,
}

/// The regions of a scene by what they may be.
#[derive(Clone, Debug)]
pub(super) struct Candidates {
    /// Ascending.
    small: Vec<Candidate>,
    /// Ascending.
    others: Vec<u32>,
}

impl Candidates {
    /// `None` where there are hardly any vertices.
    pub fn new(regions: &Regions) -> Option<Self> {
        if regions.vertices().len() < LANES {
            return None;
        }
        let mut candidates = Self {
            small: Vec::new(),
            others: Vec::new(),
        };
        for (region, all) in (0..).zip(regions.regions()) {
            let corners = regions.corners(all.pieces.start as usize);
            let (vertices, most_pixels) = match (all.pieces.len(), corners) {
                (1, &[a, b, c]) if all.locator.is_none() => ([a, b, c, c], MOST_PIXELS),
                (1, &[a, b, c]) => ([a, b, c, c], 0),
                (1, &[a, b, c, d]) => ([a, b, c, d], 0),
                _ => {
                    candidates.others.push(region);
                    continue;
                }
            };
            candidates.small.push(Candidate {
                region,
                surface: all.surfaces[0],
                vertices,
                most_pixels,
            });
        }
        Some(candidates)
    }
}

/// The specks that an eye sees.
#[derive(Clone, Debug, Default)]
pub(super) struct Specks {
    /// Of each vertex in pixels from the lower left corner of the first face: x, y, -x, -y.
    places: Vec<[f32; 4]>,
    /// By the face that they are in, in the scene's order: how many there are, and they, with room for more.
    of_faces: [(usize, Vec<Speck>); FACES],
}

/// A triangle, and the pixels whose centres it may hold: its region, its surface, the first column and row, and how many there
/// are, in 16 bits each.
type Speck = [u32; 4];

impl Specks {
    /// Forgets all.
    pub fn clear(&mut self) {
        for (count, _) in &mut self.of_faces {
            *count = 0;
        }
    }

    /// Starts with vertices, axis after axis, metres, seen from a frame whose hemicube has this resolution.
    #[inline(always)]
    fn place<S: Simd>(&mut self, simd: S, from: [&[f64]; 3], frame: &Frame, resolution: u32) {
        let [from_x, from_y, from_z] = from;
        let count = from_z.len();
        self.places.resize(count, [0.0; 4]);
        let half = 0.5 * resolution as f32;
        let zero = f32x8::splat(simd, 0.0);
        let below = f32x8::splat(simd, FACE as f32 * FACES as f32);
        for first in (0..count).step_by(LANES) {
            // At the end some are placed once more; there are more vertices than that.
            let first = first.min(count - LANES);
            let part = first..first + LANES;
            let from = [
                &from_x[part.clone()],
                &from_y[part.clone()],
                &from_z[part.clone()],
            ];
            let [x, y, z] = to_local(simd, frame, from);
            let is_along_y = x.abs().simd_ge(y.abs());
            let across = is_along_y.select(x, y);
            let along = is_along_y.select(y, -x);
            let most = across.abs();
            let is_top = z.simd_ge(most);
            // The number of the side and the axis along its rows, see `hemicube::windows`.
            let is_first = across.simd_gt(zero);
            let side = is_along_y.select(zero + 1.0, zero + 2.0);
            let side = is_first.select(side, side + 2.0);
            let along = is_first.select(along, -along);
            let scale = (f32x8::splat(simd, half) / z.max(most)).min(f32::MAX);
            let right = is_top.select(x, along) * scale + half;
            let up = is_top.select(y * scale + half, z * scale);
            let right = right + is_top.select(zero, side) * FACE as f32;
            let is_above = z.simd_gt(zero);
            let (right, up) = (is_above.select(right, below), is_above.select(up, zero));
            let (left, down) = (-right, -up);
            let (even, odd) = (right.interleave(left), up.interleave(down));
            let (low, high) = (even.0.interleave(odd.0), even.1.interleave(odd.1));
            let places = self.places[part].chunks_exact_mut(2);
            for (places, four) in places.zip([low.0, low.1, high.0, high.1]) {
                four.store_slice(bytemuck::cast_slice_mut(places));
            }
        }
    }
}

/// Eight points in a frame, of which there is one coordinate after the other, metres, as f32.
#[inline(always)]
fn to_local<S: Simd>(simd: S, frame: &Frame, [x, y, z]: [&[f64]; 3]) -> [f32x8<S>; 3] {
    let mut halves = [[f64x4::splat(simd, 0.0); 3]; 2];
    for (half, local) in halves.iter_mut().enumerate() {
        let part = 4 * half..4 * half + 4;
        let x = f64x4::from_slice(simd, &x[part.clone()]);
        let y = f64x4::from_slice(simd, &y[part.clone()]);
        let z = f64x4::from_slice(simd, &z[part]);
        *local = Vectors { x, y, z }.in_frame(frame).to_array();
    }
    let [low, high] = halves;
    [
        low[0].narrow(high[0]),
        low[1].narrow(high[1]),
        low[2].narrow(high[2]),
    ]
}

/// Sets up all regions but `own`: those that are not specks are set up as pieces.
#[simd]
pub(super) fn set<S: Simd>(
    simd: S,
    projection: &mut Projection,
    specks: &mut Specks,
    candidates: &Candidates,
    own: u32,
    resolution: u32,
) {
    let drawable = Arc::clone(&projection.drawable);
    let vertices = drawable.vertices.each_ref().map(Vec::as_slice);
    specks.place(simd, vertices, projection.frame(), resolution);
    let eye_reach = projection.eye_reach(Some(own));
    let mut others = candidates.others.iter().copied().peekable();
    let to_last = [ROOM - 0.5, ROOM - 0.5, ROOM + 0.5, ROOM + 0.5];
    let to_last = f32x4::from_slice(simd, &to_last);
    for small in candidates.small.chunks(CHUNK) {
        for (count, specks) in &mut specks.of_faces {
            let room = *count + CHUNK;
            if specks.len() < room {
                specks.resize(room, Speck::default());
            }
        }
        for candidate in small {
            let region = candidate.region;
            let [a, b, c, d] = candidate.vertices;
            let a = f32x4::from_slice(simd, &specks.places[a as usize]);
            let b = f32x4::from_slice(simd, &specks.places[b as usize]);
            let c = f32x4::from_slice(simd, &specks.places[c as usize]);
            let d = f32x4::from_slice(simd, &specks.places[d as usize]);
            // The last pixel along each axis, and the opposite of the first.
            let bounds = (a.max(b).max(c.max(d)) + to_last).floor();
            let [right, up, left, down] = *bounds.to_int::<i32x4<S>>().as_array();
            let (columns, rows) = (right + left + 1, up + down + 1);
            let is_near_centre = columns > 0 && rows > 0;
            let is_in_faces = columns >= MAX_RESOLUTION as i32;
            if is_in_faces || is_near_centre && columns * rows > candidate.most_pixels {
                if region != own {
                    while let Some(other) = others.next_if(|&other| other < region) {
                        if other != own {
                            projection.set_one(other, eye_reach);
                        }
                    }
                    projection.set_one(region, eye_reach);
                }
                continue;
            }
            let face = right >> FACE.ilog2();
            if let Some((count, specks)) = specks.of_faces.get_mut(face as usize) {
                let first = (-left - FACE * face) | (-down) << 16;
                let size = columns | rows << 16;
                specks[*count] = [region, candidate.surface.0, first as u32, size as u32];
                *count += usize::from(is_near_centre && region != own);
            }
        }
    }
    for other in others.filter(|&other| other != own) {
        projection.set_one(other, eye_reach);
    }
}

/// Pixels that specks may hold, a few at a time, and what is found of them.
#[derive(Clone, Copy, Debug, Default)]
struct Tried {
    count: usize,
    regions: [u32; LANES],
    /// Column and row.
    pixels: [[f32; LANES]; 2],
    /// By corner and axis, metres.
    corners: [[[f32; LANES]; 3]; 3],
    inverse_depth: [f32; LANES],
    /// Bits: it is seen from behind; the pixel's ray meets it, or may do so because it is drawn too large; it is neither
    /// edge-on nor at the horizon.
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

/// Draws the specks of a face over what is there: where one is nearer, or as near and before it in the scene, its depth
/// and number replace it.
#[simd]
pub(super) fn draw<S: Simd>(
    simd: S,
    projection: &Projection,
    face: usize,
    window: &Window,
    inverse_depth: &mut [f32],
    pieces: &mut [u32],
) {
    let rays = Rays {
        first: window.forward
            + (window.left + 0.5 * window.pixel) * window.right
            + (window.bottom + 0.5 * window.pixel) * window.up,
        right: window.pixel * window.right,
        upward: window.pixel * window.up,
    };
    let scene = projection.drawable.scene();
    let mut tried = Tried::default();
    let (count, specks) = &projection.specks.of_faces[face];
    for &[region, surface, first, size] in &specks[..*count] {
        let corners = scene.surface(SurfaceId(surface)).corners;
        let (left, bottom) = (first & 0xffff, first >> 16);
        let (columns, rows) = (size & 0xffff, size >> 16);
        let rows = rows.min((window.height as u32).saturating_sub(bottom));
        for pixel in 0..columns * rows {
            let (i, j) = (left + pixel % columns, bottom + pixel / columns);
            let lane = tried.count;
            tried.regions[lane] = region;
            tried.pixels[0][lane] = i as f32;
            tried.pixels[1][lane] = j as f32;
            for (to, from) in tried.corners.iter_mut().zip(corners) {
                to[0][lane] = from.x;
                to[1][lane] = from.y;
                to[2][lane] = from.z;
            }
            tried.count += 1;
            if tried.count == LANES {
                tried.find(simd, projection, &rays);
                tried.take(projection, &rays, window, inverse_depth, pieces);
            }
        }
    }
    tried.find(simd, projection, &rays);
    tried.take(projection, &rays, window, inverse_depth, pieces);
}

impl Tried {
    /// Tries all pixels.
    #[inline(always)]
    fn find<S: Simd>(&mut self, simd: S, projection: &Projection, rays: &Rays) {
        let frame = projection.frame();
        let near = NEAR_TOLERANCES * projection.drawable.plane_tolerance;
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
            let normal = ab.plus(bc).plus(ca);
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
            let most = longest * (6.0 * projection.drawable.plane_tolerance);
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
    fn take(
        &mut self,
        projection: &Projection,
        rays: &Rays,
        window: &Window,
        inverse_depth: &mut [f32],
        pieces: &mut [u32],
    ) {
        let stride = window.width + PADDING;
        let mut met = (self.is_inside | self.is_beside) & ((1 << self.count) - 1);
        while met != 0 {
            let lane = met.trailing_zeros() as usize;
            met &= met - 1;
            let has = |bits: u64| bits >> lane & 1 != 0;
            let (i, j) = (self.pixels[0][lane] as usize, self.pixels[1][lane] as usize);
            let (place, region) = (j * stride + i, self.regions[lane]);
            let depth = self.inverse_depth[lane];
            let is_nearer = match depth.total_cmp(&inverse_depth[place]) {
                Ordering::Greater => true,
                Ordering::Equal => region < region_of(projection, pieces[place]),
                Ordering::Less => false,
            };
            // What a ray meets behind the eye is no nearer than nothing.
            if is_nearer
                && depth > 0.0
                && (has(self.is_inside) || self.is_in_margin(lane, projection, rays))
                && (has(self.is_far) || !self.is_left_out(lane, projection))
            {
                inverse_depth[place] = depth;
                let back = if has(self.is_back_face) {
                    SPECK_BACK
                } else {
                    0
                };
                pieces[place] = SPECK | back | region;
            }
        }
        self.count = 0;
    }

    /// True where a ray that is outside of some of a front's edges is no farther than that is drawn too large.
    #[cold]
    fn is_in_margin(&self, lane: usize, projection: &Projection, rays: &Rays) -> bool {
        let frame = projection.frame();
        let corners = corners_of(projection, self.regions[lane]);
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
    fn is_left_out(&self, lane: usize, projection: &Projection) -> bool {
        let corners = corners_of(projection, self.regions[lane]);
        let height = |corner: Vec3| projection.frame().to_local(corner.as_dvec3()).z;
        let [a, b, c] = corners.map(height);
        projection.leaves_out(self.regions[lane], a.max(b).max(c))
    }
}

/// The corners of a region of one surface, metres.
#[inline(always)]
fn corners_of(projection: &Projection, region: u32) -> [Vec3; 3] {
    let drawable = &projection.drawable;
    let surface = drawable.regions().regions()[region as usize].surfaces[0];
    drawable.scene().surface(surface).corners
}

/// The region that a pixel sees; the greatest number where it sees none.
#[inline(always)]
fn region_of(projection: &Projection, piece: u32) -> u32 {
    if piece == NONE {
        NONE
    } else if piece & SPECK != 0 {
        piece & SPECK_REGION
    } else {
        projection.pieces[piece as usize].region
    }
}
