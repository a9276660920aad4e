//! Pictures of textures, read once each.

use std::collections::HashMap;
use std::io::{BufRead, Cursor, Seek};
use std::path::PathBuf;
use std::sync::Arc;

use image::{DynamicImage, ImageDecoder, ImageError, ImageReader, Limits};

use super::terms::Terms;
use super::texels::Texels;

/// The most texels along a side.
const MOST_ALONG: u32 = 1 << 15;

/// The most texels of a picture, which take 4 bytes each.
const MOST_TEXELS: u64 = 1 << 28;

/// The most memory that decoding a picture may take, bytes.
const MOST_MEMORY: u64 = 1 << 31;

/// Where a picture is.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    /// Its file, or what it is called where it is inside of one. Pictures of one name are one.
    pub name: PathBuf,
    /// What it is made of, where it is inside of a file.
    pub bytes: Option<Arc<[u8]>>,
}

/// Pictures that were read, by their names.
#[derive(Default)]
pub(super) struct Textures(HashMap<PathBuf, Read>);

struct Read {
    is_file: bool,
    /// `None` where it cannot be had.
    texels: Option<Texels>,
}

impl Textures {
    /// What a picture shows. The first time that it cannot be read, a warning says so.
    pub(super) fn get(
        &mut self,
        picture: &Picture,
        terms: &Terms,
        warnings: &mut Vec<String>,
    ) -> Option<&Texels> {
        let Picture { name, bytes } = picture;
        if !self.0.contains_key(name) {
            let texels = match read(picture) {
                Ok(texels) => Some(texels),
                Err(error) => {
                    warnings.push(format!(
                        "the texture {} is left out: {error}; {}",
                        name.display(),
                        terms.without_picture
                    ));
                    None
                }
            };
            let is_file = bytes.is_none();
            self.0.insert(name.clone(), Read { is_file, texels });
        }
        self.0.get(name)?.texels.as_ref()
    }

    /// The files that were asked for, by name.
    pub(super) fn into_files(self) -> Vec<PathBuf> {
        let mut files: Vec<PathBuf> = self
            .0
            .into_iter()
            .filter_map(|(name, read)| read.is_file.then_some(name))
            .collect();
        files.sort();
        files
    }
}

fn read(Picture { name, bytes }: &Picture) -> Result<Texels, ImageError> {
    if let Some(bytes) = bytes {
        return decode(ImageReader::new(Cursor::new(&bytes[..])));
    }
    if !std::fs::metadata(name)?.is_file() {
        return Err(std::io::Error::other("not a regular file").into());
    }
    decode(ImageReader::open(name)?)
}

fn decode<R: BufRead + Seek>(reader: ImageReader<R>) -> Result<Texels, ImageError> {
    let mut reader = reader.with_guessed_format()?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MOST_ALONG);
    limits.max_image_height = Some(MOST_ALONG);
    limits.max_alloc = Some(MOST_MEMORY);
    reader.limits(limits);
    let decoder = reader.into_decoder()?;
    let (width, height) = decoder.dimensions();
    let count = u64::from(width) * u64::from(height);
    let bytes = decoder.total_bytes();
    let refused = |why: String| Err(std::io::Error::other(why).into());
    if count == 0 {
        return refused("it has no texels".to_owned());
    }
    if count > MOST_TEXELS || bytes > MOST_MEMORY {
        return refused(format!(
            "it has {width} x {height} texels in {bytes} bytes, the limits are {MOST_TEXELS} texels and {MOST_MEMORY} bytes; scale it down"
        ));
    }
    let picture = DynamicImage::from_decoder(decoder)?.into_rgb8();
    Ok(Texels::new(picture.dimensions().into(), picture.into_raw()))
}
