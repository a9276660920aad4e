//! How far a picture is from one that is right, over the pixels of a mask.
//!
//! With B what a picture shows and B' what is right, W/m^2, over pixels and channels:
//!
//! power error: sqrt(sum (B - B')^2 / sum B'^2)
//!
//! visible error: sqrt(mean of ((B - B') / (B' + 0.05 mean B'))^2)
//!
//! They are [`compute::compare::errors_over`]'s, whose module says what each is for. Beside them stands what a difference map shows:
//! Y(B) - Y(B'), with the luminance Y of [`crate::scale`].

use compute::compare::{Compared, errors_over};
use compute::function::Errors;
use scene::Rgb;

use crate::luminance::luminance;
use crate::number::with_digits;
use crate::settings::Size;

/// Digits of a difference that people read.
const DIGITS: usize = 2;

/// What differs between two pictures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Comparison {
    /// Both errors; infinite where what is right is black and the picture is not.
    pub errors: Errors,
    /// Pixels that are compared.
    pub pixels: usize,
    /// Pixels of the mask that are not, since one of the pictures has no finite number there.
    pub not_finite: usize,
    /// Pixels in the picture.
    pub all_pixels: usize,
    /// Mean of the luminances' difference, W/m^2; above 0 where the picture is too bright.
    pub mean_difference: f64,
    /// The pixel whose luminance differs most, of several the first; `None` where no pixel is compared.
    pub most: Option<Most>,
}

/// The pixel whose luminance differs most.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Most {
    /// By how much, W/m^2; above 0 where the picture is too bright.
    pub difference: f64,
    /// Its column, from the left.
    pub x: u32,
    /// Its row, from the top.
    pub y: u32,
}

impl Comparison {
    /// Compares a picture with what is right: W/m^2, row by row from the top, one value per pixel. `mask` says of each pixel whether
    /// it counts.
    pub fn new(size: Size, shown: &[Rgb], right: &[Rgb], mask: &[bool]) -> Self {
        let masked = || {
            let pairs = shown.iter().zip(right).zip(mask).enumerate();
            pairs.filter_map(|(k, ((&shown, &right), &counts))| counts.then_some((k, shown, right)))
        };
        let pairs = || {
            masked().filter_map(|(k, shown, right)| {
                difference(shown, right).map(|difference| (k, shown, right, difference))
            })
        };
        let pixels = pairs().count();
        let points = pairs().map(|(_, shown, right, _)| Compared {
            area: 1.0,
            shown: shown.as_dvec3(),
            right: right.as_dvec3(),
        });
        let sum: f64 = pairs().map(|(.., difference)| difference).sum();
        let most = pairs().reduce(|a, b| if b.3.abs() > a.3.abs() { b } else { a });
        let width = (size.width as usize).max(1);
        Self {
            errors: errors_over(&points),
            pixels,
            not_finite: masked().count() - pixels,
            all_pixels: size.width as usize * size.height as usize,
            mean_difference: sum / pixels.max(1) as f64,
            most: most.map(|(k, .., difference)| Most {
                difference,
                x: (k % width) as u32,
                y: (k / width) as u32,
            }),
        }
    }

    /// One line for people, or two.
    pub fn describe(&self) -> String {
        let mut text = match self.most {
            None => "no pixel counts, so that nothing is compared".to_owned(),
            Some(most) => {
                let errors = describe_errors(self.errors);
                let over = self.describe_share();
                let differences = self.describe_differences(most);
                format!("{errors}, over {over}; {differences}")
            }
        };
        if self.not_finite > 0 {
            let pixels = counted(self.not_finite);
            text += "\n";
            text += &pixels;
            text += " left out: no finite number in one of the pictures";
        }
        text
    }

    fn describe_share(&self) -> String {
        let percent = 100.0 * self.pixels as f64 / self.all_pixels.max(1) as f64;
        if percent < 1.0 {
            counted(self.pixels)
        } else {
            format!("{percent:.0} % of the pixels")
        }
    }

    fn describe_differences(&self, most: Most) -> String {
        if most.difference == 0.0 {
            return "of one luminance in each of them".to_owned();
        }
        let mean = describe_difference(self.mean_difference);
        let Most { difference, x, y } = most;
        let difference = describe_difference(difference);
        format!("on the mean {mean}, most {difference} at x {x}, y {y}")
    }
}

/// How much brighter than it should be a pixel is, W/m^2 of luminance; `None` where either is no finite number.
pub fn difference(shown: Rgb, right: Rgb) -> Option<f64> {
    let [shown, right] = [shown, right].map(|value| {
        let luminance = luminance(value);
        (value.is_finite() && luminance.is_finite()).then_some(f64::from(luminance))
    });
    Some(shown? - right?)
}

/// Both errors for people, without a full stop.
pub(crate) fn describe_errors(errors: Errors) -> String {
    let Errors { power, visible } = errors;
    if power.is_finite() && visible.is_finite() {
        let [power, visible] = [power, visible].map(|error| 100.0 * error);
        format!("power {power:.2} %, visible {visible:.2} %")
    } else {
        "no relative error, since what is right is black".to_owned()
    }
}

/// A difference for people, W/m^2.
pub(crate) fn describe_difference(difference: f64) -> String {
    let size = with_digits(difference.abs(), DIGITS);
    let way = if difference < 0.0 { "dark" } else { "bright" };
    format!("{size} W/m^2 too {way}")
}

fn counted(pixels: usize) -> String {
    match pixels {
        1 => "1 pixel".to_owned(),
        _ => format!("{pixels} pixels"),
    }
}
