//! Colours are those of `display`.

use display::distinct::distinct_color;
use display::tone::to_srgb8;
use display::{Channel, Mode, Quantity, Shown};
use scene::Rgb;
use scene::srgb::{decode, encode};
use window::looks::Looks;
use window::values::Values;

use crate::model::{asked, by_pixel, drawn, inside, light_of_display, patches_of_display, room};

/// Half a code of 8 bits: each sample of the graphics card is rounded to one. The mean light of samples, encoded, is off by no more
/// than the samples are: with s the share of what has code c, both the light's error and its mean grow with s, and encoding,
/// whose slope falls as a power of -0.58 of the light, leaves s^0.42 of the error. f32 rounding of logarithms and powers, and of a false
/// colour's place among 1,024, of which four make a code, is within another half.
const ROUNDING: f32 = 1.0 / 255.0;

/// The largest difference of codes over 255 among pixels all of whose samples see the same patches in both pictures, and how many
/// of those there are.
fn largest_difference(looks: Looks, stops_more: f32) -> (f32, usize) {
    let loaded = room();
    let asked = asked(inside(), looks, None);
    let range = Values::new(&loaded, &looks).unwrap().range;
    let theirs = light_of_display(&loaded, &asked, &looks.tone(range));
    let mut other = asked;
    other.looks.exposure_stops += stops_more;
    let samples = drawn(&loaded, &other);
    let patches = patches_of_display(&loaded, &asked);
    let agreed: Vec<_> = samples.iter().copied().zip(patches).collect();
    let (mut largest, mut count) = (0.0_f32, 0);
    for (samples, theirs) in by_pixel(&agreed).into_iter().zip(theirs) {
        if samples
            .iter()
            .any(|&((_, seen), patch)| seen != patch || seen.is_none())
        {
            continue;
        }
        let light =
            |[r, g, b]: [u8; 3]| Rgb::from_array([r, g, b].map(|c| decode(f32::from(c) / 255.0)));
        let sum: Rgb = samples.iter().map(|&((color, _), _)| light(color)).sum();
        let mean = sum / samples.len() as f32;
        let codes = [mean, theirs]
            .map(|light| Rgb::from_array(light.clamp(Rgb::ZERO, Rgb::ONE).to_array().map(encode)));
        largest = largest.max((codes[0] - codes[1]).abs().max_element());
        count += 1;
    }
    (largest, count)
}

/// Nine tenths of all pixels are compared: edges take the rest.
const COMPARED: usize = 75 * 58 * 9 / 10;

pub fn every_mode_shows_the_colours_of_display() {
    for mode in [Mode::Log, Mode::Filmic, Mode::Linear, Mode::FalseColor] {
        for is_flat in [true, false] {
            let looks = Looks {
                mode,
                is_flat,
                ..Looks::default()
            };
            let (largest, count) = largest_difference(looks, 0.0);
            assert!(count > COMPARED, "{mode}: {count} pixels");
            assert!(
                largest <= ROUNDING,
                "{mode}, flat {is_flat}: {}",
                255.0 * largest
            );
        }
    }
}

pub fn every_channel_of_the_function_is_shown_as_display_shows_it() {
    let channels = [
        Channel::Luminance,
        Channel::Red,
        Channel::Green,
        Channel::Blue,
    ];
    let quantities = [
        Quantity::Indirect,
        Quantity::Direct,
        Quantity::Irradiance,
        Quantity::Radiance,
    ];
    for (channel, quantity) in channels.into_iter().zip(quantities) {
        let looks = Looks {
            shown: Shown {
                quantity,
                channel,
                is_luminous: true,
            },
            ..Looks::default()
        };
        let (largest, count) = largest_difference(looks, 0.0);
        assert!(count > COMPARED, "{count} pixels");
        assert!(
            largest <= ROUNDING,
            "{quantity}, {channel}: {}",
            255.0 * largest
        );
    }
}

pub fn another_exposure_would_be_noticed() {
    let looks = Looks::default();
    let (largest, _) = largest_difference(looks, 0.1);
    assert!(largest > 2.0 * ROUNDING, "{}", 255.0 * largest);
}

pub fn ids_have_the_colours_of_display() {
    let looks = Looks {
        mode: Mode::Ids,
        ..Looks::default()
    };
    for (color, patch) in drawn(&room(), &asked(inside(), looks, None)) {
        let Some(patch) = patch else { continue };
        let expected = to_srgb8(distinct_color(patch));
        for (code, expected) in color.into_iter().zip(expected) {
            // Both are rounded to 8 bits; a code that lies between two may become either.
            assert!(code.abs_diff(expected) <= 1, "{patch:?}: {color:?}");
        }
    }
}
