//! Every value that a whole file can have and no scene may have ends in a clear error.

mod common;

use common::damage::{
    COUNT, ORIGIN, data, entry, fault_of, padded, patch, seal, small_file, small_files,
};
use common::{small_scene, small_shooting_solution, small_solution};
use scene::file::{FileFault, from_bytes, to_bytes};
use scene::{Level, MAX_PATCHES, Rgb, SceneError, Solution, State};

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
fn patches_inside_of_solids_are_some_of_the_scene_in_ascending_order() {
    let bytes = small_file();
    let at = data(&bytes, "inside");
    for (patches, wrong) in [
        ([1, 5], 5),
        ([4, 1], 1),
        ([2, 2], 2),
        ([u32::MAX, 1], u32::MAX),
    ] {
        let mut bytes = bytes.clone();
        patch(&mut bytes, at, bytemuck::bytes_of(&patches));
        let fault = fault_of(&seal(bytes));
        let expected = SceneError::Inside {
            patch: wrong,
            patches: 5,
        };
        assert!(
            matches!(&fault, FileFault::Scene(found) if *found == expected),
            "{fault}"
        );
    }
}

#[test]
fn openings_have_finite_corners_and_objects_of_the_scene() {
    let bytes = small_file();
    let at = data(&bytes, "openings");
    for (offset, wrong) in [
        (0, f32::NAN.to_le_bytes()),
        (32, f32::INFINITY.to_le_bytes()),
        (36, 2_u32.to_le_bytes()),
    ] {
        let mut bytes = bytes.clone();
        patch(&mut bytes, at + offset, &wrong);
        let fault = fault_of(&seal(bytes));
        let expected = SceneError::Opening { opening: 0 };
        assert!(
            matches!(&fault, FileFault::Scene(found) if *found == expected),
            "{fault}"
        );
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
