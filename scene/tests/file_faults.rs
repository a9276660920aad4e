//! Every fault that the frame of a file can have ends in a clear error: none panics, none is taken for a scene.

mod common;

use common::damage::{
    CHECKSUM, COUNT, FILE_BYTES, FLAGS, HEADER_BYTES, OFFSET, RECORD_BYTES, SECTION_COUNT, VERSION,
    entry, fault_of, padded, patch, seal, sections, small_file, small_files,
};
use common::{checked_message, folder, write};
use scene::file::{FileFault, from_bytes, load, to_bytes};

#[test]
fn the_untouched_file_is_valid_and_sealing_changes_nothing() {
    let bytes = small_file();
    from_bytes(&bytes).unwrap();
    assert_eq!(seal(bytes.clone()), bytes);
}

#[test]
fn missing_file_is_named() {
    let path = folder().path().join("none.rad");
    let error = load(&path).unwrap_err();
    let message = checked_message(&error, &path);
    assert!(message.contains("cannot read"), "{message}");
}

#[test]
fn folder_in_place_of_a_file_is_an_error() {
    let folder = folder();
    let error = load(folder.path()).unwrap_err();
    checked_message(&error, folder.path());
    assert!(matches!(error.fault, FileFault::Io { .. }));
}

#[test]
fn empty_file_is_called_empty() {
    let folder = folder();
    let path = write(&folder, "a.rad", "");
    let error = load(&path).unwrap_err();
    checked_message(&error, &path);
    assert!(matches!(error.fault, FileFault::Empty));
}

#[test]
fn truncation_at_every_length_is_an_error() {
    let bytes = small_file();
    let folder = folder();
    for length in 1..bytes.len() {
        let fault = fault_of(&bytes[..length]);
        assert!(
            matches!(fault, FileFault::Truncated { found, .. } if found == length as u64),
            "{length}: {fault}"
        );
        let path = write(&folder, "a.rad", &bytes[..length]);
        let error = load(&path).unwrap_err();
        assert!(matches!(error.fault, FileFault::Truncated { .. }));
    }
}

#[test]
fn truncation_that_the_header_agrees_with_is_an_error() {
    let bytes = small_file();
    for length in HEADER_BYTES..bytes.len() {
        let mut short = bytes[..length].to_vec();
        patch(&mut short, FILE_BYTES, &(length as u64).to_le_bytes());
        let fault = fault_of(&seal(short));
        assert!(
            matches!(fault, FileFault::Structure { .. }),
            "{length}: {fault}"
        );
    }
}

#[test]
fn bytes_after_the_end_are_an_error() {
    let mut bytes = small_file();
    bytes.extend([0; 5]);
    assert!(matches!(
        fault_of(&bytes),
        FileFault::TrailingBytes { extra: 5 }
    ));
}

#[test]
fn flip_of_every_single_bit_is_an_error() {
    let bytes = small_file();
    for bit in 0..8 * bytes.len() {
        let mut flipped = bytes.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        let fault = fault_of(&flipped);
        let expected = match bit / 8 {
            0..VERSION => matches!(fault, FileFault::Magic),
            VERSION..SECTION_COUNT => matches!(fault, FileFault::Version { .. }),
            FILE_BYTES..CHECKSUM => matches!(
                fault,
                FileFault::Truncated { .. } | FileFault::TrailingBytes { .. }
            ),
            _ => matches!(fault, FileFault::Checksum { .. }),
        };
        assert!(expected, "bit {bit}: {fault}");
    }
}

#[test]
fn sealed_flip_of_every_single_bit_never_panics() {
    for bytes in small_files() {
        let mut accepted = 0;
        for bit in 0..8 * bytes.len() {
            let mut flipped = bytes.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            if let Ok((scene, solution)) = from_bytes(&seal(flipped)) {
                // What is accepted is valid in every part, and so can be saved and read again.
                accepted += 1;
                let again = from_bytes(&to_bytes(&scene, solution.as_ref())).unwrap();
                assert_eq!(again, (scene, solution));
            }
        }
        // A value may change to another valid one, so some are accepted.
        assert!(0 < accepted && accepted < 8 * bytes.len());
    }
}

#[test]
fn other_files_are_told_from_their_first_bytes() {
    assert!(matches!(fault_of(b"\x89PNG\r\n\x1a\n"), FileFault::Magic));
    assert!(matches!(fault_of(b"# obj"), FileFault::Magic));
    assert!(matches!(fault_of(&[0; 10_000]), FileFault::Magic));
}

#[test]
fn later_version_is_an_error_even_if_its_sizes_differ() {
    let mut bytes = small_file();
    patch(&mut bytes, VERSION, &3_u32.to_le_bytes());
    bytes.truncate(100);
    let fault = fault_of(&bytes);
    assert!(matches!(fault, FileFault::Version { found: 3 }));
    let message = fault.to_string();
    assert!(
        message.contains("version 3") && message.contains("newer version of the toolkit"),
        "{message}"
    );
}

#[test]
fn counts_of_terabytes_are_refused_before_anything_is_allocated() {
    let bytes = small_file();
    let counts = [
        1 << 40,
        u64::MAX,
        u64::MAX / 12,
        u64::MAX / 48 + 1,
        1 << 32,
        1 << 63,
    ];
    for bytes in small_files() {
        for name in sections(&bytes) {
            for count in counts {
                for field in [COUNT, OFFSET] {
                    let mut bytes = bytes.clone();
                    let at = entry(&bytes, &name) + field;
                    // A multiple of 16, so that offsets do not fail for their alignment.
                    patch(&mut bytes, at, &(count & !15).to_le_bytes());
                    let fault = fault_of(&seal(bytes));
                    assert!(
                        matches!(fault, FileFault::Structure { .. }),
                        "{name} {count}: {fault}"
                    );
                }
            }
        }
    }
    for count in [1 << 20, u32::MAX] {
        let mut bytes = bytes.clone();
        patch(&mut bytes, SECTION_COUNT, &count.to_le_bytes());
        assert!(matches!(
            fault_of(&seal(bytes)),
            FileFault::Structure { .. }
        ));
    }
    for size in [1 << 40, u64::MAX] {
        let mut bytes = bytes.clone();
        patch(&mut bytes, FILE_BYTES, &u64::to_le_bytes(size));
        let bytes = seal(bytes);
        assert!(
            matches!(fault_of(&bytes), FileFault::Truncated { expected, .. } if expected == size)
        );
        let folder = folder();
        let path = write(&folder, "a.rad", &bytes);
        assert!(matches!(
            load(&path).unwrap_err().fault,
            FileFault::Truncated { .. }
        ));
    }
}

#[test]
fn sections_that_are_missing_misplaced_or_of_other_records_are_errors() {
    for bytes in small_files() {
        for name in sections(&bytes) {
            let at = entry(&bytes, &name);
            let mut missing = bytes.clone();
            patch(&mut missing, at, &padded("another"));
            patch(&mut missing, at + FLAGS, &[0]);
            // A scene without a solution is one, as are a solution that nothing is under way of, and one whose
            // surfaces have faces by their numbers, of which no patch is known to lie inside of a solid and no opening to
            // be meant. Without vertices there is no function, and its error need not be known.
            let may_miss = [
                "irradiance",
                "unfinished",
                "faces",
                "inside",
                "openings",
                "axes",
                "vertices",
                "patch-error",
            ];
            let may_miss = may_miss.contains(&&name[..]);
            assert_eq!(from_bytes(&seal(missing)).is_ok(), may_miss, "{name}");
            let mut odd_records = bytes.clone();
            patch(&mut odd_records, at + RECORD_BYTES, &7_u32.to_le_bytes());
            assert!(matches!(
                fault_of(&seal(odd_records)),
                FileFault::Structure { .. }
            ));
            let mut unaligned = bytes.clone();
            unaligned[at + OFFSET] += 1;
            assert!(matches!(
                fault_of(&seal(unaligned)),
                FileFault::Structure { .. }
            ));
        }
    }
}
