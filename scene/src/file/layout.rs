//! The records of the file format. All are plain little-endian data without padding.

#[cfg(target_endian = "big")]
compile_error!("files are read and written in place, which needs a little-endian machine");

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

/// The first bytes of every file.
pub const MAGIC: [u8; 8] = *b"RADIOSTY";
/// The same as text, for messages.
pub const MAGIC_TEXT: &str = "RADIOSTY";
/// The format this code reads and writes.
pub const VERSION: u32 = 1;
/// Sections start at multiples of this many bytes.
pub const ALIGNMENT: usize = 16;

/// The first 64 bytes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// [`VERSION`].
    pub version: u32,
    /// Number of entries in the section table.
    pub section_count: u32,
    /// Size of the whole file.
    pub file_bytes: u64,
    /// XXH3-64 of the whole file with this field zero.
    pub checksum: u64,
    /// What was subtracted from the model's coordinates, metres.
    pub origin: [f64; 3],
    /// Zero.
    pub reserved: u64,
}

/// One entry of the section table, which follows the header.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Section {
    /// One of the [`kind`]s.
    pub kind: u32,
    /// Size of one record, bytes.
    pub record_bytes: u32,
    /// Where it starts in the file, bytes.
    pub offset: u64,
    /// Number of records.
    pub count: u64,
    /// Zero.
    pub reserved: u64,
}

/// What a section holds.
pub mod kind {
    /// JSON of [`super::Names`].
    pub const NAMES: u32 = 1;
    /// [`super::MaterialRecord`]s.
    pub const MATERIALS: u32 = 2;
    /// [`super::SurfaceRecord`]s.
    pub const SURFACES: u32 = 3;
    /// JSON of [`crate::Provenance`].
    pub const PROVENANCE: u32 = 4;
    /// RGB irradiances.
    pub const IRRADIANCE: u32 = 5;
    /// RGB irradiances of an unfinished iteration.
    pub const UNFINISHED: u32 = 6;
    /// RGB unshot radiosities.
    pub const UNSHOT: u32 = 7;
    /// RGB remainders of irradiances.
    pub const REMAINDER: u32 = 8;
}

/// Names of materials and objects, in their order.
#[derive(Debug, Serialize, Deserialize)]
pub struct Names {
    /// One per material.
    pub materials: Vec<String>,
    /// One per object.
    pub objects: Vec<String>,
}

/// A material but for its name.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct MaterialRecord {
    /// Dimensionless.
    pub reflectance: [f32; 3],
    /// W/m^2.
    pub emission: [f32; 3],
}

/// A surface and the depth of its bisection tree.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct SurfaceRecord {
    /// Metres, relative to the origin.
    pub corners: [[f32; 3]; 3],
    /// Index.
    pub material: u32,
    /// Index.
    pub object: u32,
    /// Depth of the uniform bisection tree.
    pub bisections: u32,
}
