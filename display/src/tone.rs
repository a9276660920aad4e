//! From linear RGB to what a screen shows.
//!
//! Every mode maps a value to *display light*, linear RGB in [0, 1] relative to the screen's white.
//! The samples of a pixel are averaged as display light, and the average is encoded with the sRGB
//! transfer function (IEC 61966-2-1). With Y a value's luminance and t its place on the
//! [`Scale`], clamped to [0, 1]:
//!
//! - log: the brightness that the eye is given is the logarithm of the light, so t itself is the
//!   *encoded* luminance and D = decode(t) the display's. The value's RGB is scaled by D / Y, which
//!   keeps hue and saturation. A channel that would exceed 1 pulls the colour towards the grey of
//!   luminance D just as far as needed, so that luminance is kept and lamps fade into white. (The
//!   thesis maps each value by a logarithm to the 8 bits it shows, hence a logarithm of encoded
//!   values here; a logarithm of display light would come out pale.)
//! - filmic: each channel x, by the scale, as x (2.51 x + 0.03) / (x (2.43 x + 0.59) + 0.14), which a print does to a negative
//!   (Narkowicz, "ACES filmic tone mapping curve", 2016): what is as bright as the range's high end is at four fifths of white.
//! - linear: each channel by the scale, clamped. Where nothing is clamped this commutes with
//!   averaging.
//! - false-color: the colour at t of viridis (van der Walt and Smith 2015), which is perceptually
//!   uniform, readable without colour vision, and whose darkest colour differs from black.
//!
//! # Differences
//! Averaging light first and mapping the average would be nearer to a camera, but a pixel that is
//! a tenth lamp and nine tenths wall would be as white as the lamp: edges of lamps would be
//! jagged in spite of all samples.

use scene::Rgb;
use scene::srgb::{decode, encode};

use crate::luminance::luminance;
use crate::scale::Scale;
use crate::settings::{Mode, Range};

/// Entries of the false colours' table: four for each step of 8 bits.
const COLORS: usize = 1024;

/// A mapping of values to display light.
#[derive(Clone, Debug)]
pub struct Tone {
    scale: Scale,
    curve: Curve,
}

#[derive(Clone, Debug)]
enum Curve {
    Log,
    Filmic,
    Linear,
    /// Display light, [`COLORS`] entries.
    FalseColor(Vec<Rgb>),
}

impl Tone {
    /// The mapping of a mode. [`Mode::Ids`] shows no values, and has that of [`Mode::Linear`].
    pub fn new(mode: Mode, range: Range) -> Self {
        let (scale, curve) = match mode {
            Mode::Log => (Scale::logarithmic(range), Curve::Log),
            Mode::Filmic => (Scale::linear(range), Curve::Filmic),
            Mode::Linear | Mode::Ids => (Scale::linear(range), Curve::Linear),
            Mode::FalseColor => (Scale::suiting(range), Curve::FalseColor(false_colors())),
        };
        Self { scale, curve }
    }

    /// The scale that luminances are placed on.
    pub fn scale(&self) -> &Scale {
        &self.scale
    }

    /// Display light of a value in W/m^2.
    #[inline]
    pub fn display_light(&self, value: Rgb) -> Rgb {
        match &self.curve {
            Curve::Log => {
                let light = f64::from(luminance(value));
                let t = self.scale.position(light) as f32;
                if t > 0.0 {
                    scaled_to(value, light as f32, decode(t.min(1.0)))
                } else {
                    Rgb::ZERO
                }
            }
            Curve::Filmic => Rgb::from_array(
                value
                    .to_array()
                    .map(|v| filmic(self.scale.position(f64::from(v)))),
            ),
            Curve::Linear => Rgb::from_array(
                value
                    .to_array()
                    .map(|v| self.scale.position(f64::from(v)).clamp(0.0, 1.0) as f32),
            ),
            Curve::FalseColor(_) => self.color_at(self.scale.position(f64::from(luminance(value)))),
        }
    }

    /// Display light of a place on the scale, in the colour of a legend.
    pub fn color_at(&self, position: f64) -> Rgb {
        match &self.curve {
            Curve::Log => Rgb::splat(decode(position.clamp(0.0, 1.0) as f32)),
            Curve::Filmic => Rgb::splat(filmic(position)),
            Curve::Linear => Rgb::splat(position.clamp(0.0, 1.0) as f32),
            Curve::FalseColor(colors) => {
                colors[(position.clamp(0.0, 1.0) * (COLORS - 1) as f64).round() as usize]
            }
        }
    }
}

/// A value of this luminance (above 0), scaled to display luminance `target` in [0, 1].
fn scaled_to(value: Rgb, luminance: f32, target: f32) -> Rgb {
    let scaled = value * (target / luminance);
    let largest = scaled.max_element();
    if largest <= 1.0 {
        return scaled;
    }
    // The largest channel exceeds 1 >= target, so the quotient is in [0, 1).
    let saturation = (1.0 - target) / (largest - target);
    Rgb::splat(target) + saturation * (scaled - Rgb::splat(target))
}

/// Display light of a place on a scale, 0 to 1.
fn filmic(position: f64) -> f32 {
    // Beyond 10 all is white, and squares are far from overflow.
    let x = position.clamp(0.0, 10.0);
    let light = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14);
    light.min(1.0) as f32
}

fn false_colors() -> Vec<Rgb> {
    (0..COLORS)
        .map(|k| {
            let color = colorous::VIRIDIS.eval_rational(k, COLORS);
            Rgb::from_array(color.into_array().map(|c| decode(f32::from(c) / 255.0)))
        })
        .collect()
}

/// Display light as the 8 bits of a channel that files hold.
#[inline]
pub fn to_srgb8(display_light: Rgb) -> [u8; 3] {
    display_light
        .to_array()
        .map(|c| (encode(c.clamp(0.0, 1.0)) * 255.0).round() as u8)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const RANGE: Range = Range {
        low: 0.1,
        high: 50.0,
    };
    const MODES: [Mode; 4] = [Mode::Log, Mode::Filmic, Mode::Linear, Mode::FalseColor];

    /// f32 rounding of some ten operations on values up to 1.
    const ROUNDING: f32 = 10.0 * f32::EPSILON;

    fn tone(mode: Mode) -> Tone {
        Tone::new(mode, RANGE)
    }

    fn any_value() -> impl Strategy<Value = Rgb> {
        prop::array::uniform3(1e-3_f32..1e3).prop_map(Rgb::from_array)
    }

    proptest! {
        #[test]
        fn display_luminance_never_falls_as_the_light_grows(
            value in any_value(), factor in 1.0_f32..10.0
        ) {
            for mode in MODES {
                let darker = luminance(tone(mode).display_light(value));
                let brighter = luminance(tone(mode).display_light(value * factor));
                // Viridis comes in 8 bits: its luminance wavers by less than a step of one channel.
                let slack = if mode == Mode::FalseColor { 1.0 / 255.0 } else { ROUNDING };
                prop_assert!(brighter >= darker - slack, "{mode}: {darker} to {brighter}");
            }
        }

        #[test]
        fn display_light_is_within_black_and_white(value in any_value()) {
            for mode in MODES {
                let light = tone(mode).display_light(value);
                prop_assert!(light.min_element() >= -ROUNDING, "{light}");
                prop_assert!(light.max_element() <= 1.0 + ROUNDING, "{light}");
            }
        }

        #[test]
        fn logarithmic_map_keeps_the_hue_of_what_it_need_not_clip(value in any_value()) {
            let light = tone(Mode::Log).display_light(value);
            if light.min_element() > 0.0 && light.max_element() < 1.0 - ROUNDING {
                let (a, b) = (value / value.max_element(), light / light.max_element());
                prop_assert!(a.abs_diff_eq(b, ROUNDING), "{a} became {b}");
            }
        }

        #[test]
        fn linear_map_commutes_with_averaging(a in 0.2_f32..49.0, b in 0.2_f32..49.0) {
            let map = |v| tone(Mode::Linear).display_light(Rgb::splat(v));
            prop_assert!(map(0.5 * (a + b)).abs_diff_eq(0.5 * (map(a) + map(b)), ROUNDING));
        }
    }

    #[test]
    fn ends_of_the_range_map_to_the_ends_of_the_scale() {
        let ends = |mode| {
            [RANGE.low, RANGE.high]
                .map(|v| to_srgb8(tone(mode).display_light(Rgb::splat(v as f32))))
        };
        for mode in [Mode::Log, Mode::Linear] {
            assert_eq!(ends(mode), [[0; 3], [255; 3]], "{mode}");
        }
        let viridis = [[68, 1, 84], [253, 231, 37]];
        for (end, expected) in ends(Mode::FalseColor).iter().zip(viridis) {
            assert!(
                end.iter().zip(expected).all(|(a, b)| a.abs_diff(b) <= 1),
                "{end:?}"
            );
        }
    }

    #[test]
    fn geometric_middle_of_a_logarithmic_range_is_the_middle_code() {
        let middle = (RANGE.low * RANGE.high).sqrt() as f32;
        let [r, g, b] = to_srgb8(tone(Mode::Log).display_light(Rgb::splat(middle)));
        assert!(r == g && g == b && (127..=128).contains(&r), "{r} {g} {b}");
    }

    #[test]
    fn coloured_lamps_above_the_range_are_white() {
        let lamp = Rgb::new(47.0, 38.0, 31.0) * 20.0;
        assert_eq!(to_srgb8(tone(Mode::Log).display_light(lamp)), [255; 3]);
    }

    #[test]
    fn no_light_is_black_and_not_a_number_is_not_made() {
        for mode in [Mode::Log, Mode::Linear] {
            assert_eq!(tone(mode).display_light(Rgb::ZERO), Rgb::ZERO);
        }
        assert!(tone(Mode::FalseColor).display_light(Rgb::ZERO).is_finite());
    }
}
