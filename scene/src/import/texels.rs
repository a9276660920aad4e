//! The texels of a picture, and coarser pictures of the same, whose cells have the exact means of what is below them.

use std::sync::LazyLock;

use glam::DVec3;

use crate::{Rgb, srgb};

/// How many cells along each axis are one in the next coarser picture.
const COARSER: u32 = 4;

/// Linear values of sRGB bytes.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|byte| srgb::decode(byte as f32 / 255.0)));

/// A picture.
pub(super) struct Texels {
    /// From the finest, which has the texels, to one of a single cell.
    pub grids: Vec<Grid>,
}

/// A picture in some fineness.
pub(super) struct Grid {
    /// Columns and rows, each at least 1.
    pub size: [u32; 2],
    /// Row by row from the top.
    cells: Cells,
}

enum Cells {
    /// Red, green and blue, a byte each.
    Srgb(Vec<u8>),
    Linear(Vec<Rgb>),
}

impl Texels {
    /// A picture of columns and rows, each at least 1, whose bytes are red, green and blue in sRGB, row by row from the top.
    pub(super) fn new(size: [u32; 2], bytes: Vec<u8>) -> Self {
        let mut grid = Grid {
            size,
            cells: Cells::Srgb(bytes),
        };
        let mut grids = Vec::new();
        while grid.size != [1, 1] {
            let coarser = grid.coarser();
            grids.push(grid);
            grid = coarser;
        }
        grids.push(grid);
        Self { grids }
    }
}

impl Grid {
    /// The linear colour of a cell; black where there is none.
    pub(super) fn get(&self, column: u32, row: u32) -> DVec3 {
        let index = row as usize * self.size[0] as usize + column as usize;
        match &self.cells {
            Cells::Linear(cells) => cells.get(index).map_or(DVec3::ZERO, |cell| cell.as_dvec3()),
            Cells::Srgb(bytes) => match bytes.get(3 * index..) {
                Some(&[r, g, b, ..]) => {
                    DVec3::from([r, g, b].map(|byte| f64::from(LINEAR[usize::from(byte)])))
                }
                _ => DVec3::ZERO,
            },
        }
    }

    fn coarser(&self) -> Self {
        let size = self.size.map(|count| count.div_ceil(COARSER));
        let mut cells = Vec::with_capacity(size[0] as usize * size[1] as usize);
        let [columns, rows] = [0, 1].map(|axis| {
            let count = size[axis];
            let parts = (0..count).map(|cell| parts(cell, count, self.size[axis]));
            parts.collect::<Vec<_>>()
        });
        for rows in &rows {
            for columns in &columns {
                let (mut sum, mut total) = (DVec3::ZERO, 0.0);
                for &(row, height) in rows {
                    for &(column, width) in columns {
                        sum += height * width * self.get(column, row);
                        total += height * width;
                    }
                }
                cells.push((sum / total).as_vec3());
            }
        }
        Self {
            size,
            cells: Cells::Linear(cells),
        }
    }
}

/// The cells along an axis of `fine` ones that are below one of `coarse` ones, and how much of each is.
fn parts(cell: u32, coarse: u32, fine: u32) -> Vec<(u32, f64)> {
    let ratio = f64::from(fine) / f64::from(coarse);
    let [low, high] = [cell, cell + 1].map(|k| f64::from(k) * ratio);
    (low.floor() as u32..(high.ceil() as u32).min(fine))
        .map(|k| (k, (f64::from(k) + 1.0).min(high) - f64::from(k).max(low)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means are f32, each the rounding of a sum of f64: two levels of it.
    const ROUNDING: f64 = 2.0 * f32::EPSILON as f64;

    #[test]
    fn a_coarser_picture_has_the_mean_of_the_finer_one() {
        for size in [[1, 1], [4, 4], [5, 3], [17, 2], [1, 64], [33, 31]] {
            let [width, height] = size.map(|n| n as usize);
            let bytes: Vec<u8> = (0..3 * width * height)
                .map(|k| (k * k % 251) as u8)
                .collect();
            let linear = bytes
                .chunks(3)
                .map(|c| f64::from(LINEAR[usize::from(c[1])]));
            let mean = linear.sum::<f64>() / (width * height) as f64;
            let texels = Texels::new(size, bytes);
            let coarsest = texels.grids.last().unwrap();
            assert_eq!(coarsest.size, [1, 1]);
            let found = coarsest.get(0, 0).y;
            assert!(
                (found - mean).abs() <= ROUNDING * mean,
                "{size:?}: {found} {mean}"
            );
        }
    }
}
