//! Looking up the patches that pixels see.
//!
//! # Theory
//! Along a picture's rows the coordinates of the points that rays hit in a region are, up to a common
//! factor, linear; so are the barycentric coordinates in each of its surfaces, and the way down the
//! bisection tree ([`scene::bisection`]) needs no more.
//!
//! # Practice
//! Runs of pixels that see one piece are looked up, eight pixels at a time. In a region of many surfaces that is
//! done by [`walk`] where its surfaces are wide in the picture, else by [`locate`]. What is linear
//! over a window is kept as f32: a point is right to some 2^-24 of the window's pixels, 1e-4 pixels where there are a thousand.

use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use scene::bisection::leaf_code;

mod locate;
mod tree;
mod walk;

pub(crate) use locate::Locators;

use crate::Window;
use crate::affine::{Affine, affine};
use crate::buffer::{NONE, SPECK, Seen};
use crate::eye::Standpoint;
use crate::runs::for_each_run;
use crate::spans::Projected;
use locate::{Located, Points};
use tree::{LOOK_UP_LANES, Tree, look_up_tree};
use walk::{MemberOverPixels, NO_PICTURE, Walk};

/// What the codes of a buffer stand for, those of specks excepted.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Pieces<'p> {
    /// Indices of pieces that are drawn.
    Drawn(&'p [Projected]),
    /// Indices of what rays have met.
    Met(&'p [Seen]),
}

impl Pieces<'_> {
    fn len(self) -> usize {
        match self {
            Self::Drawn(pieces) => pieces.len(),
            Self::Met(met) => met.len(),
        }
    }

    /// What is seen of a piece.
    #[inline(always)]
    pub fn seen(self, index: u32) -> Seen {
        match self {
            Self::Drawn(pieces) => pieces[index as usize].seen(),
            Self::Met(met) => met[index as usize],
        }
    }
}

/// A picture whose patches are looked up.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Source<'p> {
    pub at: &'p Standpoint<'p>,
    pub locators: &'p Locators,
    pub pieces: Pieces<'p>,
    pub window: &'p Window,
}

/// What pixels get that see no patch.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Blanks {
    pub nothing: u32,
    pub back_face: u32,
}

/// Looks patches up, row by row of a picture.
#[derive(Clone, Debug, Default)]
pub(crate) struct LookUp {
    blanks: Blanks,
    /// The regions that are looked up, ascending, where it is not all.
    only: Option<Vec<u32>>,
    /// How each of the picture's pieces is looked up, as far as it has been asked for.
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

impl LookUp {
    /// Gets ready for a picture, of which all regions are looked up, or `only` some, ascending; the others are nothing.
    pub fn start(&mut self, source: &Source, only: Option<&[u32]>, blanks: Blanks) {
        let Source {
            locators, window, ..
        } = source;
        self.blanks = blanks;
        self.only = only.map(<[u32]>::to_vec);
        self.ways.clear();
        self.ways.resize(source.pieces.len(), Way::NotAsked);
        self.picture = self.picture.checked_add(1).unwrap_or_else(|| {
            self.members.clear();
            NO_PICTURE + 1
        });
        self.members.resize(locators.count(), Vec::new());
        self.points.resize(window.width);
        self.ids.resize(window.width + LOOK_UP_LANES, 0);
    }

    /// Patch IDs of row j, whose codes are given.
    pub fn row(&mut self, level: Level, source: &Source, j: usize, codes: &[u32]) -> &[u32] {
        dispatch!(level, simd => look_up_row(simd, self, source, j, codes));
        &self.ids[..codes.len()]
    }
}

/// What all pixels of a region get: those that see its back, and those of a region that is not looked up.
#[inline(always)]
fn blank(seen: Seen, only: Option<&[u32]>, blanks: Blanks) -> Option<u32> {
    match only {
        Some(only) if only.binary_search(&seen.region).is_err() => Some(blanks.nothing),
        _ => seen.is_back_face.then_some(blanks.back_face),
    }
}

/// How a piece is looked up.
#[cold]
fn way(source: &Source, index: u32, only: Option<&[u32]>, blanks: Blanks) -> Way {
    let seen = source.pieces.seen(index);
    if let Some(id) = blank(seen, only, blanks) {
        return Way::Constant(id);
    }
    let geometry = source.at.geometry;
    let tree = &geometry.trees[seen.region as usize];
    let coordinates = || {
        let coordinates = source.at.coordinates(seen.region);
        coordinates.map(|e| affine(e, source.window))
    };
    match &geometry.regions.regions()[seen.region as usize].locator {
        None if tree.depth == 0 => Way::Constant(tree.first_patch),
        None => Way::Surface(Tree::over_pixels(
            coordinates(),
            tree.first_patch,
            tree.depth,
        )),
        Some(locator) => Way::Many(
            Located::new(source.locators, seen.region, locator, coordinates()),
            0,
        ),
    }
}

#[simd]
fn look_up_row<S: Simd>(simd: S, look_up: &mut LookUp, source: &Source, j: usize, codes: &[u32]) {
    let LookUp {
        blanks,
        only,
        ways,
        points,
        runs,
        members,
        picture,
        ids,
    } = look_up;
    let only = only.as_deref();
    let geometry = source.at.geometry;
    points.clear();
    runs.clear();
    for_each_run(
        simd,
        codes,
        #[inline(always)]
        |piece, start, end| {
            let mut is_walked = false;
            if piece & SPECK == 0 {
                let stored = &mut ways[piece as usize];
                if let Way::NotAsked = stored {
                    *stored = way(source, piece, only, *blanks);
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
    let found = points.look_up(simd, source.locators);
    let mut next = 0;
    // What is written beyond the end of a run is overwritten by the next one.
    for run in runs.iter() {
        let (start, end) = (run.start as usize, run.end as usize);
        let index = run.piece;
        if index == NONE {
            ids[start..end].fill(blanks.nothing);
            continue;
        }
        let padded = start..start + (end - start).next_multiple_of(LOOK_UP_LANES);
        if index & SPECK != 0 {
            let seen = Seen::of_speck(index);
            match blank(seen, only, *blanks) {
                Some(id) => ids[start..end].fill(id),
                None => look_up_speck(source, seen.region, [start, j], &mut ids[start..end]),
            }
            continue;
        }
        match &mut ways[index as usize] {
            Way::NotAsked => {}
            Way::Constant(id) => ids[start..end].fill(*id),
            Way::Surface(tree) => {
                look_up_tree(simd, tree, j as f32, start, &mut ids[padded]);
            }
            Way::Many(located, last) if run.is_walked => {
                let region = source.pieces.seen(index).region;
                if let Some(locator) = &geometry.regions.regions()[region as usize].locator {
                    let members = &mut members[source.locators.rank(region)];
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

/// Patch IDs of pixels from (i, j) on that see the front of a speck.
#[inline(always)]
fn look_up_speck(source: &Source, region: u32, [i, j]: [usize; 2], ids: &mut [u32]) {
    let tree = &source.at.geometry.trees[region as usize];
    if tree.depth == 0 {
        ids.fill(tree.first_patch);
    } else {
        let coordinates = source.at.coordinates(region);
        let coordinates = coordinates.map(|e| affine(e, source.window));
        for (k, id) in ids.iter_mut().enumerate() {
            let at = |[a, b, c]: Affine| (a * (i + k) as f64 + (b * j as f64 + c)) as f32;
            *id = tree.first_patch + leaf_code(tree.depth, coordinates.map(at));
        }
    }
}
