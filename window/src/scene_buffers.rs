//! A scene and its values in the memory of the graphics card.

use bytemuck::NoUninit;
use display::tone::Tone;
use scene::function::IrradianceFunction;
use scene::{Rgb, Scene, Solution};
use wgpu::util::DeviceExt;
use wgpu::{Buffer, BufferUsages, Device};

use crate::structs::{COLORS, Material, NO_ROOT, Surface};
use crate::values::Values;

/// What the graphics card cannot hold.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{what} take {bytes} bytes, the graphics card's limit is {limit}; make a picture with display FILE --out IMAGE.png"
)]
pub struct TooLarge {
    what: &'static str,
    bytes: u64,
    limit: u64,
}

/// The surfaces and the mesh of the function.
#[derive(Debug)]
pub struct SceneBuffers {
    /// One [`Surface`] per surface.
    pub surfaces: Buffer,
    /// How many there are.
    pub surface_count: u32,
    /// Nodes of the function's mesh.
    pub nodes: Buffer,
}

/// What is shown of them.
#[derive(Debug)]
pub struct ValueBuffers {
    /// Three numbers per patch.
    pub of_patches: Buffer,
    /// Three numbers per vertex; all zero where the function is not shown.
    pub of_vertices: Buffer,
    /// One [`Material`] per material.
    pub materials: Buffer,
    /// Whether the function is shown.
    pub has_function: bool,
}

impl SceneBuffers {
    /// Those of a scene.
    ///
    /// # Errors
    /// A scene that is too large.
    pub fn new(
        device: &Device,
        scene: &Scene,
        solution: Option<&Solution>,
    ) -> Result<Self, TooLarge> {
        let function = solution.and_then(|solution| solution.function.as_ref());
        let mesh = function.map(IrradianceFunction::mesh);
        let root = |surface: usize| mesh.map_or(NO_ROOT, |mesh| mesh.roots()[surface]);
        let surfaces: Vec<Surface> = scene
            .surfaces()
            .iter()
            .zip(scene.mesh().trees())
            .enumerate()
            .map(|(index, (surface, tree))| {
                let [corner_0, corner_1, corner_2] =
                    surface.corners.map(|corner| corner.to_array());
                Surface {
                    corner_0,
                    first_patch: tree.first_patch.0,
                    corner_1,
                    depth: tree.depth,
                    corner_2,
                    root: root(index),
                    material: surface.material.0,
                    padding: [0; 3],
                }
            })
            .collect();
        Ok(Self {
            surfaces: buffer(device, "surfaces", &surfaces)?,
            surface_count: surfaces.len() as u32,
            nodes: buffer(device, "nodes", mesh.map_or(&[][..], |mesh| mesh.nodes()))?,
        })
    }
}

impl ValueBuffers {
    /// Those of some values.
    ///
    /// # Errors
    /// Values that are too many.
    pub fn new(device: &Device, values: &Values) -> Result<Self, TooLarge> {
        let function = values.function.as_ref();
        let of_vertices: &[Rgb] = function.map_or(&[], |function| &function.of_vertices);
        let materials: Vec<Material> = function
            .map_or(&[][..], |function| &function.of_materials)
            .iter()
            .map(|&[more, factor]| Material {
                more: more.to_array(),
                padding_0: 0,
                factor: factor.to_array(),
                padding_1: 0,
            })
            .collect();
        Ok(Self {
            of_patches: buffer(device, "patches", &values.of_patches)?,
            of_vertices: buffer(device, "vertices", of_vertices)?,
            materials: buffer(device, "materials", &materials)?,
            has_function: function.is_some(),
        })
    }
}

/// The colours of a scale's places, display light.
pub fn colors(tone: &Tone) -> Vec<[f32; 4]> {
    let color = |k: u32| tone.color_at(f64::from(k) / f64::from(COLORS - 1));
    let colors = (0..COLORS).map(color);
    colors.map(|color| color.extend(1.0).to_array()).collect()
}

/// A buffer that shaders read. One of nothing holds a few zeros, as no binding may be empty.
pub fn buffer<T: NoUninit>(
    device: &Device,
    what: &'static str,
    values: &[T],
) -> Result<Buffer, TooLarge> {
    /// Above the size of any struct here.
    const LEAST: usize = 64;
    let bytes: &[u8] = bytemuck::cast_slice(values);
    let limits = device.limits();
    let limit = limits
        .max_storage_buffer_binding_size
        .min(limits.max_buffer_size);
    if bytes.len() as u64 > limit {
        return Err(TooLarge {
            what,
            bytes: bytes.len() as u64,
            limit,
        });
    }
    Ok(
        device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some(what),
            contents: if bytes.is_empty() { &[0; LEAST] } else { bytes },
            usage: BufferUsages::STORAGE | BufferUsages::COPY_DST,
        }),
    )
}
