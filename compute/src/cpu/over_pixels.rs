//! Values that are linear over a window's pixels.

// A function that a vectorised caller needs must be inlined into it: compiled on its own it would
// be for the baseline instruction set.
#![allow(clippy::inline_always)]

use glam::DVec3;

use crate::hemicube::Window;

/// A value that is linear over a window's pixels: its coefficients of i, of j and of 1.
pub(super) type OverPixels = [f64; 3];

/// The value v . d, linear over the pixels' centres, as the coefficients of i, of j and of 1.
#[inline(always)]
pub(super) fn over_pixels(v: DVec3, window: &Window) -> OverPixels {
    let (x, y) = (v.dot(window.right), v.dot(window.up));
    let c = v.dot(window.forward)
        + x * (window.left + 0.5 * window.pixel)
        + y * (window.bottom + 0.5 * window.pixel);
    [x * window.pixel, y * window.pixel, c]
}
