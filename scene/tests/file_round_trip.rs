//! What is written is what is read, bit for bit.

mod common;

use common::{bits, folder, small_scene, small_shooting_solution, small_solution};
use glam::{DVec3, Vec3};
use proptest::collection::vec;
use proptest::prelude::*;
use scene::file::{from_bytes, load, save, to_bytes};
use scene::function::{IrradianceFunction, NodeId, Refinement};
use scene::layers::{Lamp, Layer, LayerKind, Layers};
use scene::{
    Level, Material, MaterialId, ObjectId, Opening, PatchId, Provenance, RecordedSettings, Rgb,
    Scene, Solution, State, Surface,
};

/// Any f32 of a range of bit patterns: subnormals and extremes are as likely as the rest.
fn non_negative(limit: f32) -> impl Strategy<Value = f32> {
    (0..limit.to_bits()).prop_map(f32::from_bits)
}

fn rgb(limit: f32) -> impl Strategy<Value = Rgb> {
    [
        non_negative(limit),
        non_negative(limit),
        non_negative(limit),
    ]
    .prop_map(Rgb::from)
}

fn any_material() -> impl Strategy<Value = Material> {
    (any::<String>(), rgb(1.0), rgb(f32::INFINITY)).prop_map(|(name, reflectance, emission)| {
        Material {
            name,
            reflectance,
            emission,
        }
    })
}

fn any_scene() -> impl Strategy<Value = Scene> {
    let corner = || [-1e9_f32..1e9, -1e9_f32..1e9, -1e9_f32..1e9].prop_map(Vec3::from);
    let surface = ([corner(), corner(), corner()], 0_u32..3, 0_u32..2, 0_u32..6);
    (
        vec(any_material(), 3),
        vec(any::<String>(), 2),
        vec(surface, 1..20),
        [-1e12_f64..1e12, -1e12_f64..1e12, -1e12_f64..1e12],
    )
        .prop_filter_map("degenerate", |(materials, objects, surfaces, origin)| {
            let (surfaces, depths): (Vec<Surface>, Vec<u32>) = surfaces
                .into_iter()
                .map(|(corners, material, object, depth)| {
                    let surface = Surface {
                        corners,
                        material: MaterialId(material),
                        object: ObjectId(object),
                    };
                    (surface, depth)
                })
                .unzip();
            let scene =
                Scene::new(materials, objects, surfaces, &depths, DVec3::from(origin)).ok()?;
            let faces = (7..).step_by(3).take(scene.surfaces().len());
            let inside = (0..scene.patch_count()).skip(1).step_by(3).map(PatchId);
            let inside = inside.collect();
            let opening = |surface: &Surface| Opening {
                corners: surface.corners,
                object: surface.object,
            };
            let openings = scene.surfaces().iter().skip(1).map(opening).collect();
            scene
                .with_faces(faces.collect())
                .ok()?
                .with_inside(inside)
                .ok()?
                .with_openings(openings)
                .ok()
        })
}

/// None, or one of every other surface, some leaves of which are bisected.
fn any_function(scene: &Scene) -> impl Strategy<Value = Option<IrradianceFunction>> + use<> {
    let whole = Refinement::new(scene, |surface| surface.0 % 2 == 0, |_, _| true);
    let grown = vec(any::<prop::sample::Index>(), 0..4).prop_map(move |places| {
        let mut mesh = whole.clone();
        for place in places {
            let leaves: Vec<NodeId> = mesh.leaves().collect();
            mesh.bisect(leaves[place.index(leaves.len())]);
        }
        mesh.mesh().unwrap()
    });
    let patches = scene.patch_count() as usize;
    let function = grown.prop_flat_map(move |mesh| {
        let values = || vec(rgb(f32::INFINITY), mesh.vertex_count() as usize);
        let error = proptest::option::of(vec(0.0..f32::MAX, patches));
        let values = (values(), values(), error);
        values.prop_map(move |(irradiance, direct, error)| {
            let function = IrradianceFunction::new(mesh.clone(), irradiance, direct).unwrap();
            match error {
                Some(error) => function.with_error(error).unwrap(),
                None => function,
            }
        })
    });
    proptest::option::of(function)
}

fn any_solution(scene: &Scene) -> impl Strategy<Value = Solution> + use<> {
    let patches = scene.patch_count() as usize;
    let values = || vec(rgb(f32::INFINITY), patches);
    // A correction that is still to be shot may be negative.
    let unshot = || {
        let value = (rgb(f32::INFINITY), any::<bool>())
            .prop_map(|(v, is_negative)| if is_negative { -v } else { v });
        vec(value, patches)
    };
    let of_first_patches = move || vec(rgb(f32::INFINITY), 0..=patches);
    let state = prop_oneof![
        Just(State::AtRest),
        of_first_patches().prop_map(|irradiance| State::Unfinished { irradiance }),
        (unshot(), unshot()).prop_map(|(unshot, remainder)| State::Shooting { unshot, remainder }),
    ];
    let area = || f64::MIN_POSITIVE..1e300;
    let level = prop_oneof![
        Just(Level::Patches),
        Just(Level::PatchesAfterSources),
        area().prop_map(|max_area| Level::Sources { max_area }),
        (area(), of_first_patches())
            .prop_map(|(max_area, gathered)| Level::Gathering { max_area, gathered }),
    ];
    (
        values(),
        state,
        proptest::option::of(any::<std::collections::BTreeMap<String, String>>()),
        any::<u64>(),
        level,
        vec(-1e300_f64..1e300, 0..5),
        any_function(scene),
    )
        .prop_map(
            |(irradiance, state, settings, iterations, level, residuals, function)| Solution {
                provenance: Provenance {
                    settings: settings.map(|settings| RecordedSettings::new(&settings)),
                    iterations,
                    residuals,
                    level,
                    start_up_shots: iterations / 2,
                },
                state,
                layers: Some(layers_of(&irradiance, function.as_ref())),
                irradiance,
                function,
            },
        )
}

/// Two layers with values of the solution.
fn layers_of(irradiance: &[Rgb], function: Option<&IrradianceFunction>) -> Layers {
    let layer = |name: &str, lamp, factor: f32| Layer {
        name: name.to_owned(),
        lamp: Some(lamp),
        irradiance: irradiance.iter().map(|&h| factor * h).collect(),
        vertices: function.map_or_else(Vec::new, |function| {
            let values = function.irradiance().iter().zip(function.direct());
            values.map(|(&h, &direct)| [h, factor * direct]).collect()
        }),
    };
    Layers {
        kind: LayerKind::Lamps,
        layers: vec![
            layer("a \"lamp\"", Lamp::Object(0), 0.5),
            layer("", Lamp::Material(7), 0.25),
        ],
    }
}

proptest! {
    #[test]
    fn scene_and_solution_survive_bit_for_bit(
        (scene, solution) in any_scene().prop_flat_map(|scene| {
            let solution = proptest::option::of(any_solution(&scene));
            (Just(scene), solution)
        })
    ) {
        let bytes = to_bytes(&scene, solution.as_ref());
        let (scene_again, solution_again) = from_bytes(&bytes).unwrap();
        prop_assert_eq!(&scene_again, &scene);
        prop_assert_eq!(&solution_again, &solution);
        // Equality takes -0 for 0; equal bytes do not.
        prop_assert_eq!(to_bytes(&scene_again, solution_again.as_ref()), bytes);
    }

    #[test]
    fn random_bytes_never_panic(bytes in vec(any::<u8>(), 0..300)) {
        prop_assert!(from_bytes(&bytes).is_err());
    }

    #[test]
    fn random_bytes_after_a_valid_start_never_panic(
        start in 0_usize..300, bytes in vec(any::<u8>(), 1..300)
    ) {
        let mut file = to_bytes(&small_scene(), None);
        let end = (start + bytes.len()).min(file.len());
        let changed = &bytes[..end - start];
        let is_same = &file[start..end] == changed;
        file[start..end].copy_from_slice(changed);
        prop_assert_eq!(from_bytes(&file).is_ok(), is_same);
    }
}

#[test]
fn saved_file_loads_from_disk_with_and_without_a_solution() {
    let folder = folder();
    let path = folder.path().join("a b.rad");
    let scene = small_scene();
    save(&path, &scene, None).unwrap();
    assert_eq!(load(&path).unwrap(), (scene.clone(), None));
    for solution in [small_solution(&scene), small_shooting_solution(&scene)] {
        save(&path, &scene, Some(&solution)).unwrap();
        let (scene_again, solution_again) = load(&path).unwrap();
        let solution_again = solution_again.unwrap();
        assert_eq!(scene_again, scene);
        assert_eq!(solution_again, solution);
        assert_eq!(bits(&solution_again.irradiance), bits(&solution.irradiance));
        // A result is a valid input, and the same one: nothing drifts from save to save.
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(to_bytes(&scene_again, Some(&solution_again)), bytes);
    }
}

#[test]
fn regression_infinite_residual_leaves_the_file_readable() {
    let scene = small_scene();
    let mut solution = small_solution(&scene);
    solution.provenance.residuals = vec![f64::INFINITY, 0.5];
    let (_, again) = from_bytes(&to_bytes(&scene, Some(&solution))).unwrap();
    let residuals = again.unwrap().provenance.residuals;
    assert!(residuals[0].is_nan());
    assert_eq!(residuals[1].to_bits(), 0.5_f64.to_bits());
}
