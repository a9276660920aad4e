//! Pictures as files, each replacing what was there at once or not at all.

use std::io::{Cursor, Error};
use std::path::Path;

use image::codecs::openexr::OpenExrEncoder;
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{DynamicImage, ExtendedColorType, ImageEncoder};
use scene::Rgb;
use scene::file::{FileError, write_atomically};

use crate::picture::Picture;

/// Writes the mapped picture as PNG, 8 bits a channel, sRGB.
pub fn save_png(path: &Path, picture: &Picture) -> Result<(), FileError> {
    save_image(path, &picture.mapped)
}

/// Writes an image for the eye as PNG.
pub fn save_image(path: &Path, image: &DynamicImage) -> Result<(), FileError> {
    write_atomically(path, |out| {
        let encoder =
            PngEncoder::new_with_quality(out, CompressionType::Default, FilterType::Adaptive);
        image.write_with_encoder(encoder).map_err(Error::other)
    })
}

/// Writes the view's values as OpenEXR: RGB, f32, W/m^2, unmapped, without a legend.
pub fn save_exr(path: &Path, picture: &Picture) -> Result<(), FileError> {
    let bytes: Vec<u8> = picture
        .linear
        .iter()
        .flat_map(Rgb::to_array)
        .flat_map(f32::to_ne_bytes)
        .collect();
    write_atomically(path, |out| {
        // The encoder seeks, which a pipe cannot.
        let mut file = Cursor::new(Vec::new());
        let (width, height) = (picture.view.width, picture.view.height);
        OpenExrEncoder::new(&mut file)
            .write_image(&bytes, width, height, ExtendedColorType::Rgb32F)
            .map_err(Error::other)?;
        out.write_all(file.get_ref())
    })
}
