//! Laws of layers: light is linear, so that its parts sum to it, and each is what it would be alone.

use compute::Solve;
use compute::settings::{BackendChoice, LampViews, Points, Quality, SolveSettings};
use glam::{DVec3, Vec3};
use scene::layers::{LayerKind, Layers};
use scene::{MaterialId, ObjectId, Rgb, Scene, Solution, Surface};
use test_scenes::{block, furnace, grid, material};

/// A room of 4 x 3 x 2 m with two lamps of one material below its ceiling, which differ in size.
fn room() -> Scene {
    let lamps = [
        (Vec3::new(0.6, 0.6, 1.9), 0.5),
        (Vec3::new(2.9, 1.9, 1.5), 0.3),
    ];
    let walls = block(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0), false, 0);
    let mut surfaces: Vec<Surface> = walls;
    for (object, (corner, side)) in (1..).zip(lamps) {
        // They shine down.
        let squares = grid(corner, side * Vec3::Y, side * Vec3::X, 1);
        surfaces.extend(squares.into_iter().map(|surface| Surface {
            material: MaterialId(1),
            object: ObjectId(object),
            ..surface
        }));
    }
    let materials = vec![material(0.5, 0.0), material(0.1, 10.0)];
    let names = ["walls", "near", "far"].map(str::to_owned).to_vec();
    Scene::with_max_area(materials, names, surfaces, 0.05, DVec3::ZERO).unwrap()
}

fn settings(of: &SolveSettings, kind: LayerKind) -> SolveSettings {
    let mut settings = *of;
    settings.drawing.backend = BackendChoice::Cpu;
    settings.layers = Some(kind);
    settings.tolerance = 1e-6;
    settings
}

/// Among the patches, with rows that no emission decides.
fn of_patches(kind: LayerKind) -> SolveSettings {
    let mut settings = settings(&Quality::Mesh.settings(), kind);
    settings.solution.form_factors.resolution = 32;
    settings.solution.form_factors.points = Points::CENTROID;
    settings.solution.form_factors.lamps = LampViews::Off;
    settings
}

fn of_function(kind: LayerKind) -> SolveSettings {
    settings(&Quality::Standard.settings(), kind)
}

fn solved(scene: &Scene, settings: SolveSettings) -> (Solution, Layers) {
    let solved = Solve::new(scene).settings(settings).run().unwrap();
    let solution = solved.into_solution();
    let layers = solution.layers.clone().unwrap();
    (solution, layers)
}

/// What two iterations leave of a patch's own light, or of the mean of all where it has less. Their residual, 1e-6, is over all
/// radiosities, of which a lamp's own is ten times what walls reflect: 1e-5, twice that since half is reflected, for two of them, and
/// twice as much for the worst of the patches.
const ITERATION: f32 = 8e-5;

fn assert_near(a: Rgb, b: Rgb, mean: f32, what: &str) {
    let scale = mean.max(b.max_element());
    assert!(a.abs_diff_eq(b, ITERATION * scale), "{what}: {a} {b}");
}

/// Of the brightest channel.
fn mean(values: &[Rgb]) -> f32 {
    values.iter().sum::<Rgb>().max_element() / values.len() as f32
}

#[test]
fn layers_sum_to_the_solution() {
    let scene = room();
    for kind in [LayerKind::Lamps, LayerKind::Bounces] {
        for settings in [of_patches(kind), of_function(kind)] {
            let (solution, layers) = solved(&scene, settings);
            let names: Vec<&str> = layers.layers.iter().map(|layer| &*layer.name).collect();
            let expected: &[&str] = match kind {
                LayerKind::Lamps => &["near", "far"],
                LayerKind::Bounces => &["bounce 1", "bounce 2", "bounces 3 to 5", "bounces from 6"],
            };
            assert_eq!(names, expected);
            assert_eq!(solution.function.is_some(), settings.target.is_some());
            let ones = vec![Rgb::ONE; layers.layers.len()];
            let (mixed_scene, mixed) = solution.mixed(&scene, &ones).unwrap().unwrap();
            let mean = mean(&solution.irradiance);
            for (&sum, &all) in mixed.irradiance.iter().zip(&solution.irradiance) {
                assert_near(sum, all, mean, names[0]);
            }
            if let (Some(sum), Some(all)) = (&mixed.function, &solution.function) {
                for (&sum, &all) in sum.irradiance().iter().zip(all.irradiance()) {
                    assert_near(sum, all, mean, names[0]);
                }
                for (&sum, &all) in sum.direct().iter().zip(all.direct()) {
                    assert_near(sum, all, mean, names[0]);
                }
            }
            assert_eq!(mixed_scene.patch_emissions(), scene.patch_emissions());
        }
    }
}

/// With the rows of the same hemicubes.
#[test]
fn a_lamps_layer_is_what_it_brings_alone() {
    let scene = room();
    let (solution, layers) = solved(&scene, of_patches(LayerKind::Lamps));
    for k in 0..2 {
        let mut factors = vec![Rgb::ZERO; 2];
        factors[k] = Rgb::new(2.0, 1.0, 0.5);
        let (alone, mixed) = solution.mixed(&scene, &factors).unwrap().unwrap();
        let name = &layers.layers[k].name;
        let emitted = alone.emitted_power();
        assert!(
            emitted.min_element() > 0.0 && emitted.x > 3.9 * emitted.z,
            "{name}"
        );
        let solved = Solve::new(&alone)
            .settings(of_patches(LayerKind::Lamps))
            .run()
            .unwrap();
        let mean = mean(solved.irradiance());
        for (&mixed, &alone) in mixed.irradiance.iter().zip(solved.irradiance()) {
            assert_near(mixed, alone, mean, name);
        }
    }
}

/// With a function, whose mesh is that of both lamps, what differs is within the error that was asked for of each alone.
#[test]
fn a_lamps_function_is_near_what_it_brings_alone() {
    let scene = room();
    let (solution, _) = solved(&scene, of_function(LayerKind::Lamps));
    for k in 0..2 {
        let mut factors = vec![Rgb::ZERO; 2];
        factors[k] = Rgb::ONE;
        let (scene, mixed) = solution.mixed(&scene, &factors).unwrap().unwrap();
        let alone = Solve::new(&scene)
            .settings(of_function(LayerKind::Lamps))
            .run()
            .unwrap();
        let shown = mixed.mean_irradiance(&scene);
        let right = alone.solution().mean_irradiance(&scene);
        let areas = scene.patch_areas();
        let sum = |of: &dyn Fn(usize) -> Rgb| -> f64 {
            (0..areas.len())
                .map(|p| areas[p] * of(p).as_dvec3().length_squared())
                .sum()
        };
        let error = (sum(&|p| shown[p] - right[p]) / sum(&|p| right[p])).sqrt();
        println!("{k}: {error:.4}");
        assert!(error < 0.02, "{k}: {error}");
    }
}

/// In a furnace with E = 1 and rho = 1/2 each bounce brings half of what the one before it did.
#[test]
fn bounces_in_a_furnace_are_a_geometric_series() {
    let scene = furnace(0.5, 1.0, 0.05);
    let expected = [1.0, 0.5, 0.25 + 0.125 + 0.0625, 0.0625];
    for settings in [
        of_patches(LayerKind::Bounces),
        of_function(LayerKind::Bounces),
    ] {
        let (_, layers) = solved(&scene, settings);
        for (layer, expected) in layers.layers.iter().zip(expected) {
            let of_vertices = layer.vertices.iter().map(|[all, _]| all);
            for value in layer.irradiance.iter().chain(of_vertices) {
                assert_near(*value, Rgb::splat(expected), 2.0, &layer.name);
            }
        }
    }
}

#[test]
fn a_scene_without_lamps_has_no_layers() {
    let dark = test_scenes::scene(
        vec![material(0.5, 0.0)],
        block(Vec3::ZERO, Vec3::ONE, false, 0),
        0.5,
    );
    let solved = Solve::new(&dark)
        .settings(of_patches(LayerKind::Lamps))
        .run()
        .unwrap();
    assert!(solved.solution().layers.is_none());
}
