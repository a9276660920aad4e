//! Files of small scenes, and damage done to them byte by byte.

use scene::file::{FileFault, from_bytes, to_bytes};
use scene::{Axis, ModelAxes};
use twox_hash::XxHash3_64;

use super::{small_scene, small_shooting_solution, small_solution};

pub const HEADER_BYTES: usize = 64;
pub const SECTION_BYTES: usize = 40;
pub const VERSION: usize = 8;
pub const SECTION_COUNT: usize = 12;
pub const FILE_BYTES: usize = 16;
pub const CHECKSUM: usize = 24;
pub const ORIGIN: usize = 32;
// In an entry of the section table.
pub const RECORD_BYTES: usize = 16;
pub const FLAGS: usize = 20;
pub const OFFSET: usize = 24;
pub const COUNT: usize = 32;

pub fn small_file() -> Vec<u8> {
    let scene = small_scene();
    to_bytes(&scene, Some(&small_solution(&scene)))
}

/// The same, and one of another solver: together they have every section.
pub fn small_files() -> [Vec<u8>; 2] {
    let axes = ModelAxes {
        unit: 0.001,
        up: Some(Axis::Z),
    };
    let scene = small_scene().with_axes(axes).unwrap();
    let shooting = to_bytes(&scene, Some(&small_shooting_solution(&scene)));
    [small_file(), shooting]
}

/// Names of all sections.
pub fn sections(bytes: &[u8]) -> Vec<String> {
    let count = u32::from_le_bytes(bytes[SECTION_COUNT..][..4].try_into().unwrap());
    (0..count as usize)
        .map(|k| {
            let name = &bytes[HEADER_BYTES + k * SECTION_BYTES..][..16];
            let end = name.iter().position(|&byte| byte == 0).unwrap();
            String::from_utf8(name[..end].to_vec()).unwrap()
        })
        .collect()
}

pub fn patch(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

/// Makes the checksum right again, as someone who means harm would.
pub fn seal(mut bytes: Vec<u8>) -> Vec<u8> {
    patch(&mut bytes, CHECKSUM, &[0; 8]);
    let checksum = XxHash3_64::oneshot(&bytes);
    patch(&mut bytes, CHECKSUM, &checksum.to_le_bytes());
    bytes
}

/// Where the table entry of a section starts.
pub fn entry(bytes: &[u8], name: &str) -> usize {
    (0..sections(bytes).len())
        .map(|i| HEADER_BYTES + i * SECTION_BYTES)
        .find(|&at| bytes[at..at + 16] == padded(name))
        .unwrap()
}

/// A section's name as it is in the table.
pub fn padded(name: &str) -> [u8; 16] {
    let mut padded = [0; 16];
    padded[..name.len()].copy_from_slice(name.as_bytes());
    padded
}

/// Where the data of a section starts.
pub fn data(bytes: &[u8], name: &str) -> usize {
    let at = entry(bytes, name) + OFFSET;
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize
}

pub fn fault_of(bytes: &[u8]) -> FileFault {
    from_bytes(bytes).expect_err("the file is damaged")
}
