//! What a face of a hemicube cannot see, by a few comparisons.
//!
//! Bits say on which sides of the planes between a hemicube's faces a point is, and whether it is above the
//! horizon. A face sees a piece only if none of that face's bits is set for all its corners.

use crate::hemicube::FACES;

pub(crate) const NOT_ABOVE_HORIZON: u32 = 1;
const X_NOT_ABOVE_0: u32 = 1 << 1;
const X_NOT_BELOW_0: u32 = 1 << 2;
const Y_NOT_ABOVE_0: u32 = 1 << 3;
const Y_NOT_BELOW_0: u32 = 1 << 4;
const X_ABOVE_Z: u32 = 1 << 5;
const MINUS_X_ABOVE_Z: u32 = 1 << 6;
const Y_ABOVE_Z: u32 = 1 << 7;
const MINUS_Y_ABOVE_Z: u32 = 1 << 8;
const X_BELOW_Z: u32 = 1 << 9;
const MINUS_X_BELOW_Z: u32 = 1 << 10;
const Y_BELOW_Z: u32 = 1 << 11;
const MINUS_Y_BELOW_Z: u32 = 1 << 12;
const Y_ABOVE_X: u32 = 1 << 13;
const Y_BELOW_X: u32 = 1 << 14;
const Y_ABOVE_MINUS_X: u32 = 1 << 15;
const Y_BELOW_MINUS_X: u32 = 1 << 16;

/// All bits of a point in the frame.
#[inline(always)]
pub(crate) fn of_point(x: f64, y: f64, z: f64) -> u32 {
    let bit = |is_set: bool, bit: u32| if is_set { bit } else { 0 };
    bit(z <= 0.0, NOT_ABOVE_HORIZON)
        | bit(x <= 0.0, X_NOT_ABOVE_0)
        | bit(x >= 0.0, X_NOT_BELOW_0)
        | bit(y <= 0.0, Y_NOT_ABOVE_0)
        | bit(y >= 0.0, Y_NOT_BELOW_0)
        | bit(x > z, X_ABOVE_Z)
        | bit(-x > z, MINUS_X_ABOVE_Z)
        | bit(y > z, Y_ABOVE_Z)
        | bit(-y > z, MINUS_Y_ABOVE_Z)
        | bit(x < z, X_BELOW_Z)
        | bit(-x < z, MINUS_X_BELOW_Z)
        | bit(y < z, Y_BELOW_Z)
        | bit(-y < z, MINUS_Y_BELOW_Z)
        | bit(y > x, Y_ABOVE_X)
        | bit(y < x, Y_BELOW_X)
        | bit(y > -x, Y_ABOVE_MINUS_X)
        | bit(y < -x, Y_BELOW_MINUS_X)
}

/// The bits of each face, in the order of [`crate::hemicube::windows`].
pub(crate) const OF_FACES: [u32; FACES] = [
    NOT_ABOVE_HORIZON | X_ABOVE_Z | MINUS_X_ABOVE_Z | Y_ABOVE_Z | MINUS_Y_ABOVE_Z,
    NOT_ABOVE_HORIZON | X_NOT_ABOVE_0 | X_BELOW_Z | Y_ABOVE_X | Y_BELOW_MINUS_X,
    NOT_ABOVE_HORIZON | Y_NOT_ABOVE_0 | Y_BELOW_Z | Y_BELOW_X | Y_BELOW_MINUS_X,
    NOT_ABOVE_HORIZON | X_NOT_BELOW_0 | MINUS_X_BELOW_Z | Y_BELOW_X | Y_ABOVE_MINUS_X,
    NOT_ABOVE_HORIZON | Y_NOT_BELOW_0 | MINUS_Y_BELOW_Z | Y_ABOVE_X | Y_ABOVE_MINUS_X,
];
