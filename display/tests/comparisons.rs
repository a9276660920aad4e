//! Laws of comparing pictures: errors by hand, files as others write them, and maps of differences.

use std::path::Path;

use display::compare::Comparison;
use display::difference::DifferenceMap;
use display::input::{read_exr, read_mask};
use display::tone::to_srgb8;
use display::{Camera, Picture, Size, output};
use exr::prelude::{SpecificChannels, WritableImage, f16};
use glam::DVec3;
use image::{DynamicImage, GrayImage, ImageBuffer, Luma, RgbImage};
use proptest::prelude::*;
use scene::Rgb;

/// f64 rounding of some ten operations.
const ROUNDING: f64 = 1e-14;

const SIZE: Size = Size {
    width: 3,
    height: 2,
};

/// Six pixels that are right, and a picture: three of them differ, one of these is not in the mask.
fn example() -> ([Rgb; 6], [Rgb; 6], [bool; 6]) {
    let right = [1.0, 2.0, 4.0, 1.0, 2.0, 90.0].map(Rgb::splat);
    let mut shown = right;
    shown[1] += Rgb::splat(0.5);
    shown[3] -= Rgb::splat(1.0);
    shown[5] = Rgb::ZERO;
    (shown, right, [true, true, true, true, true, false])
}

#[test]
fn errors_are_those_that_one_finds_by_hand() {
    let (shown, right, mask) = example();
    let found = Comparison::new(SIZE, &shown, &right, &mask);
    // Squares of what is wrong are 0.25 and 1, of what is right 1, 4, 16, 1 and 4; the mean is 2, its twentieth 0.1.
    let power = (1.25_f64 / 26.0).sqrt();
    let visible = (((0.5_f64 / 2.1).powi(2) + (1.0_f64 / 1.1).powi(2)) / 5.0).sqrt();
    assert!((found.errors.power - power).abs() < ROUNDING, "{found:?}");
    assert!(
        (found.errors.visible - visible).abs() < ROUNDING,
        "{found:?}"
    );
    // Luminances of f32 differ by the rounding of their weights, which sum to 1 within one.
    let rounding = 4.0 * f64::from(f32::EPSILON);
    assert!((found.mean_difference + 0.1).abs() < rounding);
    let most = found.most.unwrap();
    assert!((most.difference + 1.0).abs() < rounding);
    assert_eq!((most.x, most.y, found.pixels), (0, 1, 5));
    assert_eq!(
        found.describe(),
        "power 21.93 %, visible 42.03 %, over 83 % of the pixels; on the mean 0.1 W/m^2 too dark, \
         most 1 W/m^2 too dark at x 0, y 1"
    );
}

#[test]
fn what_is_right_is_the_power_errors_denominator_whichever_way_round() {
    let (shown, right, mask) = example();
    let there = Comparison::new(SIZE, &shown, &right, &mask);
    let back = Comparison::new(SIZE, &right, &shown, &mask);
    // Squares of the picture: 1, 6.25, 16, 0 and 4.
    let quotient = (26.0_f64 / 27.25).sqrt();
    assert!((back.errors.power / there.errors.power - quotient).abs() < ROUNDING);
    let most = |found: &Comparison| found.most.unwrap().difference.to_bits();
    assert_eq!(most(&back), (-there.most.unwrap().difference).to_bits());
}

#[test]
fn hue_counts_as_an_error_where_luminance_is_the_same() {
    let (right, shown) = (Rgb::new(1.0, 0.0, 0.0), Rgb::new(0.0, 0.2126 / 0.7152, 0.0));
    let size = Size {
        width: 1,
        height: 1,
    };
    let found = Comparison::new(size, &[shown], &[right], &[true]);
    let power = (1.0 + f64::from(shown.y).powi(2)).sqrt();
    assert!((found.errors.power - power).abs() < ROUNDING);
    assert!(found.mean_difference.abs() < 1e-6);
}

#[test]
fn what_cannot_be_compared_is_said() {
    let (shown, right, mask) = example();
    let same = Comparison::new(SIZE, &right, &right, &mask);
    assert_eq!(
        same.describe(),
        "power 0.00 %, visible 0.00 %, over 83 % of the pixels; of one luminance in each of them"
    );
    let nothing = Comparison::new(SIZE, &shown, &right, &[false; 6]);
    assert_eq!(
        nothing.describe(),
        "no pixel counts, so that nothing is compared"
    );
    assert!(nothing.most.is_none() && nothing.mean_difference == 0.0);
    let black = Comparison::new(SIZE, &shown, &[Rgb::ZERO; 6], &mask);
    assert!(
        black
            .describe()
            .starts_with("no relative error, since what is right is black, over 83 %"),
        "{}",
        black.describe()
    );
    let both = Comparison::new(SIZE, &[Rgb::ZERO; 6], &[Rgb::ZERO; 6], &mask);
    assert!(both.errors.power == 0.0 && both.errors.visible == 0.0);

    let mut broken = right;
    broken[0].y = f32::NAN;
    broken[5].x = f32::INFINITY;
    let found = Comparison::new(SIZE, &shown, &broken, &mask);
    assert_eq!((found.pixels, found.not_finite), (4, 1));
    let lines = found.describe();
    let last = lines.lines().last().unwrap();
    assert_eq!(
        last,
        "1 pixel left out: no finite number in one of the pictures"
    );
}

proptest! {
    #[test]
    fn no_pixels_make_numbers_that_are_none(
        pixels in prop::collection::vec((prop::num::f32::ANY, prop::num::f32::ANY, any::<bool>()), 6)
    ) {
        let of = |f: fn(&(f32, f32, bool)) -> f32| -> Vec<Rgb> {
            pixels.iter().map(|p| Rgb::splat(f(p))).collect()
        };
        let (shown, right) = (of(|p| p.0), of(|p| p.1));
        let mask: Vec<bool> = pixels.iter().map(|p| p.2).collect();
        let found = Comparison::new(SIZE, &shown, &right, &mask);
        prop_assert!(!found.errors.power.is_nan() && !found.errors.visible.is_nan(), "{found:?}");
        prop_assert!(found.mean_difference.is_finite());
        prop_assert!(!found.describe().contains("NaN"));
        let map = DifferenceMap::new(SIZE, &shown, &right, &mask);
        prop_assert!(map.range.low < 0.0 && map.range.high.is_finite(), "{:?}", map.range);
        prop_assert!(map.pixels.iter().all(|p| p.min_element() >= 0.0 && p.max_element() <= 1.0));
    }
}

fn picture(size: Size, linear: Vec<Rgb>) -> Picture {
    Picture {
        camera: Camera::new(DVec3::ZERO, DVec3::X, DVec3::Z, 60.0),
        view: size,
        linear,
        mapped: DynamicImage::default(),
        tone: None,
        seen: display::shade::Seen::default(),
        visible: None,
    }
}

#[test]
fn exr_files_of_this_program_come_back_bit_by_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let (_, mut right, _) = example();
    right[2] = Rgb::new(1e-30, 3.3e7, f32::INFINITY);
    output::save_exr(&path, &picture(SIZE, right.to_vec())).unwrap();
    let read = read_exr(&path).unwrap();
    assert_eq!((read.size, read.linear), (SIZE, right.to_vec()));
    let other = Size {
        width: 4,
        height: 4,
    };
    assert_eq!(
        read_exr(&path)
            .unwrap()
            .expect_size(other)
            .unwrap_err()
            .to_string(),
        format!(
            "{}: 3x2 pixels, the picture has 4x4; give --size 3x2",
            path.display()
        )
    );
}

#[test]
fn half_floats_and_alpha_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.exr");
    let half = f16::from_f32;
    let channels = SpecificChannels::rgba(|at: exr::math::Vec2<usize>| {
        (
            half(0.5 + at.x() as f32),
            half(at.y() as f32),
            3.0_f32,
            half(0.25),
        )
    });
    exr::image::Image::from_channels((3, 2), channels)
        .write()
        .to_file(&path)
        .unwrap();
    let read = read_exr(&path).unwrap();
    assert_eq!(read.size, SIZE);
    assert_eq!(read.linear[5], Rgb::new(2.5, 1.0, 3.0));
}

fn save_mask(path: &Path, image: impl Into<DynamicImage>) {
    image.into().save(path).unwrap();
}

#[test]
fn masks_of_any_kind_count_what_is_white() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("mask.png");
    let codes = [0, 255, 127, 128, 255, 0];
    let counts = [false, true, false, true, true, false];
    let grey = GrayImage::from_raw(3, 2, codes.to_vec()).unwrap();
    save_mask(&path, grey.clone());
    assert_eq!(read_mask(&path, SIZE).unwrap(), counts);
    let wide = codes.iter().map(|&code| u16::from(code) * 257).collect();
    let wide: ImageBuffer<Luma<u16>, Vec<u16>> = ImageBuffer::from_raw(3, 2, wide).unwrap();
    save_mask(&path, wide);
    assert_eq!(read_mask(&path, SIZE).unwrap(), counts);
    let rgb: RgbImage = DynamicImage::from(grey).into_rgb8();
    save_mask(&path, rgb);
    assert_eq!(read_mask(&path, SIZE).unwrap(), counts);
    let other = Size {
        width: 2,
        height: 3,
    };
    assert_eq!(
        read_mask(&path, other).unwrap_err().to_string(),
        format!(
            "{}: 3x2 pixels, the picture has 2x3; give a mask of that size",
            path.display()
        )
    );
}

#[test]
fn files_that_are_no_pictures_are_errors_that_name_them() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let name = path.display().to_string();
    assert!(read_exr(&path).unwrap_err().to_string().starts_with(&name));
    let (_, right, _) = example();
    output::save_exr(&path, &picture(SIZE, right.to_vec())).unwrap();
    let whole = std::fs::read(&path).unwrap();
    // Cut short anywhere, and with any byte of the header turned round, it is an error or a picture, never a panic.
    for length in 0..whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        let error = read_exr(&path).unwrap_err().to_string();
        assert!(error.starts_with(&name), "{error}");
    }
    for k in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[k] ^= 0xff;
        std::fs::write(&path, &bytes).unwrap();
        read_exr(&path).ok();
    }
    std::fs::write(&path, b"text").unwrap();
    let error = read_exr(&path).unwrap_err().to_string();
    assert!(
        error.contains("no OpenEXR picture with channels R, G and B"),
        "{error}"
    );
    let error = read_mask(&path, SIZE).unwrap_err().to_string();
    assert!(
        error.starts_with(&name) && error.contains("no PNG"),
        "{error}"
    );
}

#[test]
fn map_is_white_where_nothing_differs_red_where_it_is_too_bright_blue_where_too_dark() {
    let (mut shown, right, mask) = example();
    shown[2] += Rgb::splat(1.0);
    let map = DifferenceMap::new(SIZE, &shown, &right, &mask);
    assert!((map.range.low + 1.0).abs() < ROUNDING && (map.range.high - 1.0).abs() < ROUNDING);
    let codes: Vec<[u8; 3]> = map.pixels.iter().map(|&p| to_srgb8(p)).collect();
    let [r, g, b] = codes[0];
    assert!(r.min(g).min(b) > 230, "{codes:?}");
    assert!(codes[2][0] > 2 * codes[2][2], "{codes:?}");
    assert!(codes[3][2] > 2 * codes[3][0], "{codes:?}");
    assert!(
        codes[1][0] > codes[1][2] && codes[1][0] > codes[2][0],
        "{codes:?}"
    );
    let [r, g, b] = codes[5];
    assert!(r == g && g == b && r < 80, "{codes:?}");
    // Too small for a legend.
    assert_eq!(map.image().width(), 3);
}

#[test]
fn map_keeps_its_size_beside_a_legend_that_has_both_ends() {
    let size = Size {
        width: 240,
        height: 200,
    };
    let right = vec![Rgb::ONE; 240 * 200];
    let shown: Vec<Rgb> = (0..240 * 200)
        .map(|k| Rgb::splat(1.0 + ((k % 240) as f32 - 119.5) / 1000.0))
        .collect();
    let map = DifferenceMap::new(size, &shown, &right, &vec![true; 240 * 200]);
    assert!(
        map.clipped
            == display::legend::Clipped {
                below: false,
                above: false
            }
    );
    let image = map.image().into_rgb8();
    assert!(image.width() > 240 && image.height() == 200);
    for (k, &light) in map.pixels.iter().enumerate() {
        let (x, y) = (k as u32 % 240, k as u32 / 240);
        assert_eq!(image.get_pixel(x, y).0, to_srgb8(light));
    }
    let legend: Vec<[u8; 3]> = image
        .enumerate_pixels()
        .filter_map(|(x, _, pixel)| (x >= 240).then_some(pixel.0))
        .collect();
    // A row of the legend is 1/120 of the scale.
    for k in [0, 120, 239] {
        let color = to_srgb8(map.pixels[k]);
        let near = |c: &[u8; 3]| c.iter().zip(color).all(|(a, b)| a.abs_diff(b) < 12);
        assert!(legend.iter().any(near), "{color:?}");
    }
}
