//! What the graphics card is told about the camera and the looks.

use display::Camera;
use display::tone::Tone;
use glam::DVec3;
use scene::{NO_PATCH, PatchId};

use crate::looks::Looks;
use crate::structs::{View, number_of_channel, number_of_mode};

/// Distance of the near plane, as a share of the scene's size. Depths are reversed f32, to which it is all one.
const NEAR: f64 = 1e-5;

/// A picture that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// Where it is taken from.
    pub camera: Camera,
    /// Diagonal of the scene's bounding box, metres.
    pub scene_size: f64,
    /// Pixels in a row, and rows.
    pub size: [u32; 2],
    /// Samples along a pixel's side, whatever is above 0.
    pub samples: f32,
    /// How values become colours.
    pub looks: Looks,
    /// The patch that is outlined.
    pub picked: Option<PatchId>,
}

impl Asked {
    /// Columns and rows of samples, at most `limit` of each.
    pub fn sample_size(&self, limit: u32) -> [u32; 2] {
        self.size
            .map(|pixels| ((pixels as f32 * self.samples).round() as u32).clamp(1, limit))
    }

    /// The same for the shader.
    pub fn view(&self, tone: &Tone, has_function: bool) -> View {
        let Self {
            camera,
            scene_size,
            size: [width, height],
            samples,
            looks,
            picked,
        } = *self;
        let vector = |v: DVec3| v.as_vec3().to_array();
        let half_height = camera.half_height();
        let aspect = f64::from(width.max(1)) / f64::from(height.max(1));
        let scale = tone.scale();
        let range = scale.range();
        let [start, end] = if scale.is_logarithmic() {
            [range.low.ln(), range.high.ln()]
        } else {
            [range.low, range.high]
        };
        View {
            eye: vector(camera.eye),
            half_width: (half_height * aspect) as f32,
            right: vector(camera.right),
            half_height: half_height as f32,
            up: vector(camera.up),
            near: (NEAR * scene_size) as f32,
            forward: vector(camera.forward),
            samples,
            start: start as f32,
            factor: (1.0 / (end - start)) as f32,
            is_logarithmic: u32::from(scale.is_logarithmic()),
            mode: number_of_mode(looks.mode),
            channel: number_of_channel(looks.shown.channel),
            has_function: u32::from(has_function),
            has_wires: u32::from(looks.has_wires),
            picked: picked.unwrap_or(NO_PATCH).0,
        }
    }
}
