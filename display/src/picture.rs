//! A whole picture of a scene, and the colours of its patches.

use glam::{DVec3, Vec3};
use image::{DynamicImage, RgbImage, RgbaImage};
use rayon::prelude::*;
use scene::{PatchId, Rgb, Scene, Solution};
use visibility::Cull;

use crate::camera::Camera;
use crate::contours;
use crate::dark;
use crate::default_camera::{self, Framing, Wishes};
use crate::distinct::distinct_color;
use crate::legend::{self, Clipped, Layout};
use crate::luminance::luminance;
use crate::range;
use crate::settings::{Mode, Range, RenderSettings, SettingsError, Size};
use crate::shade::{self, Light, Seen, Shading, Visible};
use crate::smooth::VertexValues;
use crate::text::Canvas;
use crate::tone::{Tone, to_srgb8};
use crate::up;

/// Rows of a picture, where none are asked for.
const DEFAULT_HEIGHT: u32 = 768;

/// The longer side of the picture that tells what there is to be seen, pixels.
const VISIBLE_SIDE: u32 = 192;

/// A picture.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Where it was taken from.
    pub camera: Camera,
    /// Size of what the camera saw: all of the picture but the legend at its right.
    pub view: Size,
    /// The view's values, W/m^2, row by row from the top; 0 where no front of a surface is seen.
    /// Empty in [`Mode::Ids`].
    pub linear: Vec<Rgb>,
    /// The picture for the eye, sRGB. In [`Mode::Ids`] it has an alpha channel, which is 0 where
    /// there is no patch.
    pub mapped: DynamicImage,
    /// How values were mapped; `None` in [`Mode::Ids`].
    pub tone: Option<Tone>,
    /// Fronts and backs of surfaces in the view.
    pub seen: Seen,
    /// What fronts show, as far as a small picture tells; `None` where there are none, and in [`Mode::Ids`].
    pub visible: Option<Extent>,
}

/// Takes a picture.
///
/// Without a solution nothing is irradiated: the radiosity is the emission.
pub fn render(
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<Picture, SettingsError> {
    settings.validate()?;
    let cull = if settings.cull_back_faces {
        Cull::BackFaces
    } else {
        Cull::Nothing
    };
    let legend = settings
        .size
        .filter(|_| settings.mode == Mode::FalseColor)
        .and_then(Layout::inside);
    let asked_view = settings.size.map(|size| Size {
        width: size.width - legend.map_or(0, |layout| layout.width),
        ..size
    });
    let (mut camera, aspect) = place_camera(scene, settings, asked_view, cull)?;
    let view = asked_view.unwrap_or(Size {
        width: (f64::from(DEFAULT_HEIGHT) * aspect).round() as u32,
        height: DEFAULT_HEIGHT,
    });
    let size = settings.size.unwrap_or_else(|| {
        if settings.mode == Mode::FalseColor {
            Layout::around(view)
        } else {
            view
        }
    });

    if settings.mode == Mode::Ids {
        let (ids, seen) = shade::ids(scene, &camera, view, cull);
        let mapped = ids_image(view, &ids, settings.raw_ids);
        return Ok(Picture {
            camera,
            view,
            linear: Vec::new(),
            mapped,
            tone: None,
            seen,
            visible: None,
        });
    }
    let values = settings.shown.of_patches(scene, solution)?;
    let function = settings.shown.function(scene, solution, &values);
    let shading = match function.filter(|_| !settings.flat) {
        Some(function) => Shading::Function(function),
        None if settings.smooth => Shading::Smooth(VertexValues::new(scene, &values)),
        None => Shading::Flat(&values),
    };
    let small = small(view);
    let mut visible = shade::visible(scene, &camera, small, cull, &shading);
    let is_dark = visible.iter().all(|seen| seen.value == Rgb::ZERO);
    // Where nobody has placed the camera, it may as well show what is lit.
    if is_dark
        && settings.eye.is_none()
        && let Some(framing) = dark::before_light(
            scene,
            &values,
            &wishes(scene, settings, asked_view, cull),
            aspect,
        )
    {
        camera = framing.camera;
        visible = shade::visible(scene, &camera, small, cull, &shading);
    }
    let range = range_for(scene, &values, &visible, settings);
    let tone = Tone::new(settings.mode, range);
    let light = shade::light(scene, &camera, view, cull, &shading, &tone);
    let Light {
        seen,
        linear,
        mut display,
        coverage,
    } = light;
    if !settings.contours.is_empty() {
        let middles = shade::middles(scene, &camera, view, cull, &shading);
        contours::draw(&mut display, scene, view, &middles, &settings.contours);
    }
    let mut pixels = widened(display, view, size);
    if settings.mode == Mode::FalseColor
        && let Some(layout) = Layout::inside(size)
    {
        let mut canvas = Canvas {
            pixels: &mut pixels,
            size,
        };
        let clipped = Clipped::of(linear.iter().copied(), tone.scale().range());
        legend::draw(&mut canvas, layout, &tone, settings.shown, clipped);
    }
    let mapped = if settings.transparent {
        rgba_image(size, &pixels, view, &coverage)
    } else {
        rgb_image(size, &pixels)
    };
    Ok(Picture {
        camera,
        view,
        linear,
        mapped,
        tone: Some(tone),
        seen,
        visible: Extent::of(&visible),
    })
}

/// The size of a picture that tells what there is to be seen.
fn small(view: Size) -> Size {
    let side = |pixels: u32| {
        let most = view.width.max(view.height).div_ceil(VISIBLE_SIDE).max(1);
        pixels.div_ceil(most)
    };
    Size {
        width: side(view.width),
        height: side(view.height),
    }
}

/// The range that is asked for, or suits what is seen or all patches.
fn range_for(
    scene: &Scene,
    values: &[Rgb],
    visible: &[Visible],
    settings: &RenderSettings,
) -> Range {
    settings.range.unwrap_or_else(|| {
        let shares = match settings.mode {
            Mode::FalseColor => range_shares(visible),
            _ => range::of_patches(scene, values),
        };
        range::suiting(&shares, settings.mode)
    })
}

/// What is seen, each pixel as much as any.
fn range_shares(visible: &[Visible]) -> Vec<range::Share> {
    let share = |seen: &Visible| range::Share {
        luminance: f64::from(luminance(seen.value)),
        amount: 1.0,
        is_emitter: seen.is_emitter,
    };
    visible.iter().map(share).collect()
}

/// The luminances that a picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// The smallest one, in the unit of what is shown.
    pub least: f64,
    /// The largest one.
    pub most: f64,
}

impl Extent {
    fn of(visible: &[Visible]) -> Option<Self> {
        let lights = visible.iter().map(|seen| f64::from(luminance(seen.value)));
        lights.fold(None, |extent, light| {
            let Self { least, most } = extent.unwrap_or(Self {
                least: light,
                most: light,
            });
            Some(Self {
                least: least.min(light),
                most: most.max(light),
            })
        })
    }
}

/// The colours of all patches in the mapping of a picture with these settings, sRGB, one per
/// patch; the patches' IDs in [`Mode::Ids`].
pub fn patch_colors(
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<Vec<[u8; 3]>, SettingsError> {
    settings.validate()?;
    if settings.mode == Mode::Ids {
        let color = |patch| color_of_id(PatchId(patch), settings.raw_ids);
        return Ok((0..scene.patch_count()).map(color).collect());
    }
    let values = settings.shown.of_patches(scene, solution)?;
    let range = settings
        .range
        .unwrap_or_else(|| range::suiting(&range::of_patches(scene, &values), settings.mode));
    let tone = Tone::new(settings.mode, range);
    let color = |&value: &Rgb| to_srgb8(tone.display_light(value));
    Ok(values.par_iter().map(color).collect())
}

/// The range that a picture of a file has, where all of its patches decide it: that of a series of pictures.
///
/// # Errors
/// Where the solution does not have what is shown.
pub fn range_of(
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<Range, SettingsError> {
    let values = settings.shown.of_patches(scene, solution)?;
    Ok(range::suiting(
        &range::of_patches(scene, &values),
        settings.mode,
    ))
}

/// A patch's ID as a colour, told from others or as it is.
fn color_of_id(patch: PatchId, is_raw: bool) -> [u8; 3] {
    if is_raw {
        id_color(patch)
    } else {
        to_srgb8(distinct_color(patch))
    }
}

/// A patch's ID as a colour: R = ID >> 16, G = ID >> 8, B = ID.
pub fn id_color(patch: PatchId) -> [u8; 3] {
    let [_, r, g, b] = patch.0.to_be_bytes();
    [r, g, b]
}

/// What the settings leave to a camera's choice.
fn wishes(scene: &Scene, settings: &RenderSettings, view: Option<Size>, cull: Cull) -> Wishes {
    Wishes {
        up: settings.up.unwrap_or_else(|| up::guess(scene)).direction(),
        fov_degrees: settings.fov_degrees,
        aspect: view.map(|size| f64::from(size.width) / f64::from(size.height)),
        cull,
    }
}

/// The camera, and width over height of its view.
fn place_camera(
    scene: &Scene,
    settings: &RenderSettings,
    view: Option<Size>,
    cull: Cull,
) -> Result<(Camera, f64), SettingsError> {
    let up = settings.up.unwrap_or_else(|| up::guess(scene)).direction();
    let aspect = view.map(|size| f64::from(size.width) / f64::from(size.height));
    let in_scene = |point: DVec3| scene.to_scene(point);
    if let Some(eye) = settings.eye {
        let [low, high] = scene.bounds().map(Vec3::as_dvec3);
        let target = settings.look_at.map_or(0.5 * (low + high), in_scene);
        let fov = settings.fov_degrees.unwrap_or(default_camera::INSIDE_FOV);
        let camera = Camera::new(in_scene(eye), target - in_scene(eye), up, fov);
        return Ok((camera, aspect.unwrap_or(default_camera::ASPECT)));
    }
    let wishes = wishes(scene, settings, view, cull);
    let Framing { mut camera, aspect } = default_camera::choose(scene, &wishes);
    if let Some(look_at) = settings.look_at {
        let forward = in_scene(look_at) - camera.eye;
        if forward == DVec3::ZERO {
            return Err(SettingsError::NoDirection { eye: look_at });
        }
        camera = Camera::new(camera.eye, forward, up, camera.fov_degrees);
    }
    Ok((camera, aspect))
}

/// Rows with room for the legend.
fn widened(pixels: Vec<Rgb>, view: Size, size: Size) -> Vec<Rgb> {
    if view == size {
        return pixels;
    }
    let mut wide = vec![Rgb::ZERO; size.width as usize * size.height as usize];
    let rows = wide.chunks_exact_mut(size.width as usize);
    for (wide, narrow) in rows.zip(pixels.chunks_exact(view.width as usize)) {
        wide[..narrow.len()].copy_from_slice(narrow);
    }
    wide
}

fn rgb_image(size: Size, pixels: &[Rgb]) -> DynamicImage {
    let bytes: Vec<u8> = pixels
        .par_iter()
        .flat_map_iter(|&light| to_srgb8(light))
        .collect();
    RgbImage::from_raw(size.width, size.height, bytes)
        .unwrap_or_default()
        .into()
}

/// The same with the view's coverage as alpha; what lies beside it covers all.
fn rgba_image(size: Size, pixels: &[Rgb], view: Size, coverage: &[f32]) -> DynamicImage {
    let (width, view_width) = (size.width as usize, view.width as usize);
    let bytes: Vec<u8> = pixels
        .par_iter()
        .enumerate()
        .flat_map_iter(|(k, &light)| {
            let (x, y) = (k % width, k / width);
            let alpha = if x < view_width {
                coverage[y * view_width + x]
            } else {
                1.0
            };
            // Rays that met nothing are black in the mean.
            let light = if alpha > 0.0 { light / alpha } else { light };
            let [r, g, b] = to_srgb8(light);
            [r, g, b, (255.0 * alpha).round() as u8]
        })
        .collect();
    RgbaImage::from_raw(size.width, size.height, bytes)
        .unwrap_or_default()
        .into()
}

fn ids_image(size: Size, ids: &[Option<PatchId>], is_raw: bool) -> DynamicImage {
    let pixel = |id: &Option<PatchId>| match id {
        Some(patch) => {
            let [r, g, b] = color_of_id(*patch, is_raw);
            [r, g, b, 255]
        }
        None => [0; 4],
    };
    let bytes = ids.iter().flat_map(pixel).collect();
    RgbaImage::from_raw(size.width, size.height, bytes)
        .unwrap_or_default()
        .into()
}
