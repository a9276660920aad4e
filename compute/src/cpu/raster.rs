//! Drawing surfaces into a window of pixels, with a depth buffer, and looking patches up.
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
//! The vectors are set up once an eye, for all windows, in f64; rows of pixels are f32. Two triangles
//! that share an edge compute its crossing of a row from the same numbers with opposite signs, so
//! no pixel between them is missed. Reversed depth: 1/w is kept, 0 is infinitely far.

use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*, u32x8};
use fearless_simd_macros::simd;
use glam::DVec3;
use scene::{Scene, SurfaceId};

use crate::hemicube::{Frame, Window};

/// Back faces are drawn this much too deep, so that a pixel on the silhouette of a solid, where a
/// front and a back face meet at equal depth, sees the front: well above the rounding of an f32
/// depth (2^-24) and of its steps along a row, well below any wall's thickness.
const BACK_FACE_RETREAT: f64 = 1.0 - 1.0 / (1 << 19) as f64;

/// Front faces are drawn this much too large, in pixels, so that a ray through an edge or a corner
/// meets a front whatever the rounding, where surfaces only touch (T-junctions) too: above the f64
/// rounding of a crossing, 2^-53 times some thousands of pixels, and far below a pixel.
const FRONT_FACE_OUTSET: f64 = 1e-9;

/// What is done about the backs of surfaces, which are one-sided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cull {
    /// They occlude, and are seen as [`Sample::BackFace`].
    Nothing,
    /// They are not there.
    BackFaces,
}

/// A surface as seen from one eye, in the eye's frame.
#[derive(Clone, Copy, Debug)]
struct Projected {
    /// e_k(d) = edges[k] . d; at least 0 inside, k-th barycentric coordinate up to a factor.
    edges: [DVec3; 3],
    /// 1/w = inverse_depth . d, 1/m.
    inverse_depth: DVec3,
    corners: [DVec3; 3],
    surface: SurfaceId,
    /// Its bisection tree's first patch and depth.
    first_patch: u32,
    depth: u32,
    is_back_face: bool,
}

/// All surfaces that an eye can see, set up for drawing into any window of its frame.
#[derive(Clone, Debug, Default)]
pub struct Projection {
    surfaces: Vec<Projected>,
}

/// Coordinates are f32: a point's distance from a plane through others like it is uncertain by some
/// units in the last place (2^-24 relative) of the largest coordinate; four of them are taken.
pub fn plane_tolerance(scene: &Scene) -> f64 {
    let [low, high] = scene.bounds();
    f64::from(low.abs().max(high.abs()).max_element()) * 4.0 / f64::from(1 << 24)
}

impl Projection {
    /// Sets up all surfaces but `own`, which the eye lies on. `tolerance` is
    /// [`plane_tolerance`]: surfaces at or below the horizon (z = 0 in the frame, if `horizon`) or
    /// edge-on within it are left out.
    pub fn set(
        &mut self,
        scene: &Scene,
        frame: &Frame,
        own: Option<SurfaceId>,
        horizon: bool,
        cull: Cull,
        tolerance: f64,
    ) {
        self.surfaces.clear();
        for (index, surface) in scene.surfaces().iter().enumerate() {
            let id = SurfaceId(index as u32);
            if own == Some(id) {
                continue;
            }
            let [q0, q1, q2] = surface.corners.map(|p| frame.to_local(p.as_dvec3()));
            if horizon && q0.z.max(q1.z).max(q2.z) <= tolerance {
                continue;
            }
            let mut edges = [q1.cross(q2), q2.cross(q0), q0.cross(q1)];
            // Twice the area times the normal; its product with any corner is the determinant.
            let normal = (q1 - q0).cross(q2 - q0);
            let mut determinant = normal.dot(q0);
            if determinant.abs() <= tolerance * normal.length() {
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
const NONE: u32 = u32::MAX;

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

/// A value that is linear over a window's pixels: its coefficients of i, of j and of 1.
type OverPixels = [f64; 3];

/// Where a triangle's edges cross a row of pixels: between `low` and `high` lies the inside.
#[derive(Clone, Copy)]
struct Crossings {
    /// Base and slope of each: the crossing of row j is at pixel base + slope j.
    low: [(f64, f64); 3],
    high: [(f64, f64); 3],
}

impl Crossings {
    /// e_k at the centre of pixel (i, j) is a i + b j + c; edges are moved outwards by `outset` pixels.
    #[inline(always)]
    fn new(edges: &[OverPixels; 3], outset: f64) -> Self {
        let mut crossings = Self {
            low: [(f64::NEG_INFINITY, 0.0); 3],
            high: [(f64::INFINITY, 0.0); 3],
        };
        for (k, &[a, b, c]) in edges.iter().enumerate() {
            let c = c + outset * (a.abs() + b.abs());
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

/// The value v . d, linear over the pixels' centres, as the coefficients of i, of j and of 1.
#[inline(always)]
fn over_pixels(v: DVec3, window: &Window) -> OverPixels {
    let (x, y) = (v.dot(window.right), v.dot(window.up));
    let c = v.dot(window.forward)
        + x * (window.left + 0.5 * window.pixel)
        + y * (window.bottom + 0.5 * window.pixel);
    [x * window.pixel, y * window.pixel, c]
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
        for k in 0..3 {
            edges[index][k] = over_pixels(seen.edges[k], window);
        }
        let outset = if seen.is_back_face {
            0.0
        } else {
            FRONT_FACE_OUTSET
        };
        let crossings = Crossings::new(&edges[index], outset);
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

/// What looking patches up needs to know, the same for all rows of a window.
struct LookUp<'a> {
    surfaces: &'a [Projected],
    edges: &'a [[OverPixels; 3]],
    nothing: u32,
    back_face: u32,
}

/// Patch IDs of row j.
#[simd]
fn look_up_row<S: Simd>(simd: S, look_up: &LookUp, j: usize, surface: &[u32], ids: &mut [u32]) {
    let mut start = 0;
    while start < surface.len() {
        let index = surface[start];
        let mut end = start + 1;
        while end < surface.len() && surface[end] == index {
            end += 1;
        }
        if index == NONE {
            ids[start..end].fill(look_up.nothing);
        } else {
            let seen = &look_up.surfaces[index as usize];
            if seen.is_back_face {
                ids[start..end].fill(look_up.back_face);
            } else if seen.depth == 0 {
                ids[start..end].fill(seen.first_patch);
            } else {
                let mut values = [(0.0, 0.0); 3];
                for (value, [a, b, c]) in values.iter_mut().zip(look_up.edges[index as usize]) {
                    *value = ((a * start as f64 + (b * j as f64 + c)) as f32, a as f32);
                }
                let ids = &mut ids[start..start + (end - start).next_multiple_of(LOOK_UP_LANES)];
                look_up_run(simd, values, seen.depth, seen.first_patch, ids);
            }
        }
        start = end;
    }
}

/// Pixels looked up at a time. Runs of one surface are often short, so that wider vectors, where
/// there are any, would mostly look up pixels that nobody asked for.
const LOOK_UP_LANES: usize = 8;

/// Patch IDs of a run of pixels of one surface: the walk down of [`scene::bisection::locate`], all
/// lanes together. `values` are e_k at the first pixel and its step from pixel to pixel.
#[simd]
fn look_up_run<S: Simd>(
    simd: S,
    values: [(f32, f32); 3],
    depth: u32,
    first_patch: u32,
    ids: &mut [u32],
) {
    let iota = f32x8::from_fn(simd, |lane| lane as f32);
    let one = u32x8::splat(simd, 1);
    let zero = u32x8::splat(simd, 0);
    let [(a_base, a_step), (b_base, b_step), (c_base, c_step)] = values;
    for (k, ids) in ids.chunks_exact_mut(LOOK_UP_LANES).enumerate() {
        let offset = iota + (k * LOOK_UP_LANES) as f32;
        let mut a = offset * a_step + a_base;
        let mut b = offset * b_step + b_base;
        let mut c = offset * c_step + c_base;
        let mut code = zero;
        for _ in 0..depth {
            let second = a.simd_lt(b);
            let difference = (a - b).abs();
            let least = a.min(b);
            a = second.select(c, difference);
            b = second.select(difference, c);
            c = least + least;
            code = (code + code) | second.select(one, zero);
        }
        (code + first_patch).store_slice(ids);
    }
}
