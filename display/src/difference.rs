//! A map of where one picture is brighter or darker than another.
//!
//! With d = Y(B) - Y(B'), the difference of luminances as in [`crate::compare`], and an end D > 0, the colour is that at
//! t = (d + D) / 2D, clamped to [0, 1], of ColorBrewer's scheme RdBu turned round (Harrower and Brewer, "ColorBrewer.org", The
//! Cartographic Journal 40, 2003): blue where the picture is too dark, white where nothing differs, red where it is too bright. It falls off in
//! brightness evenly to both sides and is told apart without red-green vision. Pixels that are not compared are a dark grey,
//! which no difference has.

use image::{DynamicImage, RgbImage};
use scene::Rgb;
use scene::srgb::decode;

use crate::compare::difference;
use crate::legend::{self, Clipped, Explained, Layout};
use crate::number::rounded_up;
use crate::scale::Scale;
use crate::settings::{Range, Size};
use crate::text::Canvas;
use crate::tone::to_srgb8;

/// Share of the pixels that differ whose colours are not clipped: a few pixels on edges differ by a hundred times what others do.
const WITHIN: f64 = 0.99;

/// Significant digits of the scale's ends, at most.
const DIGITS: i32 = 2;

/// The scale's end where nothing differs, W/m^2.
const NO_DIFFERENCE: f64 = 1.0;

/// sRGB code of pixels that are not compared.
const LEFT_OUT: f32 = 0.25;

/// Entries of the colours' table: two for each step of 8 bits on either side, and the middle.
const COLORS: usize = 1025;

/// A map of differences.
#[derive(Clone, Debug, PartialEq)]
pub struct DifferenceMap {
    /// Its size, without a legend.
    pub size: Size,
    /// Display light, row by row from the top, one per pixel.
    pub pixels: Vec<Rgb>,
    /// The differences that the ends of the colours stand for, W/m^2; 0 lies in the middle.
    pub range: Range,
    /// Ends beyond which there are differences.
    pub clipped: Clipped,
}

impl DifferenceMap {
    /// Maps how much a picture differs from what is right: W/m^2, row by row from the top, one value per pixel. `mask` says of each
    /// pixel whether it counts.
    pub fn new(size: Size, shown: &[Rgb], right: &[Rgb], mask: &[bool]) -> Self {
        let pairs = shown.iter().zip(right).zip(mask);
        let differences: Vec<Option<f64>> = pairs
            .map(|((&shown, &right), &counts)| difference(shown, right).filter(|_| counts))
            .collect();
        let end = suiting(&differences);
        let range = Range {
            low: -end,
            high: end,
        };
        let scale = Scale::linear(range);
        let colors = colors();
        let left_out = Rgb::splat(decode(LEFT_OUT));
        let color = |d: &Option<f64>| d.map_or(left_out, |d| color_at(&colors, scale.position(d)));
        let known = || differences.iter().flatten();
        Self {
            size,
            pixels: differences.iter().map(color).collect(),
            range,
            clipped: Clipped {
                below: known().any(|&d| d < range.low),
                above: known().any(|&d| d > range.high),
            },
        }
    }

    /// The map for the eye, sRGB, with a legend at its right unless it is too small for one.
    pub fn image(&self) -> DynamicImage {
        let around = Layout::around(self.size);
        let Some(layout) = Layout::inside(around) else {
            return image(self.size, &self.pixels);
        };
        let mut pixels = vec![Rgb::ZERO; around.width as usize * around.height as usize];
        let rows = pixels.chunks_exact_mut(around.width as usize);
        for (wide, narrow) in rows.zip(self.pixels.chunks(self.size.width as usize)) {
            wide[..narrow.len()].copy_from_slice(narrow);
        }
        let colors = colors();
        let explained = Explained {
            heading: &["difference".to_owned(), "W/m²".to_owned()],
            scale: &Scale::linear(self.range),
            color_at: &|position| color_at(&colors, position),
        };
        let mut canvas = Canvas {
            pixels: &mut pixels,
            size: around,
        };
        legend::draw_scale(&mut canvas, layout, &explained, self.clipped);
        image(around, &pixels)
    }
}

/// The end of a scale that holds [`WITHIN`] of the differences, W/m^2; those of 0 do not count, so that a lamp that only one
/// picture has shows what it lights.
fn suiting(differences: &[Option<f64>]) -> f64 {
    let sizes = differences.iter().flatten().map(|d| d.abs());
    let mut sizes: Vec<f64> = sizes.filter(|&size| size > 0.0).collect();
    if sizes.is_empty() {
        return NO_DIFFERENCE;
    }
    let index = (WITHIN * sizes.len() as f64).ceil() as usize - 1;
    let (_, &mut size, _) = sizes.select_nth_unstable_by(index, f64::total_cmp);
    rounded_up(size, DIGITS)
}

/// Display light from too dark to too bright, [`COLORS`] entries.
fn colors() -> Vec<Rgb> {
    let color = |k: usize| {
        let color = colorous::RED_BLUE.eval_rational(COLORS - 1 - k, COLORS);
        Rgb::from_array(color.into_array().map(|c| decode(f32::from(c) / 255.0)))
    };
    (0..COLORS).map(color).collect()
}

/// Display light of a place on the scale.
fn color_at(colors: &[Rgb], position: f64) -> Rgb {
    colors[(position.clamp(0.0, 1.0) * (COLORS - 1) as f64).round() as usize]
}

fn image(size: Size, pixels: &[Rgb]) -> DynamicImage {
    let bytes = pixels.iter().flat_map(|&light| to_srgb8(light)).collect();
    RgbImage::from_raw(size.width, size.height, bytes)
        .unwrap_or_default()
        .into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::luminance::luminance;

    /// What 8 bits leave of a colour's luminance: half a step of a channel, where sRGB is steepest 2.3 steps of light.
    const STEP: f32 = 2.3 * 0.5 / 255.0;

    #[test]
    fn colours_are_white_in_the_middle_and_fall_off_in_brightness_to_both_sides() {
        let colors = colors();
        let middle = COLORS / 2;
        assert!(colors[middle].min_element() > 0.8);
        let way = |k: usize| [colors[middle - k], colors[middle + k]];
        for k in 1..=middle {
            for (nearer, farther) in way(k - 1).into_iter().zip(way(k)) {
                assert!(luminance(farther) <= luminance(nearer) + 2.0 * STEP, "{k}");
            }
        }
        let [blue, red] = way(middle);
        assert!(blue.z > 2.0 * blue.x && red.x > 2.0 * red.z);
        assert!(luminance(colors[0]) < 0.1 && luminance(colors[COLORS - 1]) < 0.1);
    }

    #[test]
    fn the_grey_of_pixels_that_are_left_out_is_no_difference() {
        let grey = Rgb::splat(decode(LEFT_OUT));
        let distance = |color: &Rgb| color.distance(grey);
        let colors = colors();
        let nearest = colors.iter().map(distance).fold(f32::INFINITY, f32::min);
        // More than three steps of each channel at this brightness.
        assert!(nearest > 0.02, "{nearest}");
    }

    #[test]
    fn scale_holds_all_but_a_hundredth_and_ends_in_a_readable_number() {
        let mut differences: Vec<Option<f64>> =
            (1..=1000).map(|k| Some(f64::from(k) * -1.23e-3)).collect();
        // The 990th is 1.2177.
        assert_eq!(suiting(&differences).to_string(), "1.3");
        // Neither what is left out nor what is equal counts.
        differences.extend(vec![None; 5000]);
        differences.extend(vec![Some(0.0); 5000]);
        assert_eq!(suiting(&differences).to_string(), "1.3");
        assert_eq!(suiting(&[Some(0.0321)]).to_string(), "0.033");
        assert_eq!(suiting(&[Some(0.0), None]).to_string(), "1");
        assert_eq!(suiting(&[]).to_string(), "1");
    }
}
