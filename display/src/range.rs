//! A range of luminances that suits a scene, where none is asked for.
//!
//! Lamps are orders of magnitude brighter than what they light, and a few patches in corners orders
//! darker. So the range runs between two percentiles, by area, of the luminances of what reflects
//! only; lamps may clip to white, and what only stray light reaches does not count. Where there are lamps to be seen, the
//! brightest wall stays a step below white, so that a lamp is told from it.
//!
//! Where most of a scene is nearly as bright as its brightest, as outdoors, a logarithm down to its shadows would show all of it
//! pale; a log picture's range then ends sooner below.

use scene::srgb::decode;
use scene::{Rgb, Scene};

use crate::luminance::luminance;
use crate::scale::LOGARITHMIC_FROM;
use crate::settings::{Mode, Range};

/// Shares of the lit area that lie below the range and above it. Tuned by eye on the Cornell box
/// and on a hall with columns.
const DARKEST: f64 = 0.005;
const BRIGHTEST: f64 = 0.005;

/// The percentiles' quotient is taken for at least this, so that an even scene does not become all
/// contrast.
const MIN_CONTRAST: f64 = 10.0;
/// And for at most this in a log picture, where what is well lit would become pale (tuned
/// likewise), and this in false colours.
const MAX_LOG_CONTRAST: f64 = 300.0;
const MAX_FALSE_COLOR_CONTRAST: f64 = 1e4;

/// Where on a log picture's scale the median of what is lit lies at most: a photograph has its middle there or lower. Tuned by eye
/// on a courtyard under an open sky.
const HIGHEST_MEDIAN: f64 = 0.75;

/// Share of a log picture's scale that lies below the darkest patches, so that shadows keep their
/// shape: they start at an eighth of the codes. Tuned by eye on the same scenes.
const SHADOW_ROOM: f64 = 0.125;

/// The brightest of what reflects, as sRGB code where lamps are to be told from it. Tuned likewise.
const BRIGHTEST_CODE: f32 = 0.92;

/// What is taken where there is no light at all.
const DARK: Range = Range {
    low: 0.01,
    high: 1.0,
};

/// Some light of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Share {
    /// Its luminance, in the unit of what is shown.
    pub luminance: f64,
    /// How much there is of it, such as an area.
    pub amount: f64,
    /// Whether it comes from what emits.
    pub is_emitter: bool,
}

/// What patches of these values, one per patch, show, by area.
pub fn of_patches(scene: &Scene, values: &[Rgb]) -> Vec<Share> {
    let areas = scene.patch_areas();
    let emissions = scene.patch_emissions();
    let is_inside = scene.is_inside();
    let shares = (0..values.len()).filter(|&k| !is_inside[k]).map(|k| Share {
        luminance: f64::from(luminance(values[k])),
        amount: areas[k],
        is_emitter: emissions[k].max_element() > 0.0,
    });
    shares.collect()
}

/// The range for what is shown.
pub fn suiting(shares: &[Share], mode: Mode) -> Range {
    let lit = |emitters: bool| -> Vec<(f64, f64)> {
        let lit = shares
            .iter()
            .filter(|share| share.is_emitter == emitters && share.luminance > 0.0);
        lit.map(|share| (share.luminance, share.amount)).collect()
    };
    let mut lights = lit(false);
    let has_walls = !lights.is_empty();
    if !has_walls {
        lights = lit(true);
    }
    let Some([high]) = percentiles(&mut lights, [1.0 - BRIGHTEST]) else {
        return DARK;
    };
    // What only stray light reaches, as behind and below things, is no part of the picture.
    lights.retain(|&(light, _)| light >= high / MAX_FALSE_COLOR_CONTRAST);
    let Some([low, median]) = percentiles(&mut lights, [DARKEST, 0.5]) else {
        return DARK;
    };
    let is_outshone = has_walls && shares.iter().any(|s| s.is_emitter && s.luminance > high);
    let most = match mode {
        Mode::Log => MAX_LOG_CONTRAST.min((high / median).powf(1.0 / (1.0 - HIGHEST_MEDIAN))),
        _ => MAX_FALSE_COLOR_CONTRAST,
    };
    let contrast = (high / low).clamp(MIN_CONTRAST, most.max(MIN_CONTRAST));
    let low = match mode {
        Mode::Linear | Mode::Filmic => 0.0,
        // A linear scale starts at 0, to be in proportion.
        Mode::FalseColor if contrast < LOGARITHMIC_FROM => 0.0,
        Mode::FalseColor | Mode::Ids => round(high / contrast, f64::floor),
        Mode::Log => round(high / contrast.powf(1.0 / (1.0 - SHADOW_ROOM)), f64::floor),
    };
    let room = match mode {
        Mode::Log if is_outshone => (high / low).powf(1.0 / f64::from(BRIGHTEST_CODE) - 1.0),
        Mode::Linear if is_outshone => f64::from(1.0 / decode(BRIGHTEST_CODE)),
        _ => 1.0,
    };
    Range {
        low,
        high: round(room * high, f64::ceil),
    }
}

/// The luminances below which these shares (ascending) of the area lie. `lights` are luminance and
/// area.
fn percentiles<const N: usize>(lights: &mut [(f64, f64)], shares: [f64; N]) -> Option<[f64; N]> {
    lights.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let total: f64 = lights.iter().map(|(_, area)| area).sum();
    let brightest = lights.last()?.0;
    let (mut below, mut lights) = (0.0, lights.iter());
    let mut current = brightest;
    Some(shares.map(|share| {
        while below <= share * total {
            let Some(&(light, area)) = lights.next() else {
                break;
            };
            (below, current) = (below + area, light);
        }
        current
    }))
}

/// A positive number with three significant digits, so that the range as printed gives the same
/// picture when it is asked for.
fn round(value: f64, direction: fn(f64) -> f64) -> f64 {
    let exponent = value.log10().floor() as i32 - 2;
    // Dividing by a power of ten >= 1 gives the nearest f64 to the decimal number, as parsing does.
    if exponent >= 0 {
        let unit = 10_f64.powi(exponent);
        direction(value / unit) * unit
    } else {
        let units = 10_f64.powi(-exponent);
        direction(value * units) / units
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec3, Vec3};
    use scene::{Material, MaterialId, ObjectId, Surface};

    use super::*;

    /// Patches of equal area, of which one in ten is behind things and sees next to nothing.
    #[test]
    fn hidden_patches_do_not_widen_the_range() {
        let grey = Material {
            name: "grey".into(),
            reflectance: Rgb::splat(0.5),
            emission: Rgb::ZERO,
        };
        let wall = Surface {
            corners: [Vec3::ZERO, Vec3::X, Vec3::Y],
            material: MaterialId(0),
            object: ObjectId(0),
        };
        let scene = Scene::new(
            vec![grey],
            vec!["wall".into()],
            vec![wall; 200],
            &[0; 200],
            DVec3::ZERO,
        );
        let scene = scene.unwrap();
        let lit = |k: usize| Rgb::splat(1.0 + k as f32 / 10.0);
        let of = |stray: f32| -> Vec<Rgb> {
            let value = |k: usize| if k < 20 { Rgb::splat(stray) } else { lit(k) };
            (0..200).map(value).collect()
        };
        for mode in [Mode::Log, Mode::FalseColor] {
            let dark = suiting(&of_patches(&scene, &of(0.0)), mode);
            let stray = suiting(&of_patches(&scene, &of(1e-9)), mode);
            assert_eq!((dark.low, dark.high), (stray.low, stray.high), "{mode:?}");
        }
    }

    #[test]
    fn percentiles_weigh_by_area() {
        let mut lights = vec![(3.0, 1.0), (1.0, 98.0), (2.0, 1.0)];
        assert_eq!(
            percentiles(&mut lights, [0.5, 0.985, 0.995]),
            Some([1.0, 2.0, 3.0])
        );
        assert_eq!(percentiles(&mut [], [0.5]), None);
    }

    #[test]
    fn rounded_ends_survive_printing() {
        for value in [0.001_234_5, 0.077_77, 1.0, 12.3456, 98_765.4, 1.234e7] {
            for direction in [f64::floor, f64::ceil] {
                let rounded = round(value, direction);
                assert!((rounded / value - 1.0).abs() < 0.01);
                let printed: f64 = format!("{rounded}").parse().unwrap();
                assert!(printed.to_bits() == rounded.to_bits());
                assert!(
                    format!("{rounded:e}").len() <= "9.99e-99".len(),
                    "{rounded:e}"
                );
            }
        }
    }
}
