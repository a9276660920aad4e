//! Spans: convex pieces drawn row by row, with a depth buffer. The strategy of all scenes of few regions, and of what
//! is large in the others.
//!
//! Each piece covers a span of a row, between the crossings of its edges ([`projection`]);
//! no pixel is tested for being inside. The spans of all rows are found together, a vector of rows at a
//! time; then each is filled, a vector of pixels at a time. Within a span the inverse depth is linear.
//! Crossings are f64, pixels f32.

mod projection;

use fearless_simd::{Simd, prelude::*};
use fearless_simd_macros::simd;
use glam::DVec3;

pub(crate) use projection::{Projected, Projection};

use crate::Window;
use crate::affine::affine;
use crate::buffer::{Buffer, PADDING};
use crate::rounding::{FRONT_FACE_OUTSET, MOST_MARGIN};
use projection::Edge;

/// Where an edge crosses the rows: row j at pixel base + slope j.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    base: f64,
    slope: f64,
}

/// The edges of a piece: its rows lie to the right of all `low` and to the left of all `high`.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spans {
    low: Vec<Crossing>,
    high: Vec<Crossing>,
}

impl Spans {
    /// Adds an edge.
    ///
    /// e at the centre of pixel (i, j) is a i + b j + c; the edge is where it is -margin, moved outwards by
    /// `outset` pixels.
    #[inline(always)]
    fn cut(&mut self, edge: &Edge, window: &Window, outset: f64) {
        let [a, b, c] = affine(edge.across, window);
        // By how much e changes from one pixel to the next.
        let step = a.abs() + b.abs();
        let c = c + edge.margin.min(MOST_MARGIN * step) + outset * step;
        // An edge along the rows crosses them far to the left or far to the right.
        let a = if a == 0.0 {
            1e-100 * (b.abs() + c.abs()).max(f64::MIN_POSITIVE)
        } else {
            a
        };
        let scale = -1.0 / a;
        let crossing = Crossing {
            base: c * scale,
            slope: b * scale,
        };
        if a > 0.0 {
            self.low.push(crossing);
        } else {
            self.high.push(crossing);
        }
    }

    /// For as many rows from `row` on as a vector holds: the first pixel and the one after the last, of
    /// 0..width; empty where the second is not greater.
    #[inline(always)]
    fn rows<S: Simd>(&self, simd: S, row: usize, width: usize) -> [S::f64s; 2] {
        let j = S::f64s::from_fn(simd, |lane| (row + lane) as f64);
        let mut low = S::f64s::splat(simd, 0.0);
        for crossing in &self.low {
            low = low.max(j * crossing.slope + crossing.base);
        }
        let width = width as f64;
        let mut high = S::f64s::splat(simd, width - 1.0);
        for crossing in &self.high {
            high = high.min(j * crossing.slope + crossing.base);
        }
        let low = low.min(width).ceil();
        [low, (high.max(-1.0) + 1.0).trunc()]
    }
}

/// The integer in a float of 0 to 2^31, without the care that a cast takes of others.
#[inline(always)]
fn small_integer(value: f64) -> usize {
    const TWO_TO_52: f64 = (1_u64 << 52) as f64;
    (value + TWO_TO_52).to_bits() as u32 as usize
}

/// The rows a piece can touch, or `None` where it is outside the window.
#[inline(always)]
fn row_range(corners: &[DVec3], window: &Window) -> Option<(usize, usize)> {
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

/// Draws the pieces of a projection into a window, but those of which all corners have one of the bits `beyond` in
/// their outcodes.
#[simd]
pub(crate) fn draw<S: Simd>(
    simd: S,
    projection: &Projection,
    beyond: u32,
    window: &Window,
    spans: &mut Spans,
    buffer: &mut Buffer,
) {
    let Buffer {
        inverse_depth,
        codes,
    } = buffer;
    let stride = window.width + PADDING;
    let lanes = S::f64s::LEN;
    for (index, seen) in projection.pieces.iter().enumerate() {
        if seen.outcode & beyond != 0 {
            continue;
        }
        let part = seen.first as usize..seen.end as usize;
        let Some((first_row, end_row)) = row_range(&projection.corners[part.clone()], window)
        else {
            continue;
        };
        let outset = if seen.is_back_face {
            0.0
        } else {
            FRONT_FACE_OUTSET
        };
        spans.low.clear();
        spans.high.clear();
        for edge in &projection.edges[part] {
            spans.cut(edge, window, outset);
        }
        let [depth_i, depth_j, depth_1] = affine(seen.inverse_depth, window);
        let step = depth_i as f32;
        let mut row = first_row;
        while row < end_row {
            let [firsts, ends] = spans.rows(simd, row, window.width);
            for lane in 0..lanes.min(end_row - row) {
                let (first, end) = (small_integer(firsts[lane]), small_integer(ends[lane]));
                if first >= end {
                    continue;
                }
                let j = row + lane;
                let count = end - first;
                let anchor = if step < 0.0 { count - 1 } else { 0 };
                let start = j * stride + first;
                let padded = start..start + count.next_multiple_of(PADDING);
                fill(
                    simd,
                    &mut inverse_depth[padded.clone()],
                    &mut codes[padded],
                    count,
                    Depths {
                        base: (depth_i * (first + anchor) as f64 + (depth_j * j as f64 + depth_1))
                            as f32,
                        anchor: anchor as f32,
                        step,
                    },
                    index as u32,
                );
            }
            row += lanes;
        }
    }
}

/// The inverse depths of a span's pixels: base + step (k - anchor). The anchor is the deepest pixel, so that each is right to
/// some roundings of itself; counted from the nearest, those of a surface that is nearly edge-on would be right to roundings of
/// that one's, and backs nearer than the fronts in their plane.
#[derive(Clone, Copy, Debug)]
struct Depths {
    base: f32,
    anchor: f32,
    step: f32,
}

/// Draws one span: where it is nearer than what is there, its depth and index replace it.
#[simd]
fn fill<S: Simd>(
    simd: S,
    inverse_depth: &mut [f32],
    codes: &mut [u32],
    count: usize,
    depths: Depths,
    index: u32,
) {
    let lanes = S::f32s::LEN;
    let Depths { base, anchor, step } = depths;
    let from_anchor = S::f32s::from_fn(simd, |lane| lane as f32 - anchor);
    let (step_v, base_v) = (S::f32s::splat(simd, step), S::f32s::splat(simd, base));
    let count_v = S::f32s::splat(simd, count as f32 - anchor);
    let index_v = S::u32s::splat(simd, index);
    let depths = inverse_depth.chunks_exact_mut(lanes);
    let codes = codes.chunks_exact_mut(lanes);
    for (k, (old_depth, old_code)) in depths.zip(codes).enumerate() {
        if k * lanes >= count {
            break;
        }
        let offset = from_anchor + (k * lanes) as f32;
        let depth = base_v + step_v * offset;
        let before = S::f32s::from_slice(simd, old_depth);
        let nearer = depth.simd_gt(before) & offset.simd_lt(count_v);
        nearer.select(depth, before).store_slice(old_depth);
        let before = S::u32s::from_slice(simd, old_code);
        nearer.select(index_v, before).store_slice(old_code);
    }
}
