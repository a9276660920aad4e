//! Frames of one size as numbered PNGs, as an animated PNG or as a GIF.
//!
//! Frames are written as they come; no more than one is in memory. An animation replaces what was there when its last
//! frame is written, or not at all. Numbered pictures are files of their own: those before a frame that fails
//! stay, and so do those of an earlier, longer animation.
//!
//! | | colours | time from frame to frame, seconds |
//! |---|---|---|
//! | numbered PNG | all | not in the files |
//! | APNG (PNG specification, 3rd edition, 2025, section 11.3.2), marked as sRGB | all | n / d, of two bytes each: the pair nearest to 1 / rate |
//! | GIF89a | 256 a frame | hundredths, rounded so that frame k begins at round(100 k / rate) |
//!
//! A GIF's frame of up to 256 colours keeps them. For others NeuQuant finds 256 (Dekker 1994, "Kohonen neural
//! networks for optimal colour quantization"), in each frame anew; nothing is dithered, since what is dithered in
//! each frame by itself flickers where the camera rests.

use std::ffi::OsString;
use std::io::{Error, Write};
use std::path::{Path, PathBuf};

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, RgbImage};
use scene::file::{FileError, write_atomically};

/// Frames a second that can be written: from 100 seconds a frame, which a GIF can still tell.
const RATES: std::ops::RangeInclusive<f64> = 0.01..=1000.0;

/// Most frames a second of a GIF: players take a hundredth of a second for a mistake, and show a tenth.
const MAX_GIF_RATE: f64 = 50.0;

/// Longest side of a GIF, pixels: it has two bytes for it.
const MAX_GIF_SIDE: u32 = u16::MAX as u32;

/// Most frames: the four bytes that an APNG has for it, less a sign.
const MAX_FRAMES: usize = i32::MAX as usize;

/// About how many of a frame's pixels NeuQuant looks at. Tuned on pictures of rooms of 320 x 240 pixels: a tenth of
/// that doubles the colours' error. It takes 1.6 us for each.
const SAMPLES: usize = 100_000;

/// Fewest digits of a picture's number.
const MIN_DIGITS: usize = 4;

/// What frames become.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AnimationFormat {
    /// A PNG a frame, see [`frame_path`].
    Numbered,
    /// One animated PNG, in full colour.
    Apng,
    /// One GIF.
    Gif,
}

impl AnimationFormat {
    /// The format that an extension names, in any case: `.png`, `.apng` or `.gif`.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_string_lossy().to_lowercase();
        match extension.as_str() {
            "png" => Some(Self::Numbered),
            "apng" => Some(Self::Apng),
            "gif" => Some(Self::Gif),
            _ => None,
        }
    }
}

/// The file of frame `number`, from 1, of `count`: `walk.png` gives `walk-0001.png`, with digits for all, four at least.
pub fn frame_path(path: &Path, number: usize, count: usize) -> PathBuf {
    let digits = count.to_string().len().max(MIN_DIGITS);
    let mut name = path.file_stem().map_or_else(OsString::new, OsString::from);
    name.push(format!("-{number:0digits$}"));
    if let Some(extension) = path.extension() {
        name.push(".");
        name.push(extension);
    }
    path.with_file_name(name)
}

/// Writes frames, all of the first one's size.
///
/// How many there are has to be known before they are, so that the iterator has to tell. A frame's error may be
/// any that is one, or a text. An animation is shown again and again.
pub fn save<E>(
    path: &Path,
    format: AnimationFormat,
    frames_per_second: f64,
    frames: impl IntoIterator<Item = Result<RgbImage, E>, IntoIter: ExactSizeIterator>,
) -> Result<(), AnimationError>
where
    E: Into<Box<dyn std::error::Error + Send + Sync>>,
{
    if !RATES.contains(&frames_per_second) {
        return Err(AnimationError::Rate {
            rate: frames_per_second,
        });
    }
    if format == AnimationFormat::Gif && frames_per_second > MAX_GIF_RATE {
        return Err(AnimationError::GifRate {
            rate: frames_per_second,
        });
    }
    let frames = frames.into_iter();
    let count = frames.len();
    if count == 0 || count > MAX_FRAMES {
        return Err(AnimationError::Count { count });
    }
    let mut frames = Frames {
        source: frames.map(|frame| frame.map_err(Into::into)),
        count,
        given: 0,
        size: None,
    };
    match format {
        AnimationFormat::Numbered => {
            while let Some(frame) = frames.next()? {
                let path = frame_path(path, frames.given, count);
                write_atomically(&path, |out| write_png(out, &frame))?;
            }
            Ok(())
        }
        AnimationFormat::Apng => {
            write_whole(path, |out| write_apng(out, frames_per_second, &mut frames))
        }
        AnimationFormat::Gif => {
            write_whole(path, |out| write_gif(out, frames_per_second, &mut frames))
        }
    }
}

/// Writes a file that a frame's error leaves as it was.
fn write_whole(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> Result<(), Stop>,
) -> Result<(), AnimationError> {
    // Only errors of input and output pass through the writing of a file.
    let mut failure = None;
    let written = write_atomically(path, |out| {
        write(out).map_err(|stop| match stop {
            Stop::Write(error) => error,
            Stop::Frame(error) => {
                failure = Some(error);
                Error::other("a frame failed")
            }
        })
    });
    match failure {
        Some(error) => Err(error),
        None => Ok(written?),
    }
}

/// Why an animation is not written to its end.
enum Stop {
    Frame(AnimationError),
    Write(Error),
}

impl From<AnimationError> for Stop {
    fn from(error: AnimationError) -> Self {
        Self::Frame(error)
    }
}

impl From<png::EncodingError> for Stop {
    fn from(error: png::EncodingError) -> Self {
        Self::Write(match error {
            png::EncodingError::IoError(error) => error,
            error => Error::other(error),
        })
    }
}

impl From<gif::EncodingError> for Stop {
    fn from(error: gif::EncodingError) -> Self {
        Self::Write(match error {
            gif::EncodingError::Io(error) => error,
            error => Error::other(error),
        })
    }
}

/// Frames, checked as they come.
struct Frames<I> {
    source: I,
    /// How many there are to be.
    count: usize,
    /// How many have come.
    given: usize,
    /// Width and height of the first, pixels.
    size: Option<(u32, u32)>,
}

impl<I> Frames<I>
where
    I: Iterator<Item = Result<RgbImage, Box<dyn std::error::Error + Send + Sync>>>,
{
    /// The next frame; `None` after the last.
    fn next(&mut self) -> Result<Option<RgbImage>, AnimationError> {
        if self.given == self.count {
            return Ok(None);
        }
        let (number, count) = (self.given + 1, self.count);
        let frame = self.source.next();
        let frame = frame.ok_or(AnimationError::TooFew {
            found: self.given,
            count,
        })?;
        let frame = frame.map_err(|source| AnimationError::Frame {
            number,
            count,
            source,
        })?;
        self.given = number;
        let (width, height) = frame.dimensions();
        let expected = *self.size.get_or_insert((width, height));
        if expected != (width, height) || width == 0 || height == 0 {
            return Err(AnimationError::Size {
                number,
                found: (width, height),
                expected,
            });
        }
        Ok(Some(frame))
    }
}

fn write_png(out: &mut dyn Write, frame: &RgbImage) -> std::io::Result<()> {
    let (width, height) = frame.dimensions();
    PngEncoder::new_with_quality(out, CompressionType::Default, FilterType::Adaptive)
        .write_image(frame, width, height, ExtendedColorType::Rgb8)
        .map_err(Error::other)
}

fn write_apng<I>(out: &mut dyn Write, rate: f64, frames: &mut Frames<I>) -> Result<(), Stop>
where
    I: Iterator<Item = Result<RgbImage, Box<dyn std::error::Error + Send + Sync>>>,
{
    let Some(first) = frames.next()? else {
        return Ok(());
    };
    let (width, height) = first.dimensions();
    let mut encoder = png::Encoder::new(out, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::Adaptive);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    // Without end.
    encoder.set_animated(frames.count as u32, 0)?;
    let (numerator, denominator) = delay(rate);
    encoder.set_frame_delay(numerator, denominator)?;
    let mut writer = encoder.write_header()?;
    let mut frame = Some(first);
    while let Some(image) = frame {
        writer.write_image_data(&image)?;
        drop(image);
        frame = frames.next()?;
    }
    Ok(writer.finish()?)
}

/// Seconds from frame to frame as a fraction of 16 bits, the smallest of the nearest ones.
fn delay(rate: f64) -> (u16, u16) {
    let fractions = (1..=u16::MAX).filter_map(|numerator| {
        let exact = f64::from(numerator) * rate;
        let denominator = exact.round();
        let fits = (1.0..=f64::from(u16::MAX)).contains(&denominator);
        // What is told apart only by the rounding of the product is equally near.
        let error = ((denominator - exact).abs() / exact).max(1e-12);
        fits.then_some((numerator, denominator as u16, error))
    });
    let nearest = fractions.min_by(|a, b| a.2.total_cmp(&b.2));
    nearest.map_or((1, 1), |(numerator, denominator, _)| {
        (numerator, denominator)
    })
}

fn write_gif<I>(out: &mut dyn Write, rate: f64, frames: &mut Frames<I>) -> Result<(), Stop>
where
    I: Iterator<Item = Result<RgbImage, Box<dyn std::error::Error + Send + Sync>>>,
{
    let Some(first) = frames.next()? else {
        return Ok(());
    };
    let (Ok(width), Ok(height)) = (first.width().try_into(), first.height().try_into()) else {
        return Err(AnimationError::GifSize {
            size: first.dimensions(),
        }
        .into());
    };
    let mut encoder = gif::Encoder::new(out, width, height, &[])?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    let begin = |frame: usize| (100.0 * frame as f64 / rate).round();
    // NeuQuant looks at one pixel of so many.
    let one_of = (first.pixels().len() / SAMPLES).clamp(1, 30) as i32;
    let mut frame = Some(first);
    while let Some(image) = frame {
        let mut coded = gif::Frame::from_rgb_speed(width, height, &image, one_of);
        drop(image);
        coded.delay = (begin(frames.given) - begin(frames.given - 1)) as u16;
        encoder.write_frame(&coded)?;
        frame = frames.next()?;
    }
    Ok(encoder.into_inner().map(|_| ())?)
}

/// Frames that are not written.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum AnimationError {
    #[error("{rate} frames a second: the rate must be between {} and {}; 25 suits most", RATES.start(), RATES.end())]
    Rate { rate: f64 },
    #[error(
        "{rate} frames a second: a GIF shows {MAX_GIF_RATE} at most; give a lower rate or write an .apng"
    )]
    GifRate { rate: f64 },
    #[error("{count} frames: an animation has 1 to {MAX_FRAMES}")]
    Count { count: usize },
    #[error("frame {number} of {count}: {source}")]
    Frame {
        number: usize,
        count: usize,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    #[error("the frames end after {found} of {count}")]
    TooFew { found: usize, count: usize },
    #[error(
        "frame {number} has {}x{} pixels; all must have the first one's {}x{}, and no side 0",
        found.0, found.1, expected.0, expected.1
    )]
    Size {
        number: usize,
        found: (u32, u32),
        expected: (u32, u32),
    },
    #[error(
        "frames of {}x{} pixels: a side of a GIF has at most {MAX_GIF_SIDE}; give a smaller size or write an .apng",
        size.0, size.1
    )]
    GifSize { size: (u32, u32) },
    #[error(transparent)]
    File(#[from] FileError),
}
