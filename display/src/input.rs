//! Pictures of light and masks, read from files.
//!
//! Light is OpenEXR with channels R, G and B, f16 or f32, linear, W/m^2; an alpha channel is left out. A mask is a PNG of
//! 8 or 16 bits: what is white counts, what is black does not, and between them half of the codes each.

use std::fs::File;
use std::io::{self, BufReader};
use std::path::{Path, PathBuf};

use image::codecs::openexr::OpenExrDecoder;
use image::codecs::png::PngDecoder;
use image::{DynamicImage, ImageDecoder, ImageError, ImageResult};
use scene::Rgb;

use crate::settings::{MAX_PIXELS, MAX_SIDE, Size};

/// A code of 16 bits from which on a pixel of a mask counts.
const WHITE: u16 = 0x8000;

/// A picture of light.
#[derive(Clone, Debug, PartialEq)]
pub struct LightFile {
    /// Where it was read from.
    pub path: PathBuf,
    /// Its size.
    pub size: Size,
    /// W/m^2, row by row from the top, one value per pixel. Some may be no finite numbers.
    pub linear: Vec<Rgb>,
}

/// Why a picture could not be used.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum InputError {
    #[error("{}: {cause}", path.display())]
    Open { path: PathBuf, cause: io::Error },
    #[error("{}: no {format}: {cause}", path.display())]
    Decode {
        path: PathBuf,
        format: &'static str,
        cause: ImageError,
    },
    #[error(
        "{}: {size} pixels; each side must be 1 to {MAX_SIDE}, and the limit is {MAX_PIXELS} in all",
        path.display()
    )]
    TooLarge { path: PathBuf, size: Size },
    #[error("{}: {found} pixels, the picture has {picture}; give --size {found}", path.display())]
    Size {
        path: PathBuf,
        found: Size,
        picture: Size,
    },
    #[error("{}: {found} pixels, the picture has {picture}; give a mask of that size", path.display())]
    MaskSize {
        path: PathBuf,
        found: Size,
        picture: Size,
    },
}

impl LightFile {
    /// Checks that it has as many pixels as a picture that it is compared with.
    ///
    /// # Errors
    /// If it has others.
    pub fn expect_size(&self, picture: Size) -> Result<(), InputError> {
        if self.size == picture {
            return Ok(());
        }
        Err(InputError::Size {
            path: self.path.clone(),
            found: self.size,
            picture,
        })
    }
}

/// Reads an OpenEXR file.
///
/// # Errors
/// A file that cannot be read, is no OpenEXR file with channels R, G and B, or is larger than a picture may be.
pub fn read_exr(path: &Path) -> Result<LightFile, InputError> {
    let (size, image) = read(
        path,
        "OpenEXR picture with channels R, G and B",
        OpenExrDecoder::new,
        |_| Ok(()),
    )?;
    let pixels = image.into_rgb32f();
    Ok(LightFile {
        path: path.to_owned(),
        size,
        linear: pixels.pixels().map(|p| Rgb::from_array(p.0)).collect(),
    })
}

/// Reads a mask for a picture: whether each pixel counts, row by row from the top.
///
/// # Errors
/// A file that cannot be read, is no PNG, or has another size than the picture.
pub fn read_mask(path: &Path, picture: Size) -> Result<Vec<bool>, InputError> {
    let expect_size = |found| {
        if found == picture {
            return Ok(());
        }
        Err(InputError::MaskSize {
            path: path.to_owned(),
            found,
            picture,
        })
    };
    let (_, image) = read(path, "PNG", PngDecoder::new, expect_size)?;
    let codes = image.into_luma16();
    Ok(codes.pixels().map(|p| p.0[0] >= WHITE).collect())
}

/// Reads a picture once its size is known to be good.
fn read<D: ImageDecoder>(
    path: &Path,
    format: &'static str,
    open: fn(BufReader<File>) -> ImageResult<D>,
    expect_size: impl Fn(Size) -> Result<(), InputError>,
) -> Result<(Size, DynamicImage), InputError> {
    let file = File::open(path).map_err(|cause| InputError::Open {
        path: path.to_owned(),
        cause,
    })?;
    let decode_error = |cause| InputError::Decode {
        path: path.to_owned(),
        format,
        cause,
    };
    let decoder = open(BufReader::new(file)).map_err(decode_error)?;
    let (width, height) = decoder.dimensions();
    let size = Size { width, height };
    let sides = 1..=MAX_SIDE;
    if !sides.contains(&width)
        || !sides.contains(&height)
        || u64::from(width) * u64::from(height) > MAX_PIXELS
    {
        return Err(InputError::TooLarge {
            path: path.to_owned(),
            size,
        });
    }
    expect_size(size)?;
    let image = DynamicImage::from_decoder(decoder).map_err(decode_error)?;
    Ok((size, image))
}
