//! Who finds the pixels of what the faces of hemicubes see: the fixed pipeline, or a compute shader. Twin of
//! `spans` of the crate `visibility`.
//!
//! # Theory
//! Raster units find the pixels of a triangle for nothing, where a chip has many for its arithmetic units, as
//! graphics cards have. Data-centre GPUs have few or slow ones; there, many threads that each try a pixel
//! are faster.
//!
//! # Practice
//! Both begin with what `projection.wgsl` found, and decide each pixel by the same few lines of
//! `item_buffer.wgsl`: the item buffers are the same to the bit. So the faster one is taken, as measured on a
//! scene's own hemicubes ([`super::rows`]). The pipeline draws all faces of all tiles at once, each cut out by
//! clip distances; where an adapter has none, the compute shader draws.

use super::adapter::Gpu;
use super::structs::{self, BLOCK_SIDE};

/// Format of the atlas.
pub const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Uint;
/// Format of the pipeline's depths.
pub const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// A way to rasterise.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Raster {
    /// The fixed pipeline.
    Pipeline,
    /// A compute shader.
    Compute,
}

impl Raster {
    /// Those that an adapter can do.
    pub fn offered_by(gpu: &Gpu) -> &'static [Self] {
        let features = gpu.device.features();
        if features.contains(wgpu::Features::CLIP_DISTANCES) {
            &[Self::Pipeline, Self::Compute]
        } else {
            &[Self::Compute]
        }
    }

    /// What it is, for people.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Pipeline => "fixed pipeline",
            Self::Compute => "compute shader",
        }
    }
}

/// Buffers that the shaders read.
#[derive(Debug)]
pub struct Inputs<'a> {
    /// [`structs::DrawSettings`].
    pub settings: &'a wgpu::Buffer,
    /// One [`structs::Face`] per face.
    pub faces: &'a wgpu::Buffer,
    /// [`structs::Projected`] of all faces.
    pub projected: &'a wgpu::Buffer,
    /// One [`structs::Span`] per face.
    pub spans: &'a wgpu::Buffer,
}

/// The fixed pipeline.
#[derive(Debug)]
pub struct PipelineRaster {
    pipeline: wgpu::RenderPipeline,
    bind_group: wgpu::BindGroup,
    depth_view: wgpu::TextureView,
}

impl PipelineRaster {
    /// For an atlas of this size.
    pub fn new(gpu: &Gpu, inputs: &Inputs, size: wgpu::Extent3d) -> Self {
        let module = gpu.shader("raster_pipeline.wgsl", structs::raster_pipeline_wgsl());
        let pipeline = gpu
            .device
            .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("item buffer"),
                layout: None,
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("place_corner"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                // Nothing is culled: backs occlude.
                primitive: wgpu::PrimitiveState::default(),
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH_FORMAT,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("look_up"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(COLOUR_FORMAT.into())],
                }),
                multiview_mask: None,
                cache: None,
            });
        let bind_group = gpu.bind_group(
            &pipeline.get_bind_group_layout(0),
            &[
                inputs.settings.as_entire_binding(),
                inputs.faces.as_entire_binding(),
                inputs.projected.as_entire_binding(),
            ],
        );
        let none = wgpu::TextureUsages::empty();
        let depth = gpu.texture("depths", size, DEPTH_FORMAT, none);
        Self {
            pipeline,
            bind_group,
            depth_view: depth.create_view(&wgpu::TextureViewDescriptor::default()),
        }
    }

    /// Draws what the device has counted.
    pub fn draw(
        &self,
        encoder: &mut wgpu::CommandEncoder,
        atlas: &wgpu::TextureView,
        arguments: &wgpu::Buffer,
    ) {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("item buffers"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: atlas,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations {
                    load: wgpu::LoadOp::Clear(wgpu::Color {
                        a: f64::from(structs::ALPHA_NOTHING),
                        ..wgpu::Color::TRANSPARENT
                    }),
                    store: wgpu::StoreOp::Store,
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &self.depth_view,
                depth_ops: Some(wgpu::Operations {
                    load: wgpu::LoadOp::Clear(0.0),
                    store: wgpu::StoreOp::Discard,
                }),
                stencil_ops: None,
            }),
            ..wgpu::RenderPassDescriptor::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.draw_indirect(arguments, 0);
    }
}

/// The compute shader.
#[derive(Debug)]
pub struct ComputeRaster {
    pipeline: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
    /// Blocks along a face.
    blocks: u32,
}

impl ComputeRaster {
    /// For an atlas of tiles of this resolution.
    pub fn new(gpu: &Gpu, inputs: &Inputs, atlas: &wgpu::TextureView, resolution: u32) -> Self {
        let pipeline = compute_pipeline(
            gpu,
            "raster_compute.wgsl",
            structs::raster_compute_wgsl(),
            "draw_block",
        );
        let bind_group = gpu.bind_group(
            &pipeline.get_bind_group_layout(0),
            &[
                inputs.settings.as_entire_binding(),
                inputs.faces.as_entire_binding(),
                inputs.projected.as_entire_binding(),
                inputs.spans.as_entire_binding(),
                wgpu::BindingResource::TextureView(atlas),
            ],
        );
        Self {
            pipeline,
            bind_group,
            blocks: resolution.div_ceil(BLOCK_SIDE),
        }
    }

    /// Draws so many faces.
    pub fn draw(&self, encoder: &mut wgpu::CommandEncoder, faces: u32) {
        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.dispatch_workgroups(self.blocks, self.blocks, faces);
    }
}

/// A pipeline of one shader, whose bindings follow from its text.
pub fn compute_pipeline(
    gpu: &Gpu,
    name: &str,
    wgsl: String,
    entry_point: &str,
) -> wgpu::ComputePipeline {
    let module = gpu.shader(name, wgsl);
    gpu.device
        .create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some(name),
            layout: None,
            module: &module,
            entry_point: Some(entry_point),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            cache: None,
        })
}
