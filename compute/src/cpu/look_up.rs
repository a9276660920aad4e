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

use std::ops::Range;

use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*, u32x8};
use fearless_simd_macros::simd;
use glam::DVec3;

use super::projection::{OverPixels, Projection, over_pixels};
use super::raster::NONE;
use super::regions::{Locator, Member, NO_MEMBER};
use super::runs::for_each_run;
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

/// A region's member in a picture.
#[derive(Clone, Copy, Debug)]
struct MemberOverPixels {
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
const NO_PICTURE: u32 = 0;

const NOT_SET_UP: MemberOverPixels = MemberOverPixels {
    tree: Tree {
        barycentric: [[0.0; 3]; 3],
        first_patch: 0,
        depth: 0,
    },
    crossings: [[0.0; 2]; 3],
    is_exit: [false; 3],
    neighbours: [NO_MEMBER; 3],
    picture: NO_PICTURE,
};

/// Coefficients of i, of j and of 1 of a value over the pixels.
type Linear = [f32; 3];

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
struct Tree {
    barycentric: [Linear; 3],
    first_patch: u32,
    depth: u32,
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
        self.members
            .resize(projection.drawable.member_count(), NOT_SET_UP);
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

/// Looks up runs of pixels in a region of many surfaces.
///
/// A run is walked from surface to surface: where it leaves one, its barycentric coordinates tell the side, and
/// the surface on the other side is the next, unless a corner or a surface smaller than a pixel is in the
/// way. Then the locator is asked.
struct Walk<'a> {
    locator: &'a Locator,
    coordinates: &'a [OverPixels; 3],
    members: &'a mut [MemberOverPixels],
    picture: u32,
    row: usize,
}

/// How far beyond its side, in pixels, a surface is still taken to hold a pixel: more than rounding, less than
/// matters.
const BESIDE: f32 = 1.0 / 1024.0;

/// Pixels that no run has.
const MOST_EXIT: f32 = (1 << 20) as f32;

impl Walk<'_> {
    /// Patch IDs of a run, which is not empty; `last` is the member to try first, and then the one that was right.
    #[inline(always)]
    fn look_up<S: Simd>(&mut self, simd: S, run: Range<usize>, last: &mut u32, ids: &mut [u32]) {
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
        let [u, v, w] = *self.coordinates;
        let value = |[a, b, c]: OverPixels| (a * i + (b * j + c)) as f32;
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
    /// A member over the pixels, over which the region's coordinates are given.
    #[inline(always)]
    fn new(member: &Member, [u, v, w]: &[OverPixels; 3], picture: u32) -> Self {
        let mut new = Self {
            picture,
            neighbours: member.neighbours,
            ..NOT_SET_UP
        };
        new.tree.first_patch = member.first_patch;
        new.tree.depth = member.depth;
        for (side, [p, q, r]) in member.barycentric.into_iter().enumerate() {
            let value = |k: usize| p * u[k] + q * v[k] + r * w[k];
            let [a, b, c] = [value(0), value(1), value(2)];
            new.tree.barycentric[side] = [a as f32, b as f32, c as f32];
            new.is_exit[side] = a < 0.0;
            // A side along the rows crosses them far to the left or far to the right.
            let least = (b.abs() + c.abs()) / f64::from(MOST_EXIT);
            let a = a.abs().max(least).copysign(a);
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

/// Patch IDs of pixels from `start` on of row j in one surface.
#[inline(always)]
fn look_up_tree<S: Simd>(simd: S, tree: &Tree, j: f32, start: usize, ids: &mut [u32]) {
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
const LOOK_UP_LANES: usize = 8;

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
