//! The one kind of file: a scene, with or without a solution.
//!
//! Any result is a valid input again, and a checkpoint is such a file.
//!
//! # Layout
//! Everything is little-endian. The source file `layout.rs` has the records field by field. A
//! header of 64 bytes, then the table of sections, then the sections themselves, each an array of
//! plain records at an offset that is a multiple of 16, so that a mapped file can be read in place.
//! An entry of the table has the section's name, ASCII, and flags; the order is free:
//!
//! | section | record | count |
//! |---|---|---|
//! | names* | JSON: names of materials and of objects | bytes |
//! | materials* | 6 f32: reflectance; emission, W/m^2 | materials |
//! | surfaces* | 9 f32: corners, metres; 3 u32: material, object, bisections | surfaces |
//! | faces | u32: triangle of the imported file | surfaces |
//! | inside | u32: patches inside of solids, ascending | as many as are known |
//! | openings | 9 f32: corners, metres; u32: object; triangles taken out of the model on purpose | as many as are known |
//! | provenance | JSON: [`crate::Provenance`] | bytes |
//! | irradiance | 3 f32, W/m^2 | patches |
//! | gathered | 3 f32, W/m^2 | patches done |
//! | unfinished | 3 f32, W/m^2 | patches done |
//! | unshot | 3 f32, W/m^2 | patches |
//! | remainder | 3 f32, W/m^2 | patches |
//! | function-roots | u32: the node of each surface, 2^32 - 1 where it has none | surfaces |
//! | function-nodes | 3 u32: vertices; u32: first child, 0 for a leaf | nodes |
//! | vertices | 9 f32: position, metres; irradiance and the direct part of it, W/m^2 | vertices |
//! | patch-error | f32: estimate of the function's error, W/m^2 | patches |
//! | layers | JSON: what the layers are | bytes |
//! | layer-irradiance | 3 f32, W/m^2, layer by layer | layers x patches |
//! | layer-vertices | 6 f32: irradiance and the direct part of it, W/m^2, layer by layer | layers x vertices |
//!
//! Where there are no faces, a surface's is its number. Provenance and irradiance are there where there is a
//! solution, those of the function where it has an [`crate::function::IrradianceFunction`], but patch-error only where its error has been
//! estimated, those of layers where it has [`crate::layers::Layers`], the others where its [`crate::Level`] or its [`crate::State`] has them. The header's
//! checksum (XXH3, 64 bits) covers every other byte of the file.
//!
//! # Growth
//! Bit 0 of an entry's flags, the * of the table, marks what a reader must know. A reader that meets
//! an unknown section so marked refuses the file and names it; one that is not marked is skipped.
//!
//! - *A section is added* for whatever a file is to say more: faces, layers, caches. A program that
//!   does not know it goes on as it did. Records do not grow: what belongs to a surface or a patch
//!   and is new gets an array of its own, and what changes its meaning gets another name. JSON may
//!   get fields, which old programs do not see and new ones do not need.
//! - *It is marked* where what is left without it is wrong, not only less: a mesh whose patches are
//!   numbered in another way, irradiances that are to be added to others. Most are not.
//! - *The version rises* where an old program could not even find the sections or tell what it must
//!   know: another header, another table, another checksum. It refuses the file by its version.
//! - *Every older version is read*, by a module of its own that gives the table of the newest one
//!   (`version_1.rs`), and none is written.
//!
//! Other flags than bit 0 are not used. One that is set changes how its section, known or not, is to be
//! read, so it refuses the file too, as do two sections of one name.
//!
//! # Safety of what is on disk
//! Reading checks sizes before allocating anything, and every value before returning it. Writing
//! goes to a temporary name in the same folder, is synced, and renamed over the old file, so the
//! name always holds one whole file. [`OutputLock`] keeps a second program from the same name.

mod identity;
mod layout;
mod lock;
mod read;
mod table;
mod version_1;
mod write;

use std::path::{Path, PathBuf};

pub use identity::is_same_file;
pub use lock::OutputLock;
pub use read::{from_bytes, load};
pub use write::{save, to_bytes, write_atomically};

use crate::SceneError;

/// Why a file could not be read or written.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct FileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    pub fault: FileFault,
}

impl FileError {
    pub(crate) fn new(path: &Path, fault: impl Into<FileFault>) -> Self {
        Self {
            path: path.to_owned(),
            fault: fault.into(),
        }
    }
}

/// What can be wrong with a file.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum FileFault {
    #[error("cannot {action}: {source}")]
    Io {
        action: &'static str,
        source: std::io::Error,
    },
    #[error("the file is read-only; make it writable, or choose another name")]
    ReadOnly,
    #[error("the file is empty")]
    Empty,
    #[error(
        "not a radiosity file (it does not start with {:?}); make one with genx",
        layout::MAGIC_TEXT
    )]
    Magic,
    #[error(
        "version {found} of the format is not supported, this program reads 1 to {}; use a newer version of the toolkit",
        layout::VERSION
    )]
    Version { found: u32 },
    #[error(
        "the file has a section {section}, which a reader must know and this program does not; use a newer version of the toolkit"
    )]
    UnknownSection { section: String },
    #[error(
        "section {section} has flags {flags:#x}, which this program does not know; use a newer version of the toolkit"
    )]
    UnknownFlags { section: String, flags: u32 },
    #[error("truncated: {found} bytes, expected {expected}")]
    Truncated { found: u64, expected: u64 },
    #[error("{extra} bytes follow the end of the file's data")]
    TrailingBytes { extra: u64 },
    #[error("damaged: checksum {found:016x}, expected {expected:016x}")]
    Checksum { found: u64, expected: u64 },
    #[error("damaged: {what}")]
    Structure { what: String },
    #[error("{colors} colours for {patches} patches")]
    ColorCount { colors: usize, patches: u32 },
    #[error(
        "it is there and no export has written it, so it is not replaced; choose another name for the .obj, or move the .mtl away"
    )]
    ForeignMaterials,
    #[error("another program is writing this file (it holds {})", lock.display())]
    Locked { lock: PathBuf },
    #[error(transparent)]
    Scene(#[from] SceneError),
}
