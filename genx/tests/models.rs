//! Laws that hold for all generated models.

mod common;

use std::collections::HashMap;

use common::{Random, cast, rays_from_surfaces};
use genx::{Model, Settings, make};
use glam::Vec3;
use scene::{Rgb, Scene};

const GENERATED: [Model; 5] = [
    Model::Cube,
    Model::Hall,
    Model::Bend,
    Model::Cornell,
    Model::Furnace,
];

const CLOSED: [Model; 4] = [Model::Cube, Model::Hall, Model::Bend, Model::Furnace];

fn scene(model: Model) -> Scene {
    make(&Settings::new(model)).unwrap().scene
}

/// A patch for each surface, so that only the geometry is made.
fn surfaces_only(model: Model) -> Scene {
    let mut settings = Settings::new(model);
    settings.max_area = Some(f64::INFINITY);
    make(&settings).unwrap().scene
}

fn patches_at(model: Model, max_area: f64) -> u32 {
    let mut settings = Settings::new(model);
    settings.max_area = Some(max_area);
    make(&settings).unwrap().scene.patch_count()
}

/// Sides that no other surface has in the opposite direction, corner for corner and bit for bit.
fn open_sides(scene: &Scene) -> Vec<[Vec3; 2]> {
    let bits = |p: Vec3| p.to_array().map(|x| (x + 0.0).to_bits()); // -0 and 0 are one place
    let mut count: HashMap<_, i32> = HashMap::new();
    let sides: Vec<[Vec3; 2]> = scene
        .surfaces()
        .iter()
        .flat_map(|s| [0, 1, 2].map(|k| [s.corners[k], s.corners[(k + 1) % 3]]))
        .collect();
    for &[a, b] in &sides {
        *count.entry((bits(a), bits(b))).or_default() += 1;
    }
    sides
        .into_iter()
        .filter(|&[a, b]| count.get(&(bits(b), bits(a))) != count.get(&(bits(a), bits(b))))
        .collect()
}

/// Volume in front of closed surfaces, m^3, by the divergence theorem; negative if they look outward.
fn enclosed_volume(scene: &Scene) -> f64 {
    -scene
        .surfaces()
        .iter()
        .map(|s| {
            let [a, b, c] = s.corners.map(Vec3::as_dvec3);
            a.dot(b.cross(c)) / 6.0
        })
        .sum::<f64>()
}

#[test]
fn longest_side_of_a_starting_triangle_is_at_most_twice_its_shortest() {
    for model in GENERATED {
        for (index, surface) in surfaces_only(model.clone()).surfaces().iter().enumerate() {
            let mut sides = surface.side_lengths();
            sides.sort_by(f64::total_cmp);
            assert!(
                sides[2] <= 2.0 * sides[0],
                "{model:?}, surface {index}: {sides:?}"
            );
        }
    }
}

#[test]
fn surfaces_stay_few_since_they_are_what_is_drawn() {
    for (model, most) in [
        (Model::Cube, 99),
        (Model::Hall, 999),
        (Model::Bend, 99),
        (Model::Cornell, 199),
        (Model::Furnace, 99),
    ] {
        let surfaces = surfaces_only(model.clone()).surfaces().len();
        assert!(surfaces <= most, "{model:?}: {surfaces}");
    }
}

#[test]
fn every_side_in_a_closed_model_is_shared_corner_for_corner() {
    for model in CLOSED {
        let open = open_sides(&surfaces_only(model.clone()));
        assert!(open.is_empty(), "{model:?}: {open:?}");
    }
}

#[test]
fn sides_that_cornell_does_not_share_lie_around_its_open_front() {
    let open = open_sides(&surfaces_only(Model::Cornell));
    assert!(open.iter().flatten().all(|p| p.z == 0.0), "{open:?}");
    let length: f64 = open
        .iter()
        .map(|[a, b]| a.as_dvec3().distance(b.as_dvec3()))
        .sum();
    // Floor, ceiling, right wall, and the left one, which leans from 0.5528 to 0.556 m.
    let around = 0.5528 + 0.556 + 0.5488 + (0.5488_f64.powi(2) + 0.0032_f64.powi(2)).sqrt();
    // Some 20 corners, each off by f32 rounding, 2^-25 m.
    assert!(
        (length - around).abs() < 20.0 * 2.0_f64.powi(-25),
        "{length}"
    );
}

#[test]
fn closed_models_enclose_their_volume() {
    let hall = 0.93_f64.powi(3)
        * (200.0 * 40.0 * 160.0 // the room
            - 12.0 * (120.0 * 40.0 - 40.0 * 26.0) // partition but for its portal
            - 20.0 * 12.0 * (40.0 + 40.0) // podium and bench
            - 9.0 * 9.0 * (6.0 * 40.0 + 9.0)); // columns and lantern
    for (model, volume) in [
        (Model::Cube, 1000.0),
        (Model::Hall, hall),
        (Model::Bend, 7.8 * 3.0 * 9.0 - 1.8 * 3.0 * 6.0),
        (Model::Furnace, 1.0),
    ] {
        let enclosed = enclosed_volume(&surfaces_only(model.clone()));
        // Each coordinate is rounded to f32, so each of three factors is off by at most 2^-24.
        assert!(
            (enclosed / volume - 1.0).abs() < 3.0 * 2.0_f64.powi(-24),
            "{model:?}: {enclosed} m^3, not {volume}"
        );
    }
}

#[test]
fn every_ray_in_a_closed_model_ends_on_a_front() {
    for model in CLOSED {
        let scene = surfaces_only(model.clone());
        let rays = rays_from_surfaces(&scene, 40, &mut Random(1));
        for (from, direction) in rays {
            let hit = cast(&scene, from, direction);
            assert!(
                hit.is_some_and(|hit| hit.is_front),
                "{model:?}: from {from} along {direction}: {hit:?}"
            );
        }
    }
}

#[test]
fn every_ray_in_cornell_ends_on_a_front_or_leaves_through_the_open_front() {
    let scene = surfaces_only(Model::Cornell);
    let mut left = 0;
    for (from, direction) in rays_from_surfaces(&scene, 200, &mut Random(2)) {
        if let Some(hit) = cast(&scene, from, direction) {
            assert!(hit.is_front, "from {from} along {direction}: {hit:?}");
        } else {
            let at_front = from + direction * (-from.z / direction.z);
            assert!(
                direction.z < 0.0
                    && (0.0..=0.556).contains(&at_front.x)
                    && (0.0..=0.5488).contains(&at_front.y),
                "from {from} along {direction}"
            );
            left += 1;
        }
    }
    assert!(left > 0, "the front is closed");
}

#[test]
fn hall_gives_the_patch_counts_of_the_thesis_within_20_percent() {
    for (max_area, thesis) in [(5.0, 26_360.0), (1.0, 136_512.0), (0.25, 546_048.0)] {
        let patches = f64::from(patches_at(Model::Hall, max_area));
        assert!(
            (patches / thesis - 1.0).abs() <= 0.2,
            "at {max_area} m^2: {patches}"
        );
    }
}

#[test]
fn defaults_give_the_patch_counts_that_suit_each_model() {
    for (model, range) in [
        (Model::Cube, 1000..=10_000),
        (Model::Bend, 1000..=10_000),
        (Model::Cornell, 2000..=5000),
        (Model::Furnace, 100..=300),
    ] {
        let patches = scene(model.clone()).patch_count();
        assert!(range.contains(&patches), "{model:?}: {patches}");
    }
}

#[test]
fn no_patch_is_larger_than_the_threshold() {
    for model in GENERATED {
        let max_area = 0.013 * surfaces_only(model.clone()).area();
        let mut settings = Settings::new(model.clone());
        settings.max_area = Some(max_area);
        let scene = make(&settings).unwrap().scene;
        assert!(
            scene.patch_areas().iter().all(|&area| area <= max_area),
            "{model:?}"
        );
    }
}

#[test]
fn infinite_threshold_makes_each_surface_one_patch() {
    for model in GENERATED {
        let scene = surfaces_only(model);
        assert_eq!(scene.patch_count() as usize, scene.surfaces().len());
    }
}

#[test]
fn hall_has_six_columns_a_partition_and_several_lamps() {
    let scene = surfaces_only(Model::Hall);
    let upright_corners: std::collections::BTreeSet<[u32; 2]> = scene
        .surfaces()
        .iter()
        .filter(|s| scene.object(s.object) == "columns")
        .flat_map(|s| s.corners)
        .map(|p| [p.x.to_bits(), p.z.to_bits()])
        .collect();
    assert_eq!(upright_corners.len(), 6 * 4);
    assert!(scene.objects().iter().any(|name| name == "partition"));
    let emitters = scene.materials().iter().filter(|m| m.is_emitter()).count();
    assert!(emitters >= 3, "{emitters}");
}

#[test]
fn everything_in_a_generated_scene_has_a_user() {
    for model in GENERATED {
        let scene = surfaces_only(model.clone());
        for (index, material) in scene.materials().iter().enumerate() {
            let used = scene.surfaces().iter().any(|s| s.material.index() == index);
            assert!(used, "{model:?}: {}", material.name);
        }
        for (index, object) in scene.objects().iter().enumerate() {
            let used = scene.surfaces().iter().any(|s| s.object.index() == index);
            assert!(used, "{model:?}: {object}");
        }
    }
}

#[test]
fn given_reflectance_and_power_hold_for_every_surface_and_lamp_of_the_thesis_models() {
    for model in [Model::Cube, Model::Hall, Model::Bend] {
        let settings = Settings {
            max_area: Some(2.5),
            reflectance: Some(0.15),
            light_power: Some(100_000.0),
            ..Settings::new(model.clone())
        };
        let scene = make(&settings).unwrap().scene;
        for material in scene.materials() {
            assert_eq!(material.reflectance, Rgb::splat(0.15), "{model:?}");
            assert!(
                [Rgb::ZERO, Rgb::splat(100_000.0)].contains(&material.emission),
                "{model:?}: {material:?}"
            );
        }
        assert!(scene.emitted_power().min_element() > 0.0);
    }
}

#[test]
fn every_wall_of_the_furnace_emits_and_reflects_what_is_asked_for() {
    let mut settings = Settings::new(Model::Furnace);
    let made = make(&settings).unwrap().scene;
    assert!(made.patch_emissions().iter().all(|&e| e == Rgb::ONE));
    assert!(
        made.patch_reflectances()
            .iter()
            .all(|&rho| rho == Rgb::splat(0.5))
    );

    settings.reflectance = Some(0.25);
    settings.light_power = Some(3.0);
    let made = make(&settings).unwrap().scene;
    assert!(made.patch_emissions().iter().all(|&e| e == Rgb::splat(3.0)));
    assert!(
        made.patch_reflectances()
            .iter()
            .all(|&rho| rho == Rgb::splat(0.25))
    );
}

#[test]
fn a_model_without_power_is_made_with_a_warning() {
    let mut settings = Settings::new(Model::Cube);
    assert_eq!(make(&settings).unwrap().warnings, [] as [&str; 0]);
    settings.light_power = Some(0.0);
    let warnings = make(&settings).unwrap().warnings;
    assert!(
        warnings.len() == 1 && warnings[0].contains("nothing emits"),
        "{warnings:?}"
    );
}

#[test]
fn settings_outside_their_ranges_make_nothing() {
    for (max_area, reflectance, light_power) in [
        (Some(0.0), None, None),
        (Some(-1.0), None, None),
        (Some(f64::NAN), None, None),
        (None, Some(1.0), None),
        (None, Some(-0.1), None),
        (None, Some(f32::NAN), None),
        (None, None, Some(-1.0)),
        (None, None, Some(f32::INFINITY)),
        (None, None, Some(f32::NAN)),
    ] {
        let settings = Settings {
            max_area,
            reflectance,
            light_power,
            ..Settings::new(Model::Furnace)
        };
        let error = make(&settings).unwrap_err();
        assert!(
            matches!(error, genx::GenxError::Settings(_)),
            "{settings:?}: {error}"
        );
    }
}
