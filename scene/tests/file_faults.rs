//! Every fault a file can have ends in a clear error: none panics, none is taken for a scene.

mod common;

use common::{
    checked_message, folder, small_scene, small_shooting_solution, small_solution, write,
};
use scene::file::{FileFault, from_bytes, load, to_bytes};
use scene::{Level, MAX_PATCHES, Rgb, SceneError, Solution, State};
use twox_hash::XxHash3_64;

const HEADER_BYTES: usize = 64;
const SECTION_BYTES: usize = 40;
const VERSION: usize = 8;
const SECTION_COUNT: usize = 12;
const FILE_BYTES: usize = 16;
const CHECKSUM: usize = 24;
const ORIGIN: usize = 32;
// In an entry of the section table.
const RECORD_BYTES: usize = 16;
const FLAGS: usize = 20;
const OFFSET: usize = 24;
const COUNT: usize = 32;

fn small_file() -> Vec<u8> {
    let scene = small_scene();
    to_bytes(&scene, Some(&small_solution(&scene)))
}

/// The same, and one of another solver: together they have every section.
fn small_files() -> [Vec<u8>; 2] {
    let scene = small_scene();
    let shooting = to_bytes(&scene, Some(&small_shooting_solution(&scene)));
    [small_file(), shooting]
}

/// Names of all sections.
fn sections(bytes: &[u8]) -> Vec<String> {
    let count = u32::from_le_bytes(bytes[SECTION_COUNT..][..4].try_into().unwrap());
    (0..count as usize)
        .map(|k| {
            let name = &bytes[HEADER_BYTES + k * SECTION_BYTES..][..16];
            let end = name.iter().position(|&byte| byte == 0).unwrap();
            String::from_utf8(name[..end].to_vec()).unwrap()
        })
        .collect()
}

fn patch(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

/// Makes the checksum right again, as someone who means harm would.
fn seal(mut bytes: Vec<u8>) -> Vec<u8> {
    patch(&mut bytes, CHECKSUM, &[0; 8]);
    let checksum = XxHash3_64::oneshot(&bytes);
    patch(&mut bytes, CHECKSUM, &checksum.to_le_bytes());
    bytes
}

/// Where the table entry of a section starts.
fn entry(bytes: &[u8], name: &str) -> usize {
    (0..sections(bytes).len())
        .map(|i| HEADER_BYTES + i * SECTION_BYTES)
        .find(|&at| bytes[at..at + 16] == padded(name))
        .unwrap()
}

/// A section's name as it is in the table.
fn padded(name: &str) -> [u8; 16] {
    let mut padded = [0; 16];
    padded[..name.len()].copy_from_slice(name.as_bytes());
    padded
}

/// Where the data of a section starts.
fn data(bytes: &[u8], name: &str) -> usize {
    let at = entry(bytes, name) + OFFSET;
    u64::from_le_bytes(bytes[at..at + 8].try_into().unwrap()) as usize
}

fn fault_of(bytes: &[u8]) -> FileFault {
    from_bytes(bytes).expect_err("the file is damaged")
}

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
            // surfaces have faces by their numbers.
            let may_miss = ["irradiance", "unfinished", "faces"].contains(&&name[..]);
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

#[test]
fn values_out_of_range_are_errors_in_every_array() {
    let [bytes, shooting] = small_files();
    let with = |name, float: usize, value: f32| {
        let is_shot = ["unshot", "remainder"].contains(&name);
        let mut bytes = if is_shot { &shooting } else { &bytes }.clone();
        let at = data(&bytes, name) + 4 * float;
        patch(&mut bytes, at, &value.to_le_bytes());
        fault_of(&seal(bytes))
    };
    let infinities = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY];
    for value in infinities {
        for float in 0..9 {
            let fault = with("surfaces", float, value);
            assert!(
                matches!(
                    fault,
                    FileFault::Scene(SceneError::Coordinate { surface: 0, .. })
                ),
                "{fault}"
            );
        }
    }
    for value in infinities.into_iter().chain([1.0, 1.5, -0.1]) {
        for float in 0..3 {
            let fault = with("materials", float, value);
            assert!(
                matches!(fault, FileFault::Scene(SceneError::Reflectance { .. })),
                "{fault}"
            );
        }
    }
    for value in infinities.into_iter().chain([-1.0, -1e-30]) {
        for float in 3..6 {
            let fault = with("materials", float, value);
            assert!(
                matches!(fault, FileFault::Scene(SceneError::Emission { .. })),
                "{fault}"
            );
        }
        for name in [
            "irradiance",
            "gathered",
            "unfinished",
            "unshot",
            "remainder",
        ] {
            // What is left to shoot may be negative: a correction.
            if ["unshot", "remainder"].contains(&name) && value.is_finite() {
                continue;
            }
            let fault = with(name, 7, value);
            assert!(
                matches!(
                    fault,
                    FileFault::Scene(SceneError::Irradiance { patch: 2, .. })
                ),
                "{fault}"
            );
        }
    }
    let mut origin = bytes.clone();
    patch(&mut origin, ORIGIN + 8, &f64::NAN.to_le_bytes());
    assert!(matches!(
        fault_of(&seal(origin)),
        FileFault::Scene(SceneError::Origin { .. })
    ));
}

#[test]
fn bad_indices_depths_and_triangles_are_errors() {
    let bytes = small_file();
    let first = data(&bytes, "surfaces");
    let with = |offset: usize, value: u32| {
        let mut bytes = bytes.clone();
        patch(&mut bytes, first + offset, &value.to_le_bytes());
        fault_of(&seal(bytes))
    };
    assert!(matches!(
        with(36, 2),
        FileFault::Scene(SceneError::MaterialIndex { .. })
    ));
    assert!(matches!(
        with(40, u32::MAX),
        FileFault::Scene(SceneError::ObjectIndex { .. })
    ));
    for depth in [24, 31, 32, 64, u32::MAX] {
        assert!(matches!(
            with(44, depth),
            FileFault::Scene(SceneError::Bisections { .. })
        ));
    }
    // The solution no longer fits the mesh.
    assert!(matches!(
        with(44, 1),
        FileFault::Scene(SceneError::SolutionLength { .. })
    ));
    let mut flat = bytes.clone();
    flat.copy_within(first..first + 12, first + 12);
    assert!(matches!(
        fault_of(&seal(flat)),
        FileFault::Scene(SceneError::Degenerate { surface: 0, .. })
    ));
}

#[test]
fn more_patches_than_24_bits_hold_are_an_error_that_tells_both_numbers() {
    let mut bytes = small_file();
    let first = data(&bytes, "surfaces");
    for surface in 0..2 {
        patch(&mut bytes, first + 48 * surface + 44, &23_u32.to_le_bytes());
    }
    let fault = fault_of(&seal(bytes));
    assert!(matches!(
        fault,
        FileFault::Scene(SceneError::TooManyPatches {
            patches: 16_777_216
        })
    ));
    let message = fault.to_string();
    assert!(
        message.contains("16777216") && message.contains(&MAX_PATCHES.to_string()),
        "{message}"
    );
}

#[test]
fn solution_of_the_wrong_length_is_an_error_in_every_array() {
    let scene = small_scene();
    let patches = scene.patch_count() as usize;
    let is_refused = |solution: &Solution| {
        matches!(
            fault_of(&to_bytes(&scene, Some(solution))),
            FileFault::Scene(SceneError::SolutionLength { patches: 5, .. })
        )
    };
    let values = |count| vec![Rgb::ONE; count];
    for count in [patches - 1, patches + 1] {
        let mut solution = small_solution(&scene);
        solution.irradiance = values(count);
        assert!(is_refused(&solution));
        for (unshot, remainder) in [(count, patches), (patches, count)] {
            solution = small_shooting_solution(&scene);
            solution.state = State::Shooting {
                unshot: values(unshot),
                remainder: values(remainder),
            };
            assert!(is_refused(&solution));
        }
    }
    let mut solution = small_solution(&scene);
    solution.state = State::Unfinished {
        irradiance: values(patches + 1),
    };
    assert!(is_refused(&solution));
    solution = small_solution(&scene);
    solution.provenance.level = Level::Gathering {
        max_area: 0.1,
        gathered: values(patches + 1),
    };
    assert!(is_refused(&solution));
}

#[test]
fn areas_of_sources_that_are_none_are_errors() {
    let scene = small_scene();
    for max_area in [0.0, -1.0] {
        let mut solution = small_solution(&scene);
        solution.provenance.level = Level::Sources { max_area };
        assert!(matches!(
            fault_of(&to_bytes(&scene, Some(&solution))),
            FileFault::Scene(SceneError::SourceArea { .. })
        ));
    }
}

#[test]
fn states_of_two_solvers_at_once_are_an_error() {
    let [_, bytes] = small_files();
    let mut mixed = bytes.clone();
    patch(
        &mut mixed,
        entry(&bytes, "remainder"),
        &padded("unfinished"),
    );
    let fault = fault_of(&seal(mixed));
    assert!(fault.to_string().contains("come together"), "{fault}");
}

#[test]
fn faces_that_are_more_or_fewer_than_surfaces_are_an_error() {
    let bytes = small_file();
    let at = entry(&bytes, "faces") + COUNT;
    for count in [0_u64, 1, 3] {
        let mut bytes = bytes.clone();
        patch(&mut bytes, at, &count.to_le_bytes());
        assert!(matches!(
            fault_of(&seal(bytes)),
            FileFault::Scene(SceneError::FaceCount { surfaces: 2, .. })
        ));
    }
}

#[test]
fn damaged_names_are_errors() {
    let bytes = small_file();
    let names = data(&bytes, "names");
    for damage in [b"[", b"}", b"\xFF", b"\0"] {
        let mut bytes = bytes.clone();
        patch(&mut bytes, names, damage);
        assert!(matches!(
            fault_of(&seal(bytes)),
            FileFault::Structure { .. }
        ));
    }
    // One material less than there are names.
    let mut fewer = bytes.clone();
    let at = entry(&bytes, "materials") + COUNT;
    patch(&mut fewer, at, &1_u64.to_le_bytes());
    let fault = fault_of(&seal(fewer));
    assert!(
        fault.to_string().contains("2 names for 1 materials"),
        "{fault}"
    );
}

#[test]
fn names_of_sections_that_are_double_or_no_ascii_are_errors() {
    let bytes = small_file();
    let at = entry(&bytes, "unfinished");
    let long = *b"sixteen-letters!";
    for (name, told) in [
        (padded("irradiance"), Some("two sections \"irradiance\"")),
        (padded(""), Some("\"\" is no name")),
        (padded("two words"), Some("\"two words\" is no name")),
        (padded("a\0b"), Some("\"a\" is no name")),
        (padded("é"), Some("\"\\xc3\\xa9\" is no name")),
        (long, None),
    ] {
        let mut bytes = bytes.clone();
        patch(&mut bytes, at, &name);
        let bytes = seal(bytes);
        let Some(told) = told else {
            from_bytes(&bytes).unwrap();
            continue;
        };
        let fault = fault_of(&bytes);
        assert!(
            matches!(&fault, FileFault::Structure { what } if what.contains(told)),
            "{fault}"
        );
    }
}
