//! Looking up the patches that pixels see.
//!
//! Along a run of pixels of one surface the barycentric coordinates of the hit points are, up to a
//! common factor, linear, and the walk down the bisection tree ([`scene::bisection`]) needs no more.

use fearless_simd::{Simd, f32x8, prelude::*, u32x8};
use fearless_simd_macros::simd;

use super::projection::{OverPixels, Projected};
use super::raster::NONE;

/// What looking patches up needs to know, the same for all rows of a window.
pub(super) struct LookUp<'a> {
    /// All that the eye sees.
    pub surfaces: &'a [Projected],
    /// Their e_k over the window's pixels.
    pub edges: &'a [[OverPixels; 3]],
    /// What a pixel gets that sees nothing.
    pub nothing: u32,
    /// What a pixel gets that sees a back face.
    pub back_face: u32,
}

/// Patch IDs of row j.
#[simd]
pub(super) fn look_up_row<S: Simd>(
    simd: S,
    look_up: &LookUp,
    j: usize,
    surface: &[u32],
    ids: &mut [u32],
) {
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
