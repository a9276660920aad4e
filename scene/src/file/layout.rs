//! The records of the file format. All are plain little-endian data without padding.

#[cfg(target_endian = "big")]
compile_error!("files are read and written in place, which needs a little-endian machine");

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

use crate::layers::{Lamp, LayerKind};

/// The first bytes of every file.
pub const MAGIC: [u8; 8] = *b"RADIOSTY";
/// The same as text, for messages.
pub const MAGIC_TEXT: &str = "RADIOSTY";
/// The format that this code writes. It reads this one and all before it.
pub const VERSION: u32 = 2;
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
    /// What the section holds.
    pub name: SectionName,
    /// Size of one record, bytes.
    pub record_bytes: u32,
    /// [`REQUIRED`] or nothing.
    pub flags: u32,
    /// Where it starts in the file, bytes.
    pub offset: u64,
    /// Number of records.
    pub count: u64,
}

/// The flag of a section that a reader must know: what it would read without is not what was written.
pub const REQUIRED: u32 = 1 << 0;

/// A section's name: 1 to 16 visible ASCII characters, then zeros.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub struct SectionName([u8; 16]);

impl SectionName {
    /// JSON of [`Names`].
    pub const NAMES: Self = Self::new("names");
    /// [`MaterialRecord`]s.
    pub const MATERIALS: Self = Self::new("materials");
    /// [`SurfaceRecord`]s.
    pub const SURFACES: Self = Self::new("surfaces");
    /// u32 numbers of faces.
    pub const FACES: Self = Self::new("faces");
    /// u32 numbers of the patches inside of solids; not there where none is known.
    pub const INSIDE: Self = Self::new("inside");
    /// [`OpeningRecord`]s; not there where none is known.
    pub const OPENINGS: Self = Self::new("openings");
    /// JSON of [`crate::ModelAxes`]; not there where they are metres and nothing else is known.
    pub const AXES: Self = Self::new("axes");
    /// JSON of [`crate::Provenance`].
    pub const PROVENANCE: Self = Self::new("provenance");
    /// RGB irradiances.
    pub const IRRADIANCE: Self = Self::new("irradiance");
    /// RGB irradiances that patches have gathered from sources.
    pub const GATHERED: Self = Self::new("gathered");
    /// RGB irradiances of an unfinished iteration.
    pub const UNFINISHED: Self = Self::new("unfinished");
    /// RGB unshot radiosities.
    pub const UNSHOT: Self = Self::new("unshot");
    /// RGB remainders of irradiances.
    pub const REMAINDER: Self = Self::new("remainder");

    /// u32 indices of surfaces' nodes in an irradiance function's mesh.
    pub const FUNCTION_ROOTS: Self = Self::new("function-roots");
    /// [`crate::function::Node`]s.
    pub const FUNCTION_NODES: Self = Self::new("function-nodes");
    /// [`VertexRecord`]s.
    pub const VERTICES: Self = Self::new("vertices");
    /// f32 estimates of an irradiance function's error; not there where there are none.
    pub const PATCH_ERROR: Self = Self::new("patch-error");

    /// JSON of [`LayerNames`]; not there where there are no layers.
    pub const LAYERS: Self = Self::new("layers");
    /// RGB irradiances of the patches, one layer after the other.
    pub const LAYER_IRRADIANCE: Self = Self::new("layer-irradiance");
    /// [`LayerVertexRecord`]s, one layer after the other.
    pub const LAYER_VERTICES: Self = Self::new("layer-vertices");

    /// All that this code knows.
    const ALL: [Self; 20] = [
        Self::NAMES,
        Self::MATERIALS,
        Self::SURFACES,
        Self::FACES,
        Self::INSIDE,
        Self::OPENINGS,
        Self::AXES,
        Self::PROVENANCE,
        Self::IRRADIANCE,
        Self::GATHERED,
        Self::UNFINISHED,
        Self::UNSHOT,
        Self::REMAINDER,
        Self::FUNCTION_ROOTS,
        Self::FUNCTION_NODES,
        Self::VERTICES,
        Self::PATCH_ERROR,
        Self::LAYERS,
        Self::LAYER_IRRADIANCE,
        Self::LAYER_VERTICES,
    ];

    const fn new(name: &str) -> Self {
        let (name, mut bytes) = (name.as_bytes(), [0; 16]);
        let mut k = 0;
        while k < name.len() {
            bytes[k] = name[k];
            k += 1;
        }
        Self(bytes)
    }

    /// Whether this code knows what such a section holds.
    pub fn is_known(self) -> bool {
        Self::ALL.contains(&self)
    }

    /// Whether a file may have a section of this name.
    pub fn is_valid(self) -> bool {
        let end = self.0.iter().position(|&byte| byte == 0);
        let (name, padding) = self.0.split_at(end.unwrap_or(self.0.len()));
        !name.is_empty()
            && name.iter().all(u8::is_ascii_graphic)
            && padding.iter().all(|&byte| byte == 0)
    }
}

impl std::fmt::Display for SectionName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let name = self.0.split(|&byte| byte == 0).next().unwrap_or_default();
        write!(f, "\"{}\"", name.escape_ascii())
    }
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

/// A triangle that was taken out of the model on purpose.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct OpeningRecord {
    /// Metres, relative to the origin.
    pub corners: [[f32; 3]; 3],
    /// Index.
    pub object: u32,
}

/// A vertex of an irradiance function's mesh.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct VertexRecord {
    /// Metres, relative to the origin.
    pub position: [f32; 3],
    /// W/m^2.
    pub irradiance: [f32; 3],
    /// W/m^2.
    pub direct: [f32; 3],
}

/// What layers are.
#[derive(Debug, Serialize, Deserialize)]
pub struct LayerNames {
    /// Of what.
    pub kind: LayerKind,
    /// One per layer.
    pub names: Vec<String>,
    /// What emits in each, where they are of lamps; else empty.
    pub lamps: Vec<Lamp>,
}

/// A layer's light at a vertex.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct LayerVertexRecord {
    /// W/m^2.
    pub irradiance: [f32; 3],
    /// W/m^2.
    pub direct: [f32; 3],
}
