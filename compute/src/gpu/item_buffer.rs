//! Item buffers of many hemicubes in one atlas. Twin of [`crate::cpu::item_buffer`].

use std::ops::Range;

use glam::DVec3;
use scene::{Scene, SurfaceId};

use super::adapter::Gpu;
use super::atlas::{AtlasLayout, TILES_PER_HEMICUBE};
use super::readback::Readback;
use super::structs::{self, DrawSettings, Face, Surface};
use crate::cpu;
use crate::cpu::item_buffer::{BACK_FACE, NOTHING};
use crate::hemicube::{self, Frame, Window};
use crate::rows::BackendError;

/// The faces in each tile, from its first row on.
const FACES_OF_TILE: [&[usize]; TILES_PER_HEMICUBE] = [&[0], &[1, 2], &[3, 4]];

/// Surfaces in the lists of one drawing, 4 bytes each, unless one list alone is longer.
const LISTED_SURFACES_BUDGET: usize = 4 << 20;

/// Distance of the near plane over the scene's plane tolerance: nearer than any wall is known, in a scene
/// with things far away too. Reversed f32 depths are as exact with any near plane, and this leaves them
/// far above 2^-126.
const NEAR_PLANE: f32 = 1.0 / (1_u64 << 40) as f32;

const COLOUR_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8Uint;
const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// One face to be drawn.
#[derive(Clone, Debug)]
struct Draw {
    /// Column, row, width and height in the atlas, pixels.
    viewport: [u32; 4],
    /// Where the surfaces to draw are listed.
    listed: Range<u32>,
}

/// Tiles to be drawn together.
#[derive(Clone, Debug, Default)]
struct Pending {
    tiles: u32,
    /// One per draw.
    faces: Vec<Face>,
    draws: Vec<Draw>,
    /// Surfaces above the horizon, a list for each surface whose patches look out.
    lists: Vec<u32>,
    /// Whose list was added last, and where it is.
    last_list: Option<(SurfaceId, Range<u32>)>,
}

/// Draws tiles of hemicubes into an atlas.
#[derive(Debug)]
pub struct AtlasDrawer {
    layout: AtlasLayout,
    windows: [Window; 5],
    plane_tolerance: f64,
    pending: Pending,
    /// The newest list of surfaces above a surface's horizon, and whose it is.
    horizon: (Option<SurfaceId>, Vec<u32>),
    lists_capacity: usize,
    colour: wgpu::Texture,
    colour_view: wgpu::TextureView,
    depth_view: wgpu::TextureView,
    pipeline: wgpu::RenderPipeline,
    bind_group: wgpu::BindGroup,
    faces: wgpu::Buffer,
    lists: wgpu::Buffer,
}

impl AtlasDrawer {
    /// A drawer for hemicubes of this resolution.
    pub fn new(gpu: &Gpu, scene: &Scene, resolution: u32) -> Result<Self, BackendError> {
        let limits = gpu.device.limits();
        let layout =
            AtlasLayout::new(resolution, limits.max_texture_dimension_2d).ok_or_else(|| {
                let most = limits.max_texture_dimension_2d;
                gpu.unsuitable(format!(
                    "resolution {resolution} exceeds its textures' {most}"
                ))
            })?;
        let windows = hemicube::windows(resolution);
        let plane_tolerance = cpu::plane_tolerance(scene);

        let surfaces = surfaces(scene);
        let count = surfaces.len();
        let bytes = size_of_val(surfaces.as_slice()) as u64;
        if bytes > limits.max_storage_buffer_binding_size {
            return Err(gpu.unsuitable(format!("{count} surfaces exceed its buffers")));
        }
        let lists_capacity =
            count * (LISTED_SURFACES_BUDGET / count).clamp(1, layout.tiles() as usize);
        let storage = wgpu::BufferUsages::STORAGE;
        let written = storage | wgpu::BufferUsages::COPY_DST;
        let faces_bytes = u64::from(layout.tiles()) * 2 * size_of::<Face>() as u64;
        let faces = gpu.buffer("faces", faces_bytes, written);
        let lists = gpu.buffer("above horizon", 4 * lists_capacity as u64, written);
        let settings = DrawSettings {
            near: plane_tolerance as f32 * NEAR_PLANE,
            plane_tolerance: plane_tolerance as f32,
            pixel: windows[0].pixel as f32,
            padding: 0.0,
        };
        let pipeline = pipeline(gpu);
        let bind_group = gpu.bind_group(
            &pipeline.get_bind_group_layout(0),
            &[
                gpu.constant_buffer("draw settings", &[settings], wgpu::BufferUsages::UNIFORM)
                    .as_entire_binding(),
                gpu.constant_buffer("surfaces", &surfaces, storage)
                    .as_entire_binding(),
                faces.as_entire_binding(),
                lists.as_entire_binding(),
            ],
        );
        let colour = gpu.texture(
            "item buffers",
            layout.size(),
            COLOUR_FORMAT,
            wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_SRC,
        );
        let depth = gpu.texture(
            "depths",
            layout.size(),
            DEPTH_FORMAT,
            wgpu::TextureUsages::empty(),
        );
        let view =
            |texture: &wgpu::Texture| texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self {
            layout,
            windows,
            plane_tolerance,
            pending: Pending::default(),
            horizon: (None, Vec::new()),
            lists_capacity,
            colour_view: view(&colour),
            depth_view: view(&depth),
            colour,
            pipeline,
            bind_group,
            faces,
            lists,
        })
    }

    /// Where the tiles lie.
    pub fn layout(&self) -> AtlasLayout {
        self.layout
    }

    /// The atlas.
    pub fn view(&self) -> &wgpu::TextureView {
        &self.colour_view
    }

    /// Whether a tile of a hemicube on this surface can be added before the next [`Self::draw`].
    pub fn has_room(&mut self, scene: &Scene, own: SurfaceId) -> bool {
        if self.pending.tiles == self.layout.tiles() {
            return false;
        }
        if matches!(&self.pending.last_list, Some((surface, _)) if *surface == own) {
            return true;
        }
        self.find_horizon(scene, own);
        self.pending.lists.len() + self.horizon.1.len() <= self.lists_capacity
    }

    /// Adds a tile of the hemicube at `frame` on a surface. There is room for it, and its place in
    /// the atlas follows that of the tile added before.
    pub fn add(
        &mut self,
        scene: &Scene,
        own: SurfaceId,
        frame: &Frame,
        tile: usize,
        origin: [u32; 2],
    ) {
        let listed = self.list(scene, own);
        let mut y = origin[1];
        for &face in FACES_OF_TILE[tile] {
            let window = &self.windows[face];
            let (width, height) = (window.width as u32, window.height as u32);
            self.pending
                .faces
                .push(face_of(frame, window, [origin[0], y]));
            self.pending.draws.push(Draw {
                viewport: [origin[0], y, width, height],
                listed: listed.clone(),
            });
            y += height;
        }
        self.pending.tiles += 1;
    }

    /// Draws all tiles added since the last time.
    pub fn draw(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder) {
        let pending = &self.pending;
        gpu.queue
            .write_buffer(&self.faces, 0, bytemuck::cast_slice(&pending.faces));
        gpu.queue
            .write_buffer(&self.lists, 0, bytemuck::cast_slice(&pending.lists));
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("item buffers"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.colour_view,
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
        for (face, draw) in (0..).zip(&pending.draws) {
            let [x, y, width, height] = draw.viewport;
            pass.set_scissor_rect(x, y, width, height);
            pass.set_viewport(x as f32, y as f32, width as f32, height as f32, 0.0, 1.0);
            pass.draw(3 * draw.listed.start..3 * draw.listed.end, face..face + 1);
        }
        drop(pass);
        self.pending.tiles = 0;
        self.pending.faces.clear();
        self.pending.draws.clear();
        self.pending.lists.clear();
        self.pending.last_list = None;
    }

    /// The pixels of a tile, row by row: patch IDs, [`NOTHING`] or [`BACK_FACE`].
    pub fn read(&self, gpu: &Gpu, [x, y]: [u32; 2]) -> Result<Vec<u32>, BackendError> {
        let resolution = self.layout.resolution;
        let row_bytes = (4 * resolution).next_multiple_of(wgpu::COPY_BYTES_PER_ROW_ALIGNMENT);
        let bytes = u64::from(row_bytes) * u64::from(resolution);
        let mut readback = Readback::new(gpu, "item buffer readback", bytes);
        let mut encoder = gpu.encoder();
        encoder.copy_texture_to_buffer(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x, y, z: 0 },
                ..self.colour.as_image_copy()
            },
            wgpu::TexelCopyBufferInfo {
                buffer: readback.buffer(),
                layout: wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(row_bytes),
                    rows_per_image: None,
                },
            },
            wgpu::Extent3d {
                width: resolution,
                height: resolution,
                depth_or_array_layers: 1,
            },
        );
        let submission = gpu.submit(encoder)?;
        readback.ask(bytes);
        gpu.wait(submission)?;
        readback.take(gpu, |bytes| {
            bytes
                .chunks_exact(row_bytes as usize)
                .flat_map(|row| row[..4 * resolution as usize].chunks_exact(4))
                .map(|texel| match *texel {
                    [r, g, b, structs::ALPHA_PATCH] => u32::from_be_bytes([0, r, g, b]),
                    [_, _, _, structs::ALPHA_BACK_FACE] => BACK_FACE,
                    _ => NOTHING,
                })
                .collect()
        })
    }

    /// Where the surfaces above a surface's horizon are listed; there is room for the list.
    fn list(&mut self, scene: &Scene, own: SurfaceId) -> Range<u32> {
        if let Some((surface, listed)) = &self.pending.last_list
            && *surface == own
        {
            return listed.clone();
        }
        self.find_horizon(scene, own);
        let start = self.pending.lists.len() as u32;
        self.pending.lists.extend_from_slice(&self.horizon.1);
        let listed = start..self.pending.lists.len() as u32;
        self.pending.last_list = Some((own, listed.clone()));
        listed
    }

    /// Finds the surfaces that rise above the plane of a surface, where all its hemicubes stand.
    fn find_horizon(&mut self, scene: &Scene, own: SurfaceId) {
        if self.horizon.0 == Some(own) {
            return;
        }
        let normal = scene.surface(own).normal();
        let height = |p: glam::Vec3| p.as_dvec3().dot(normal);
        let own_height = height(scene.surface(own).corners[0]);
        let own_reach = cpu::reach(scene.surface(own));
        let tolerance = self.plane_tolerance;
        let (surface, list) = &mut self.horizon;
        *surface = Some(own);
        list.clear();
        list.extend((0..).zip(scene.surfaces()).filter_map(|(index, surface)| {
            let reach = cpu::reach(surface).max(own_reach);
            let is_above = surface.corners.into_iter().any(|p| {
                let above = height(p) - own_height;
                above > 0.0 && !cpu::is_in_plane(above, tolerance, normal, reach)
            });
            (is_above && index != own.0).then_some(index)
        }));
    }
}

/// All surfaces as the shader sees them.
fn surfaces(scene: &Scene) -> Vec<Surface> {
    let trees = scene.mesh().trees();
    scene
        .surfaces()
        .iter()
        .zip(trees)
        .map(|(surface, tree)| {
            let [corner_0, corner_1, corner_2] = surface.corners.map(|p| p.to_array());
            Surface {
                corner_0,
                first_patch: tree.first_patch.0,
                corner_1,
                depth: tree.depth,
                corner_2,
                padding: 0,
            }
        })
        .collect()
}

/// A face of the hemicube at `frame` as the shader sees it.
fn face_of(frame: &Frame, window: &Window, [x, y]: [u32; 2]) -> Face {
    let in_scene = |v: DVec3| {
        (v.x * frame.tangent + v.y * frame.bitangent + v.z * frame.normal)
            .as_vec3()
            .to_array()
    };
    let eye_high = frame.position.as_vec3();
    Face {
        eye_high: eye_high.to_array(),
        bottom: window.bottom as f32,
        eye_low: (frame.position - eye_high.as_dvec3()).as_vec3().to_array(),
        height: (window.height as f64 * window.pixel) as f32,
        right: in_scene(window.right),
        origin_x: x as f32,
        up: in_scene(window.up),
        origin_y: y as f32,
        forward: in_scene(window.forward),
        padding: 0.0,
    }
}

fn pipeline(gpu: &Gpu) -> wgpu::RenderPipeline {
    let module = gpu.shader("item_buffer.wgsl", structs::item_buffer_wgsl());
    gpu.device
        .create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("item buffer"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("project"),
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
        })
}
