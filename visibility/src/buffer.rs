//! What the pixels of a window see, and how near it is: what every strategy draws into.

use crate::Window;

/// No piece, in a buffer's codes.
pub(crate) const NONE: u32 = u32::MAX;

/// Marks the code of a pixel that sees a speck, whose region is the lowest bits.
pub(crate) const SPECK: u32 = 1 << 31;

/// And that it is the speck's back. There are 2^24 regions at most, so that no such code is [`NONE`].
pub(crate) const SPECK_BACK: u32 = 1 << 30;

/// A region's number, in the code of a pixel that sees a speck.
pub(crate) const SPECK_REGION: u32 = SPECK_BACK - 1;

/// Rows are padded so that the widest vector (16 lanes) can run over their end.
pub(crate) const PADDING: usize = 16;

/// Pixels with a depth buffer. Reversed depth: 1/w is kept, 0 is infinitely far.
#[derive(Clone, Debug, Default)]
pub(crate) struct Buffer {
    /// 1/w, 1/m; `width + PADDING` a row.
    pub inverse_depth: Vec<f32>,
    /// Index of a piece, [`NONE`], or a speck; `width + PADDING` a row.
    pub codes: Vec<u32>,
}

impl Buffer {
    /// Sees nothing in any pixel of a window.
    pub fn clear(&mut self, window: &Window) {
        self.clear_codes(window);
        self.inverse_depth.clear();
        self.inverse_depth.resize(self.codes.len(), 0.0);
    }

    /// The same for a strategy that keeps depths of its own.
    pub fn clear_codes(&mut self, window: &Window) {
        self.codes.clear();
        self.codes
            .resize((window.width + PADDING) * window.height, NONE);
    }

    /// The codes of row j of a window.
    pub fn row(&self, window: &Window, j: usize) -> &[u32] {
        &self.codes[j * (window.width + PADDING)..][..window.width]
    }
}

/// A region, and the side of it that is seen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Seen {
    pub region: u32,
    pub is_back_face: bool,
}

impl Seen {
    /// What the code of a speck says.
    #[inline(always)]
    pub fn of_speck(code: u32) -> Self {
        Self {
            region: code & SPECK_REGION,
            is_back_face: code & SPECK_BACK != 0,
        }
    }

    /// The code of a speck.
    #[inline(always)]
    pub fn speck(self) -> u32 {
        let back = if self.is_back_face { SPECK_BACK } else { 0 };
        SPECK | back | self.region
    }
}
