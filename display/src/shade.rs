//! The light that each pixel of a picture sees: item buffers, and the patches' values in them.
//!
//! A picture is cut into bands of rows, each with its own item buffer of [`SAMPLES`] x [`SAMPLES`]
//! rays a pixel on a regular grid. A ray that meets the front of a surface sees the value of the
//! patch there, or that of the irradiance function; the back of a surface, and nothing at all, are black. Bands are independent and a
//! pixel's samples are summed in a fixed order, so a picture does not depend on the number of
//! threads.

use std::sync::Arc;

use rayon::prelude::*;
use scene::function::IrradianceFunction;
use scene::{PatchId, Rgb, Scene, SurfaceId};
use visibility::{Canvas, Cull, Drawable, Eye, Sample, View, Viewer, Window};

use crate::camera::Camera;
use crate::quantity::Shown;
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
    /// One value per patch.
    Flat(&'a [Rgb]),
    /// Interpolated in each patch.
    Smooth(VertexValues),
    /// The irradiance function.
    Function(ShownFunction<'a>),
}

/// A function of which an affine image is shown, such as E + rho H.
#[derive(Clone, Debug)]
pub struct ShownFunction<'a> {
    /// Whose function it is.
    pub scene: &'a Scene,
    /// Its mesh.
    pub function: &'a IrradianceFunction,
    /// What is linear between vertices, one per vertex, W/m^2.
    pub values: Vec<Rgb>,
    /// What is added to that and what it is multiplied by, one per material.
    pub of_material: Vec<[Rgb; 2]>,
    /// Which channels are shown.
    pub shown: Shown,
    /// What is shown of patches, one per patch, for surfaces that have no vertices.
    pub means: &'a [Rgb],
}

impl ShownFunction<'_> {
    #[inline]
    fn at(&self, front: &Front) -> Rgb {
        let Front {
            surface,
            barycentric,
            patch,
            ..
        } = *front;
        match self
            .function
            .interpolate(&self.values, surface, barycentric)
        {
            // Beyond the border by a rounding it may be below 0 by as little.
            Some(irradiance) => {
                let [more, factor] = self.of_material[self.scene.surface(surface).material.index()];
                self.shown
                    .of_channels(more + factor * irradiance.max(Rgb::ZERO))
            }
            None => self.means[patch.index()],
        }
    }
}

/// Where a ray meets a surface from the front.
#[derive(Clone, Copy, Debug)]
struct Front {
    surface: SurfaceId,
    /// In the surface.
    barycentric: [f32; 3],
    patch: PatchId,
    /// In the patch.
    local: [f32; 3],
}

impl Shading<'_> {
    /// The value where a ray meets a surface.
    #[inline]
    fn at(&self, front: &Front) -> Rgb {
        match self {
            Self::Flat(values) => values[front.patch.index()],
            Self::Smooth(values) => values.at(front.patch, front.local),
            Self::Function(function) => function.at(front),
        }
    }

    /// The same, and its display light, which has been computed for patches of one value each.
    #[inline]
    fn light_at(&self, front: &Front, tone: &Tone, of_patches: &[Rgb]) -> [Rgb; 2] {
        let value = self.at(front);
        let light = of_patches.get(front.patch.index());
        [
            value,
            light.map_or_else(|| tone.display_light(value), |&light| light),
        ]
    }
}

/// How many rays of a picture met surfaces.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// From the front.
    pub fronts: u64,
    /// From behind; none where backs are not drawn.
    pub backs: u64,
}

impl Seen {
    fn plus(self, other: Self) -> Self {
        Self {
            fronts: self.fronts + other.fronts,
            backs: self.backs + other.backs,
        }
    }

    /// Share of the surfaces' rays that met backs, 0 to 1; `None` where no ray met a surface.
    pub fn back_share(self) -> Option<f64> {
        let all = self.fronts + self.backs;
        (all > 0).then(|| self.backs as f64 / all as f64)
    }
}

/// A picture of light, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// What the rays met.
    pub seen: Seen,
    /// Mean value of each pixel, W/m^2.
    pub linear: Vec<Rgb>,
    /// Mean display light of each pixel.
    pub display: Vec<Rgb>,
    /// Share of each pixel's rays that met a surface, 0 to 1.
    pub coverage: Vec<f32>,
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
    let mut coverage = vec![0.0; pixels];
    let of_patches: Vec<Rgb> = match shading {
        Shading::Flat(values) => values.par_iter().map(|&v| tone.display_light(v)).collect(),
        Shading::Smooth(_) | Shading::Function(_) => Vec::new(),
    };
    let mut viewer = Viewer::new(&Arc::new(Drawable::new(scene)));
    let bands = Bands::new(&mut viewer, camera, size, cull, SAMPLES);
    let samples = SAMPLES as usize;
    let share = 1.0 / (samples * samples) as f32;
    let seen = linear
        .par_chunks_mut(bands.pixels())
        .zip(display.par_chunks_mut(bands.pixels()))
        .zip(coverage.par_chunks_mut(bands.pixels()))
        .enumerate()
        .map_init(
            Canvas::default,
            |canvas, (band, ((linear, display), coverage))| {
                let seen = bands.for_each_hit(canvas, band, |pixel, front| {
                    coverage[pixel] += share;
                    if let Some(front) = front {
                        let [value, light] = shading.light_at(&front, tone, &of_patches);
                        linear[pixel] += value;
                        display[pixel] += light;
                    }
                });
                for pixel in linear.iter_mut().chain(display.iter_mut()) {
                    *pixel *= share;
                }
                seen
            },
        )
        .reduce(Seen::default, Seen::plus);
    Light {
        seen,
        linear,
        display,
        coverage,
    }
}

/// What the middle of each pixel of a picture sees, from the front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Visible {
    /// The value there.
    pub value: Rgb,
    /// Whether it emits.
    pub is_emitter: bool,
}

/// What a picture of this size shows, in the order of its pixels.
pub fn visible(
    scene: &Scene,
    camera: &Camera,
    size: Size,
    cull: Cull,
    shading: &Shading,
) -> Vec<Visible> {
    let mut viewer = Viewer::new(&Arc::new(Drawable::new(scene)));
    let bands = Bands::new(&mut viewer, camera, size, cull, 1);
    let count = (size.height as usize).div_ceil(bands.rows);
    let of_band = |canvas: &mut Canvas, band| {
        let mut seen = Vec::new();
        bands.for_each_hit(canvas, band, |_, front| {
            seen.extend(front.map(|front| {
                Visible {
                    value: shading.at(&front),
                    is_emitter: scene
                        .material(scene.surface(front.surface).material)
                        .is_emitter(),
                }
            }));
        });
        seen
    };
    (0..count)
        .into_par_iter()
        .map_init(Canvas::default, of_band)
        .flatten()
        .collect()
}

/// What the middle of a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Middle {
    /// The patch there.
    pub patch: PatchId,
    /// The value there.
    pub value: Rgb,
}

/// What the middle of each pixel sees from the front, row by row from the top; `None` where that is nothing.
pub fn middles(
    scene: &Scene,
    camera: &Camera,
    size: Size,
    cull: Cull,
    shading: &Shading,
) -> Vec<Option<Middle>> {
    let mut middles = vec![None; size.width as usize * size.height as usize];
    let mut viewer = Viewer::new(&Arc::new(Drawable::new(scene)));
    let bands = Bands::new(&mut viewer, camera, size, cull, 1);
    middles
        .par_chunks_mut(bands.pixels())
        .enumerate()
        .for_each_init(Canvas::default, |canvas, (band, middles)| {
            bands.for_each_hit(canvas, band, |pixel, front| {
                middles[pixel] = front.map(|front| Middle {
                    patch: front.patch,
                    value: shading.at(&front),
                });
            });
        });
    middles
}

/// The patch that the middle of each pixel sees, row by row from the top; `None` where there is
/// none or the back of one. And what these rays met.
pub fn ids(scene: &Scene, camera: &Camera, size: Size, cull: Cull) -> (Vec<Option<PatchId>>, Seen) {
    let mut ids = vec![None; size.width as usize * size.height as usize];
    let mut viewer = Viewer::new(&Arc::new(Drawable::new(scene)));
    let bands = Bands::new(&mut viewer, camera, size, cull, 1);
    let seen = ids
        .par_chunks_mut(bands.pixels())
        .enumerate()
        .map_init(Canvas::default, |canvas, (band, ids)| {
            bands.for_each_hit(canvas, band, |pixel, front| {
                ids[pixel] = front.map(|front| front.patch);
            })
        })
        .reduce(Seen::default, Seen::plus);
    (ids, seen)
}

/// A picture as bands of rows, from the top.
struct Bands<'a> {
    scene: &'a Scene,
    view: View<'a>,
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

impl<'a> Bands<'a> {
    fn new(viewer: &'a mut Viewer, camera: &Camera, size: Size, cull: Cull, samples: u32) -> Self {
        let window = camera.window(size, samples);
        let samples = samples as usize;
        let rows = (BAND_SAMPLES / (window.width * samples)).clamp(1, 64);
        let eye = Eye::free(&camera.frame(), cull);
        Self {
            scene: viewer.drawable().scene(),
            // Each band is drawn by itself.
            view: viewer.view(&eye, window.width * samples * rows),
            window,
            samples,
            width: size.width as usize,
            rows,
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

    /// The window of a band.
    fn window(&self, band: usize) -> Window {
        let rows = self.rows_of(band);
        // A window's rows run upwards.
        let below = (self.height - band * self.rows - rows) * self.samples;
        Window {
            bottom: self.window.bottom + below as f64 * self.window.pixel,
            height: rows * self.samples,
            ..self.window
        }
    }

    /// Draws a band, and hands out where each ray meets a surface, with its pixel's index in the band; `None` where that is its
    /// back.
    fn for_each_hit(
        &self,
        canvas: &mut Canvas,
        band: usize,
        mut take: impl FnMut(usize, Option<Front>),
    ) -> Seen {
        let picture = canvas.draw(&self.view, &self.window(band));
        let mut seen = Seen::default();
        let height = self.rows_of(band) * self.samples;
        for j in 0..height {
            let row = (height - 1 - j) / self.samples;
            let pixels = 0..self.width * self.samples;
            picture.for_each_sample(j, pixels, |i, sample| {
                let pixel = row * self.width + i / self.samples;
                match sample {
                    Sample::Nothing => {}
                    Sample::BackFace(_) => {
                        seen.backs += 1;
                        take(pixel, None);
                    }
                    Sample::Front {
                        surface,
                        barycentric,
                        ..
                    } => {
                        seen.fronts += 1;
                        let (patch, local) = self.scene.mesh().locate(surface, barycentric);
                        let front = Front {
                            surface,
                            barycentric,
                            patch,
                            local,
                        };
                        take(pixel, Some(front));
                    }
                }
            });
        }
        seen
    }
}
