//! Animations, read back.

mod common;

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use common::lit_room;
use display::animation::{AnimationError, AnimationFormat, frame_path, save};
use display::camera_path::CameraPath;
use display::{RenderSettings, SettingsError, Size, render};
use image::codecs::png::PngDecoder;
use image::{AnimationDecoder, DynamicImage, ImageDecoder, Rgb, RgbImage};
use tempfile::{TempDir, tempdir};

const SIZE: (u32, u32) = (37, 21);

const WHOLE: [(AnimationFormat, &str); 2] = [
    (AnimationFormat::Apng, "walk.apng"),
    (AnimationFormat::Gif, "walk.gif"),
];

/// A frame of 37 colours, others than those of all other frames.
fn frame(number: usize) -> RgbImage {
    RgbImage::from_fn(SIZE.0, SIZE.1, |x, y| {
        Rgb([
            (3 * ((x + y) % 37)) as u8,
            (20 * number) as u8,
            255 - number as u8,
        ])
    })
}

/// Frames without a fault.
fn frames(count: usize) -> impl ExactSizeIterator<Item = Result<RgbImage, String>> {
    (0..count).map(|number| Ok(frame(number)))
}

/// The decoder's frames, without alpha.
fn without_alpha<'a>(decoder: impl AnimationDecoder<'a>) -> Vec<RgbImage> {
    let frames = decoder.into_frames().collect_frames().unwrap();
    let images = frames.into_iter().map(image::Frame::into_buffer);
    images
        .map(|image| DynamicImage::from(image).to_rgb8())
        .collect()
}

fn open(path: &Path) -> BufReader<File> {
    BufReader::new(File::open(path).unwrap())
}

/// Frames, hundredths of a second of each, and whether they go on for ever.
fn read_gif(path: &Path) -> (Vec<RgbImage>, Vec<u16>, bool) {
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::RGBA);
    let mut decoder = options.read_info(open(path)).unwrap();
    let (mut images, mut delays) = (Vec::new(), Vec::new());
    let size = [decoder.width(), decoder.height()].map(u32::from);
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        assert_eq!([frame.width, frame.height].map(u32::from), size);
        let rgb = frame
            .buffer
            .chunks_exact(4)
            .inspect(|pixel| assert_eq!(pixel[3], 255));
        let rgb = rgb.flat_map(|pixel| pixel[..3].to_vec()).collect();
        images.push(RgbImage::from_raw(size[0], size[1], rgb).unwrap());
        delays.push(frame.delay);
    }
    let is_endless = matches!(decoder.repeat(), gif::Repeat::Infinite);
    (images, delays, is_endless)
}

fn names(folder: &TempDir) -> Vec<String> {
    let entries = std::fs::read_dir(folder.path()).unwrap();
    let mut names: Vec<String> = entries
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .collect();
    names.sort();
    names
}

#[test]
fn numbered_pictures_hold_the_frames() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("walk.png");
    save(&path, AnimationFormat::Numbered, 25.0, frames(11)).unwrap();
    assert_eq!(names(&folder).len(), 11);
    for number in 0..11 {
        let picture = folder.path().join(format!("walk-{:04}.png", number + 1));
        assert_eq!(
            image::open(picture).unwrap(),
            DynamicImage::from(frame(number))
        );
    }
}

#[test]
fn numbers_have_digits_for_all_frames_and_four_at_least() {
    for (path, number, count, expected) in [
        ("a/walk.png", 1, 1, "a/walk-0001.png"),
        ("walk.tar.PNG", 9_999, 9_999, "walk.tar-9999.PNG"),
        ("walk.png", 7, 10_000, "walk-00007.png"),
        ("walk", 12, 50, "walk-0012"),
        (".png", 3, 50, ".png-0003"),
    ] {
        assert_eq!(
            frame_path(Path::new(path), number, count),
            Path::new(expected)
        );
    }
}

#[test]
fn extensions_name_the_format_in_any_case() {
    for (path, format) in [
        ("a.png", Some(AnimationFormat::Numbered)),
        ("a.b.APNG", Some(AnimationFormat::Apng)),
        ("a.Gif", Some(AnimationFormat::Gif)),
        ("a.exr", None),
        ("gif", None),
    ] {
        assert_eq!(AnimationFormat::of(Path::new(path)), format, "{path}");
    }
}

#[test]
fn animated_png_holds_the_frames_the_rate_and_srgb_and_has_no_end() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("walk.png");
    for (rate, delay) in [
        (25.0, (1, 25)),
        (30.0, (1, 30)),
        (29.97, (100, 2997)),
        (0.01, (100, 1)),
        (1000.0, (1, 1000)),
        (2.5, (2, 5)),
    ] {
        save(&path, AnimationFormat::Apng, rate, frames(9)).unwrap();
        let decoder = PngDecoder::new(open(&path)).unwrap();
        assert_eq!(decoder.dimensions(), SIZE);
        let images = without_alpha(decoder.apng().unwrap());
        assert!(images.into_iter().eq((0..9).map(frame)), "rate {rate}");
        let mut reader = png::Decoder::new(open(&path)).read_info().unwrap();
        let control = *reader.info().animation_control().unwrap();
        assert_eq!((control.num_frames, control.num_plays), (9, 0));
        assert!(reader.info().srgb.is_some());
        let mut buffer = vec![0; reader.output_buffer_size().unwrap()];
        for _ in 0..9 {
            reader.next_frame(&mut buffer).unwrap();
            let control = reader.info().frame_control().unwrap();
            assert_eq!((control.delay_num, control.delay_den), delay, "rate {rate}");
        }
    }
    assert_eq!(names(&folder), ["walk.png"]);
}

#[test]
fn apngs_delay_is_as_near_to_the_rate_as_two_bytes_can_be() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("walk.apng");
    for rate in [
        std::f64::consts::PI,
        23.976,
        999.99,
        0.0123,
        24_000.0 / 1001.0,
    ] {
        save(&path, AnimationFormat::Apng, rate, frames(1)).unwrap();
        let reader = png::Decoder::new(open(&path)).read_info().unwrap();
        let control = reader.info().frame_control().unwrap();
        let shown = f64::from(control.delay_den) / f64::from(control.delay_num);
        // Of denominators up to 65,535 one can be had within half of one.
        assert!(
            (shown / rate - 1.0).abs() < 0.5 / 65_000.0,
            "{shown} {rate}"
        );
    }
}

#[test]
fn gif_of_few_colours_holds_the_frames_exactly_and_has_no_end() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("walk.gif");
    save(&path, AnimationFormat::Gif, 30.0, frames(12)).unwrap();
    let (images, delays, is_endless) = read_gif(&path);
    assert!(images.into_iter().eq((0..12).map(frame)));
    assert!(is_endless);
    // 12 frames at 30 a second are 40 hundredths, each 3 or 4.
    assert_eq!(delays.iter().sum::<u16>(), 40);
    assert!(
        delays.iter().all(|delay| (3..=4).contains(delay)),
        "{delays:?}"
    );
}

#[test]
fn gif_of_many_colours_is_near_to_the_frames() {
    // 256 cells of a square of 256 x 256 colours have sides of 16, and a root mean square distance to their middles
    // of 16 sqrt(2 / 12) = 6.5; NeuQuant's cells are no squares: twice that.
    const LIMIT: f64 = 2.0 * 6.5;
    let folder = tempdir().unwrap();
    let path = folder.path().join("walk.gif");
    let image = RgbImage::from_fn(128, 128, |x, y| Rgb([2 * x as u8, 2 * y as u8, 90]));
    save(
        &path,
        AnimationFormat::Gif,
        10.0,
        [Ok::<_, String>(image.clone())],
    )
    .unwrap();
    let (images, _, _) = read_gif(&path);
    let squares = images[0]
        .iter()
        .zip(image.iter())
        .map(|(&a, &b)| (f64::from(a) - f64::from(b)).powi(2));
    let error = (squares.sum::<f64>() / (128.0 * 128.0)).sqrt();
    assert!(error < LIMIT, "{error}");
    assert!(error > 0.0, "the picture has more than 256 colours");
}

#[test]
fn frame_that_fails_leaves_an_animation_as_it_was() {
    for (format, name) in WHOLE {
        let folder = tempdir().unwrap();
        let path = folder.path().join(name);
        let failing = || {
            (0..5).map(|k| {
                if k == 3 {
                    Err("no such wall")
                } else {
                    Ok(frame(k))
                }
            })
        };
        let message = save(&path, format, 10.0, failing())
            .unwrap_err()
            .to_string();
        assert_eq!(message, "frame 4 of 5: no such wall");
        assert!(names(&folder).is_empty(), "{:?}", names(&folder));
        std::fs::write(&path, "before").unwrap();
        save(&path, format, 10.0, failing()).unwrap_err();
        assert_eq!(names(&folder), [name]);
        assert_eq!(std::fs::read(&path).unwrap(), b"before");
    }
}

#[test]
fn frame_that_fails_ends_numbered_pictures_before_it() {
    let folder = tempdir().unwrap();
    let path = folder.path().join("walk.png");
    let failing = (0..5).map(|k| {
        if k == 2 {
            Err("no such wall")
        } else {
            Ok(frame(k))
        }
    });
    let error = save(&path, AnimationFormat::Numbered, 10.0, failing).unwrap_err();
    assert!(matches!(
        error,
        AnimationError::Frame {
            number: 3,
            count: 5,
            ..
        }
    ));
    assert_eq!(names(&folder), ["walk-0001.png", "walk-0002.png"]);
}

/// Tells of more items than it has.
struct Boastful(usize);

impl Iterator for Boastful {
    type Item = Result<RgbImage, String>;

    fn next(&mut self) -> Option<Self::Item> {
        self.0 = self.0.checked_sub(1)?;
        Some(Ok(frame(self.0)))
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        (self.0 + 2, Some(self.0 + 2))
    }
}

impl ExactSizeIterator for Boastful {}

#[test]
fn frames_that_are_too_few_or_of_other_sizes_are_no_animation() {
    let narrow = || vec![Ok(frame(0)), Ok::<_, String>(RgbImage::new(36, 21))];
    for (format, name) in WHOLE {
        let folder = tempdir().unwrap();
        let path = folder.path().join(name);
        let message = save(&path, format, 10.0, narrow()).unwrap_err().to_string();
        assert!(
            message.contains("frame 2 has 36x21") && message.contains("37x21"),
            "{message}"
        );
        let error = save(&path, format, 10.0, [Ok::<_, String>(RgbImage::new(0, 5))]).unwrap_err();
        assert!(
            matches!(error, AnimationError::Size { number: 1, .. }),
            "{error}"
        );
        let error = save(&path, format, 10.0, frames(0)).unwrap_err();
        assert!(
            matches!(error, AnimationError::Count { count: 0 }),
            "{error}"
        );
        let error = save(&path, format, 10.0, Boastful(3)).unwrap_err();
        assert!(
            matches!(error, AnimationError::TooFew { found: 3, count: 5 }),
            "{error}"
        );
        assert!(names(&folder).is_empty());
    }
}

#[test]
fn rates_and_sides_beyond_a_format_are_refused() {
    let folder = tempdir().unwrap();
    for rate in [0.0, -1.0, 0.0099, 1001.0, f64::NAN, f64::INFINITY] {
        for (format, name) in WHOLE {
            let error = save(&folder.path().join(name), format, rate, frames(1)).unwrap_err();
            assert!(matches!(error, AnimationError::Rate { .. }), "{error}");
        }
    }
    let gif = folder.path().join("walk.gif");
    let error = save(&gif, AnimationFormat::Gif, 50.1, frames(1)).unwrap_err();
    assert!(
        error.to_string().contains("50.1 frames a second"),
        "{error}"
    );
    save(&gif, AnimationFormat::Gif, 50.0, frames(3)).unwrap();
    assert_eq!(read_gif(&gif).1, [2, 2, 2]);
    save(&gif, AnimationFormat::Gif, 0.01, frames(2)).unwrap();
    assert_eq!(read_gif(&gif).1, [10_000, 10_000]);
    let wide = [Ok::<_, String>(RgbImage::new(65_536, 1))];
    let error = save(&gif, AnimationFormat::Gif, 10.0, wide.clone()).unwrap_err();
    assert!(error.to_string().contains("65536x1"), "{error}");
    save(
        &folder.path().join("a.apng"),
        AnimationFormat::Apng,
        10.0,
        wide,
    )
    .unwrap();
}

#[test]
fn walk_through_a_room_shows_what_pictures_from_its_key_frames_show() {
    let (scene, solution) = lit_room();
    let path =
        CameraPath::parse("0 0,1.5,3 0,1.3,-3 50\n1 1,1.2,1 -1,0.5,-3\n1.5 1.5,2,-1 -1,0.5,-3 70")
            .unwrap();
    let settings = RenderSettings {
        size: Some(Size {
            width: 96,
            height: 72,
        }),
        range: Some(display::Range {
            low: 0.1,
            high: 100.0,
        }),
        ..RenderSettings::default()
    };
    let picture = |pose: display::camera_path::Pose| -> Result<RgbImage, SettingsError> {
        let settings = RenderSettings {
            eye: Some(pose.eye),
            look_at: Some(pose.look_at),
            fov_degrees: pose.fov_degrees,
            ..settings.clone()
        };
        Ok(render(&scene, Some(&solution), &settings)?.mapped.to_rgb8())
    };
    let folder = tempdir().unwrap();
    let file = folder.path().join("walk.apng");
    save(
        &file,
        AnimationFormat::Apng,
        8.0,
        path.frames(8.0).map(picture),
    )
    .unwrap();
    let images = without_alpha(PngDecoder::new(open(&file)).unwrap().apng().unwrap());
    assert_eq!(images.len(), 13);
    for (number, time) in [(0, 0.0), (8, 1.0), (12, 1.5)] {
        assert_eq!(
            images[number],
            picture(path.at(time)).unwrap(),
            "at {time} s"
        );
    }
    assert!(
        images.windows(2).all(|pair| pair[0] != pair[1]),
        "it moves all the time"
    );
}
