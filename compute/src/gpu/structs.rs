//! All data that Rust and the shaders share: structs, constants, and the shaders themselves.
//!
//! The constants are typed here only, and are put in front of each shader's text. The structs are typed
//! in the shaders too; a test compares every offset and size.

use bytemuck::{Pod, Zeroable};
use scene::NO_PATCH;
use visibility::COORDINATE_ULPS;

/// Alpha of a pixel that sees nothing: the value the atlas is cleared to.
pub const ALPHA_NOTHING: u8 = 0;
/// Alpha of a pixel that sees the back of a surface.
pub const ALPHA_BACK_FACE: u8 = 128;
/// Alpha of a pixel that sees a patch.
pub const ALPHA_PATCH: u8 = 255;

/// What the reversed depth of a back is multiplied by, so that it lies behind the front that it meets at
/// a silhouette. Depths are f32: for a plane that is seen at an angle theta they err by some 2^-22 / theta,
/// which 2^-12 covers down to a thousandth. A back in front of something by less than that share of its
/// distance is not reported.
pub const BACK_FACE_RETREAT: f32 = 1.0 - 1.0 / 4096.0;

/// How far outwards the edges of fronts are moved, relative to the coordinates of a corner and of the eye
/// along the normal of the edge's plane, so that a ray that passes between two fronts by rounding alone meets
/// both: 16 units in the
/// last place (2^-24). A corner's own rounding takes up to 2 of them, that of its difference from the eye 2
/// to 7, and the products make that 10 to 30 if all err the same way from one end of a scene to the
/// other; a quarter of what is taken sufficed wherever measured. More would hide more of what is
/// behind: the sky in an opening is seen smaller by this on all sides.
pub const FRONT_FACE_OUTSET: f32 = 16.0 / 16_777_216.0;

/// The same for the rounding of an edge's plane q_i x q_j, relative to the factors' lengths: a unit in the
/// last place for each product, and one for their difference.
pub const PRODUCT_ULPS: f32 = 2.0 / 16_777_216.0;

/// The most that both together may move an edge, in pixels: what is so far away that its own coordinates
/// are less certain than that is not to grow by it.
pub const MOST_MARGIN: f32 = 1.0 / 256.0;

/// How much farther outwards edges are moved in what is rasterised, pixels: covers two corners that are
/// each rounded to 1/16 of a pixel, the coarsest that Vulkan allows (most have 1/256). What is covered in
/// vain is cut off pixel by pixel.
pub const RASTERISED_OUTSET: f32 = 1.0 / 16.0;

/// The least factor by which moving edges outwards may change the determinant of their vectors. In
/// front of the eye it grows; where it shrinks further, edges cross behind the eye, or nearly. That happens
/// to slivers only, which are then sought in the whole picture.
pub const MIN_GROWTH: f32 = 0.5;

/// By how much all corners of a surface must be beyond a face's border for it to be left out, relative to the
/// largest coordinates by axis, summed: corners in the face's axes are off by some 20 units in the last place
/// (2^-24) of that at most.
pub const CULLED_OUTSET: f32 = 64.0 / 16_777_216.0;

/// Threads of a workgroup: the most that every adapter offers.
pub const WORKGROUP_SIZE: u32 = 256;
/// Side of the block of pixels that a workgroup draws, a thread each.
pub const BLOCK_SIDE: u32 = WORKGROUP_SIZE.isqrt();
/// Consecutive pixels that one thread sums, runs of the same patch by one addition.
pub const PIXELS_PER_THREAD: u32 = 16;

/// A surface.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Surface {
    /// First corner, metres, relative to the scene's origin.
    pub corner_0: [f32; 3],
    /// First leaf of its bisection tree.
    pub first_patch: u32,
    /// Second corner, metres.
    pub corner_1: [f32; 3],
    /// Bisections down to a leaf.
    pub depth: u32,
    /// Third corner, metres.
    pub corner_2: [f32; 3],
    /// Fills the struct up to its alignment.
    pub padding: u32,
}

/// One of the five faces of a hemicube, as a picture. The vectors are in the scene's axes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Face {
    /// The eye, metres, relative to the scene's origin, rounded.
    pub eye_high: [f32; 3],
    /// Edge of the first row on the plane at distance 1, dimensionless.
    pub bottom: f32,
    /// What `eye_high` lacks.
    pub eye_low: [f32; 3],
    /// Height of the picture on the plane at distance 1, dimensionless.
    pub height: f32,
    /// Unit vector, direction of growing columns.
    pub right: [f32; 3],
    /// Column of the atlas where it starts, pixels.
    pub origin_x: f32,
    /// Unit vector, direction of growing rows.
    pub up: [f32; 3],
    /// Row of the atlas where it starts, pixels.
    pub origin_y: f32,
    /// Unit vector into the picture.
    pub forward: [f32; 3],
    /// First word of the bits that tell which surfaces rise above the horizon.
    pub horizon: u32,
}

/// What is the same for all faces.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct DrawSettings {
    /// Distance of the near plane, metres.
    pub near: f32,
    /// Distance of the eye from a surface's plane up to which it is seen edge-on at most, metres.
    pub plane_tolerance: f32,
    /// Side of a pixel on the plane at distance 1, dimensionless.
    pub pixel: f32,
    /// Pixels along a face.
    pub resolution: u32,
    /// Surfaces of the scene.
    pub surface_count: u32,
    /// Width of the atlas, pixels.
    pub atlas_width: f32,
    /// Height of the atlas, pixels.
    pub atlas_height: f32,
    /// Fills the struct up to its alignment.
    pub padding: u32,
}

/// A surface as one face sees it, made on the device and used there only. Its members are told in
/// `item_buffer.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
#[allow(missing_docs)] // Rust asks for its size alone
pub struct Projected {
    pub edge_0: [f32; 3],
    pub first_patch: u32,
    pub edge_1: [f32; 3],
    pub depth: u32,
    pub edge_2: [f32; 3],
    pub is_back_face: u32,
    pub margins: [f32; 3],
    pub face: u32,
    pub inverse_depth: [f32; 3],
    pub padding: u32,
    pub corner_0: [f32; 3],
    pub padding_0: u32,
    pub corner_1: [f32; 3],
    pub padding_1: u32,
    pub corner_2: [f32; 3],
    pub padding_2: u32,
}

/// Where a face's surfaces are among those of all faces.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Span {
    /// Its first.
    pub start: u32,
    /// After its last.
    pub end: u32,
}

/// What an indirect draw is told: WebGPU's own layout.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct DrawArguments {
    /// Three for each surface that a face sees, counted on the device.
    pub vertex_count: u32,
    /// One.
    pub instance_count: u32,
    /// None are left out.
    pub first_vertex: u32,
    /// None are left out.
    pub first_instance: u32,
}

/// A third of a hemicube's picture: R x R pixels of the atlas.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Tile {
    /// Column of the atlas where it starts, pixels.
    pub origin_x: u32,
    /// Row of the atlas where it starts, pixels.
    pub origin_y: u32,
    /// Row of sums that it adds to.
    pub row: u32,
    /// Where its delta form factors start.
    pub first_factor: u32,
    /// Pixels after which they repeat.
    pub factor_period: u32,
}

/// What is the same for all tiles and rows of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct MergeSettings {
    /// Pixels along a tile.
    pub resolution: u32,
    /// Patches of the scene; a row has two sums more, for nothing and for back faces.
    pub patch_count: u32,
    /// Words of 32 bits in a row, a bit for each patch.
    pub words_per_row: u32,
    /// Blocks of words in a row, each a workgroup's.
    pub blocks_per_row: u32,
    /// Rows of the batch.
    pub row_count: u32,
}

/// What is read back of a row besides its entries.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct RowSummary {
    /// Where the row's entries end in the batch's.
    pub end: u32,
    /// Share that sees nothing, in units.
    pub open: u32,
    /// Share that sees back faces, in units.
    pub back_face: u32,
}

/// An entry of a row, as the device counts it: [`crate::rows::Entry`] in whole units.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct CountedEntry {
    /// The patch that receives.
    pub patch: u32,
    /// Its form factor in units.
    pub units: u32,
}

/// The text of `projection.wgsl`, ready to compile.
pub fn projection_wgsl() -> String {
    with_constants(&[
        include_str!("inclusive_sum.wgsl"),
        include_str!("item_buffer.wgsl"),
        include_str!("projection.wgsl"),
    ])
}

/// The text of `raster_pipeline.wgsl`, ready to compile.
pub fn raster_pipeline_wgsl() -> String {
    let rest = with_constants(&[
        include_str!("item_buffer.wgsl"),
        include_str!("raster_pipeline.wgsl"),
    ]);
    format!("enable clip_distances;\n{rest}")
}

/// The text of `raster_compute.wgsl`, ready to compile.
pub fn raster_compute_wgsl() -> String {
    with_constants(&[
        include_str!("item_buffer.wgsl"),
        include_str!("raster_compute.wgsl"),
    ])
}

/// The text of `merger.wgsl`, ready to compile.
pub fn merger_wgsl() -> String {
    with_constants(&[
        include_str!("inclusive_sum.wgsl"),
        include_str!("merger.wgsl"),
    ])
}

fn with_constants(parts: &[&str]) -> String {
    let integers = [
        ("ALPHA_NOTHING", ALPHA_NOTHING.into()),
        ("ALPHA_BACK_FACE", ALPHA_BACK_FACE.into()),
        ("ALPHA_PATCH", ALPHA_PATCH.into()),
        ("NO_PATCH", NO_PATCH.0),
        ("WORKGROUP_SIZE", WORKGROUP_SIZE),
        ("BLOCK_SIDE", BLOCK_SIDE),
        ("PIXELS_PER_THREAD", PIXELS_PER_THREAD),
    ];
    integers
        .iter()
        .map(|(name, value)| format!("const {name}: u32 = {value}u;\n"))
        .chain([
            format!("const BACK_FACE_RETREAT: f32 = {BACK_FACE_RETREAT:?}f;\n"),
            format!("const MIN_GROWTH: f32 = {MIN_GROWTH:?}f;\n"),
            format!("const FRONT_FACE_OUTSET: f32 = {FRONT_FACE_OUTSET:?}f;\n"),
            format!("const PRODUCT_ULPS: f32 = {PRODUCT_ULPS:?}f;\n"),
            format!("const MOST_MARGIN: f32 = {MOST_MARGIN:?}f;\n"),
            format!("const RASTERISED_OUTSET: f32 = {RASTERISED_OUTSET:?}f;\n"),
            format!(
                "const COORDINATE_ULPS: f32 = {:?}f;\n",
                COORDINATE_ULPS as f32
            ),
            format!("const CULLED_OUTSET: f32 = {CULLED_OUTSET:?}f;\n"),
        ])
        .chain(parts.iter().map(|part| format!("{part}\n")))
        .collect()
}

#[cfg(test)]
mod tests;
