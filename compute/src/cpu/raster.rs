//! Drawing convex pieces into a window of pixels, with a depth buffer.
//!
//! Each piece covers a span of a row, between the crossings of its edges ([`super::projection`]);
//! no pixel is tested for being inside. The spans of all rows are found together, a vector of rows at a
//! time; then each is filled, a vector of pixels at a time. Within a span the inverse depth is linear.
//! Reversed depth: 1/w is kept, 0 is infinitely far. Crossings are f64, pixels f32.

// Functions that a vectorised caller needs must be inlined into it: compiled on their own they would
// be for the baseline instruction set.
#![allow(clippy::inline_always)]

use std::ops::Range;
use std::sync::Arc;

use fearless_simd::{Level, Simd, dispatch, prelude::*};
use fearless_simd_macros::simd;
use glam::DVec3;
use scene::SurfaceId;

use super::cast::{BACK, cast};
use super::coarse_depth::CoarseDepth;
use super::look_up::LookUp;
use super::outside;
use super::over_pixels::over_pixels;
use super::projection::{Edge, Projection};
use super::runs::for_each_run;
use super::specks;
use super::tried::Picture;
use crate::hemicube::Window;

/// Front faces are drawn this much too large, in pixels, so that a ray through an edge or a corner
/// meets a front whatever the rounding, where surfaces only touch (T-junctions) too: above the f64
/// rounding of a crossing, 2^-53 times some thousands of pixels, and far below a pixel.
pub(super) const FRONT_FACE_OUTSET: f64 = 1e-9;

/// The most that margins for rounded corners may move an edge, in pixels: what is so far away that its own
/// coordinates are less certain than that is not to grow by it.
pub(super) const MOST_MARGIN: f64 = 1.0 / 256.0;

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

/// No piece, in the buffer of pieces.
pub(super) const NONE: u32 = u32::MAX;

/// Rows are padded so that the widest vector (16 lanes) can run over their end.
pub(super) const PADDING: usize = 16;

/// A window's depth and piece buffers. Kept between pictures to save allocating.
#[derive(Clone, Debug)]
pub struct Raster {
    level: Level,
    window: Option<Window>,
    /// 1/w, 1/m; `width + PADDING` a row.
    inverse_depth: Vec<f32>,
    /// Index into the projection's pieces, [`NONE`], or a speck ([`super::tried`]); `width + PADDING` a row.
    pieces: Vec<u32>,
    coarse: CoarseDepth,
    spans: Spans,
    look_up: LookUp,
}

impl Default for Raster {
    fn default() -> Self {
        Self {
            level: Level::new(),
            window: None,
            inverse_depth: Vec::new(),
            pieces: Vec::new(),
            coarse: CoarseDepth::default(),
            spans: Spans::default(),
            look_up: LookUp::default(),
        }
    }
}

impl Raster {
    /// Draws all pieces of a projection that is [`set`](Projection::set).
    pub fn draw(&mut self, projection: &Projection, window: &Window) {
        self.draw_inside(projection, window, 0);
    }

    /// Draws a projection that is [`set_for`](Projection::set_for) this window, among others, or casts rays for it;
    /// or one that is [`set_for_hemicube`](Projection::set_for_hemicube). If the window is that of a hemicube's face
    /// ([`crate::hemicube::windows`]), `face` is its number; the face's specks are drawn too.
    pub fn draw_or_cast(
        &mut self,
        projection: &mut Projection,
        face: Option<usize>,
        window: &Window,
    ) {
        if projection.casting.is_none() {
            let beyond = face.map_or(0, |face| outside::OF_FACES[face]);
            self.draw_inside(projection, window, beyond);
            if let Some(face) = face {
                let mut picture = Picture {
                    inverse_depth: &mut self.inverse_depth,
                    pieces: &mut self.pieces,
                    coarse: &mut self.coarse,
                };
                dispatch!(self.level, simd => specks::draw(
                    simd, projection, face, window, &mut picture
                ));
            }
            return;
        }
        self.start(window);
        dispatch!(self.level, simd => cast(simd, projection, window, &mut self.pieces));
        projection.pieces.clear();
        let drawable = Arc::clone(&projection.drawable);
        let Some(hierarchy) = &drawable.hierarchy else {
            return;
        };
        for run in self.pieces.chunk_by_mut(|a, b| a == b) {
            if run[0] != NONE {
                let triangle = &hierarchy.triangles[(run[0] & !BACK) as usize];
                run.fill(projection.met(triangle.region, run[0] & BACK != 0));
            }
        }
    }

    /// Sees nothing anywhere in a window.
    fn start(&mut self, window: &Window) {
        self.window = Some(*window);
        self.pieces.clear();
        self.pieces
            .resize((window.width + PADDING) * window.height, NONE);
    }

    /// Draws what none of the bits `beyond` of [`outside`] says of that it is outside.
    fn draw_inside(&mut self, projection: &Projection, window: &Window, beyond: u32) {
        self.start(window);
        self.inverse_depth.clear();
        self.inverse_depth.resize(self.pieces.len(), 0.0);
        let Self {
            level,
            inverse_depth,
            pieces,
            spans,
            ..
        } = self;
        dispatch!(*level, simd => draw(
            simd, projection, beyond, window, spans, inverse_depth, pieces
        ));
    }

    /// Hands out the patch IDs of the last picture row by row, with `nothing` and `back_face` for
    /// pixels that see no patch.
    pub fn for_each_row(
        &mut self,
        projection: &Projection,
        nothing: u32,
        back_face: u32,
        take: impl FnMut(usize, &[u32]),
    ) {
        self.look_up_rows(projection, None, nothing, back_face, take);
    }

    /// Hands out the runs of pixels that see the same patch of some regions, ascending: patch, row, pixels. What else
    /// is seen costs no look-up.
    pub fn for_each_run_of(
        &mut self,
        projection: &Projection,
        regions: &[u32],
        mut take: impl FnMut(u32, usize, Range<usize>),
    ) {
        let level = self.level;
        self.look_up_rows(projection, Some(regions), NONE, NONE, |j, ids| {
            dispatch!(level, simd => for_each_run(simd, ids, #[inline(always)] |id, start, end| {
                if id != NONE {
                    take(id, j, start..end);
                }
            }));
        });
    }

    fn look_up_rows(
        &mut self,
        projection: &Projection,
        regions: Option<&[u32]>,
        nothing: u32,
        back_face: u32,
        mut take: impl FnMut(usize, &[u32]),
    ) {
        let Some(window) = self.window else { return };
        let stride = window.width + PADDING;
        self.look_up.start(projection, &window, nothing, back_face);
        if let Some(regions) = regions {
            self.look_up.leave_out_all_but(projection, regions);
        }
        for (j, pieces) in self.pieces.chunks_exact(stride).enumerate() {
            let ids = self
                .look_up
                .row(self.level, projection, j, &pieces[..window.width]);
            take(j, ids);
        }
    }

    /// Hands out the runs of pixels of the last picture that see a piece: row, pixels.
    pub fn for_each_covered_run(&self, mut take: impl FnMut(usize, Range<usize>)) {
        let Some(window) = self.window else { return };
        let stride = window.width + PADDING;
        for (j, row) in self.pieces.chunks_exact(stride).enumerate() {
            let row = &row[..window.width];
            dispatch!(self.level, simd => for_each_run(simd, row, #[inline(always)] |piece, start, end| {
                if piece != NONE {
                    take(j, start..end);
                }
            }));
        }
    }

    /// What pixel (i, j) of the last picture sees, drawn of a projection that is [`set`](Projection::set): of what
    /// rays meet and of specks no more than the patches is known.
    pub fn sample(&self, projection: &Projection, i: usize, j: usize) -> Sample {
        let mut sample = Sample::Nothing;
        self.for_each_sample(projection, j, i..i + 1, |_, seen| sample = seen);
        sample
    }

    /// Hands out what some pixels i of row j of the last picture see, of which the same holds.
    pub fn for_each_sample(
        &self,
        projection: &Projection,
        j: usize,
        pixels: Range<usize>,
        mut take: impl FnMut(usize, Sample),
    ) {
        let Some(window) = &self.window else { return };
        let mut i = pixels.start;
        let row = &self.pieces[j * (window.width + PADDING)..][pixels];
        for run in row.chunk_by(|a, b| a == b) {
            let Some(seen) = projection.pieces.get(run[0] as usize) else {
                for _ in run {
                    take(i, Sample::Nothing);
                    i += 1;
                }
                continue;
            };
            let coordinates = projection.coordinates(seen.region);
            let mut last = 0;
            for _ in run {
                let direction = window.forward
                    + (window.left + (i as f64 + 0.5) * window.pixel) * window.right
                    + (window.bottom + (j as f64 + 0.5) * window.pixel) * window.up;
                let at = |k: usize| coordinates[k].dot(direction);
                let (surface, [a, b, c]) =
                    projection
                        .drawable
                        .surface_at(seen.region, [at(0), at(1), at(2)], &mut last);
                let sample = if seen.is_back_face {
                    Sample::BackFace(surface)
                } else {
                    let (a, b, c) = (a.max(0.0), b.max(0.0), c.max(0.0));
                    let sum = a + b + c;
                    Sample::Front {
                        surface,
                        barycentric: [(a / sum) as f32, (b / sum) as f32, (c / sum) as f32],
                        depth: (1.0 / seen.inverse_depth.dot(direction)) as f32,
                    }
                };
                take(i, sample);
                i += 1;
            }
        }
    }
}

/// Where an edge crosses the rows: row j at pixel base + slope j.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    base: f64,
    slope: f64,
}

/// The edges of a piece: its rows lie to the right of all `low` and to the left of all `high`.
#[derive(Clone, Debug, Default)]
struct Spans {
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
        let [a, b, c] = over_pixels(edge.across, window);
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

#[simd]
fn draw<S: Simd>(
    simd: S,
    projection: &Projection,
    beyond: u32,
    window: &Window,
    spans: &mut Spans,
    inverse_depth: &mut [f32],
    pieces: &mut [u32],
) {
    let stride = window.width + PADDING;
    let lanes = S::f64s::LEN;
    for (index, seen) in projection.pieces.iter().enumerate() {
        if seen.outside & beyond != 0 {
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
        let [depth_i, depth_j, depth_1] = over_pixels(seen.inverse_depth, window);
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
                let start = j * stride + first;
                let padded = start..start + count.next_multiple_of(PADDING);
                fill(
                    simd,
                    &mut inverse_depth[padded.clone()],
                    &mut pieces[padded],
                    count,
                    (depth_i * first as f64 + (depth_j * j as f64 + depth_1)) as f32,
                    depth_i as f32,
                    index as u32,
                );
            }
            row += lanes;
        }
    }
}

/// Draws one span: where it is nearer than what is there, its depth and index replace it.
#[simd]
fn fill<S: Simd>(
    simd: S,
    inverse_depth: &mut [f32],
    pieces: &mut [u32],
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
    let pieces = pieces.chunks_exact_mut(lanes);
    for (k, (old_depth, old_piece)) in depths.zip(pieces).enumerate() {
        if k * lanes >= count {
            break;
        }
        let offset = iota + (k * lanes) as f32;
        let depth = base_v + step_v * offset;
        let before = S::f32s::from_slice(simd, old_depth);
        let nearer = depth.simd_gt(before) & offset.simd_lt(count_v);
        nearer.select(depth, before).store_slice(old_depth);
        let before = S::u32s::from_slice(simd, old_piece);
        nearer.select(index_v, before).store_slice(old_piece);
    }
}
