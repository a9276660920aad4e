//! Laws of what a patch sees.

use std::collections::BTreeMap;

use compute::backend::Backend;
use compute::receivers::Patches;
use compute::rows::{Entry, Row, UNITS_PER_ONE, Unseen};
use compute::settings::{
    BackendChoice, ClosedForms, Drawing, FormFactorSettings, LampViews, Maps, Points, Seed,
    SolutionSettings, SolveSettings,
};
use compute::sources::Sources;
use compute::{FormFactors, Solve};
use display::hemicube::{Seen, UnfoldedHemicube};
use display::hemicube_picture::{HemicubeSettings, render};
use display::multipliers::Multipliers;
use display::shade::ids;
use display::{Camera, Mode, Range, Size};
use glam::{DVec3, Vec3};
use scene::function::{IrradianceFunction, Node, VertexMesh};
use scene::{PatchId, Rgb, Scene, Solution};
use test_scenes::{block, colourful_room, furnace, furnished_room, material, scene};
use visibility::Cull;
use visibility::hemicube::windows;

const RESOLUTION: u32 = 32;

fn scenes() -> Vec<(&'static str, Scene)> {
    // Open above and at a side, so that patches see nothing, and backs of the side's neighbours from behind.
    let mut open = block(Vec3::ZERO, Vec3::ONE, false, 0);
    open.drain(2..4);
    open.extend(block(Vec3::splat(0.25), Vec3::splat(0.5), false, 0));
    vec![
        ("colourful room", colourful_room(0.02)),
        ("furnished room", furnished_room(0.02)),
        ("open box", scene(vec![material(0.5, 1.0)], open, 0.02)),
    ]
}

fn some_patches(scene: &Scene) -> impl Iterator<Item = PatchId> {
    let count = scene.patch_count();
    (0..count).step_by(count as usize / 7).map(PatchId)
}

/// One hemicube a patch, and nothing but hemicubes.
fn form_factor_settings(maps: Maps, seed: Seed) -> FormFactorSettings {
    FormFactorSettings {
        maps,
        seed,
        points: Points::CENTROID,
        lamps: LampViews::Off,
        closed_forms: ClosedForms::Off,
        ..FormFactorSettings::new(RESOLUTION)
    }
}

fn drawing() -> Drawing {
    Drawing {
        backend: BackendChoice::Cpu,
        ..Drawing::default()
    }
}

/// The rows that compute draws of a scene.
fn rows(scene: &Scene, settings: FormFactorSettings) -> Backend<'_> {
    let sources = Sources::patches_of(scene);
    let patches = Patches::new(scene, sources.drawable(), settings.points, settings.seed);
    let form_factors = FormFactors::new(scene, settings, drawing());
    form_factors.at(Box::new(patches), sources).unwrap()
}

fn row(backend: &mut Backend, patch: PatchId) -> Row {
    let mut batch = backend.source.draw_rows(patch.0..patch.0 + 1).unwrap();
    batch.rows_mut()[0].clone()
}

/// The row that an unfolded hemicube makes.
fn counted(hemicube: &UnfoldedHemicube, multipliers: &Multipliers) -> Row {
    let mut sums: BTreeMap<u32, u32> = BTreeMap::new();
    let mut unseen = Unseen::default();
    for (seen, &units) in hemicube.ids().iter().zip(multipliers.units()) {
        match seen {
            Seen::Patch(patch) => *sums.entry(patch.0).or_default() += units,
            Seen::Back => unseen.back_face += units,
            Seen::Nothing => unseen.open += units,
            Seen::Outside => assert_eq!(units, 0),
        }
    }
    let entry = |(source, units)| Entry {
        source,
        units: units as f32,
    };
    Row {
        entries: sums.into_iter().map(entry).collect(),
        unseen,
    }
}

/// An irradiance for each patch, of no order.
fn some_solution(scene: &Scene) -> Solution {
    let irradiance = |k: u32| Rgb::new(1.0, 0.5, 0.25) * (1 + k * 7919 % 101) as f32;
    Solution {
        irradiance: (0..scene.patch_count()).map(irradiance).collect(),
        ..Solution::dark(scene)
    }
}

#[test]
fn pixels_count_what_computes_rows_have() {
    let mut unseen = Unseen::default();
    for (name, scene) in scenes() {
        for (maps, seed) in [
            (Maps::Exact, Seed::DEFAULT),
            (Maps::Exact, Seed::Number(7)),
            (Maps::Thesis, Seed::Aligned),
        ] {
            let mut backend = rows(&scene, form_factor_settings(maps, seed));
            for patch in some_patches(&scene) {
                let hemicube = UnfoldedHemicube::new(&scene, patch, RESOLUTION, seed).unwrap();
                let multipliers = Multipliers::new(maps, hemicube.unfolding());
                let counted = counted(&hemicube, &multipliers);
                assert_eq!(counted, row(&mut backend, patch), "{name}, {patch:?}");
                unseen.open |= counted.unseen.open;
                unseen.back_face |= counted.unseen.back_face;
            }
        }
    }
    // Of all kinds of pixels there were some.
    assert!(unseen.open > 0 && unseen.back_face > 0);
}

/// A form factor is rounded to 24 bits, and so is the result on either side: each is off by 2^-24 of it at most.
const ROUNDING: f32 = 3.0 * f32::EPSILON / 2.0;

#[test]
fn sum_of_the_products_is_the_irradiance_by_computes_rows() {
    for (name, scene) in scenes() {
        let solution = some_solution(&scene);
        let radiosity = solution.radiosity(&scene);
        for maps in [Maps::Exact, Maps::Thesis] {
            let mut backend = rows(&scene, form_factor_settings(maps, Seed::DEFAULT));
            let settings = HemicubeSettings {
                resolution: RESOLUTION,
                maps,
                ..HemicubeSettings::default()
            };
            for patch in some_patches(&scene) {
                let picture = render(&scene, Some(&solution), patch, &settings).unwrap();
                let row = row(&mut backend, patch);
                let product =
                    |e: &Entry| f64::from(e.units) * radiosity[e.source as usize].as_dvec3();
                let sum: DVec3 = row.entries.iter().map(product).sum();
                let expected = (sum / f64::from(UNITS_PER_ONE)).as_vec3();
                let error = (picture.irradiance - expected).abs();
                assert!(
                    error.cmple(ROUNDING * expected).all(),
                    "{name}, {patch:?}: {} for {expected}",
                    picture.irradiance
                );
            }
        }
    }
}

/// Rows are kept with an error of 2e-7 of the radiosities' spread (`compute::compact_rows`), and gathered in f32: as much
/// again for a few roundings of what is no more than the largest radiosity.
const KEPT_ROUNDING: f32 = 4e-7;

#[test]
fn irradiance_is_that_of_the_solvers_next_iteration() {
    let scene = colourful_room(0.02);
    let solution = some_solution(&scene);
    let settings = SolveSettings {
        solution: SolutionSettings {
            form_factors: form_factor_settings(Maps::Exact, Seed::DEFAULT),
            ..SolutionSettings::default()
        },
        drawing: drawing(),
        max_iterations: Some(1),
        ..SolveSettings::default()
    };
    let solve = Solve::new(&scene).settings(settings);
    let next = solve.start(Some(solution.clone())).run().unwrap();
    assert_eq!(next.solution().provenance.iterations, 1);
    let brightest = solution
        .radiosity(&scene)
        .iter()
        .fold(0.0, |most, b| b.max_element().max(most));
    let settings = HemicubeSettings {
        resolution: RESOLUTION,
        ..HemicubeSettings::default()
    };
    for patch in some_patches(&scene) {
        let picture = render(&scene, Some(&solution), patch, &settings).unwrap();
        let error = (picture.irradiance - next.irradiance()[patch.index()]).abs();
        assert!(
            error.max_element() <= KEPT_ROUNDING * brightest,
            "{patch:?}: {error}"
        );
    }
}

/// An eye at the patch that looks along the normal, a right angle wide, sees the top face: neither turned nor mirrored.
#[test]
fn middle_of_the_square_is_what_a_camera_sees() {
    let scene = furnished_room(0.02);
    let half = RESOLUTION as usize / 2;
    for patch in some_patches(&scene) {
        let hemicube = UnfoldedHemicube::new(&scene, patch, RESOLUTION, Seed::DEFAULT).unwrap();
        let frame = hemicube.frame();
        let camera = Camera::new(frame.position, frame.normal, hemicube.up_in_scene(), 90.0);
        let size = Size {
            width: RESOLUTION,
            height: RESOLUTION,
        };
        let (seen, _) = ids(&scene, &camera, size, Cull::Nothing);
        let differing = seen.iter().enumerate().filter(|&(k, seen)| {
            let (column, row) = (k % (2 * half) + half, k / (2 * half) + half);
            let in_square = hemicube.ids()[row * 4 * half + column];
            *seen
                != match in_square {
                    Seen::Patch(patch) => Some(patch),
                    _ => None,
                }
        });
        // The camera's axes are those of the frame but for the last bits of f64: a pixel's centre may change sides where
        // an edge runs through it, as none does here.
        assert_eq!(differing.count(), 0, "{patch:?}");
    }
}

#[test]
fn scene_is_upright_as_seen_from_walls() {
    // Two of a room's walls stand across the axis that points up.
    let scene = furnished_room(0.02);
    let up = display::up::guess(&scene).direction();
    let mut walls = 0;
    for patch in some_patches(&scene) {
        let hemicube = UnfoldedHemicube::new(&scene, patch, RESOLUTION, Seed::DEFAULT).unwrap();
        let (picture_up, normal) = (hemicube.up_in_scene(), hemicube.frame().normal);
        assert!(picture_up.dot(normal).abs() < 1e-12);
        if normal.dot(up).abs() < 1e-6 {
            walls += 1;
            // Within half a right angle, as far as f64 tells.
            assert!(picture_up.dot(up) >= 0.5_f64.sqrt() - 1e-9, "{patch:?}");
        }
    }
    assert!(walls > 1);
}

/// The irradiance 1 + x + 2y + 3z at each corner of a unit cube's surfaces, which is linear between them.
fn linear_function(scene: &Scene) -> IrradianceFunction {
    let count = scene.surfaces().len();
    let node = |k: u32| Node {
        vertices: [3 * k, 3 * k + 1, 3 * k + 2],
        child: 0,
    };
    let vertices: Vec<Vec3> = scene.surfaces().iter().flat_map(|s| s.corners).collect();
    let values: Vec<Rgb> = vertices
        .iter()
        .map(|&v| Rgb::splat(linear(v.as_dvec3()) as f32))
        .collect();
    let mesh = VertexMesh::new(
        count,
        (0..count as u32).collect(),
        (0..count as u32).map(node).collect(),
        vertices,
    );
    let direct = vec![Rgb::ZERO; values.len()];
    IrradianceFunction::new(mesh.unwrap(), values, direct).unwrap()
}

fn linear(at: DVec3) -> f64 {
    1.0 + at.dot(DVec3::new(1.0, 2.0, 3.0))
}

#[test]
fn pixels_see_the_irradiance_function_at_their_own_places() {
    let scene = furnace(0.5, 1.0, 0.05);
    let function = linear_function(&scene);
    let means = vec![Rgb::ZERO; scene.patch_count() as usize];
    for patch in some_patches(&scene) {
        let hemicube = UnfoldedHemicube::new(&scene, patch, RESOLUTION, Seed::DEFAULT).unwrap();
        let radiosities = hemicube.radiosities(&means, Some(&function));
        let frame = hemicube.frame();
        for (face, window) in windows(RESOLUTION).iter().enumerate() {
            for k in 0..window.pixel_count() {
                let (i, j) = (k % window.width, k / window.width);
                let direction = frame.to_scene(window.direction(i, j));
                let to_wall = |k: usize| {
                    let wall = if direction[k] > 0.0 { 1.0 } else { 0.0 };
                    (wall - frame.position[k]) / direction[k]
                };
                let distance = (0..3)
                    .filter(|&k| direction[k].abs() > 1e-12)
                    .map(to_wall)
                    .fold(f64::MAX, f64::min);
                let expected = 1.0 + 0.5 * linear(frame.position + distance * direction);
                let seen = radiosities[hemicube.unfolding().index(face, i, j)];
                // Coordinates on a surface are f32, of values up to 7.
                let error = (f64::from(seen.x) - expected).abs();
                assert!(
                    error < 7.0 * f64::from(f32::EPSILON),
                    "{patch:?}: {seen} for {expected}"
                );
            }
        }
    }
}

#[test]
fn function_is_shown_unless_flat_values_are_asked_for() {
    let scene = furnace(0.5, 1.0, 0.05);
    let solution = Solution {
        function: Some(linear_function(&scene)),
        ..some_solution(&scene)
    };
    let irradiance = |flat: bool| {
        let settings = HemicubeSettings {
            resolution: RESOLUTION,
            flat,
            ..HemicubeSettings::default()
        };
        render(&scene, Some(&solution), PatchId(3), &settings)
            .unwrap()
            .irradiance
    };
    assert_ne!(irradiance(true), irradiance(false));
}

/// In a furnace of radiosity B a hemicube's irradiance is B, since its delta form factors sum to 1.
#[test]
fn furnace_without_a_solution_irradiates_with_its_emission() {
    let scene = furnace(0.5, 3.0, 0.05);
    for resolution in [2, 6, 128] {
        let settings = HemicubeSettings {
            resolution,
            ..HemicubeSettings::default()
        };
        let picture = render(&scene, None, PatchId(0), &settings).unwrap();
        assert_eq!(picture.irradiance, Rgb::splat(3.0));
        let side = (2 * resolution).max(256);
        assert!(picture.image.width() > 2 * side && picture.image.height() > 2 * side);
    }
}

#[test]
fn errors_name_the_count_the_limits_and_the_remedy() {
    let scene = furnace(0.5, 1.0, 1.0);
    let error = |patch: u32, settings: &HemicubeSettings| {
        let error = render(&scene, None, PatchId(patch), settings).unwrap_err();
        error.to_string()
    };
    let good = HemicubeSettings::default();
    let beyond = error(12, &good);
    assert!(
        beyond.contains("patch 12") && beyond.contains("12 patches"),
        "{beyond}"
    );
    assert!(error(u32::MAX, &good).contains("12 patches"));
    let odd = HemicubeSettings {
        resolution: 127,
        ..good
    };
    assert!(error(0, &odd).contains("127") && error(0, &odd).contains("4096"));
    let by_ids = HemicubeSettings {
        mode: Mode::Ids,
        ..good
    };
    assert!(error(0, &by_ids).contains("false-color"));
    let upside_down = HemicubeSettings {
        range: Some(Range {
            low: 2.0,
            high: 1.0,
        }),
        ..good
    };
    assert!(error(0, &upside_down).contains("2:1"));
}
