//! Finds which surface of a region holds a point.
//!
//! # Method
//! A uniform grid over the region's bounding box, about two cells a surface, and in each cell a binary
//! space partition by lines along the surfaces' sides. Regular walls have one line in a cell, or none.
//!
//! # Exactness
//! Lines are linear in the region's coordinates p, whose sum is s: a line's value is the distance from it times
//! s, the sum of c_k p_k, where |c_k| is at most the distance of the reference's corners from any line
//! across the box, below 3 D for a box with the diagonal D. Coefficients, coordinates, products and
//! sums are rounded, each by 2^-24 relative: 6 in a row. As 0 <= p_k <= s, an error of the distance is below
//! 3 * 6 * 3 D 2^-24 = 3.3e-6 D. A point so far from all edges or farther is given to the surface that
//! holds it. A cell's border may be mistaken by less, but where it is the same surface is on both sides.

// The caller is vectorised: compiled on its own this would be for the baseline instruction set.
#![allow(clippy::inline_always)]

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
pub(super) const LEAF: u32 = 1 << 31;

/// A line, and what is on either side of it: codes, of nodes or with [`LEAF`] of members.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// Coefficients of the region's coordinates; at least 0 on the first side.
    pub line: [f32; 3],
    pub sides: [u32; 2],
}

/// Finds which surface of a region holds a point.
#[derive(Clone, Debug, PartialEq)]
pub struct Locator {
    /// In the order of their surfaces.
    pub(super) members: Vec<Member>,
    pub(super) nodes: Vec<Node>,
    /// Codes, one per cell, row by row; at least one.
    pub(super) cells: Vec<u32>,
    /// Cells in a row, and rows.
    pub(super) size: [u32; 2],
}

impl Locator {
    /// The index in [`Self::members`] of the surface that holds a point, which is given by barycentric
    /// coordinates with respect to [`super::Region::reference`], up to a common positive factor. Points that
    /// no surface holds are given to one near by.
    #[inline(always)]
    pub fn locate(&self, point: [f32; 3]) -> usize {
        let [a, b, c] = point;
        let mut code = if let [only] = self.cells[..] {
            only
        } else {
            // The reference's sides from its first corner are twice those of the grid.
            let scale = 2.0 / (a + b + c);
            // A cast saturates, and makes 0 of NaN.
            let cell = |value: f32, count: u32| {
                let cell = (value * (scale * count as f32)) as i32;
                cell.clamp(0, count as i32 - 1) as u32
            };
            let (column, row) = (cell(b, self.size[0]), cell(c, self.size[1]));
            self.cells[(row * self.size[0] + column) as usize]
        };
        while code & LEAF == 0 {
            let Node { line, sides } = &self.nodes[code as usize];
            let value = line[0] * a + line[1] * b + line[2] * c;
            code = sides[usize::from(value < 0.0)];
        }
        (code & !LEAF) as usize
    }

    /// The surfaces, ascending.
    pub fn members(&self) -> &[Member] {
        &self.members
    }
}
