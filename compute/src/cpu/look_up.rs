//! Looking up the patches that pixels see.
//!
//! # Theory
//! Along a picture's rows the coordinates of the points that rays hit in a region are, up to a common
//! factor, linear; so are the barycentric coordinates in each of its surfaces, and the way down the
//! bisection tree ([`scene::bisection`]) needs no more.
//!
//! # Practice
//! Runs of pixels that see one piece are looked up, eight pixels at a time. In a region of many surfaces that is
//! done by [`super::walk`] where its surfaces are wide in the picture, else by [`super::locate`]. What is linear
//! over a window is kept as f32: a point is right to some 2^-24 of the window's pixels, 1e-4 pixels where there are a thousand.

// Functions that a vectorised caller needs must be inlined into it: compiled on their own they would
// be for the baseline instruction set.
#![allow(clippy::inline_always)]

use fearless_simd::{Level, Simd, dispatch, f32x8, prelude::*, u32x8};
use fearless_simd_macros::simd;
use scene::bisection::leaf_code;

use super::locate::{Located, Points};
use super::over_pixels::{OverPixels, over_pixels};
use super::projection::Projection;
use super::raster::NONE;
use super::runs::for_each_run;
use super::tried::{SPECK, SPECK_BACK, SPECK_REGION};
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
    /// What one row's pixels see of regions of many surfaces.
    points: Points,
    /// Runs of one row.
    runs: Vec<Run>,
    /// Of the members of each region of many surfaces; none before it is walked for the first time.
    members: Vec<Vec<MemberOverPixels>>,
    /// Counts pictures; what is of another one is not valid.
    picture: u32,
    /// One row of patch IDs.
    ids: Vec<u32>,
}

/// Pixels of a row that see one piece.
#[derive(Clone, Copy, Debug)]
struct Run {
    start: u32,
    end: u32,
    piece: u32,
    /// Whether it is walked from surface to surface.
    is_walked: bool,
}

/// Runs of fewer pixels are not worth the question how wide surfaces are. Tuned, as the next one, on the hall at 100 to 500
/// pixels and the reference scenes at 128 and 500.
const FEWEST_WALKED: usize = 24;

/// Mean width in pixels from which on surfaces are walked through.
const WIDE: f32 = 12.0;

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
    /// By finding the surface first; walks try the member on which the last one began.
    Many(Located, u32),
}

/// A bisection tree over the pixels: a - b, c and a + b + c, see [`scene::bisection`].
#[derive(Clone, Copy, Debug)]
pub(super) struct Tree {
    pub difference: Linear,
    pub third: Linear,
    pub sum: Linear,
    pub first_patch: u32,
    pub depth: u32,
}

impl Tree {
    /// The tree of a surface whose barycentric coordinates are given.
    #[inline(always)]
    pub fn over_pixels([a, b, c]: [OverPixels; 3], first_patch: u32, depth: u32) -> Self {
        Self {
            difference: [0, 1, 2].map(|k| (a[k] - b[k]) as f32),
            third: c.map(|c| c as f32),
            sum: [0, 1, 2].map(|k| (a[k] + b[k] + c[k]) as f32),
            first_patch,
            depth,
        }
    }
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
        self.picture = self.picture.checked_add(1).unwrap_or_else(|| {
            self.members.clear();
            NO_PICTURE + 1
        });
        self.members
            .resize(projection.drawable.locators.count(), Vec::new());
        self.points.resize(window.width);
        self.ids.resize(window.width + LOOK_UP_LANES, 0);
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
    let tree = &drawable.trees[seen.region as usize];
    match &drawable.regions().regions()[seen.region as usize].locator {
        None if tree.depth == 0 => Way::Constant(tree.first_patch),
        None => {
            let coordinates = projection.coordinates(seen.region);
            let over_pixels = coordinates.map(|e| over_pixels(e, window));
            Way::Surface(Tree::over_pixels(over_pixels, tree.first_patch, tree.depth))
        }
        Some(locator) => {
            let coordinates = projection.coordinates(seen.region);
            let over_pixels = coordinates.map(|e| over_pixels(e, window));
            Way::Many(Located::new(drawable, seen.region, locator, over_pixels), 0)
        }
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
        points,
        runs,
        members,
        picture,
        ids,
    } = look_up
    else {
        return;
    };
    points.clear();
    runs.clear();
    for_each_run(
        simd,
        pieces,
        #[inline(always)]
        |piece, start, end| {
            let mut is_walked = false;
            if piece & SPECK == 0 {
                let stored = &mut ways[piece as usize];
                if let Way::NotAsked = stored {
                    *stored = way(projection, window, piece as usize, *back_face);
                }
                if let Way::Many(located, _) = stored {
                    is_walked =
                        end - start >= FEWEST_WALKED && located.width(j, start..end) >= WIDE;
                    if !is_walked {
                        points.add(simd, located, j, start..end);
                    }
                }
            }
            runs.push(Run {
                start: start as u32,
                end: end as u32,
                piece,
                is_walked,
            });
        },
    );
    let found = points.look_up(simd, &projection.drawable.locators);
    let mut next = 0;
    // What is written beyond the end of a run is overwritten by the next one.
    for run in runs.iter() {
        let (start, end) = (run.start as usize, run.end as usize);
        let index = run.piece;
        if index == NONE {
            ids[start..end].fill(*nothing);
            continue;
        }
        let padded = start..start + (end - start).next_multiple_of(LOOK_UP_LANES);
        if index & SPECK != 0 {
            look_up_speck(
                projection,
                window,
                index,
                *back_face,
                [start, j],
                &mut ids[start..end],
            );
            continue;
        }
        match &mut ways[index as usize] {
            Way::NotAsked => {}
            Way::Constant(id) => ids[start..end].fill(*id),
            Way::Surface(tree) => {
                look_up_tree(simd, tree, j as f32, start, &mut ids[padded]);
            }
            Way::Many(located, last) if run.is_walked => {
                let drawable = &projection.drawable;
                let region = projection.pieces[index as usize].region;
                if let Some(locator) = &drawable.regions().regions()[region as usize].locator {
                    let members = &mut members[drawable.locators.rank(region)];
                    let count = locator.members().len();
                    if members.len() != count {
                        members.resize(count, MemberOverPixels::NOT_SET_UP);
                    }
                    let mut walk = Walk {
                        locator,
                        coordinates: &located.coordinates(),
                        members,
                        picture: *picture,
                        row: j,
                    };
                    walk.look_up(simd, start..end, last, ids);
                }
            }
            Way::Many(..) => {
                let to = ids[padded].chunks_exact_mut(LOOK_UP_LANES);
                for (to, from) in to.zip(found[next..].chunks_exact(LOOK_UP_LANES)) {
                    to.copy_from_slice(from);
                }
                next += end - start;
            }
        }
    }
}

/// Patch IDs of pixels that see a speck.
#[inline(always)]
fn look_up_speck(
    projection: &Projection,
    window: &Window,
    index: u32,
    back_face: u32,
    [i, j]: [usize; 2],
    ids: &mut [u32],
) {
    let region = index & SPECK_REGION;
    let tree = &projection.drawable.trees[region as usize];
    if index & SPECK_BACK != 0 {
        ids.fill(back_face);
    } else if tree.depth == 0 {
        ids.fill(tree.first_patch);
    } else {
        let coordinates = projection
            .coordinates(region)
            .map(|e| over_pixels(e, window));
        for (k, id) in ids.iter_mut().enumerate() {
            let at = |[a, b, c]: OverPixels| (a * (i + k) as f64 + (b * j as f64 + c)) as f32;
            *id = tree.first_patch + leaf_code(tree.depth, coordinates.map(at));
        }
    }
}

/// Patch IDs of pixels from `start` on of row j in one surface.
#[inline(always)]
pub(super) fn look_up_tree<S: Simd>(simd: S, tree: &Tree, j: f32, start: usize, ids: &mut [u32]) {
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
pub(super) const LOOK_UP_LANES: usize = 8;

/// Coefficients of i and of 1 of a value over the pixels of a row.
pub(super) type AlongRow = [f32; 2];

/// A value at pixels i.
#[inline(always)]
pub(super) fn at<S: Simd>([a, b]: AlongRow, i: f32x8<S>) -> f32x8<S> {
    i * a + b
}

/// The walk down of [`scene::bisection::locate`], all lanes together. It is told a - b, c and a + b + c, which stays:
/// a child's a - b is |a - b| - c in the first one, and the opposite in the second one, its c is twice the lesser
/// of a and b.
#[inline(always)]
pub(super) fn leaf_codes<S: Simd>(
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
