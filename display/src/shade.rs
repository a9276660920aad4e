//! The light that each pixel of a picture sees: item buffers, and the patches' values in them.
//!
//! A picture is cut into bands of rows, each with its own item buffer of [`SAMPLES`] x [`SAMPLES`]
//! rays a pixel on a regular grid. A ray that meets the front of a surface sees the value of the
//! patch there; the back of a surface, and nothing at all, are black. Bands are independent and a
//! pixel's samples are summed in a fixed order, so a picture does not depend on the number of
//! threads.

use compute::cpu::{Cull, Projection, Raster, Sample, plane_tolerance};
use compute::hemicube::Window;
use rayon::prelude::*;
use scene::{PatchId, Rgb, Scene};

use crate::camera::Camera;
use crate::settings::Size;
use crate::smooth::VertexValues;
use crate::tone::Tone;

/// Rays a pixel along each direction. 4 x 4 leave steps of a sixteenth at edges, which a screen of
/// 8 bits hardly shows.
pub const SAMPLES: u32 = 4;

/// Samples in a band: few enough that its buffers (8 bytes a sample) stay in a core's cache.
const BAND_SAMPLES: usize = 1 << 17;

/// What the surfaces look like.
#[derive(Clone, Debug)]
pub enum Shading<'a> {
    /// One value per patch, W/m^2, and the same as display light.
    Flat(&'a [Rgb], Vec<Rgb>),
    /// Interpolated in each patch.
    Smooth(VertexValues),
}

impl<'a> Shading<'a> {
    /// Each patch in its value, W/m^2.
    pub fn flat(values: &'a [Rgb], tone: &Tone) -> Self {
        Self::Flat(
            values,
            values.par_iter().map(|&v| tone.display_light(v)).collect(),
        )
    }

    /// The value at a point of a patch, and its display light.
    #[inline]
    fn at(&self, patch: PatchId, local: [f32; 3], tone: &Tone) -> [Rgb; 2] {
        match self {
            Self::Flat(values, lights) => [values[patch.index()], lights[patch.index()]],
            Self::Smooth(values) => {
                let value = values.at(patch, local);
                [value, tone.display_light(value)]
            }
        }
    }
}

/// A picture of light, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Mean value of each pixel, W/m^2.
    pub linear: Vec<Rgb>,
    /// Mean display light of each pixel.
    pub display: Vec<Rgb>,
}

/// Takes a picture of light.
pub fn light(
    scene: &Scene,
    camera: &Camera,
    size: Size,
    cull: Cull,
    shading: &Shading,
    tone: &Tone,
) -> Light {
    let pixels = size.width as usize * size.height as usize;
    let mut linear = vec![Rgb::ZERO; pixels];
    let mut display = vec![Rgb::ZERO; pixels];
    let projection = project(scene, camera, cull);
    let bands = Bands::new(camera, size, SAMPLES);
    let samples = SAMPLES as usize;
    let share = 1.0 / (samples * samples) as f32;
    linear
        .par_chunks_mut(bands.pixels())
        .zip(display.par_chunks_mut(bands.pixels()))
        .enumerate()
        .for_each_init(Raster::default, |raster, (band, (linear, display))| {
            bands.draw(raster, &projection, band);
            bands.for_each_sample(raster, &projection, band, |pixel, sample| {
                if let Sample::Front {
                    surface,
                    barycentric,
                    ..
                } = sample
                {
                    let (patch, local) = scene.mesh().locate(surface, barycentric);
                    let [value, light] = shading.at(patch, local, tone);
                    linear[pixel] += value;
                    display[pixel] += light;
                }
            });
            for pixel in linear.iter_mut().chain(display.iter_mut()) {
                *pixel *= share;
            }
        });
    Light { linear, display }
}

/// The patch that the middle of each pixel sees, row by row from the top; `None` where there is
/// none or the back of one.
pub fn ids(scene: &Scene, camera: &Camera, size: Size, cull: Cull) -> Vec<Option<PatchId>> {
    let mut ids = vec![None; size.width as usize * size.height as usize];
    let projection = project(scene, camera, cull);
    let bands = Bands::new(camera, size, 1);
    ids.par_chunks_mut(bands.pixels())
        .enumerate()
        .for_each_init(Raster::default, |raster, (band, ids)| {
            bands.draw(raster, &projection, band);
            bands.for_each_sample(raster, &projection, band, |pixel, sample| {
                if let Sample::Front {
                    surface,
                    barycentric,
                    ..
                } = sample
                {
                    ids[pixel] = Some(scene.mesh().locate(surface, barycentric).0);
                }
            });
        });
    ids
}

fn project(scene: &Scene, camera: &Camera, cull: Cull) -> Projection {
    let mut projection = Projection::default();
    projection.set(
        scene,
        &camera.frame(),
        None,
        false,
        cull,
        plane_tolerance(scene),
    );
    projection
}

/// A picture as bands of rows, from the top.
struct Bands {
    window: Window,
    /// Rays a pixel along each direction.
    samples: usize,
    /// Pixels in a row.
    width: usize,
    /// Rows of pixels in a band; the last one may have fewer.
    rows: usize,
    /// Rows of pixels in all.
    height: usize,
}

impl Bands {
    fn new(camera: &Camera, size: Size, samples: u32) -> Self {
        let window = camera.window(size, samples);
        let samples = samples as usize;
        Self {
            window,
            samples,
            width: size.width as usize,
            rows: (BAND_SAMPLES / (window.width * samples)).clamp(1, 64),
            height: size.height as usize,
        }
    }

    /// Pixels in a whole band.
    fn pixels(&self) -> usize {
        self.width * self.rows
    }

    fn rows_of(&self, band: usize) -> usize {
        self.rows.min(self.height - band * self.rows)
    }

    fn draw(&self, raster: &mut Raster, projection: &Projection, band: usize) {
        let rows = self.rows_of(band);
        // A window's rows run upwards.
        let below = (self.height - band * self.rows - rows) * self.samples;
        let window = Window {
            bottom: self.window.bottom + below as f64 * self.window.pixel,
            height: rows * self.samples,
            ..self.window
        };
        raster.draw(projection, &window);
    }

    /// Hands out what each ray sees, with its pixel's index in the band.
    fn for_each_sample(
        &self,
        raster: &Raster,
        projection: &Projection,
        band: usize,
        mut take: impl FnMut(usize, Sample),
    ) {
        let height = self.rows_of(band) * self.samples;
        for j in 0..height {
            let row = (height - 1 - j) / self.samples;
            for i in 0..self.width * self.samples {
                take(
                    row * self.width + i / self.samples,
                    raster.sample(projection, i, j),
                );
            }
        }
    }
}
