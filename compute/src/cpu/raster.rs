//! Drawing surfaces into a window of pixels, with a depth buffer.
//!
//! Each triangle covers a span of a row, between the crossings of its edges ([`super::projection`]);
//! no pixel is tested for being inside. Within a span the inverse depth is linear. Reversed depth:
//! 1/w is kept, 0 is infinitely far. Crossings are f64, pixels f32.

// Functions that a vectorised caller needs must be inlined into it: compiled on their own they would
// be for the baseline instruction set.
#![allow(clippy::inline_always)]

use fearless_simd::{Level, Simd, dispatch, prelude::*};
use fearless_simd_macros::simd;
use glam::DVec3;
use scene::SurfaceId;

use super::look_up::{LookUp, look_up_row};
use super::projection::{OverPixels, Projected, Projection, over_pixels};
use crate::hemicube::Window;

/// Front faces are drawn this much too large, in pixels, so that a ray through an edge or a corner
/// meets a front whatever the rounding, where surfaces only touch (T-junctions) too: above the f64
/// rounding of a crossing, 2^-53 times some thousands of pixels, and far below a pixel.
const FRONT_FACE_OUTSET: f64 = 1e-9;

/// The most that margins for rounded corners may move an edge, in pixels: what is so far away that its own
/// coordinates are less certain than that is not to grow by it.
const MOST_MARGIN: f64 = 1.0 / 256.0;

/// What a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// No surface.
    Nothing,
    /// The back of a surface.
    BackFace(SurfaceId),
    /// The front of a surface.
    Front {
        /// Which.
        surface: SurfaceId,
        /// Where on it; they sum to 1.
        barycentric: [f32; 3],
        /// Distance along the window's forward direction, metres.
        depth: f32,
    },
}

/// No surface, in the buffer of surfaces.
pub(super) const NONE: u32 = u32::MAX;

/// Rows are padded so that the widest vector (16 lanes) can run over their end.
const PADDING: usize = 16;

/// A window's depth and surface buffers. Kept between pictures to save allocating.
#[derive(Clone, Debug)]
pub struct Raster {
    level: Level,
    window: Option<Window>,
    /// Of the surfaces' e_k; set for those that touch the window.
    edges: Vec<[OverPixels; 3]>,
    /// 1/w, 1/m; `width + PADDING` a row.
    inverse_depth: Vec<f32>,
    /// Index into the projection's surfaces, or [`NONE`]; `width + PADDING` a row.
    surface: Vec<u32>,
    /// One row of patch IDs.
    row: Vec<u32>,
}

impl Default for Raster {
    fn default() -> Self {
        Self {
            level: Level::new(),
            window: None,
            edges: Vec::new(),
            inverse_depth: Vec::new(),
            surface: Vec::new(),
            row: Vec::new(),
        }
    }
}

impl Raster {
    /// Draws all surfaces of a projection.
    pub fn draw(&mut self, projection: &Projection, window: &Window) {
        self.window = Some(*window);
        self.edges
            .resize(projection.surfaces.len(), Default::default());
        let pixels = (window.width + PADDING) * window.height;
        self.inverse_depth.clear();
        self.inverse_depth.resize(pixels, 0.0);
        self.surface.clear();
        self.surface.resize(pixels, NONE);
        let Self {
            level,
            edges,
            inverse_depth,
            surface,
            ..
        } = self;
        dispatch!(*level, simd => draw(
            simd, &projection.surfaces, window, edges, inverse_depth, surface
        ));
    }

    /// Hands out the patch IDs of the last picture row by row, with `nothing` and `back_face` for
    /// pixels that see no patch.
    pub fn for_each_row(
        &mut self,
        projection: &Projection,
        nothing: u32,
        back_face: u32,
        mut take: impl FnMut(usize, &[u32]),
    ) {
        let Some(window) = self.window else { return };
        let stride = window.width + PADDING;
        self.row.resize(stride, 0);
        let look_up = LookUp {
            surfaces: &projection.surfaces,
            edges: &self.edges,
            nothing,
            back_face,
        };
        for j in 0..window.height {
            let surface = &self.surface[j * stride..][..window.width];
            let row = &mut self.row;
            dispatch!(self.level, simd => look_up_row(simd, &look_up, j, surface, row));
            take(j, &self.row[..window.width]);
        }
    }

    /// What pixel (i, j) of the last picture sees.
    pub fn sample(&self, projection: &Projection, i: usize, j: usize) -> Sample {
        let Some(window) = &self.window else {
            return Sample::Nothing;
        };
        let index = self.surface[j * (window.width + PADDING) + i];
        let Some(seen) = projection.surfaces.get(index as usize) else {
            return Sample::Nothing;
        };
        if seen.is_back_face {
            return Sample::BackFace(seen.surface);
        }
        let direction = window.forward
            + (window.left + (i as f64 + 0.5) * window.pixel) * window.right
            + (window.bottom + (j as f64 + 0.5) * window.pixel) * window.up;
        let [a, b, c] = seen.edges.map(|edge| edge.dot(direction).max(0.0));
        let sum = a + b + c;
        Sample::Front {
            surface: seen.surface,
            barycentric: [a, b, c].map(|e| (e / sum) as f32),
            depth: (1.0 / seen.inverse_depth.dot(direction)) as f32,
        }
    }
}

/// Where a triangle's edges cross a row of pixels: between `low` and `high` lies the inside.
#[derive(Clone, Copy)]
struct Crossings {
    /// Base and slope of each: the crossing of row j is at pixel base + slope j.
    low: [(f64, f64); 3],
    high: [(f64, f64); 3],
}

impl Crossings {
    /// e_k at the centre of pixel (i, j) is a i + b j + c; edges are where it is -`margins`, moved outwards by
    /// `outset` pixels.
    #[inline(always)]
    fn new(edges: &[OverPixels; 3], margins: &[f64; 3], outset: f64) -> Self {
        let mut crossings = Self {
            low: [(f64::NEG_INFINITY, 0.0); 3],
            high: [(f64::INFINITY, 0.0); 3],
        };
        for (k, &[a, b, c]) in edges.iter().enumerate() {
            // By how much e_k changes from one pixel to the next.
            let step = a.abs() + b.abs();
            let c = c + margins[k].min(MOST_MARGIN * step) + outset * step;
            // An edge along the rows crosses them far to the left or far to the right.
            let a = if a == 0.0 {
                1e-100 * (b.abs() + c.abs())
            } else {
                a
            };
            let crossing = (-c / a, -b / a);
            if a > 0.0 {
                crossings.low[k] = crossing;
            } else {
                crossings.high[k] = crossing;
            }
        }
        crossings
    }

    /// The first pixel of row j and the pixel after its last, of 0..width; empty where the second is
    /// not greater.
    #[inline(always)]
    fn span(&self, j: usize, width: usize) -> (usize, usize) {
        let j = j as f64;
        let at = |(base, slope): (f64, f64)| base + slope * j;
        let [l0, l1, l2] = self.low;
        let [h0, h1, h2] = self.high;
        let low = at(l0).max(at(l1)).max(at(l2)).max(0.0);
        let high = at(h0).min(at(h1)).min(at(h2)).min(width as f64 - 1.0);
        // A cast saturates, so that a negative `high` ends the row before its first pixel.
        (low.ceil() as usize, (high + 1.0) as usize)
    }
}

/// The rows a triangle can touch, or `None` where it is outside the window.
#[inline(always)]
fn row_range(corners: &[DVec3; 3], window: &Window) -> Option<(usize, usize)> {
    let right = window.left + window.width as f64 * window.pixel;
    let top = window.bottom + window.height as f64 * window.pixel;
    let mut outside = [true; 5];
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut all_in_front = true;
    for &q in corners {
        let (x, y, w) = (q.dot(window.right), q.dot(window.up), q.dot(window.forward));
        outside[0] &= w <= 0.0;
        outside[1] &= x < window.left * w;
        outside[2] &= x > right * w;
        outside[3] &= y < window.bottom * w;
        outside[4] &= y > top * w;
        if w > 0.0 {
            low = low.min(y / w);
            high = high.max(y / w);
        } else {
            all_in_front = false;
        }
    }
    if outside.contains(&true) {
        return None;
    }
    if !all_in_front {
        return Some((0, window.height));
    }
    // A row more on either side makes up for the division's rounding.
    let first = ((low - window.bottom) / window.pixel - 1.5).max(0.0) as usize;
    let end = ((high - window.bottom) / window.pixel + 1.5).max(0.0) as usize;
    Some((first, end.min(window.height)))
}

#[simd]
fn draw<S: Simd>(
    simd: S,
    surfaces: &[Projected],
    window: &Window,
    edges: &mut [[OverPixels; 3]],
    inverse_depth: &mut [f32],
    surface: &mut [u32],
) {
    let stride = window.width + PADDING;
    for (index, seen) in surfaces.iter().enumerate() {
        let Some((first_row, end_row)) = row_range(&seen.corners, window) else {
            continue;
        };
        for (over, edge) in edges[index].iter_mut().zip(seen.edges) {
            *over = over_pixels(edge, window);
        }
        let outset = if seen.is_back_face {
            0.0
        } else {
            FRONT_FACE_OUTSET
        };
        let crossings = Crossings::new(&edges[index], &seen.margins, outset);
        let [depth_i, depth_j, depth_1] = over_pixels(seen.inverse_depth, window);
        for j in first_row..end_row {
            let (first, end) = crossings.span(j, window.width);
            if first >= end {
                continue;
            }
            let count = end - first;
            let start = j * stride + first;
            let padded = start..start + count.next_multiple_of(PADDING);
            fill(
                simd,
                &mut inverse_depth[padded.clone()],
                &mut surface[padded],
                count,
                (depth_i * first as f64 + (depth_j * j as f64 + depth_1)) as f32,
                depth_i as f32,
                index as u32,
            );
        }
    }
}

/// Draws one span: where it is nearer than what is there, its depth and index replace it.
#[simd]
fn fill<S: Simd>(
    simd: S,
    inverse_depth: &mut [f32],
    surface: &mut [u32],
    count: usize,
    base: f32,
    step: f32,
    index: u32,
) {
    let lanes = S::f32s::LEN;
    let iota = S::f32s::from_fn(simd, |lane| lane as f32);
    let (step_v, base_v) = (S::f32s::splat(simd, step), S::f32s::splat(simd, base));
    let count_v = S::f32s::splat(simd, count as f32);
    let index_v = S::u32s::splat(simd, index);
    let depths = inverse_depth.chunks_exact_mut(lanes);
    let surfaces = surface.chunks_exact_mut(lanes);
    for (k, (old_depth, old_surface)) in depths.zip(surfaces).enumerate() {
        if k * lanes >= count {
            break;
        }
        let offset = iota + (k * lanes) as f32;
        let depth = base_v + step_v * offset;
        let before = S::f32s::from_slice(simd, old_depth);
        let nearer = depth.simd_gt(before) & offset.simd_lt(count_v);
        nearer.select(depth, before).store_slice(old_depth);
        let before = S::u32s::from_slice(simd, old_surface);
        nearer.select(index_v, before).store_slice(old_surface);
    }
}
