//! Values that are linear over a window's pixels.

use glam::DVec3;

use crate::Window;

/// A value that is linear over a window's pixels: its coefficients of i, of j and of 1.
pub(crate) type Affine = [f64; 3];

/// The value v . d, linear over the pixels' centres, as the coefficients of i, of j and of 1.
#[inline(always)]
pub(crate) fn affine(v: DVec3, window: &Window) -> Affine {
    let (x, y) = (v.dot(window.right), v.dot(window.up));
    let c = v.dot(window.forward)
        + x * (window.left + 0.5 * window.pixel)
        + y * (window.bottom + 0.5 * window.pixel);
    [x * window.pixel, y * window.pixel, c]
}
