//! Rooms and blocks made of the cells of a grid, which makes them closed and conforming by
//! construction: each cell is solid or empty, all outside the grid is solid, and wherever an empty
//! cell meets a solid one there is a face, looking into the empty one.

use crate::builder::Plane;

/// Index of a cell along x, y and z.
pub type Cell = [usize; 3];

/// Boxes of unequal sizes, some of them solid.
pub struct Grid {
    /// Where the cells begin and end along x, y and z, metres, ascending.
    ticks: [Vec<f64>; 3],
    /// One per cell, x fastest.
    solid: Vec<bool>,
}

/// A rectangle between an empty cell and a solid one.
#[derive(Clone, Copy, Debug)]
pub struct Face {
    /// Its plane; the front looks into the empty cell.
    pub plane: Plane,
    /// Extent along the plane's u, metres.
    pub u: [f64; 2],
    /// Extent along the plane's v, metres.
    pub v: [f64; 2],
    /// The cell in front.
    pub empty: Cell,
    /// The cell behind, `None` outside the grid.
    pub solid: Option<Cell>,
}

impl Grid {
    /// A grid of empty cells.
    pub fn new(ticks: [Vec<f64>; 3]) -> Self {
        let cells = ticks.iter().map(|t| t.len().saturating_sub(1)).product();
        Self {
            ticks,
            solid: vec![false; cells],
        }
    }

    fn counts(&self) -> Cell {
        [0, 1, 2].map(|axis| self.ticks[axis].len().saturating_sub(1))
    }

    fn index(&self, [x, y, z]: Cell) -> usize {
        let [nx, ny, _] = self.counts();
        (z * ny + y) * nx + x
    }

    fn cells(&self) -> impl Iterator<Item = Cell> + use<> {
        let [nx, ny, nz] = self.counts();
        (0..nz).flat_map(move |z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z])))
    }

    /// Makes solid the cells the condition holds for.
    pub fn fill(&mut self, is_solid: impl Fn(Cell) -> bool) {
        for cell in self.cells().filter(|&cell| is_solid(cell)) {
            let index = self.index(cell);
            self.solid[index] = true;
        }
    }

    /// The cell beside this one, `None` outside the grid.
    fn beside(&self, mut cell: Cell, axis: usize, positive: bool) -> Option<Cell> {
        cell[axis] = if positive {
            cell[axis] + 1
        } else {
            cell[axis].checked_sub(1)?
        };
        (cell[axis] < self.counts()[axis]).then_some(cell)
    }

    /// All faces, in the order of the empty cells.
    pub fn faces(&self) -> Vec<Face> {
        let mut faces = Vec::new();
        for empty in self.cells().filter(|&cell| !self.solid[self.index(cell)]) {
            for axis in 0..3 {
                let extent = |axis: usize| {
                    let axis = axis % 3;
                    [0, 1].map(|end| self.ticks[axis][empty[axis] + end])
                };
                for end in [0, 1] {
                    let solid = self.beside(empty, axis, end == 1);
                    if solid.is_some_and(|cell| !self.solid[self.index(cell)]) {
                        continue;
                    }
                    faces.push(Face {
                        plane: Plane {
                            axis,
                            at: extent(axis)[end],
                            positive: end == 0,
                        },
                        u: extent(axis + 1),
                        v: extent(axis + 2),
                        empty,
                        solid,
                    });
                }
            }
        }
        faces
    }
}
