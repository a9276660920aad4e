//! The shader as the graphics card runs it.

use wgpu::{BindGroup, Buffer, BufferBindingType, Device, RenderPipeline, ShaderStages};

use crate::structs::surfaces_wgsl;
use crate::targets::{COLOR, DEPTH, SEEN};

/// Buffers of the shader: the view, and six that are read.
pub const BUFFERS: usize = 7;

/// Ways to draw surfaces.
#[derive(Debug)]
pub struct Pipelines {
    layout: wgpu::BindGroupLayout,
    fronts: RenderPipeline,
    fronts_and_backs: RenderPipeline,
}

impl Pipelines {
    /// Compiles the shader.
    pub fn new(device: &Device) -> Self {
        let module = device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some("surfaces.wgsl"),
            source: wgpu::ShaderSource::Wgsl(surfaces_wgsl().into()),
        });
        let entries: [_; BUFFERS] = std::array::from_fn(|binding| wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility: ShaderStages::VERTEX_FRAGMENT,
            ty: wgpu::BindingType::Buffer {
                ty: if binding == 0 {
                    BufferBindingType::Uniform
                } else {
                    BufferBindingType::Storage { read_only: true }
                },
                has_dynamic_offset: false,
                min_binding_size: None,
            },
            count: None,
        });
        let layout = device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor {
            label: Some("surfaces"),
            entries: &entries,
        });
        let pipeline_layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some("surfaces"),
            bind_group_layouts: &[Some(&layout)],
            immediate_size: 0,
        });
        let pipeline = |cull_mode| {
            device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
                label: Some("surfaces"),
                layout: Some(&pipeline_layout),
                vertex: wgpu::VertexState {
                    module: &module,
                    entry_point: Some("corner"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    buffers: &[],
                },
                primitive: wgpu::PrimitiveState {
                    front_face: wgpu::FrontFace::Ccw,
                    cull_mode,
                    ..wgpu::PrimitiveState::default()
                },
                depth_stencil: Some(wgpu::DepthStencilState {
                    format: DEPTH,
                    depth_write_enabled: Some(true),
                    depth_compare: Some(wgpu::CompareFunction::Greater),
                    stencil: wgpu::StencilState::default(),
                    bias: wgpu::DepthBiasState::default(),
                }),
                multisample: wgpu::MultisampleState::default(),
                fragment: Some(wgpu::FragmentState {
                    module: &module,
                    entry_point: Some("shade"),
                    compilation_options: wgpu::PipelineCompilationOptions::default(),
                    targets: &[Some(COLOR.into()), Some(SEEN.into())],
                }),
                multiview_mask: None,
                cache: None,
            })
        };
        Self {
            fronts: pipeline(Some(wgpu::Face::Back)),
            fronts_and_backs: pipeline(None),
            layout,
        }
    }

    /// The pipeline that draws fronts, and backs if they are to be seen.
    pub fn drawing(&self, has_backs: bool) -> &RenderPipeline {
        if has_backs {
            &self.fronts_and_backs
        } else {
            &self.fronts
        }
    }

    /// The shader's buffers, in the order of their bindings.
    pub fn bind(&self, device: &Device, buffers: [&Buffer; BUFFERS]) -> BindGroup {
        let entries: Vec<_> = (0..)
            .zip(buffers)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("surfaces"),
            layout: &self.layout,
            entries: &entries,
        })
    }
}
