//! The way down the bisection trees of surfaces, for eight pixels at a time.

use fearless_simd::{Simd, f32x8, prelude::*, u32x8};

use crate::affine::Affine;

/// Coefficients of i, of j and of 1 of a value over the pixels.
pub(crate) type Linear = [f32; 3];

/// A bisection tree over the pixels: a - b, c and a + b + c, see [`scene::bisection`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tree {
    pub difference: Linear,
    pub third: Linear,
    pub sum: Linear,
    pub first_patch: u32,
    pub depth: u32,
}

impl Tree {
    /// The tree of a surface whose barycentric coordinates are given.
    #[inline(always)]
    pub fn over_pixels([a, b, c]: [Affine; 3], first_patch: u32, depth: u32) -> Self {
        Self {
            difference: [0, 1, 2].map(|k| (a[k] - b[k]) as f32),
            third: c.map(|c| c as f32),
            sum: [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) as f32),
            first_patch,
            depth,
        }
    }
}

/// Patch IDs of pixels from `start` on of row j in one surface.
#[inline(always)]
pub(crate) fn look_up_tree<S: Simd>(simd: S, tree: &Tree, j: f32, start: usize, ids: &mut [u32]) {
    let iota = f32x8::from_fn(simd, |lane| lane as f32);
    let row = |[a, b, c]: Linear| [a, b * j + c];
    let (difference, third, sum) = (row(tree.difference), row(tree.third), row(tree.sum));
    for (k, ids) in ids.chunks_exact_mut(LOOK_UP_LANES).enumerate() {
        let i = iota + (start + k * LOOK_UP_LANES) as f32;
        let code = leaf_codes(
            simd,
            [at(difference, i), at(third, i), at(sum, i)],
            tree.depth,
        );
        (code + tree.first_patch).store_slice(ids);
    }
}

/// Pixels looked up at a time. Runs of one region are often short, so that wider vectors, where
/// there are any, would mostly look up pixels that nobody asked for.
pub(crate) const LOOK_UP_LANES: usize = 8;

/// Coefficients of i and of 1 of a value over the pixels of a row.
pub(crate) type AlongRow = [f32; 2];

/// A value at pixels i.
#[inline(always)]
pub(crate) fn at<S: Simd>([a, b]: AlongRow, i: f32x8<S>) -> f32x8<S> {
    i * a + b
}

/// The walk down of [`scene::bisection::locate`], all lanes together. It is told a - b, c and a + b + c, which stays:
/// a child's a - b is |a - b| - c in the first one, and the opposite in the second one, its c is twice the lesser
/// of a and b.
#[inline(always)]
pub(crate) fn leaf_codes<S: Simd>(
    simd: S,
    [difference, third, sum]: [f32x8<S>; 3],
    depth: u32,
) -> u32x8<S> {
    const SIGN: u32 = 1 << 31;
    let (mut difference, mut third) = (difference, third);
    let mut code = u32x8::splat(simd, 0);
    for _ in 0..depth {
        let sign = difference.bitcast::<u32x8<S>>() & SIGN;
        let magnitude = difference.abs();
        let first = (magnitude - third).bitcast::<u32x8<S>>();
        difference = (first ^ sign).bitcast();
        third = sum - (third + magnitude);
        code = (code + code) | (sign >> 31);
    }
    code
}
