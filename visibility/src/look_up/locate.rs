//! Looking up the patches of regions of many surfaces, for many pixels together.
//!
//! # Theory
//! What [`Locator`] does for one point is done for eight, without asking whether they lie in one surface: the
//! roots of their cells are fetched, and the line of each is tried. After as many rounds of that as most cells
//! need, the surfaces' bisection trees are fetched and gone down. Pixels that see another
//! surface every few pixels cost no more than others, since hardly anything branches.
//!
//! # Practice
//! A row's pixels are collected first, in a list without gaps between runs, and each step is done for all of them
//! before the next one begins: steps are short, and one vector of pixels does not wait for another. Nodes are
//! four words each, trees eight, so that they are fetched as vectors and transposed.

use std::ops::Range;

use fearless_simd::{Simd, f32x4, f32x8, prelude::*, u32x8};

use super::tree::{AlongRow, LOOK_UP_LANES, at, leaf_codes};
use crate::affine::Affine;
use crate::regions::{LEAF, Locator, Node, Regions, STEEP, Tree};

/// Share of the cells' area that may be left after the rounds that all pixels go through: it is looked up one pixel
/// at a time.
const MOST_LEFT: f64 = 0.01;

/// The most rounds.
const MOST_ROUNDS: u32 = 3;

/// The locators of all regions in one table.
#[derive(Clone, Debug, Default)]
pub(crate) struct Locators {
    /// Where the nodes of each region begin.
    first_nodes: Vec<u32>,
    nodes: Vec<Node>,
    /// How many regions before each one have a locator, then how many do.
    ranks: Vec<u32>,
    trees: Vec<Tree>,
    /// Rounds after which most points have found their surface, and whether all have.
    rounds: u32,
    rounds_find_all: bool,
    /// The most bisections of a surface. Where there are none, leaves are patches and not trees.
    depth: u32,
}

impl Locators {
    /// Those of some regions.
    pub fn new(regions: &Regions) -> Self {
        let locators = || regions.regions().iter().flat_map(|r| &r.locator);
        let trees: Vec<Tree> = locators().flat_map(Locator::trees).copied().collect();
        let depth = trees.iter().map(|tree| tree.depth).max().unwrap_or(0);
        let mut all = Self {
            depth,
            ..Self::default()
        };
        let mut first_tree = 0;
        let mut rank = 0;
        // Cells that are done after so many rounds.
        let mut cells = [0_usize; MOST_ROUNDS as usize + 1];
        for region in regions.regions() {
            let first_node = all.nodes.len() as u32;
            all.first_nodes.push(first_node);
            all.ranks.push(rank);
            let Some(locator) = &region.locator else {
                continue;
            };
            let code = |code: u32| {
                if code & LEAF == 0 {
                    code + first_node
                } else if depth == 0 {
                    LEAF | trees[first_tree + (code & !LEAF) as usize].first_patch
                } else {
                    code + first_tree as u32
                }
            };
            all.nodes.extend(locator.nodes().iter().map(|node| Node {
                sides: [
                    code(node.sides[0] & !STEEP) | node.sides[0] & STEEP,
                    code(node.sides[1]),
                ],
                ..*node
            }));
            first_tree += locator.trees().len();
            rank += 1;
            let [columns, rows] = locator.size();
            for cell in 0..columns * rows {
                let rounds = all.rounds_of(first_node + cell);
                cells[rounds.min(MOST_ROUNDS + 1) as usize - 1] += 1;
            }
        }
        let count: usize = cells.iter().sum();
        let mut left = count;
        for cells in &cells[..MOST_ROUNDS as usize] {
            if left as f64 <= MOST_LEFT * count as f64 {
                break;
            }
            left -= cells;
            all.rounds += 1;
        }
        all.rounds_find_all = left == 0;
        all.ranks.push(rank);
        all.trees = trees;
        all
    }

    /// How many regions have a locator.
    pub fn count(&self) -> usize {
        self.ranks.last().map_or(0, |&count| count as usize)
    }

    /// How many of them are before a region.
    pub fn rank(&self, region: u32) -> usize {
        self.ranks[region as usize] as usize
    }

    /// Rounds that a node's points take at most, counted no farther than is asked for.
    fn rounds_of(&self, node: u32) -> u32 {
        let is_found = |code: &u32| code & LEAF != 0;
        if self.nodes[node as usize].sides.iter().all(is_found) {
            return 1;
        }
        let mut level = vec![node];
        let mut rounds = 0;
        while !level.is_empty() && rounds <= MOST_ROUNDS {
            rounds += 1;
            level = level
                .iter()
                .flat_map(|&node| self.nodes[node as usize].sides)
                .filter(|code| !is_found(code))
                .map(|code| code & !STEEP)
                .collect();
        }
        rounds
    }
}

/// A region of many surfaces in a picture.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Located {
    /// The columns and the rows of the locator's grid, and what both have as a common factor, over the pixels.
    columns: Affine,
    rows: Affine,
    factor: Affine,
    /// Columns and rows of the grid.
    size: [u32; 2],
    /// The region's first node in [`Locators`].
    first_node: u32,
    /// About how many surfaces begin within a cell's side.
    surfaces_per_cell: f32,
}

impl Located {
    /// The region's coordinates over the pixels are given.
    pub fn new(
        locators: &Locators,
        region: u32,
        locator: &Locator,
        [u, v, w]: [Affine; 3],
    ) -> Self {
        // The reference's sides from its first corner are twice those of the grid.
        let [columns, rows] = locator.size().map(|count| 2.0 * f64::from(count));
        Self {
            columns: v.map(|value| columns * value),
            rows: w.map(|value| rows * value),
            factor: [0, 1, 2].map(|k| u[k] + v[k] + w[k]),
            size: locator.size(),
            first_node: locators.first_nodes[region as usize],
            surfaces_per_cell: (locator.members().len() as f32
                / locator
                    .size()
                    .map(|count| count as f32)
                    .iter()
                    .product::<f32>())
            .sqrt(),
        }
    }

    /// Coordinates of the region over the pixels.
    pub fn coordinates(&self) -> [Affine; 3] {
        let [v, w] = [(self.columns, self.size[0]), (self.rows, self.size[1])]
            .map(|(value, count)| value.map(|x| x / (2.0 * f64::from(count))));
        [[0, 1, 2].map(|k| self.factor[k] - v[k] - w[k]), v, w]
    }

    /// The mean width, in pixels, of the surfaces that a run of row j sees, about.
    #[inline(always)]
    pub fn width(&self, j: usize, run: Range<usize>) -> f32 {
        let pixels = (run.end - 1 - run.start) as f32;
        let [columns, rows, factor] = self.along(j, run.start);
        let end = |[a, b]: AlongRow| a * pixels + b;
        let (first, last) = (1.0 / factor[1], 1.0 / end(factor));
        let columns = (end(columns) * last - columns[1] * first).abs();
        let rows = (end(rows) * last - rows[1] * first).abs();
        pixels / (1.0 + self.surfaces_per_cell * (columns + rows))
    }

    /// Columns, rows and the common factor along row j from pixel `start` on.
    #[inline(always)]
    fn along(&self, j: usize, start: usize) -> [AlongRow; 3] {
        let (i, j) = (start as f64, j as f64);
        let along = |[a, b, c]: Affine| [a as f32, (a * i + (b * j + c)) as f32];
        [along(self.columns), along(self.rows), along(self.factor)]
    }
}

/// Points of regions, to be looked up together: without gaps, though vectors are written beyond the ends of runs.
#[derive(Clone, Debug, Default)]
pub(crate) struct Points {
    /// In their grids.
    columns: Vec<f32>,
    rows: Vec<f32>,
    /// Nodes, then patches.
    codes: Vec<u32>,
    /// How many there are.
    count: usize,
}

impl Points {
    /// Makes room for a row of so many pixels.
    pub fn resize(&mut self, width: usize) {
        let room = (width + LOOK_UP_LANES).next_multiple_of(LOOK_UP_LANES);
        self.columns.resize(room, 0.0);
        self.rows.resize(room, 0.0);
        self.codes.resize(room, 0);
    }

    /// Starts anew.
    pub fn clear(&mut self) {
        self.count = 0;
    }

    /// Adds a run of pixels of row j, for which there is room.
    #[inline(always)]
    pub fn add<S: Simd>(&mut self, simd: S, located: &Located, j: usize, run: Range<usize>) {
        let [columns, rows, factor] = located.along(j, run.start);
        let [width, height] = [located.size[0] as f32, located.size[1] as f32];
        let last = u32x8::splat(simd, located.size[0] * located.size[1] - 1);
        let zero = f32x8::splat(simd, 0.0);
        let one = f32x8::splat(simd, 1.0);
        let iota = f32x8::from_slice(simd, &IOTA);
        let end = self.count + run.len().next_multiple_of(LOOK_UP_LANES);
        let places = self.count..end;
        let to = self.columns[places.clone()].as_chunks_mut().0;
        let to = to
            .iter_mut()
            .zip(self.rows[places.clone()].as_chunks_mut().0);
        let to = to.zip(self.codes[places].as_chunks_mut().0);
        for (k, ((to_x, to_y), to_cell)) in to.enumerate() {
            let i = iota + (k * LOOK_UP_LANES) as f32;
            let scale = one / at(factor, i);
            let (x, y) = (at(columns, i) * scale, at(rows, i) * scale);
            // Pixels beyond the run may be anywhere.
            let column = x.max(zero).min(width - 1.0).floor();
            let row = y.max(zero).min(height - 1.0).floor();
            let cell = (row * width + column).to_int::<u32x8<S>>().min(last);
            *to_x = *x.as_array();
            *to_y = *y.as_array();
            *to_cell = *(cell + located.first_node).as_array();
        }
        self.count += run.len();
    }

    /// Looks all up: patch IDs in the order in which they were added, and some after them that fill a vector.
    #[inline(always)]
    pub fn look_up<S: Simd>(&mut self, simd: S, locators: &Locators) -> &[u32] {
        let count = self.count.next_multiple_of(LOOK_UP_LANES);
        // What fills the last vector may be a patch of the row before; any node will do.
        self.codes[self.count..count].fill(0);
        let columns: &[Eight<f32>] = self.columns[..count].as_chunks().0;
        let rows: &[Eight<f32>] = self.rows[..count].as_chunks().0;
        let codes: &mut [Eight<u32>] = self.codes[..count].as_chunks_mut().0;
        find(simd, locators, columns, rows, codes);
        descend(simd, locators, columns, rows, codes);
        &self.codes
    }
}

/// What a vector holds.
type Eight<T> = [T; LOOK_UP_LANES];

/// Finds the surfaces on which points lie: codes of nodes become those of trees, or patches where trees have no depth.
#[inline(always)]
fn find<S: Simd>(
    simd: S,
    locators: &Locators,
    columns: &[Eight<f32>],
    rows: &[Eight<f32>],
    codes: &mut [Eight<u32>],
) {
    let nodes: &[[f32; 4]] = bytemuck::cast_slice(&locators.nodes);
    for round in 0..locators.rounds {
        for ((x, y), codes) in columns.iter().zip(rows).zip(&mut *codes) {
            let (x, y) = (f32x8::from_slice(simd, x), f32x8::from_slice(simd, y));
            if round == 0 {
                *codes = *sides(simd, nodes, codes, x, y).as_array();
            } else {
                let before = u32x8::from_slice(simd, codes);
                let is_found = before.simd_ge(LEAF);
                let places = is_found.select(u32x8::splat(simd, 0), before);
                let after = sides(simd, nodes, places.as_array(), x, y);
                *codes = *is_found.select(before, after).as_array();
            }
        }
    }
    if !locators.rounds_find_all {
        for ((x, y), codes) in columns.iter().zip(rows).zip(&mut *codes) {
            if u32x8::from_slice(simd, codes).simd_lt(LEAF).any_true() {
                for ((&x, &y), code) in x.iter().zip(y).zip(codes) {
                    while *code & LEAF == 0 {
                        *code = locators.nodes[*code as usize].side(x, y);
                    }
                }
            }
        }
    }
}

/// Goes down the trees of surfaces on which points lie.
#[inline(always)]
fn descend<S: Simd>(
    simd: S,
    locators: &Locators,
    columns: &[Eight<f32>],
    rows: &[Eight<f32>],
    codes: &mut [Eight<u32>],
) {
    if locators.depth == 0 {
        for codes in codes {
            let patches = u32x8::from_slice(simd, codes) & (LEAF - 1);
            *codes = *patches.as_array();
        }
        return;
    }
    let trees: &[[f32; 8]] = bytemuck::cast_slice(&locators.trees);
    let most_depth = u32x8::splat(simd, locators.depth);
    let one = f32x8::splat(simd, 1.0);
    for ((x, y), codes) in columns.iter().zip(rows).zip(codes) {
        let (x, y) = (f32x8::from_slice(simd, x), f32x8::from_slice(simd, y));
        let places = u32x8::from_slice(simd, codes) & (LEAF - 1);
        let (low, high) = fetch_pairs(simd, trees, places.as_array());
        let ([p0, p1, p2, q0], [q1, q2, first, depth]) = (low, high);
        let difference = p0 + p1 * x + p2 * y;
        let third = q0 + q1 * x + q2 * y;
        let leaves = leaf_codes(simd, [difference, third, one], locators.depth);
        let patches =
            first.bitcast::<u32x8<S>>() + (leaves >> (most_depth - depth.bitcast::<u32x8<S>>()));
        *codes = *patches.as_array();
    }
}

const IOTA: [f32; LOOK_UP_LANES] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];

/// What is on the sides of nodes' lines on which points lie.
#[inline(always)]
fn sides<S: Simd>(
    simd: S,
    nodes: &[[f32; 4]],
    places: &[u32; LOOK_UP_LANES],
    x: f32x8<S>,
    y: f32x8<S>,
) -> u32x8<S> {
    let [a, b, below, other] = fetch(simd, nodes, places);
    let (below, other) = (below.bitcast::<u32x8<S>>(), other.bitcast::<u32x8<S>>());
    let is_steep = (below & STEEP).simd_ne(0);
    let (along, across) = (is_steep.select(y, x), is_steep.select(x, y));
    let is_below = across.simd_lt(a + b * along);
    is_below.select(below & !STEEP, other)
}

/// Records of a table, transposed: the k-th vector has the k-th word of each.
#[inline(always)]
fn fetch<S: Simd>(simd: S, table: &[[f32; 4]], places: &[u32; LOOK_UP_LANES]) -> [f32x8<S>; 4] {
    let mut records = [f32x4::splat(simd, 0.0); LOOK_UP_LANES];
    for (record, &place) in records.iter_mut().zip(places) {
        *record = f32x4::from_slice(simd, &table[place as usize]);
    }
    transposed(records)
}

/// The same of records of twice as many words, in two halves.
#[inline(always)]
fn fetch_pairs<S: Simd>(
    simd: S,
    table: &[[f32; 8]],
    places: &[u32; LOOK_UP_LANES],
) -> ([f32x8<S>; 4], [f32x8<S>; 4]) {
    let mut low = [f32x4::splat(simd, 0.0); LOOK_UP_LANES];
    let mut high = low;
    for ((low, high), &place) in low.iter_mut().zip(&mut high).zip(places) {
        let record = &table[place as usize];
        *low = f32x4::from_slice(simd, &record[..4]);
        *high = f32x4::from_slice(simd, &record[4..]);
    }
    (transposed(low), transposed(high))
}

#[inline(always)]
fn transposed<S: Simd>(records: [f32x4<S>; LOOK_UP_LANES]) -> [f32x8<S>; 4] {
    let [a, b, c, d, e, f, g, h] = records;
    let (low, high) = (transposed_four(a, b, c, d), transposed_four(e, f, g, h));
    [
        low[0].combine(high[0]),
        low[1].combine(high[1]),
        low[2].combine(high[2]),
        low[3].combine(high[3]),
    ]
}

#[inline(always)]
fn transposed_four<S: Simd>(a: f32x4<S>, b: f32x4<S>, c: f32x4<S>, d: f32x4<S>) -> [f32x4<S>; 4] {
    let (even, odd) = (a.zip_low(c), b.zip_low(d));
    let (even_high, odd_high) = (a.zip_high(c), b.zip_high(d));
    [
        even.zip_low(odd),
        even.zip_high(odd),
        even_high.zip_low(odd_high),
        even_high.zip_high(odd_high),
    ]
}
