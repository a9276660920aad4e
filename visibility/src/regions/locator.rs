//! Finds which surface of a region holds a point.
//!
//! # Method
//! A uniform grid over the region's bounding box, some cells a surface, and in each cell a binary
//! space partition by lines along the surfaces' sides. Regular walls have one line in a cell, or none: a point's
//! cell is the root of its partition, and mostly all of it.
//!
//! # Exactness
//! Points are given by columns x and rows y from the grid's lowest corner, lines as x = a + b y or y = a + b x, so that
//! in metres b is at most 1. For a line across a box of width W, height H and diagonal D, in metres,
//! x is at most W, b y at most H, a at most W + H, or the other way round. x and y are right to 4 roundings of 2^-24 relative
//! (two products, a division, a sum), a to one, b y to 6, and there are two sums: an error of the distance is below
//! (4 W + (W + H) + 6 H + 2 (W + H)) 2^-24 < 16 D 2^-24 = 9.6e-7 D. A point so far from all edges or farther is given to the
//! surface that holds it. A cell's border may be mistaken by less, but where it is the same surface is on both sides.

use bytemuck::{Pod, Zeroable};
use scene::SurfaceId;

/// One surface of a region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Member {
    /// Which.
    pub surface: SurfaceId,
    /// Its bisection tree's first patch.
    pub first_patch: u32,
    /// Its bisection tree's depth.
    pub depth: u32,
    /// `barycentric[k] . p` is the k-th barycentric coordinate in the surface of the point with
    /// the region's coordinates p, with the same common factor; dimensionless.
    pub barycentric: [[f64; 3]; 3],
    /// The member that lies beyond the side where the k-th barycentric coordinate is 0, or [`NO_MEMBER`] where
    /// there is none that shares the side.
    pub neighbours: [u32; 3],
}

/// No member.
pub const NO_MEMBER: u32 = u32::MAX;

/// Marks a code that stands for a member, not a node.
pub(crate) const LEAF: u32 = 1 << 31;

/// Marks the first of a node's codes where its line is x = a + b y. Else it is y = a + b x.
pub(crate) const STEEP: u32 = 1 << 30;

/// A line, and what is on either side of it; one vector of four words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(16))]
pub(crate) struct Node {
    /// Coefficients a and b, in columns and rows.
    pub line: [f32; 2],
    /// Codes, of nodes or with [`LEAF`] of members: of what is below the line (x < a + b y), and of the other side.
    pub sides: [u32; 2],
}

impl Node {
    /// All of a cell.
    pub fn all(code: u32) -> Self {
        Self {
            line: [0.0; 2],
            sides: [code; 2],
        }
    }

    /// The code of the side on which a point is.
    #[inline(always)]
    pub fn side(&self, x: f32, y: f32) -> u32 {
        let [a, b] = self.line;
        let [below, other] = self.sides;
        let (along, across) = if below & STEEP == 0 { (x, y) } else { (y, x) };
        if across < a + b * along {
            below & !STEEP
        } else {
            other
        }
    }
}

/// A member's bisection tree over the grid; one vector of eight words.
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
#[repr(C, align(32))]
pub(crate) struct Tree {
    /// Coefficients of 1, of the columns and of the rows of a - b and of c; see [`scene::bisection`].
    pub difference: [f32; 3],
    pub third: [f32; 3],
    pub first_patch: u32,
    pub depth: u32,
}

/// Finds which surface of a region holds a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Locator {
    /// In the order of their surfaces.
    pub(super) members: Vec<Member>,
    /// One per member.
    pub(super) trees: Vec<Tree>,
    /// The first ones are the cells' roots, row by row.
    pub(super) nodes: Vec<Node>,
    /// Cells in a row, and rows.
    pub(super) size: [u32; 2],
}

impl Locator {
    /// The index in [`Self::members`] of the surface that holds a point, which is given by barycentric
    /// coordinates with respect to [`super::Region::reference`], up to a common positive factor. Points that
    /// no surface holds are given to one near by.
    #[inline(always)]
    pub fn locate(&self, [a, b, c]: [f32; 3]) -> usize {
        // The reference's sides from its first corner are twice those of the grid.
        let scale = 2.0 / (a + b + c);
        let [columns, rows] = self.size;
        let (x, y) = (b * scale * columns as f32, c * scale * rows as f32);
        // A cast saturates, and makes 0 of NaN.
        let cell = |value: f32, count: u32| (value as u32).min(count - 1);
        let mut code = cell(y, rows) * columns + cell(x, columns);
        while code & LEAF == 0 {
            code = self.nodes[code as usize].side(x, y);
        }
        (code & !LEAF) as usize
    }

    /// The surfaces, ascending.
    pub fn members(&self) -> &[Member] {
        &self.members
    }

    /// Columns and rows of the grid.
    pub(crate) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// The nodes of all partitions; the first ones are the cells' roots, row by row.
    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// One per member.
    pub(crate) fn trees(&self) -> &[Tree] {
        &self.trees
    }
}
