//! Files of other versions of the toolkit: later sections are skipped or refused, files of version 1 are read.

mod common;

use common::{checked_message, folder, small_scene, small_solution, write};
use scene::file::{FileFault, from_bytes, load, to_bytes};
use scene::{Provenance, Solution};
use twox_hash::XxHash3_64;

const HEADER_BYTES: usize = 64;
const ENTRY_BYTES: usize = 40;
const SECTION_COUNT: usize = 12;
const FILE_BYTES: usize = 16;
const CHECKSUM: usize = 24;
const OFFSET: usize = 24;

/// A file with one section more, of the name "later", as a later program would write it.
fn with_later_section(flags: u32) -> Vec<u8> {
    let scene = small_scene();
    let mut bytes = to_bytes(&scene, Some(&small_solution(&scene)));
    let count = u32::from_le_bytes(bytes[SECTION_COUNT..][..4].try_into().unwrap());
    // Sections stay at multiples of 16.
    let more = 48;
    for k in 0..count as usize {
        let at = HEADER_BYTES + k * ENTRY_BYTES + OFFSET;
        let offset = u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap());
        bytes[at..at + 8].copy_from_slice(&(offset + more).to_le_bytes());
    }
    let mut entry = b"later\0\0\0\0\0\0\0\0\0\0\0".to_vec();
    entry.extend(1_u32.to_le_bytes());
    entry.extend(flags.to_le_bytes());
    let end = bytes.len() as u64 + more;
    entry.extend(end.next_multiple_of(16).to_le_bytes());
    entry.extend(3_u64.to_le_bytes());
    entry.resize(more as usize, 0);
    let at = HEADER_BYTES + count as usize * ENTRY_BYTES;
    bytes.splice(at..at, entry);
    bytes.resize(bytes.len().next_multiple_of(16), 0);
    bytes.extend(b"new");
    bytes[SECTION_COUNT..][..4].copy_from_slice(&(count + 1).to_le_bytes());
    let size = bytes.len() as u64;
    bytes[FILE_BYTES..][..8].copy_from_slice(&size.to_le_bytes());
    bytes[CHECKSUM..][..8].fill(0);
    let checksum = XxHash3_64::oneshot(&bytes);
    bytes[CHECKSUM..][..8].copy_from_slice(&checksum.to_le_bytes());
    bytes
}

#[test]
fn unknown_section_that_is_not_marked_is_skipped() {
    let scene = small_scene();
    let solution = small_solution(&scene);
    let read = from_bytes(&with_later_section(0)).unwrap();
    assert_eq!(read, (scene, Some(solution)));
}

#[test]
fn unknown_section_that_is_marked_is_refused_by_its_name_and_with_the_remedy() {
    let folder = folder();
    let path = write(&folder, "a.rad", with_later_section(1));
    let error = load(&path).unwrap_err();
    let message = checked_message(&error, &path);
    assert!(matches!(error.fault, FileFault::UnknownSection { .. }));
    assert!(
        message.contains("\"later\"") && message.contains("use a newer version of the toolkit"),
        "{message}"
    );
}

#[test]
fn unknown_flags_are_refused_whatever_their_section_is() {
    for flags in [2, 3, 1 << 31] {
        let fault = from_bytes(&with_later_section(flags)).unwrap_err();
        let unknown = flags & !1;
        assert!(
            matches!(&fault, FileFault::UnknownFlags { section, flags } if section == "\"later\"" && *flags == unknown),
            "{fault}"
        );
    }
}

/// See `data/README.md`.
const VERSION_1: &[u8] = include_bytes!("data/version-1.rad");

#[test]
fn file_of_version_1_has_its_scene_and_a_start() {
    let (scene, solution) = from_bytes(VERSION_1).unwrap();
    assert_eq!(scene.patch_count(), 12);
    assert_eq!(scene.surfaces().len(), 12);
    let numbers: Vec<u32> = (0..12).collect();
    assert_eq!(scene.faces(), numbers);
    assert_eq!(scene.objects(), ["wall"]);
    assert!((scene.area() - 6.0).abs() < 1e-6);
    let solution = solution.unwrap();
    // Three patches have shot.
    assert!(solution.irradiance.iter().any(|h| h.x > 0.1));
    let start = Solution {
        irradiance: solution.irradiance.clone(),
        provenance: Provenance {
            iterations: 3,
            ..Provenance::default()
        },
        ..Solution::dark(&scene)
    };
    assert_eq!(solution, start);
    // Written again it is of the newest version, and says the same.
    let again = to_bytes(&scene, Some(&solution));
    assert_eq!(again[8..12], 2_u32.to_le_bytes());
    assert_eq!(from_bytes(&again).unwrap(), (scene, Some(solution)));
}

#[test]
fn truncation_of_a_file_of_version_1_at_every_length_is_an_error() {
    for length in 0..VERSION_1.len() {
        from_bytes(&VERSION_1[..length]).unwrap_err();
    }
}

#[test]
fn sealed_flip_of_every_single_bit_of_a_file_of_version_1_never_panics() {
    for bit in 0..8 * VERSION_1.len() {
        let mut flipped = VERSION_1.to_vec();
        flipped[bit / 8] ^= 1 << (bit % 8);
        flipped[CHECKSUM..][..8].fill(0);
        let checksum = XxHash3_64::oneshot(&flipped);
        flipped[CHECKSUM..][..8].copy_from_slice(&checksum.to_le_bytes());
        if let Ok((scene, solution)) = from_bytes(&flipped) {
            from_bytes(&to_bytes(&scene, solution.as_ref())).unwrap();
        }
    }
}
