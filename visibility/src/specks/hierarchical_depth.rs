//! A hierarchical depth buffer of one level: the farthest depth in each block of pixels. What is behind all of some
//! blocks need not be drawn (Greene, Kass and Miller, "Hierarchical Z-buffer visibility", SIGGRAPH 1993).

use std::ops::Range;

use fearless_simd::{Simd, f32x8, prelude::*};

use crate::Window;
use crate::buffer::PADDING;

/// Pixels along a block.
const BLOCK: usize = 8;

/// Of a block whose pixels have changed since it was last asked for.
const UNKNOWN: f32 = -1.0;

/// A rectangle of pixels that may see something, and how near that is.
pub(crate) struct Rectangle {
    pub columns: Range<usize>,
    pub rows: Range<usize>,
    /// No inverse depth of it is larger, 1/m.
    pub nearest: f32,
}

/// The smallest inverse depths of blocks of pixels. Kept between pictures to save allocating.
#[derive(Clone, Debug, Default)]
pub(crate) struct HierarchicalDepth {
    /// Pixels in a row and rows of the picture.
    width: usize,
    height: usize,
    /// Blocks in a row.
    columns: usize,
    /// 1/m, or [`UNKNOWN`]; row after row.
    farthest: Vec<f32>,
}

impl HierarchicalDepth {
    /// Knows nothing of a picture.
    pub fn start(&mut self, window: &Window) {
        self.width = window.width;
        self.height = window.height;
        self.columns = window.width.div_ceil(BLOCK);
        let count = self.columns * window.height.div_ceil(BLOCK);
        self.farthest.clear();
        self.farthest.resize(count, UNKNOWN);
    }

    /// Pixel (i, j) has come nearer.
    #[inline(always)]
    pub fn forget(&mut self, i: usize, j: usize) {
        self.farthest[j / BLOCK * self.columns + i / BLOCK] = UNKNOWN;
    }

    /// True where all blocks that hold some pixels are nearer than what these may see.
    #[inline(always)]
    pub fn hides<S: Simd>(
        &mut self,
        simd: S,
        inverse_depth: &[f32],
        Rectangle {
            columns,
            rows,
            nearest,
        }: &Rectangle,
    ) -> bool {
        for row in rows.start / BLOCK..rows.end.div_ceil(BLOCK) {
            for column in columns.start / BLOCK..columns.end.div_ceil(BLOCK) {
                let block = row * self.columns + column;
                if self.farthest[block] == UNKNOWN {
                    self.farthest[block] = self.look(simd, inverse_depth, column, row);
                }
                if *nearest >= self.farthest[block] {
                    return false;
                }
            }
        }
        true
    }

    /// The smallest inverse depth in a block.
    #[inline(always)]
    fn look<S: Simd>(&self, simd: S, inverse_depth: &[f32], column: usize, row: usize) -> f32 {
        let stride = self.width + PADDING;
        let (left, bottom) = (column * BLOCK, row * BLOCK);
        let mut farthest = f32x8::splat(simd, f32::INFINITY);
        for j in bottom..(bottom + BLOCK).min(self.height) {
            let start = j * stride + left;
            let depths = f32x8::from_slice(simd, &inverse_depth[start..start + BLOCK]);
            farthest = farthest.min(depths);
        }
        // What lies beyond the end of a row is no pixel.
        let farthest = farthest.as_array();
        let pixels = &farthest[..BLOCK.min(self.width - left)];
        pixels.iter().copied().fold(f32::INFINITY, f32::min)
    }
}
