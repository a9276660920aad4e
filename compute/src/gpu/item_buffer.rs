//! Item buffers of many hemicubes in one atlas. Twin of [`visibility::item_buffer`].

use scene::{Scene, SurfaceId};
use visibility::item_buffer::{BACK_FACE, NOTHING};
use visibility::{Frame, Window, hemicube};

use super::adapter::Gpu;
use super::atlas::{AtlasLayout, TILES_PER_HEMICUBE};
use super::horizon::{self, Horizon};
use super::raster::{self, ComputeRaster, Inputs, PipelineRaster, Raster};
use super::readback::Readback;
use super::structs::{self, DrawArguments, DrawSettings, Face, Projected, Span, Surface};
use crate::rows::BackendError;

/// The faces in each tile, from its first row on.
const FACES_OF_TILE: [&[usize]; TILES_PER_HEMICUBE] = [&[0], &[1, 2], &[3, 4]];
/// The most faces in a tile.
const MOST_FACES: u32 = 2;

/// What the surfaces seen by the faces of one drawing may take, were all above the horizons seen by all, bytes,
/// unless one tile alone needs more. Not tuned.
const PROJECTED_BUDGET: u64 = 128 << 20;
/// What the horizons of one drawing may take, bytes, unless one alone needs more. Not tuned.
const HORIZONS_BUDGET: u64 = 4 << 20;

/// Distance of the near plane over the scene's plane tolerance: nearer than any wall is known, in a scene
/// with things far away too. Reversed f32 depths are as exact with any near plane, and this leaves them
/// far above 2^-126.
const NEAR_PLANE: f32 = 1.0 / (1_u64 << 40) as f32;

/// Tiles to be drawn together.
#[derive(Clone, Debug, Default)]
struct Pending {
    tiles: u32,
    faces: Vec<Face>,
    /// Surfaces that the faces see at most, together.
    projected: u64,
    /// A horizon for each surface whose patches look out.
    horizons: Vec<u32>,
    /// Whose horizon was added last, and where it starts.
    last_horizon: Option<(SurfaceId, u32)>,
}

/// Draws tiles of hemicubes into an atlas.
#[derive(Debug)]
pub struct AtlasDrawer {
    layout: AtlasLayout,
    windows: [Window; 5],
    plane_tolerance: f64,
    pending: Pending,
    horizon: Horizon,
    most_projected: u64,
    most_horizon_words: usize,
    colour: wgpu::Texture,
    colour_view: wgpu::TextureView,
    projection: wgpu::ComputePipeline,
    bind_group: wgpu::BindGroup,
    faces: wgpu::Buffer,
    horizons: wgpu::Buffer,
    arguments: wgpu::Buffer,
    /// `None` where the adapter cannot do it.
    pipeline: Option<PipelineRaster>,
    compute: ComputeRaster,
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
        let plane_tolerance = visibility::plane_tolerance(scene);

        let surfaces = surfaces(scene);
        let count = surfaces.len();
        let most = limits
            .max_storage_buffer_binding_size
            .min(limits.max_buffer_size);
        let projected_bytes = size_of::<Projected>() as u64;
        let one_tile = count as u64 * u64::from(MOST_FACES);
        if one_tile * projected_bytes > most {
            return Err(gpu.unsuitable(format!("{count} surfaces exceed its buffers")));
        }
        let faces_count = u64::from(layout.tiles() * MOST_FACES);
        let most_projected = (PROJECTED_BUDGET.min(most) / projected_bytes)
            .min(faces_count * count as u64)
            .max(one_tile);
        let words = horizon::words(count);
        let most_horizon_words =
            words * (HORIZONS_BUDGET as usize / 4 / words).clamp(1, layout.tiles() as usize);
        let storage = wgpu::BufferUsages::STORAGE;
        let written = storage | wgpu::BufferUsages::COPY_DST;
        let settings = DrawSettings {
            near: plane_tolerance as f32 * NEAR_PLANE,
            plane_tolerance: plane_tolerance as f32,
            pixel: windows[0].pixel as f32,
            resolution,
            surface_count: count as u32,
            atlas_width: layout.size().width as f32,
            atlas_height: layout.size().height as f32,
            padding: 0,
        };
        let uniform = wgpu::BufferUsages::UNIFORM;
        let settings = gpu.constant_buffer("draw settings", &[settings], uniform);
        let surfaces = gpu.constant_buffer("surfaces", &surfaces, storage);
        let faces = gpu.buffer("faces", faces_count * size_of::<Face>() as u64, written);
        let horizons = gpu.buffer("horizons", 4 * most_horizon_words as u64, written);
        let projected = gpu.buffer("projected", most_projected * projected_bytes, storage);
        let spans = gpu.buffer("spans", faces_count * size_of::<Span>() as u64, storage);
        let arguments = gpu.buffer(
            "draw arguments",
            size_of::<DrawArguments>() as u64,
            written | wgpu::BufferUsages::INDIRECT,
        );
        let name = "projection.wgsl";
        let wgsl = structs::projection_wgsl();
        let projection = raster::compute_pipeline(gpu, name, wgsl, "project_surfaces");
        let bind_group = gpu.bind_group(
            &projection.get_bind_group_layout(0),
            &[
                settings.as_entire_binding(),
                surfaces.as_entire_binding(),
                faces.as_entire_binding(),
                horizons.as_entire_binding(),
                projected.as_entire_binding(),
                spans.as_entire_binding(),
                arguments.as_entire_binding(),
            ],
        );
        let colour = gpu.texture(
            "item buffers",
            layout.size(),
            raster::COLOUR_FORMAT,
            wgpu::TextureUsages::TEXTURE_BINDING
                | wgpu::TextureUsages::STORAGE_BINDING
                | wgpu::TextureUsages::COPY_SRC,
        );
        let colour_view = colour.create_view(&wgpu::TextureViewDescriptor::default());
        let inputs = Inputs {
            settings: &settings,
            faces: &faces,
            projected: &projected,
            spans: &spans,
        };
        let has_pipeline = Raster::offered_by(gpu).contains(&Raster::Pipeline);
        Ok(Self {
            layout,
            windows,
            plane_tolerance,
            pending: Pending::default(),
            horizon: Horizon::default(),
            most_projected,
            most_horizon_words,
            pipeline: has_pipeline.then(|| PipelineRaster::new(gpu, &inputs, layout.size())),
            compute: ComputeRaster::new(gpu, &inputs, &colour_view, resolution),
            colour_view,
            colour,
            projection,
            bind_group,
            faces,
            horizons,
            arguments,
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

    /// Whether a tile of the hemicube at `frame` can be added before the next [`Self::draw`].
    pub fn has_room(&mut self, scene: &Scene, own: Option<SurfaceId>, frame: &Frame) -> bool {
        self.horizon.find(scene, own, frame, self.plane_tolerance);
        let pending = &self.pending;
        let is_known = own.is_some()
            && matches!(pending.last_horizon, Some((surface, _)) if Some(surface) == own);
        let words = if is_known {
            0
        } else {
            self.horizon.words().len()
        };
        let projected = u64::from(self.horizon.count() * MOST_FACES);
        pending.tiles < self.layout.tiles()
            && pending.projected + projected <= self.most_projected
            && pending.horizons.len() + words <= self.most_horizon_words
    }

    /// Adds a tile of the hemicube at `frame` on the surface `own`, if on any. There is room for it, and its place in
    /// the atlas follows that of the tile added before.
    pub fn add(
        &mut self,
        scene: &Scene,
        own: Option<SurfaceId>,
        frame: &Frame,
        tile: usize,
        origin: [u32; 2],
    ) {
        let horizon = self.horizon_of(scene, own, frame);
        let mut y = origin[1];
        for &face in FACES_OF_TILE[tile] {
            let window = &self.windows[face];
            let face = face_of(frame, window, [origin[0], y], horizon);
            self.pending.faces.push(face);
            self.pending.projected += u64::from(self.horizon.count());
            y += window.height as u32;
        }
        self.pending.tiles += 1;
    }

    /// Draws all tiles added since the last time.
    pub fn draw(&mut self, gpu: &Gpu, encoder: &mut wgpu::CommandEncoder, raster: Raster) {
        let pending = &mut self.pending;
        let faces = pending.faces.len() as u32;
        let arguments = DrawArguments {
            vertex_count: 0,
            instance_count: 1,
            first_vertex: 0,
            first_instance: 0,
        };
        let write = |buffer, bytes| gpu.queue.write_buffer(buffer, 0, bytes);
        write(&self.faces, bytemuck::cast_slice(&pending.faces));
        write(&self.horizons, bytemuck::cast_slice(&pending.horizons));
        write(&self.arguments, bytemuck::bytes_of(&arguments));

        let mut pass = encoder.begin_compute_pass(&wgpu::ComputePassDescriptor::default());
        pass.set_pipeline(&self.projection);
        pass.set_bind_group(0, &self.bind_group, &[]);
        pass.dispatch_workgroups(faces, 1, 1);
        drop(pass);
        match (raster, &self.pipeline) {
            (Raster::Pipeline, Some(pipeline)) => {
                pipeline.draw(encoder, &self.colour_view, &self.arguments);
            }
            _ => self.compute.draw(encoder, faces),
        }
        pending.tiles = 0;
        pending.faces.clear();
        pending.projected = 0;
        pending.horizons.clear();
        pending.last_horizon = None;
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

    /// Where the horizon of a hemicube starts; there is room for it.
    fn horizon_of(&mut self, scene: &Scene, own: Option<SurfaceId>, frame: &Frame) -> u32 {
        self.horizon.find(scene, own, frame, self.plane_tolerance);
        if let Some((surface, start)) = self.pending.last_horizon
            && Some(surface) == own
        {
            return start;
        }
        let start = self.pending.horizons.len() as u32;
        let words = self.horizon.words();
        self.pending.horizons.extend_from_slice(words);
        self.pending.last_horizon = own.map(|own| (own, start));
        start
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
fn face_of(frame: &Frame, window: &Window, [x, y]: [u32; 2], horizon: u32) -> Face {
    let in_scene = |v| frame.to_scene(v).as_vec3().to_array();
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
        horizon,
    }
}
