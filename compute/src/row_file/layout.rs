//! The records of a row file. All are plain little-endian data without padding.

use std::hash::Hasher;

use bytemuck::{Pod, Zeroable};
use twox_hash::XxHash3_64;

/// The first bytes of every row file.
pub const MAGIC: [u8; 8] = *b"RADIROWS";
/// The same as text, for messages.
pub const MAGIC_TEXT: &str = "RADIROWS";
/// The only version there is. It rises whenever an old program would take rows for what they are not: another
/// layout, another field of the identity.
pub const VERSION: u32 = 1;
/// Identities are not longer than this, bytes.
pub const MAX_IDENTITY_BYTES: u32 = 1 << 16;

/// The first bytes of a record.
pub const RECORD_MAGIC: [u8; 4] = *b"rows";

/// The first 24 bytes. The identity follows.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Header {
    /// [`MAGIC`].
    pub magic: [u8; 8],
    /// [`VERSION`].
    pub version: u32,
    /// Length of the identity.
    pub identity_bytes: u32,
    /// XXH3-64 of this header with this field zero, then of the identity.
    pub checksum: u64,
}

impl Header {
    /// The header of this identity.
    pub fn new(identity: &[u8]) -> Self {
        let header = Self {
            magic: MAGIC,
            version: VERSION,
            identity_bytes: identity.len() as u32,
            checksum: 0,
        };
        let checksum = checksum(&[bytemuck::bytes_of(&header), identity]);
        Self { checksum, ..header }
    }
}

/// The first 48 bytes of a record. Its body follows.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct RecordHeader {
    /// [`RECORD_MAGIC`].
    pub magic: [u8; 4],
    /// Number of the block.
    pub block: u32,
    /// Bit k: the body has the row of the block's k-th receiver.
    pub drawn: u64,
    /// Bit k: that row was left out as unlit. No bit is in both.
    pub unlit: u64,
    /// Length of the body.
    pub body_bytes: u64,
    /// XXH3-64 of the body.
    pub body_checksum: u64,
    /// XXH3-64 of this header with this field zero.
    pub checksum: u64,
}

impl RecordHeader {
    /// The header of this body.
    pub fn new(block: u32, drawn: u64, unlit: u64, body: &[u8]) -> Self {
        let header = Self {
            magic: RECORD_MAGIC,
            block,
            drawn,
            unlit,
            body_bytes: body.len() as u64,
            body_checksum: checksum(&[body]),
            checksum: 0,
        };
        Self {
            checksum: header.expected_checksum(),
            ..header
        }
    }

    /// True where the header is as it was written.
    pub fn is_whole(&self) -> bool {
        self.magic == RECORD_MAGIC && self.checksum == self.expected_checksum()
    }

    /// What [`Self::checksum`] is where the header is whole.
    pub fn expected_checksum(&self) -> u64 {
        let unsigned = Self {
            checksum: 0,
            ..*self
        };
        checksum(&[bytemuck::bytes_of(&unsigned)])
    }
}

/// What a body says of a row.
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[repr(C)]
pub struct RowRecord {
    /// See [`crate::rows::Unseen`].
    pub open: u32,
    /// See [`crate::rows::Unseen`].
    pub back_face: u32,
    /// How many block headers it has.
    pub headers: u32,
    /// How many numbers it has.
    pub numbers: u32,
}

/// XXH3-64 of some bytes, one part after the other.
pub fn checksum(parts: &[&[u8]]) -> u64 {
    let mut hasher = XxHash3_64::new();
    for part in parts {
        hasher.write(part);
    }
    hasher.finish()
}
