//! Looking up the patches of a region of many surfaces, where these are wide in the picture.
//!
//! A run of pixels is walked from surface to surface. In a picture the sides of a surface cross a row at pixels
//! that are linear in the row's number: the run leaves the surface at the first side that it crosses outwards, and
//! the neighbour there is the next surface. Where there is none, or where it does not hold the next pixel, since a
//! corner or a surface smaller than a pixel was in the way, the [`Locator`] is asked; neighbours save time and
//! decide nothing. Crossings are kept for each surface and picture, as far as they have been asked for.
//!
//! Each surface costs some mispredicted branches: where it is narrow, [`super::locate`] is faster.

use std::ops::Range;

use fearless_simd::{Simd, prelude::*, u32x8};

use super::tree::{LOOK_UP_LANES, Tree, look_up_tree};
use crate::affine::Affine;
use crate::regions::{Locator, Member, NO_MEMBER};

/// A region's member in a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MemberOverPixels {
    /// Coefficients of the row j and of 1 of the pixel where the side crosses the row.
    crossings: [[f32; 2]; 3],
    /// Whether rows leave through the side; else they enter there.
    is_exit: [bool; 3],
    /// See [`Member::neighbours`].
    neighbours: [u32; 3],
    picture: u32,
    tree: Tree,
}

/// No picture has this number.
pub(crate) const NO_PICTURE: u32 = 0;

/// Looks up runs of pixels of one row in a region of many surfaces.
pub(crate) struct Walk<'a> {
    pub locator: &'a Locator,
    /// The region's, over the pixels.
    pub coordinates: &'a [Affine; 3],
    /// One per member.
    pub members: &'a mut [MemberOverPixels],
    /// The number of the picture.
    pub picture: u32,
    pub row: usize,
}

/// How far beyond its side along the row, in pixels, a surface is still taken to hold a pixel: less than matters,
/// and more than rounding but for sides that are nearly along the row. There the locator may be asked in vain.
const BESIDE: f32 = 1.0 / 1024.0;

/// Pixels that no run has.
const MOST_EXIT: f32 = (1 << 20) as f32;

/// What a side's value changes by from one pixel to the next is taken to be at least this share of what it is:
/// no picture shows the difference, and crossings are f32.
const LEAST_SLOPE: f64 = 1e-30;

impl Walk<'_> {
    /// Patch IDs of a run, which is not empty; `last` is the member to try first, and then the one that was right.
    #[inline(always)]
    pub fn look_up<S: Simd>(
        &mut self,
        simd: S,
        run: Range<usize>,
        last: &mut u32,
        ids: &mut [u32],
    ) {
        let j = self.row as f32;
        let mut start = run.start;
        let mut index = *last;
        let mut is_found = false;
        while start < run.end {
            let member = self.member(index);
            let mut entry = 0.0;
            let mut exit = MOST_EXIT;
            let mut next = NO_MEMBER;
            for k in 0..3 {
                let [b, c] = member.crossings[k];
                let crossing = b * j + c;
                let is_next = member.is_exit[k] && crossing < exit;
                next = if is_next { member.neighbours[k] } else { next };
                exit = if is_next { crossing } else { exit };
                let is_entry = !member.is_exit[k] && crossing > entry;
                entry = if is_entry { crossing } else { entry };
            }
            let i = start as f32;
            let holds = i + BESIDE >= entry && i - BESIDE <= exit;
            if !(holds || is_found) {
                index = self.find(start);
                is_found = true;
                continue;
            }
            if start == run.start {
                *last = index;
            }
            // A cast saturates, and makes 0 of NaN.
            let end = (exit as u32 as usize + 1).clamp(start + 1, run.end);
            let ids = &mut ids[start..start + (end - start).next_multiple_of(LOOK_UP_LANES)];
            if member.tree.depth == 0 {
                fill(simd, member.tree.first_patch, ids);
            } else {
                look_up_tree(simd, &member.tree, j, start, ids);
            }
            start = end;
            index = next;
            is_found = false;
            if index == NO_MEMBER && start < run.end {
                index = self.find(start);
                is_found = true;
            }
        }
    }

    /// The member that the locator finds at a pixel.
    #[inline(always)]
    fn find(&self, i: usize) -> u32 {
        let (i, j) = (i as f64, self.row as f64);
        let value = |[a, b, c]: Affine| (a * i + (b * j + c)) as f32;
        let [u, v, w] = *self.coordinates;
        self.locator.locate([value(u), value(v), value(w)]) as u32
    }

    /// A member over the pixels.
    #[inline(always)]
    fn member(&mut self, index: u32) -> &MemberOverPixels {
        let stored = &mut self.members[index as usize];
        if stored.picture != self.picture {
            let member = &self.locator.members()[index as usize];
            *stored = MemberOverPixels::new(member, self.coordinates, self.picture);
        }
        stored
    }
}

impl MemberOverPixels {
    /// Of no picture.
    pub const NOT_SET_UP: Self = Self {
        tree: Tree {
            difference: [0.0; 3],
            third: [0.0; 3],
            sum: [0.0; 3],
            first_patch: 0,
            depth: 0,
        },
        crossings: [[0.0; 2]; 3],
        is_exit: [false; 3],
        neighbours: [NO_MEMBER; 3],
        picture: NO_PICTURE,
    };

    /// A member over the pixels, over which the region's coordinates are given.
    #[inline(always)]
    fn new(member: &Member, [u, v, w]: &[Affine; 3], picture: u32) -> Self {
        let barycentric = member
            .barycentric
            .map(|[p, q, r]| [0, 1, 2].map(|k| p * u[k] + q * v[k] + r * w[k]));
        let mut new = Self {
            picture,
            neighbours: member.neighbours,
            tree: Tree::over_pixels(barycentric, member.first_patch, member.depth),
            ..Self::NOT_SET_UP
        };
        for (side, [a, b, c]) in barycentric.into_iter().enumerate() {
            // A side along the rows crosses them far to the left or far to the right.
            let least = LEAST_SLOPE * (b.abs() + c.abs());
            let a = a.abs().max(least).copysign(a);
            new.is_exit[side] = a.is_sign_negative();
            new.crossings[side] = [(-b / a) as f32, (-c / a) as f32];
        }
        new
    }
}

/// The same patch for all.
#[inline(always)]
fn fill<S: Simd>(simd: S, patch: u32, ids: &mut [u32]) {
    let patches = u32x8::splat(simd, patch);
    for ids in ids.chunks_exact_mut(LOOK_UP_LANES) {
        patches.store_slice(ids);
    }
}
