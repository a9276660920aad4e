//! The mean colour of a texture over a triangle: until textures are shown, a surface reflects the mean of its part.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use image::{ImageReader, Limits};

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

/// Pictures that were read, by their files; `None` for those that cannot be.
#[derive(Default)]
pub(super) struct Textures(HashMap<PathBuf, Option<Texture>>);

impl Textures {
    /// The picture of a file. The first time that it cannot be read, a warning says so.
    pub(super) fn get(&mut self, path: &Path, warnings: &mut Vec<String>) -> Option<&Texture> {
        let read = || match Texture::read(path) {
            Ok(texture) => Some(texture),
            Err(error) => {
                warnings.push(format!(
                    "the texture {} is left out: {error}; Kd alone counts, or grey where that is 0",
                    path.display()
                ));
                None
            }
        };
        let texture = self.0.entry(path.to_owned()).or_insert_with(read);
        texture.as_ref()
    }

    /// The files that were asked for.
    pub(super) fn into_files(self) -> impl Iterator<Item = PathBuf> {
        self.0.into_keys()
    }
}

impl Texture {
    fn read(path: &Path) -> Result<Self, image::ImageError> {
        if !std::fs::metadata(path)?.is_file() {
            return Err(std::io::Error::other("not a regular file").into());
        }
        let mut reader = ImageReader::open(path)?.with_guessed_format()?;
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

    /// The mean over the triangle between three texture coordinates, (0, 0) at the lower left of the picture, which
    /// repeats; rounded, so that like surfaces are alike.
    pub(super) fn mean(&self, corners: [DVec2; 3]) -> Rgb {
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
            let column = at.x.rem_euclid(size.x) as u32;
            let row = (size.y - at.y).rem_euclid(size.y) as u32;
            let [column, row] = [column.min(self.size[0] - 1), row.min(self.size[1] - 1)];
            sum += self.texels[(row * self.size[0] + column) as usize].as_dvec3();
        }
        ((sum / points * STEPS).round() / STEPS).as_vec3()
    }
}
