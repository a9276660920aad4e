//! The mean colour of a texture over a triangle: until textures are shown, a surface reflects the mean of its part.

use std::collections::HashMap;
use std::io::{BufRead, Cursor, Seek};
use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use image::{ImageReader, Limits};

use super::looks::Terms;
use crate::{Rgb, srgb};

/// The most pixels along a side.
const MOST_PIXELS: u32 = 1 << 15;

/// The most memory that decoding a picture may take, bytes.
const MOST_MEMORY: u64 = 1 << 31;

/// Points that a mean is taken over: as many as there are texels below, within these.
const POINTS: [f64; 2] = [16.0, 4096.0];

/// Parts of 1 that means are rounded to, so that surfaces that look alike are one material.
const STEPS: f64 = 4096.0;

/// A picture, linear.
pub(super) struct Texture {
    size: [u32; 2],
    /// Row by row from the top.
    texels: Vec<Rgb>,
}

/// Where a picture is.
#[derive(Clone, Debug)]
pub(crate) struct Picture {
    /// Its file, or what it is called where it is inside of one. Pictures of one name are one.
    pub name: PathBuf,
    /// What it is made of, where it is inside of a file.
    pub bytes: Option<Arc<[u8]>>,
}

/// What is beyond the sides of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Wrap {
    /// The same picture.
    #[default]
    Repeat,
    /// The same picture, every other time mirrored.
    Mirror,
    /// Its outermost texels.
    Clamp,
}

impl Wrap {
    /// The texel at a coordinate, of `size` texels.
    fn texel(self, at: f64, size: f64) -> u32 {
        let inside = match self {
            Self::Repeat => at.rem_euclid(size),
            Self::Mirror => {
                let twice = at.rem_euclid(2.0 * size);
                twice.min(2.0 * size - twice)
            }
            Self::Clamp => at.max(0.0),
        };
        inside.min(size - 1.0) as u32
    }
}

/// Pictures that were read, by their names.
#[derive(Default)]
pub(super) struct Textures(HashMap<PathBuf, Read>);

struct Read {
    is_file: bool,
    /// `None` where it cannot be had.
    texture: Option<Texture>,
}

impl Textures {
    /// What a picture shows. The first time that it cannot be read, a warning says so.
    pub(super) fn get(
        &mut self,
        picture: &Picture,
        terms: &Terms,
        warnings: &mut Vec<String>,
    ) -> Option<&Texture> {
        let Picture { name, bytes } = picture;
        if !self.0.contains_key(name) {
            let texture = match Texture::read(picture) {
                Ok(texture) => Some(texture),
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
            self.0.insert(name.clone(), Read { is_file, texture });
        }
        self.0.get(name)?.texture.as_ref()
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

impl Texture {
    fn read(Picture { name, bytes }: &Picture) -> Result<Self, image::ImageError> {
        if let Some(bytes) = bytes {
            return Self::decode(ImageReader::new(Cursor::new(&bytes[..])));
        }
        if !std::fs::metadata(name)?.is_file() {
            return Err(std::io::Error::other("not a regular file").into());
        }
        Self::decode(ImageReader::open(name)?)
    }

    fn decode<R: BufRead + Seek>(reader: ImageReader<R>) -> Result<Self, image::ImageError> {
        let mut reader = reader.with_guessed_format()?;
        let mut limits = Limits::default();
        limits.max_image_width = Some(MOST_PIXELS);
        limits.max_image_height = Some(MOST_PIXELS);
        limits.max_alloc = Some(MOST_MEMORY);
        reader.limits(limits);
        let picture = reader.decode()?.into_rgb8();
        let linear: Vec<f32> = (0..=u8::MAX)
            .map(|value| srgb::decode(f32::from(value) / 255.0))
            .collect();
        let texels = picture.pixels();
        let texels = texels.map(|texel| Rgb::from(texel.0.map(|value| linear[usize::from(value)])));
        Ok(Self {
            size: picture.dimensions().into(),
            texels: texels.collect(),
        })
    }

    /// The mean over the triangle between three texture coordinates, (0, 0) at the lower left of the picture; rounded, so
    /// that like surfaces are alike.
    pub(super) fn mean(&self, corners: [DVec2; 3], wrap: [Wrap; 2]) -> Rgb {
        let size = DVec2::new(self.size[0].into(), self.size[1].into());
        let [a, b, c] = corners.map(|corner| corner * size);
        let texels = 0.5 * (b - a).perp_dot(c - a).abs();
        let points = texels.clamp(POINTS[0], POINTS[1]).ceil();
        let mut sum = DVec3::ZERO;
        for k in 0..points as u32 {
            // Points of the R2 sequence (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018), folded
            // from the square to the triangle.
            let [mut u, mut v] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_3]
                .map(|step: f64| (0.5 + step * f64::from(k)).fract());
            if u + v > 1.0 {
                (u, v) = (1.0 - u, 1.0 - v);
            }
            let at = a + u * (b - a) + v * (c - a);
            let column = wrap[0].texel(at.x, size.x);
            let row = wrap[1].texel(size.y - at.y, size.y);
            sum += self.texels[(row * self.size[0] + column) as usize].as_dvec3();
        }
        ((sum / points * STEPS).round() / STEPS).as_vec3()
    }
}
