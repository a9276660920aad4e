//! Looking up the patches of regions of many surfaces, for many pixels together.
//!
//! # Theory
//! What [`Locator`](super::regions::Locator) does for one point is done for eight, without asking whether they lie in one surface: the
//! roots of their cells are fetched, and the line of each is tried. After as many rounds of that as most cells
//! need, the surfaces' bisection trees are fetched and gone down. Pixels that see another
//! surface every few pixels cost no more than others, since hardly anything branches.
//!
//! # Practice
//! A row's pixels are collected first, in a list without gaps between runs, and each step is done for all of them
//! before the next one begins: steps are short, and one vector of pixels does not wait for another. Nodes are
//! four words each, trees eight, so that they are fetched as vectors and transposed.

// Functions that a vectorised caller needs must be inlined into it: compiled on their own they would
// be for the baseline instruction set. That goes for closures too.
#![allow(clippy::inline_always)]

use std::ops::Range;

use fearless_simd::{Simd, f32x4, f32x8, prelude::*, u32x8};

use super::drawable::Drawable;
use super::look_up::{AlongRow, LOOK_UP_LANES, at, leaf_codes};
use super::projection::OverPixels;
use super::regions::{LEAF, Locator, Node, Regions, STEEP, Tree};

/// Share of the cells' area that may be left after the rounds that all pixels go through: it is looked up one pixel
/// at a time.
const MOST_LEFT: f64 = 0.01;

/// The most rounds.
const MOST_ROUNDS: u32 = 3;

/// The locators of all regions in one table.
#[derive(Clone, Debug, Default)]
pub(super) struct Locators {
    /// Where the nodes of each region begin.
    first_nodes: Vec<u32>,
    nodes: Vec<Node>,
    trees: Vec<Tree>,
    /// Rounds after which most points have found their surface.
    rounds: u32,
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
        // Cells that are done after so many rounds.
        let mut cells = [0_usize; MOST_ROUNDS as usize + 1];
        for region in regions.regions() {
            let first_node = all.nodes.len() as u32;
            all.first_nodes.push(first_node);
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
        all.trees = trees;
        all
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
pub(super) struct Located {
    /// The columns and the rows of the locator's grid, and what both have as a common factor, over the pixels.
    columns: OverPixels,
    rows: OverPixels,
    factor: OverPixels,
    /// Columns and rows of the grid.
    size: [u32; 2],
    /// The region's first node in [`Locators`].
    first_node: u32,
}

impl Located {
    /// The region's coordinates over the pixels are given.
    pub fn new(
        drawable: &Drawable,
        region: u32,
        locator: &Locator,
        [u, v, w]: [OverPixels; 3],
    ) -> Self {
        // The reference's sides from its first corner are twice those of the grid.
        let [columns, rows] = locator.size().map(|count| 2.0 * f64::from(count));
        Self {
            columns: v.map(|value| columns * value),
            rows: w.map(|value| rows * value),
            factor: [0, 1, 2].map(|k| u[k] + v[k] + w[k]),
            size: locator.size(),
            first_node: drawable.locators.first_nodes[region as usize],
        }
    }
}

/// Points of regions, to be looked up together.
#[derive(Clone, Debug, Default)]
pub(super) struct Points {
    /// In their grids.
    columns: Vec<f32>,
    rows: Vec<f32>,
    /// Nodes, then patches.
    codes: Vec<u32>,
}

impl Points {
    /// Starts anew.
    pub fn clear(&mut self) {
        self.columns.clear();
        self.rows.clear();
        self.codes.clear();
    }

    /// Adds a run of pixels of row j, and some after it so that they fill vectors.
    #[inline(always)]
    pub fn add<S: Simd>(&mut self, simd: S, located: &Located, j: usize, run: Range<usize>) {
        let j = j as f64;
        let start = run.start as f64;
        let [a, b, c] = located.columns;
        let columns: AlongRow = [a as f32, (a * start + (b * j + c)) as f32];
        let [a, b, c] = located.rows;
        let rows: AlongRow = [a as f32, (a * start + (b * j + c)) as f32];
        let [a, b, c] = located.factor;
        let factor: AlongRow = [a as f32, (a * start + (b * j + c)) as f32];
        let [width, height] = [located.size[0] as f32, located.size[1] as f32];
        let last = u32x8::splat(simd, located.size[0] * located.size[1] - 1);
        let zero = f32x8::splat(simd, 0.0);
        let one = f32x8::splat(simd, 1.0);
        let iota = f32x8::from_fn(
            simd,
            #[inline(always)]
            |lane| lane as f32,
        );
        let mut k = 0;
        while k < run.len() {
            let i = iota + k as f32;
            let scale = one / at(factor, i);
            let (x, y) = (at(columns, i) * scale, at(rows, i) * scale);
            // Pixels beyond the run may be anywhere.
            let column = x.max(zero).min(width - 1.0).floor();
            let row = y.max(zero).min(height - 1.0).floor();
            let cell = (row * width + column).to_int::<u32x8<S>>().min(last);
            self.columns.extend_from_slice(x.as_slice());
            self.rows.extend_from_slice(y.as_slice());
            self.codes
                .extend_from_slice((cell + located.first_node).as_slice());
            k += LOOK_UP_LANES;
        }
    }

    /// Looks all up: patch IDs in the order in which they were added.
    #[inline(always)]
    pub fn look_up<S: Simd>(&mut self, simd: S, locators: &Locators) -> &[u32] {
        let nodes: &[[f32; 4]] = bytemuck::cast_slice(&locators.nodes);
        let (columns, _) = self.columns.as_chunks::<LOOK_UP_LANES>();
        let (rows, _) = self.rows.as_chunks::<LOOK_UP_LANES>();
        let (codes, _) = self.codes.as_chunks_mut::<LOOK_UP_LANES>();
        for round in 0..locators.rounds {
            for ((x, y), codes) in columns.iter().zip(rows).zip(codes.iter_mut()) {
                let (x, y) = (f32x8::from_slice(simd, x), f32x8::from_slice(simd, y));
                if round == 0 {
                    sides(simd, nodes, codes, x, y).store_slice(codes);
                } else {
                    let before = u32x8::from_slice(simd, codes);
                    let is_found = before.simd_ge(LEAF);
                    is_found
                        .select(u32x8::splat(simd, 0), before)
                        .store_slice(codes);
                    let after = sides(simd, nodes, codes, x, y);
                    is_found.select(before, after).store_slice(codes);
                }
            }
        }
        for ((x, y), codes) in columns.iter().zip(rows).zip(codes.iter_mut()) {
            let before = u32x8::from_slice(simd, codes);
            if before.simd_lt(LEAF).any_true() {
                for ((&x, &y), code) in x.iter().zip(y).zip(codes.iter_mut()) {
                    while *code & LEAF == 0 {
                        *code = locators.nodes[*code as usize].side(x, y);
                    }
                }
            }
            let found = u32x8::from_slice(simd, codes) & (LEAF - 1);
            found.store_slice(codes);
        }
        if locators.depth > 0 {
            let trees: &[[f32; 4]] = bytemuck::cast_slice(&locators.trees);
            let most_depth = u32x8::splat(simd, locators.depth);
            let one = f32x8::splat(simd, 1.0);
            for ((x, y), codes) in columns.iter().zip(rows).zip(codes.iter_mut()) {
                let (x, y) = (f32x8::from_slice(simd, x), f32x8::from_slice(simd, y));
                let twice = u32x8::from_slice(simd, codes) << 1;
                twice.store_slice(codes);
                let [p0, p1, p2, q0] = fetch(simd, trees, codes);
                (twice + 1).store_slice(codes);
                let [q1, q2, first, depth] = fetch(simd, trees, codes);
                let difference = p0 + p1 * x + p2 * y;
                let third = q0 + q1 * x + q2 * y;
                let leaves = leaf_codes(simd, [difference, third, one], locators.depth);
                let patches = first.bitcast::<u32x8<S>>()
                    + (leaves >> (most_depth - depth.bitcast::<u32x8<S>>()));
                patches.store_slice(codes);
            }
        }
        &self.codes
    }
}

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
    let [a, b, c, d, e, f, g, h] = records;
    let low = transposed([a, b, c, d]);
    let high = transposed([e, f, g, h]);
    [
        low[0].combine(high[0]),
        low[1].combine(high[1]),
        low[2].combine(high[2]),
        low[3].combine(high[3]),
    ]
}

#[inline(always)]
fn transposed<S: Simd>([a, b, c, d]: [f32x4<S>; 4]) -> [f32x4<S>; 4] {
    let (even, odd) = (a.zip_low(c), b.zip_low(d));
    let (even_high, odd_high) = (a.zip_high(c), b.zip_high(d));
    [
        even.zip_low(odd),
        even.zip_high(odd),
        even_high.zip_low(odd_high),
        even_high.zip_high(odd_high),
    ]
}
