//! Colours by which people tell patches apart.
//!
//! # Theory
//! Multiplicative hashing (Knuth, "The Art of Computer Programming", volume 3, section 6.4): the fractional part of
//! k phi, phi the golden ratio, spreads consecutive numbers k as evenly as can be, so that patches with near IDs, which
//! are neighbours along their surface's bisection tree, have hues far apart. Patches whose IDs differ by a Fibonacci number
//! have nearly the same hue; a second sequence, of k sqrt(2), gives them other lightnesses. Hue and lightness are those
//! of Oklab (Ottosson, "A perceptual color space for image processing", 2020), in which equal steps look about equal.

use std::f32::consts::TAU;

use scene::{PatchId, Rgb};

/// 2^32 times the fractional parts of the golden ratio and of the square root of 2, odd.
const GOLDEN: u32 = 0x9e37_79b9;
const SQUARE_ROOT_OF_2: u32 = 0x6a09_e667;

/// Lightnesses and their chromas in Oklab, both 0 to 1: none is dark, and most hues of each are within sRGB.
const SHADES: [[f32; 2]; 4] = [[0.62, 0.15], [0.72, 0.10], [0.80, 0.15], [0.90, 0.07]];

/// A patch's colour as display light, linear RGB in [0, 1]: the same for the same ID, and far from black.
pub fn distinct_color(patch: PatchId) -> Rgb {
    // The upper bits of the products, as many as an f32 holds.
    let fraction = |factor: u32| (patch.0.wrapping_mul(factor) >> 8) as f32 / (1 << 24) as f32;
    let shade = (fraction(SQUARE_ROOT_OF_2) * SHADES.len() as f32) as usize;
    let [lightness, chroma] = SHADES[shade.min(SHADES.len() - 1)];
    let (sin, cos) = (TAU * fraction(GOLDEN)).sin_cos();
    from_oklab(lightness, chroma * cos, chroma * sin).clamp(Rgb::ZERO, Rgb::ONE)
}

/// Linear RGB of a colour in Oklab.
fn from_oklab(lightness: f32, a: f32, b: f32) -> Rgb {
    let l = (lightness + 0.396_337_78 * a + 0.215_803_76 * b).powi(3);
    let m = (lightness - 0.105_561_346 * a - 0.063_854_17 * b).powi(3);
    let s = (lightness - 0.089_484_18 * a - 1.291_485_5 * b).powi(3);
    Rgb::new(
        4.076_741_7 * l - 3.307_711_6 * m + 0.230_969_94 * s,
        -1.268_438 * l + 2.609_757_4 * m - 0.341_319_4 * s,
        -0.004_196_086_3 * l - 0.703_418_6 * m + 1.707_614_7 * s,
    )
}

#[cfg(test)]
mod tests {
    use scene::MAX_PATCHES;
    use scene::srgb::encode;

    use super::*;
    use crate::luminance::luminance;

    fn encoded(patch: u32) -> Rgb {
        Rgb::from_array(distinct_color(PatchId(patch)).to_array().map(encode))
    }

    fn some_patches() -> impl Iterator<Item = u32> {
        (0..1000)
            .chain((0..1000).map(|k| 16_769 * k))
            .chain([MAX_PATCHES - 10])
    }

    /// The matrices' inverses take white to lightness 1 without chroma, as published, with 7 digits.
    #[test]
    fn white_of_oklab_is_white() {
        assert!(from_oklab(1.0, 0.0, 0.0).abs_diff_eq(Rgb::ONE, 1e-6));
        assert!(from_oklab(0.5, 0.0, 0.0).abs_diff_eq(Rgb::splat(0.125), 1e-6));
    }

    /// A lightness of 0.62 is a luminance of 0.62^3 = 0.24; chroma and clamping move it by less than a third.
    #[test]
    fn colours_are_within_the_screens_and_not_dark() {
        for patch in some_patches() {
            let color = distinct_color(PatchId(patch));
            assert!(color.min_element() >= 0.0 && color.max_element() <= 1.0);
            assert!(luminance(color) > 0.16, "{patch}: {color}");
        }
    }

    /// Hues of IDs that differ by 1, 2, 3 or 4 are a seventh of a turn apart or more. In the palest shade that is an Oklab
    /// distance of 2 * 0.07 sin(pi / 7) = 0.06, three times what can just be told apart, and at least as much in some
    /// channel's code, since these are steeper than Oklab's coordinates where colours are light.
    #[test]
    fn patches_with_near_ids_have_colours_far_apart() {
        for patch in some_patches() {
            for step in 1..=4 {
                let difference = (encoded(patch) - encoded(patch + step)).abs().max_element();
                assert!(difference > 0.06, "{patch} + {step}: {difference}");
            }
        }
    }

    /// Within 144 patches hues repeat within 1/144 of a turn only in other shades, or they differ by that at least.
    #[test]
    fn no_two_patches_of_a_hundred_share_a_colour() {
        let colors: Vec<Rgb> = (0..100).map(encoded).collect();
        for (k, a) in colors.iter().enumerate() {
            for (m, b) in colors[..k].iter().enumerate() {
                // One step of 8 bits.
                assert!((*a - *b).abs().max_element() > 1.0 / 255.0, "{k} and {m}");
            }
        }
    }
}
