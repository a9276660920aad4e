//! Laws of finished pictures, and golden ones.
//!
//! The golden pictures are in `tests/golden`. After a change that is meant to alter them, look at
//! the new ones and write them with `REGENERATE_GOLDEN=1 cargo test -p display --test pictures`.

mod common;

use std::path::{Path, PathBuf};

use common::{closed_cube, lit_room, solution};
use display::scale::luminance;
use display::{Mode, Quantity, Range, RenderSettings, Shown, Size, output, patch_colors, render};
use image::{DynamicImage, RgbImage};
use scene::srgb::decode;
use scene::{PatchId, Rgb};

const SIZE: Size = Size {
    width: 96,
    height: 72,
};

fn settings(mode: Mode) -> RenderSettings {
    RenderSettings {
        mode,
        size: Some(SIZE),
        ..RenderSettings::default()
    }
}

#[test]
fn patches_in_the_picture_have_the_colors_of_the_exports() {
    let (scene, solution) = lit_room();
    for mode in [Mode::Log, Mode::Linear] {
        let colors = patch_colors(&scene, Some(&solution), &settings(mode)).unwrap();
        let picture = render(&scene, Some(&solution), &settings(mode)).unwrap();
        let known: std::collections::BTreeSet<[u8; 3]> = colors.into_iter().collect();
        let image = picture.mapped.to_rgb8();
        let exact = image.pixels().filter(|p| known.contains(&p.0)).count();
        // The others lie on borders between patches.
        assert!(exact * 4 > image.pixels().len(), "{mode}: {exact} pixels");
    }
}

#[test]
fn ids_as_colors_are_the_ids() {
    let scene = closed_cube(9);
    let settings = RenderSettings {
        raw_ids: true,
        ..settings(Mode::Ids)
    };
    let colors = patch_colors(&scene, None, &settings).unwrap();
    for (patch, [r, g, b]) in colors.into_iter().enumerate() {
        assert_eq!(
            patch,
            usize::from(r) << 16 | usize::from(g) << 8 | usize::from(b)
        );
    }
}

#[test]
fn furnace_is_one_color_flat_and_smooth() {
    let scene = closed_cube(4);
    let solution = solution(&scene, |_| Rgb::splat(3.0));
    for smooth in [false, true] {
        for mode in [Mode::Log, Mode::Linear] {
            let settings = RenderSettings {
                smooth,
                ..settings(mode)
            };
            let picture = render(&scene, Some(&solution), &settings).unwrap();
            let image = picture.mapped.to_rgb8();
            let first = image.get_pixel(0, 0);
            assert!(
                first[0] > 128 && image.pixels().all(|p| p == first),
                "{mode} {smooth}"
            );
        }
    }
}

#[test]
fn irradiance_is_shown_without_reflectance_and_emission() {
    let scene = closed_cube(0);
    let solution = solution(&scene, |_| Rgb::splat(3.0));
    for (quantity, expected) in [(Quantity::Radiosity, 1.5), (Quantity::Irradiance, 3.0)] {
        let settings = RenderSettings {
            shown: Shown {
                quantity,
                ..Shown::default()
            },
            ..settings(Mode::Linear)
        };
        let picture = render(&scene, Some(&solution), &settings).unwrap();
        // The mean of 16 equal values is exact.
        assert!(picture.linear.iter().all(|&v| v == Rgb::splat(expected)));
    }
}

#[test]
fn range_that_was_chosen_gives_the_same_picture_when_asked_for() {
    let (scene, solution) = lit_room();
    for mode in [Mode::Log, Mode::Linear, Mode::FalseColor] {
        let chosen = render(&scene, Some(&solution), &settings(mode)).unwrap();
        let Range { low, high } = chosen.tone.unwrap().scale().range();
        let printed = format!("{low}:{high}");
        let (low, high) = printed.split_once(':').unwrap();
        let range = Range {
            low: low.parse().unwrap(),
            high: high.parse().unwrap(),
        };
        let settings = RenderSettings {
            range: Some(range),
            ..settings(mode)
        };
        let asked = render(&scene, Some(&solution), &settings).unwrap();
        assert!(chosen.mapped == asked.mapped, "{mode}");
    }
}

#[test]
fn light_beyond_the_range_is_white_and_below_it_black() {
    let (scene, solution) = lit_room();
    let range = Some(Range {
        low: 50.0,
        high: 60.0,
    });
    let settings = RenderSettings {
        range,
        ..settings(Mode::Log)
    };
    let picture = render(&scene, Some(&solution), &settings).unwrap();
    let colors: Vec<[u8; 3]> = picture.mapped.to_rgb8().pixels().map(|p| p.0).collect();
    assert!(colors.contains(&[255; 3]), "the lamp");
    assert!(
        colors.iter().filter(|&&c| c == [0; 3]).count() * 2 > colors.len(),
        "all else"
    );
}

#[test]
fn scene_without_any_light_is_black_in_every_mode() {
    let scene = closed_cube(2);
    for mode in [Mode::Log, Mode::Linear] {
        let picture = render(&scene, None, &settings(mode)).unwrap();
        assert!(picture.mapped.to_rgb8().pixels().all(|p| p.0 == [0; 3]));
    }
}

#[test]
fn exr_holds_the_unmapped_values() {
    let (scene, solution) = lit_room();
    let picture = render(&scene, Some(&solution), &settings(Mode::Linear)).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.exr");
    output::save_exr(&path, &picture).unwrap();
    let read = image::open(&path).unwrap().into_rgb32f();
    assert_eq!(read.dimensions(), (SIZE.width, SIZE.height));
    for (pixel, value) in read.pixels().zip(&picture.linear) {
        assert_eq!(Rgb::from_array(pixel.0), *value);
    }
    let brightest = picture
        .linear
        .iter()
        .map(|&v| luminance(v))
        .fold(0.0, f32::max);
    assert!(
        (brightest - 200.0).abs() < 1e-3,
        "the lamp emits 200 W/m^2, found {brightest}"
    );
}

#[test]
fn legend_takes_its_room_from_the_view_and_not_from_the_size() {
    let (scene, solution) = lit_room();
    for (size, has_legend) in [((320, 240), true), ((40, 30), false)] {
        let size = Size {
            width: size.0,
            height: size.1,
        };
        let settings = RenderSettings {
            size: Some(size),
            ..settings(Mode::FalseColor)
        };
        let picture = render(&scene, Some(&solution), &settings).unwrap();
        assert_eq!(
            (picture.mapped.width(), picture.mapped.height()),
            (size.width, size.height)
        );
        assert_eq!(picture.view.width < size.width, has_legend);
        assert_eq!(
            picture.linear.len() as u32,
            picture.view.width * size.height
        );
    }
}

#[test]
fn nonsense_settings_are_errors_and_not_panics() {
    let scene = closed_cube(0);
    let nan = f64::NAN;
    let bad = [
        RenderSettings {
            size: Some(Size {
                width: 0,
                height: 5,
            }),
            ..Default::default()
        },
        RenderSettings {
            size: Some(Size {
                width: 16_385,
                height: 5,
            }),
            ..Default::default()
        },
        RenderSettings {
            size: Some(Size {
                width: 16_384,
                height: 16_384,
            }),
            ..Default::default()
        },
        RenderSettings {
            fov_degrees: Some(nan),
            ..Default::default()
        },
        RenderSettings {
            fov_degrees: Some(180.0),
            ..Default::default()
        },
        RenderSettings {
            eye: Some(glam::DVec3::splat(nan)),
            ..Default::default()
        },
        RenderSettings {
            range: Some(Range {
                low: 1.0,
                high: 1.0,
            }),
            ..Default::default()
        },
        RenderSettings {
            range: Some(Range {
                low: 0.0,
                high: 1.0,
            }),
            ..Default::default()
        },
        RenderSettings {
            range: Some(Range {
                low: nan,
                high: 1.0,
            }),
            ..settings(Mode::Linear)
        },
        RenderSettings {
            smooth: true,
            ..settings(Mode::Ids)
        },
    ];
    for settings in bad {
        assert!(render(&scene, None, &settings).is_err(), "{settings:?}");
        assert!(
            patch_colors(&scene, None, &settings).is_err(),
            "{settings:?}"
        );
    }
}

#[test]
fn extreme_settings_make_pictures_all_the_same() {
    let scene = closed_cube(0);
    let extreme = [
        RenderSettings {
            fov_degrees: Some(1e-300),
            ..settings(Mode::Log)
        },
        RenderSettings {
            fov_degrees: Some(179.999_999),
            ..settings(Mode::Log)
        },
        RenderSettings {
            eye: Some(glam::DVec3::splat(1e12)),
            ..settings(Mode::Log)
        },
        RenderSettings {
            eye: Some(glam::DVec3::ZERO),
            ..settings(Mode::Log)
        },
        RenderSettings {
            eye: Some(glam::DVec3::ONE),
            ..settings(Mode::FalseColor)
        },
        RenderSettings {
            range: Some(Range {
                low: 1.0,
                high: 1.0 + f64::EPSILON,
            }),
            size: Some(Size {
                width: 320,
                height: 240,
            }),
            ..settings(Mode::FalseColor)
        },
        RenderSettings {
            range: Some(Range {
                low: 1e-300,
                high: 1e300,
            }),
            size: Some(Size {
                width: 320,
                height: 240,
            }),
            ..settings(Mode::FalseColor)
        },
        RenderSettings {
            size: Some(Size {
                width: 16_384,
                height: 1,
            }),
            ..Default::default()
        },
        RenderSettings {
            size: Some(Size {
                width: 1,
                height: 1,
            }),
            ..Default::default()
        },
        RenderSettings {
            size: Some(Size {
                width: 1,
                height: 3000,
            }),
            ..settings(Mode::FalseColor)
        },
    ];
    for settings in extreme {
        render(&scene, None, &settings).unwrap();
    }
}

/// Root mean square difference of display light that other processors may make. Powers and
/// logarithms may differ in their last bits, which moves an 8-bit code by one step at most (1/255,
/// and twice that in linear light near white); and at the borders of patches a ray may meet the
/// neighbour, one of 16 in a pixel, in one pixel of 50: sqrt(1/50) / 16 = 0.009.
const GOLDEN_TOLERANCE: f64 = 0.009 + 2.0 / 255.0;

fn golden_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/golden")
        .join(name)
}

fn difference(a: &RgbImage, b: &RgbImage) -> f64 {
    assert_eq!(a.dimensions(), b.dimensions());
    let light = |v: u8| f64::from(decode(f32::from(v) / 255.0));
    let squares = a
        .iter()
        .zip(b.iter())
        .map(|(&a, &b)| (light(a) - light(b)).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

fn compare_with_golden(name: &str, picture: &DynamicImage) {
    let path = golden_path(name);
    let picture = picture.to_rgb8();
    if std::env::var_os("REGENERATE_GOLDEN").is_some() {
        picture.save(&path).unwrap();
    }
    let golden = image::open(&path)
        .unwrap_or_else(|e| panic!("{}: {e}", path.display()))
        .to_rgb8();
    let difference = difference(&picture, &golden);
    assert!(
        difference <= GOLDEN_TOLERANCE,
        "{name}: differs by {difference}"
    );
}

#[test]
fn lit_room_looks_as_it_did() {
    let (scene, solution) = lit_room();
    let smooth = RenderSettings {
        smooth: true,
        ..settings(Mode::Log)
    };
    let picture = render(&scene, Some(&solution), &smooth).unwrap();
    compare_with_golden("lit_room_log_smooth.png", &picture.mapped);

    let size = Some(Size {
        width: 240,
        height: 160,
    });
    let false_color = RenderSettings {
        size,
        ..settings(Mode::FalseColor)
    };
    let picture = render(&scene, Some(&solution), &false_color).unwrap();
    compare_with_golden("lit_room_false_color.png", &picture.mapped);
}

#[test]
fn golden_comparison_notices_a_shift_by_one_pixel_and_a_dimmer_lamp() {
    let golden = image::open(golden_path("lit_room_log_smooth.png"))
        .unwrap()
        .to_rgb8();
    let (width, height) = golden.dimensions();
    let shifted = RgbImage::from_fn(width, height, |x, y| *golden.get_pixel((x + 1) % width, y));
    assert!(difference(&golden, &shifted) > GOLDEN_TOLERANCE);
    let dimmer = RgbImage::from_fn(width, height, |x, y| {
        image::Rgb(
            golden
                .get_pixel(x, y)
                .0
                .map(|v| (f32::from(v) * 0.95) as u8),
        )
    });
    assert!(difference(&golden, &dimmer) > GOLDEN_TOLERANCE);
}

#[test]
fn every_patch_of_the_golden_scene_is_lit() {
    let (scene, solution) = lit_room();
    let radiosity = solution.radiosity(&scene);
    for (patch, value) in radiosity.iter().enumerate() {
        assert!(value.min_element() > 0.0, "{:?}", PatchId(patch as u32));
    }
}
