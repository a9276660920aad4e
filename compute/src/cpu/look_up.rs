//! Looking up the patches that pixels see.
//!
//! # Theory
//! Along a picture's rows the coordinates of the points that rays hit in a region are, up to a common
//! factor, linear; so are the barycentric coordinates in each of its surfaces, and the walk down the
//! bisection tree ([`scene::bisection`]) needs no more.
//!
//! # Practice
//! Runs of pixels that see one piece are looked up, eight pixels at a time. What is linear over a window is kept
//! as f32: a point is right to some 2^-24 of the window's pixels, 1e-4 pixels where there are a thousand.

// Functions that a vectorised caller needs must be inlined into it: compiled on their own they would
// be for the baseline instruction set.
#![allow(clippy::inline_always)]

use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*, u32x8};
use fearless_simd_macros::simd;
use glam::DVec3;

use super::projection::{OverPixels, Projection, over_pixels};
use super::raster::NONE;
use super::runs::for_each_run;
use super::walk::{MemberOverPixels, NO_PICTURE, Walk};
use crate::hemicube::Window;

/// Looks patches up, row by row of a picture.
#[derive(Clone, Debug, Default)]
pub(super) struct LookUp {
    window: Option<Window>,
    /// What a pixel gets that sees nothing.
    nothing: u32,
    /// What a pixel gets that sees a back face.
    back_face: u32,
    /// How each of the projection's pieces is looked up, as far as it has been asked for.
    ways: Vec<Way>,
    /// Of all regions' members, see [`Drawable::first_member`].
    members: Vec<MemberOverPixels>,
    /// Counts pictures; what is of another one is not valid.
    picture: u32,
    /// One row of patch IDs.
    ids: Vec<u32>,
}

/// Coefficients of i, of j and of 1 of a value over the pixels.
pub(super) type Linear = [f32; 3];

/// How the patches of a piece are found.
#[derive(Clone, Copy, Debug, Default)]
enum Way {
    #[default]
    NotAsked,
    /// All pixels get the same.
    Constant(u32),
    /// By bisection of one surface.
    Surface(Tree),
    /// By finding the surface first, from the region's coordinates.
    Many {
        region: u32,
        coordinates: [OverPixels; 3],
        /// The member that the last run began on.
        last: u32,
    },
}

/// A bisection tree over the pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tree {
    pub barycentric: [Linear; 3],
    pub first_patch: u32,
    pub depth: u32,
}

impl LookUp {
    /// Gets ready for a picture.
    pub fn start(
        &mut self,
        projection: &Projection,
        window: &Window,
        nothing: u32,
        back_face: u32,
    ) {
        self.window = Some(*window);
        self.nothing = nothing;
        self.back_face = back_face;
        self.ways.clear();
        self.ways.resize(projection.pieces.len(), Way::NotAsked);
        self.ids.resize(window.width + LOOK_UP_LANES, 0);
        self.picture = self.picture.checked_add(1).unwrap_or_else(|| {
            self.members.clear();
            NO_PICTURE + 1
        });
        self.members.resize(
            projection.drawable.member_count(),
            MemberOverPixels::NOT_SET_UP,
        );
    }

    /// Takes what is not of some regions, ascending, for nothing.
    pub fn leave_out_all_but(&mut self, projection: &Projection, regions: &[u32]) {
        for (way, piece) in self.ways.iter_mut().zip(&projection.pieces) {
            if regions.binary_search(&piece.region).is_err() {
                *way = Way::Constant(self.nothing);
            }
        }
    }

    /// Patch IDs of row j, whose pixels see `pieces`.
    pub fn row(
        &mut self,
        level: Level,
        projection: &Projection,
        j: usize,
        pieces: &[u32],
    ) -> &[u32] {
        dispatch!(level, simd => look_up_row(simd, self, projection, j, pieces));
        &self.ids[..pieces.len()]
    }
}

/// How a piece is looked up in a window.
#[cold]
fn way(projection: &Projection, window: &Window, index: usize, back_face: u32) -> Way {
    let seen = &projection.pieces[index];
    if seen.is_back_face {
        return Way::Constant(back_face);
    }
    let drawable = &projection.drawable;
    let facts = &drawable.facts[seen.region as usize];
    let coordinates = || projection.coordinates(seen.region);
    let linear = |e: DVec3| over_pixels(e, window).map(|value| value as f32);
    match &drawable.regions().regions()[seen.region as usize].locator {
        None if facts.depth == 0 => Way::Constant(facts.first_patch),
        None => Way::Surface(Tree {
            barycentric: coordinates().map(linear),
            first_patch: facts.first_patch,
            depth: facts.depth,
        }),
        Some(_) => Way::Many {
            region: seen.region,
            coordinates: coordinates().map(|e| over_pixels(e, window)),
            last: 0,
        },
    }
}

#[simd]
fn look_up_row<S: Simd>(
    simd: S,
    look_up: &mut LookUp,
    projection: &Projection,
    j: usize,
    pieces: &[u32],
) {
    let LookUp {
        window: Some(window),
        nothing,
        back_face,
        ways,
        members,
        picture,
        ids,
    } = look_up
    else {
        return;
    };
    for_each_run(
        simd,
        pieces,
        #[inline(always)]
        |index, start, end| {
            if index == NONE {
                ids[start..end].fill(*nothing);
                return;
            }
            let stored = &mut ways[index as usize];
            if let Way::NotAsked = stored {
                *stored = way(projection, window, index as usize, *back_face);
            }
            let padded = start..start + (end - start).next_multiple_of(LOOK_UP_LANES);
            match stored {
                Way::NotAsked => {}
                Way::Constant(id) => ids[start..end].fill(*id),
                Way::Surface(tree) => {
                    look_up_tree(simd, tree, j as f32, start, &mut ids[padded]);
                }
                Way::Many {
                    region,
                    coordinates,
                    last,
                } => {
                    let drawable = &projection.drawable;
                    let first_member = drawable.first_member(*region);
                    if let Some(locator) = &drawable.regions().regions()[*region as usize].locator {
                        let mut walk = Walk {
                            locator,
                            coordinates,
                            members: &mut members[first_member..][..locator.members().len()],
                            picture: *picture,
                            row: j,
                        };
                        walk.look_up(simd, start..end, last, ids);
                    }
                }
            }
        },
    );
}

/// The same patch for all.
#[inline(always)]
pub(super) fn fill<S: Simd>(simd: S, patch: u32, ids: &mut [u32]) {
    let patches = u32x8::splat(simd, patch);
    for ids in ids.chunks_exact_mut(LOOK_UP_LANES) {
        patches.store_slice(ids);
    }
}

/// Patch IDs of pixels from `start` on of row j in one surface.
#[inline(always)]
pub(super) fn look_up_tree<S: Simd>(simd: S, tree: &Tree, j: f32, start: usize, ids: &mut [u32]) {
    let iota = f32x8::from_fn(simd, |lane| lane as f32);
    for (k, ids) in ids.chunks_exact_mut(LOOK_UP_LANES).enumerate() {
        let i = iota + (start + k * LOOK_UP_LANES) as f32;
        let [a, b, c] = &tree.barycentric;
        let barycentric = [at(*a, i, j), at(*b, i, j), at(*c, i, j)];
        let code = leaf_codes(simd, barycentric, tree.depth);
        (code + tree.first_patch).store_slice(ids);
    }
}

/// Pixels looked up at a time. Runs of one surface are often short, so that wider vectors, where
/// there are any, would mostly look up pixels that nobody asked for.
pub(super) const LOOK_UP_LANES: usize = 8;

/// A value at pixels i of row j.
#[inline(always)]
fn at<S: Simd>([a, b, c]: Linear, i: f32x8<S>, j: f32) -> f32x8<S> {
    i * a + (b * j + c)
}

/// The walk down of [`scene::bisection::locate`], all lanes together.
#[inline(always)]
fn leaf_codes<S: Simd>(simd: S, [mut a, mut b, mut c]: [f32x8<S>; 3], depth: u32) -> u32x8<S> {
    let one = u32x8::splat(simd, 1);
    let zero = u32x8::splat(simd, 0);
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
    code
}
