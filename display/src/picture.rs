//! A whole picture of a scene, and the colours of its patches.

use glam::{DVec3, Vec3};
use image::{DynamicImage, RgbImage, RgbaImage};
use rayon::prelude::*;
use scene::{PatchId, Rgb, Scene, Solution};
use visibility::Cull;

use crate::camera::Camera;
use crate::dark;
use crate::default_camera::{self, Framing, Wishes};
use crate::legend::{self, Clipped, Layout};
use crate::range;
use crate::settings::{Mode, Quantity, RenderSettings, SettingsError, Size};
use crate::shade::{self, Light, Seen, Shading, ShownFunction};
use crate::smooth::VertexValues;
use crate::text::Canvas;
use crate::tone::{Tone, to_srgb8};
use crate::up;

/// Rows of a picture, where none are asked for.
const DEFAULT_HEIGHT: u32 = 768;

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

    let values = patch_values(scene, solution, settings.quantity)?;
    let Some(tone) = tone(scene, &values, settings) else {
        let (ids, seen) = shade::ids(scene, &camera, view, cull);
        let mapped = ids_image(view, &ids);
        return Ok(Picture {
            camera,
            view,
            linear: Vec::new(),
            mapped,
            tone: None,
            seen,
        });
    };
    let function = solution.and_then(|solution| solution.function.as_ref());
    let is_flat = settings.flat || settings.quantity == Quantity::Error;
    let shading = match function.filter(|_| !is_flat) {
        Some(function) => {
            let is_radiosity = settings.quantity == Quantity::Radiosity;
            Shading::Function(ShownFunction::new(scene, function, is_radiosity, &values))
        }
        None if settings.smooth => Shading::Smooth(VertexValues::new(scene, &values)),
        None => Shading::flat(&values, &tone),
    };
    let mut light = shade::light(scene, &camera, view, cull, &shading, &tone);
    let is_dark = light.linear.iter().all(|&value| value == Rgb::ZERO);
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
        light = shade::light(scene, &camera, view, cull, &shading, &tone);
    }
    let Light {
        seen,
        linear,
        display,
    } = light;
    let mut pixels = widened(display, view, size);
    if settings.mode == Mode::FalseColor
        && let Some(layout) = Layout::inside(size)
    {
        let mut canvas = Canvas {
            pixels: &mut pixels,
            size,
        };
        let clipped = Clipped::of(&values, tone.scale().range());
        legend::draw(&mut canvas, layout, &tone, settings.quantity, clipped);
    }
    Ok(Picture {
        camera,
        view,
        linear,
        mapped: rgb_image(size, &pixels),
        tone: Some(tone),
        seen,
    })
}

/// The colours of all patches in the mapping of a picture with these settings, sRGB, one per
/// patch; the patches' IDs in [`Mode::Ids`].
pub fn patch_colors(
    scene: &Scene,
    solution: Option<&Solution>,
    settings: &RenderSettings,
) -> Result<Vec<[u8; 3]>, SettingsError> {
    settings.validate()?;
    let values = patch_values(scene, solution, settings.quantity)?;
    Ok(match tone(scene, &values, settings) {
        Some(tone) => values
            .par_iter()
            .map(|&v| to_srgb8(tone.display_light(v)))
            .collect(),
        None => (0..scene.patch_count())
            .map(|patch| id_color(PatchId(patch)))
            .collect(),
    })
}

/// A patch's ID as a colour: R = ID >> 16, G = ID >> 8, B = ID.
pub fn id_color(patch: PatchId) -> [u8; 3] {
    let [_, r, g, b] = patch.0.to_be_bytes();
    [r, g, b]
}

/// The values to show, W/m^2, one per patch.
fn patch_values(
    scene: &Scene,
    solution: Option<&Solution>,
    quantity: Quantity,
) -> Result<Vec<Rgb>, SettingsError> {
    Ok(match (solution, quantity) {
        (Some(solution), Quantity::Radiosity) => solution.mean_radiosity(scene),
        (Some(solution), Quantity::Irradiance) => solution.mean_irradiance(scene),
        (None, Quantity::Radiosity) => scene.patch_emissions(),
        (None, Quantity::Irradiance) => vec![Rgb::ZERO; scene.patch_count() as usize],
        (solution, Quantity::Error) => {
            let error = solution.and_then(Solution::error);
            let error = error.ok_or(SettingsError::NoError)?;
            error.iter().map(|&error| Rgb::splat(error)).collect()
        }
    })
}

/// The mapping that is asked for; `None` in [`Mode::Ids`].
fn tone(scene: &Scene, values: &[Rgb], settings: &RenderSettings) -> Option<Tone> {
    if settings.mode == Mode::Ids {
        return None;
    }
    let range = settings
        .range
        .unwrap_or_else(|| range::suiting(scene, values, settings.mode));
    Tone::new(settings.mode, range)
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

fn ids_image(size: Size, ids: &[Option<PatchId>]) -> DynamicImage {
    let pixel = |id: &Option<PatchId>| match id {
        Some(patch) => {
            let [r, g, b] = id_color(*patch);
            [r, g, b, 255]
        }
        None => [0; 4],
    };
    let bytes = ids.iter().flat_map(pixel).collect();
    RgbaImage::from_raw(size.width, size.height, bytes)
        .unwrap_or_default()
        .into()
}
