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
    /// The irradiance function.
    Function(ShownFunction<'a>),
}

/// A function of which an affine image is shown: E + rho H, or H itself.
#[derive(Clone, Debug)]
pub struct ShownFunction<'a> {
    scene: &'a Scene,
    function: &'a IrradianceFunction,
    /// Whether it is the radiosity that is shown.
    is_radiosity: bool,
    /// One per patch, W/m^2, for surfaces that have no other values.
    means: &'a [Rgb],
}

impl<'a> ShownFunction<'a> {
    /// The radiosity or the irradiance by this function; `means` has that of patches, W/m^2.
    pub fn new(
        scene: &'a Scene,
        function: &'a IrradianceFunction,
        is_radiosity: bool,
        means: &'a [Rgb],
    ) -> Self {
        Self {
            scene,
            function,
            is_radiosity,
            means,
        }
    }

    #[inline]
    fn at(&self, front: &Front) -> Rgb {
        let Front {
            surface,
            barycentric,
            patch,
            ..
        } = *front;
        let values = self.function.irradiance();
        match self.function.interpolate(values, surface, barycentric) {
            // Beyond the border by a rounding it may be below 0 by as little.
            Some(irradiance) if self.is_radiosity => {
                let material = self.scene.material(self.scene.surface(surface).material);
                material.emission + material.reflectance * irradiance.max(Rgb::ZERO)
            }
            Some(irradiance) => irradiance.max(Rgb::ZERO),
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

impl<'a> Shading<'a> {
    /// Each patch in its value, W/m^2.
    pub fn flat(values: &'a [Rgb], tone: &Tone) -> Self {
        Self::Flat(
            values,
            values.par_iter().map(|&v| tone.display_light(v)).collect(),
        )
    }

    /// The value where a ray meets a surface, and its display light.
    #[inline]
    fn at(&self, front: &Front, tone: &Tone) -> [Rgb; 2] {
        let value = match self {
            Self::Flat(values, lights) => {
                let patch = front.patch.index();
                return [values[patch], lights[patch]];
            }
            Self::Smooth(values) => values.at(front.patch, front.local),
            Self::Function(function) => function.at(front),
        };
        [value, tone.display_light(value)]
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
    let mut viewer = Viewer::new(&Arc::new(Drawable::new(scene)));
    let bands = Bands::new(&mut viewer, camera, size, cull, SAMPLES);
    let samples = SAMPLES as usize;
    let share = 1.0 / (samples * samples) as f32;
    let seen = linear
        .par_chunks_mut(bands.pixels())
        .zip(display.par_chunks_mut(bands.pixels()))
        .enumerate()
        .map_init(Canvas::default, |canvas, (band, (linear, display))| {
            let seen = bands.for_each_front(canvas, band, |pixel, front| {
                let [value, light] = shading.at(&front, tone);
                linear[pixel] += value;
                display[pixel] += light;
            });
            for pixel in linear.iter_mut().chain(display.iter_mut()) {
                *pixel *= share;
            }
            seen
        })
        .reduce(Seen::default, Seen::plus);
    Light {
        seen,
        linear,
        display,
    }
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
            bands.for_each_front(canvas, band, |pixel, front| ids[pixel] = Some(front.patch))
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

    /// Draws a band, and hands out where each ray meets a surface from the front, with its pixel's index in the band.
    fn for_each_front(
        &self,
        canvas: &mut Canvas,
        band: usize,
        mut take: impl FnMut(usize, Front),
    ) -> Seen {
        let picture = canvas.draw(&self.view, &self.window(band));
        let mut seen = Seen::default();
        let height = self.rows_of(band) * self.samples;
        for j in 0..height {
            let row = (height - 1 - j) / self.samples;
            let pixels = 0..self.width * self.samples;
            picture.for_each_sample(j, pixels, |i, sample| match sample {
                Sample::Nothing => {}
                Sample::BackFace(_) => seen.backs += 1,
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
                    take(row * self.width + i / self.samples, front);
                }
            });
        }
        seen
    }
}
