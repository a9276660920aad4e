//! Luminance: Y = 0.2126 R + 0.7152 G + 0.0722 B of linear RGB, with the weights of ITU-R BT.709-6, item 3.2.

use scene::Rgb;

/// Weights of linear red, green and blue in the luminance, dimensionless.
const LUMINANCE_WEIGHTS: Rgb = Rgb::new(0.2126, 0.7152, 0.0722);

/// Luminance of a linear RGB value, in its unit.
#[inline]
pub fn luminance(value: Rgb) -> f32 {
    value.dot(LUMINANCE_WEIGHTS)
}
