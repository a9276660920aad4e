//! Drawing surfaces and asking which patch a pixel sees.

use std::sync::{Arc, Mutex, PoisonError};

use display::tone::Tone;
use scene::{NO_PATCH, PatchId, Scene, Solution};
use wgpu::{BufferUsages, Device, LoadOp, Queue, TextureView};

use crate::pipelines::Pipelines;
use crate::scene_buffers::{SceneBuffers, TooLarge, ValueBuffers, buffer, colors};
use crate::structs::View;
use crate::targets::{Targets, read, view};
use crate::values::Values;
use crate::view::Asked;

/// sRGB codes over 255 of what no surface covers: a dark blue, which is told from black walls.
const BACKGROUND: wgpu::Color = wgpu::Color {
    r: 0.07,
    g: 0.08,
    b: 0.11,
    a: 1.0,
};

/// A scene on the graphics card.
#[derive(Debug)]
struct Content {
    scene: SceneBuffers,
    values: ValueBuffers,
    tone: Tone,
    bind_group: wgpu::BindGroup,
}

/// What draws pictures of one scene after the other.
#[derive(Debug)]
pub struct Renderer {
    device: Device,
    queue: Queue,
    pipelines: Pipelines,
    /// One [`View`].
    view: wgpu::Buffer,
    content: Option<Content>,
    targets: Option<Targets>,
    /// The first thing that went wrong.
    failure: Arc<Mutex<Option<String>>>,
}

impl Renderer {
    /// On a device, whose errors are noted from now on rather than ending the program.
    pub fn new(device: &Device, queue: &Queue) -> Self {
        let failure: Arc<Mutex<Option<String>>> = Arc::default();
        let noted = Arc::clone(&failure);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| {
            let text = error.to_string();
            let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
            noted
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .get_or_insert(line);
        }));
        let view = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("view"),
            size: size_of::<View>() as u64,
            usage: BufferUsages::UNIFORM | BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        Self {
            pipelines: Pipelines::new(device),
            device: device.clone(),
            queue: queue.clone(),
            view,
            content: None,
            targets: None,
            failure,
        }
    }

    /// What has gone wrong on the graphics card, if anything has.
    pub fn failure(&self) -> Option<String> {
        let failure = self.failure.lock();
        failure.unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Takes a scene in place of the one before, and what is shown of it.
    ///
    /// # Errors
    /// What does not fit on the graphics card; the scene before stays.
    pub fn set_scene(
        &mut self,
        scene: &Scene,
        solution: Option<&Solution>,
        values: &Values,
        tone: Tone,
    ) -> Result<(), TooLarge> {
        let scene = SceneBuffers::new(&self.device, scene, solution)?;
        let values = ValueBuffers::new(&self.device, values)?;
        self.put(scene, values, tone)
    }

    /// Shows something else of the same scene.
    ///
    /// # Errors
    /// As [`Self::set_scene`].
    pub fn set_values(&mut self, values: &Values, tone: Tone) -> Result<(), TooLarge> {
        let values = ValueBuffers::new(&self.device, values)?;
        match self.content.take() {
            Some(content) => self.put(content.scene, values, tone),
            None => Ok(()),
        }
    }

    /// Maps the same values in another way.
    pub fn set_tone(&mut self, tone: Tone) {
        if let Some(content) = &mut self.content {
            content.tone = tone;
        }
    }

    fn put(
        &mut self,
        scene: SceneBuffers,
        values: ValueBuffers,
        tone: Tone,
    ) -> Result<(), TooLarge> {
        let colors = buffer(&self.device, "colors", &colors(&tone))?;
        let bind_group = self.pipelines.bind(
            &self.device,
            [
                &self.view,
                &scene.surfaces,
                &values.of_patches,
                &scene.nodes,
                &values.of_vertices,
                &values.materials,
                &colors,
            ],
        );
        self.content = Some(Content {
            scene,
            values,
            tone,
            bind_group,
        });
        Ok(())
    }

    /// Draws a picture. Returns its colours where they are a new texture.
    pub fn draw(&mut self, asked: &Asked) -> Option<TextureView> {
        let size = asked.sample_size(self.device.limits().max_texture_dimension_2d);
        let is_new = self
            .targets
            .as_ref()
            .is_none_or(|targets| targets.size != size);
        if is_new {
            self.targets = Some(Targets::new(&self.device, size));
        }
        let targets = self.targets.as_ref()?;
        let content = self.content.as_ref();
        if let Some(Content { tone, values, .. }) = content {
            let view = asked.view(tone, values.has_function);
            self.queue
                .write_buffer(&self.view, 0, bytemuck::bytes_of(&view));
        }
        let mut encoder = self
            .device
            .create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let [color, seen, depth] = [&targets.color, &targets.seen, &targets.depth].map(view);
            let none = wgpu::Color {
                r: f64::from(NO_PATCH.0),
                ..wgpu::Color::TRANSPARENT
            };
            let attachments = [(&color, BACKGROUND), (&seen, none)].map(|(view, clear)| {
                Some(wgpu::RenderPassColorAttachment {
                    view,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: LoadOp::Clear(clear),
                        store: wgpu::StoreOp::Store,
                    },
                })
            });
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("surfaces"),
                color_attachments: &attachments,
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &depth,
                    depth_ops: Some(wgpu::Operations {
                        load: LoadOp::Clear(0.0),
                        store: wgpu::StoreOp::Discard,
                    }),
                    stencil_ops: None,
                }),
                ..wgpu::RenderPassDescriptor::default()
            });
            if let Some(content) = content {
                pass.set_pipeline(self.pipelines.drawing(asked.looks.has_backs));
                pass.set_bind_group(0, &content.bind_group, &[]);
                pass.draw(0..3 * content.scene.surface_count, 0..1);
            }
        }
        self.queue.submit([encoder.finish()]);
        is_new.then(|| targets.color_view())
    }

    /// The patch whose front the pixel at a column and a row sees, 0 to 1 from the picture's top left corner; as drawn last.
    pub fn patch_at(&self, [x, y]: [f32; 2]) -> Option<PatchId> {
        let targets = self.targets.as_ref()?;
        let [column, row] = [(x, targets.size[0]), (y, targets.size[1])]
            .map(|(share, count)| ((share * count as f32) as u32).min(count - 1));
        let texels = read(
            &self.device,
            &self.queue,
            &targets.seen,
            [column, row],
            [1, 1],
        )?;
        let patch = PatchId(u32::from_le_bytes(*texels.first()?));
        (patch != NO_PATCH).then_some(patch)
    }

    /// The sRGB codes and the patches of all samples as drawn last, row by row from the top.
    pub fn samples(&self) -> Option<Vec<([u8; 3], Option<PatchId>)>> {
        let targets = self.targets.as_ref()?;
        let all = |texture| read(&self.device, &self.queue, texture, [0, 0], targets.size);
        let (colors, seen) = (all(&targets.color)?, all(&targets.seen)?);
        let samples = colors.into_iter().zip(seen).map(|([r, g, b, _], seen)| {
            let patch = PatchId(u32::from_le_bytes(seen));
            ([r, g, b], (patch != NO_PATCH).then_some(patch))
        });
        Some(samples.collect())
    }

    /// Columns and rows of samples of the last picture.
    pub fn sample_size(&self) -> Option<[u32; 2]> {
        self.targets.as_ref().map(|targets| targets.size)
    }
}
