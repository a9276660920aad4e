//! Laws of comparing solutions place by place.

mod common;

use common::{Builder, closed_cube, lit_room, solution};
use display::by_position::ByPosition;
use glam::{DVec3, Vec3};
use scene::{PatchId, Rgb, Scene, Solution};

/// f32 rounding of positions, barycentric coordinates and values, some ten operations, relative to values of the order of 1.
const ROUNDING: f64 = 10.0 * f32::EPSILON as f64;

/// A room of 2 x 2 x 2 m whose middle is at `at` in the model, cut into patches so often; the scene's origin is `origin`.
fn cube(at: DVec3, origin: DVec3, depth: u32) -> Scene {
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    let middle = (at - origin).as_vec3();
    builder.room(middle - Vec3::ONE, middle + Vec3::ONE, &[], material, depth);
    builder.scene_at(origin)
}

/// Irradiance that is linear over the model: 3 + x + y/2 + z/4, W/m^2, at each patch's centroid.
fn linear(scene: &Scene) -> Solution {
    solution(scene, |patch| {
        let at = scene.to_model(scene.patch(patch).centroid());
        Rgb::splat((3.0 + at.x + 0.5 * at.y + 0.25 * at.z) as f32)
    })
}

fn longest_patch_side(scene: &Scene) -> f64 {
    let patches = (0..scene.patch_count()).map(|k| scene.patch(PatchId(k)));
    let sides = patches.flat_map(|patch| {
        let [a, b, c] = patch.corners.map(Vec3::as_dvec3);
        [a.distance(b), b.distance(c), c.distance(a)]
    });
    sides.fold(0.0, f64::max)
}

#[test]
fn solution_is_the_same_as_itself() {
    let (scene, solution) = lit_room();
    let pairs = ByPosition::new((&scene, &solution), (&scene, &solution));
    let found = pairs.errors_by_area();
    assert!(found.errors.power == 0.0 && found.errors.visible == 0.0);
    assert!((found.compared_share - 1.0).abs() < 1e-12);
    assert_eq!(
        found.describe(&scene),
        "power 0.00 %, visible 0.00 %, over 100 % of the area; of one luminance in each patch"
    );
    for (known, given) in pairs.irradiance().iter().zip(&solution.irradiance) {
        assert!(
            known
                .unwrap()
                .abs_diff_eq(*given, 1e-5 * given.max_element())
        );
    }
}

/// With another origin positions round otherwise, so that all surfaces are looked up.
#[test]
fn solution_is_the_same_from_another_origin_and_with_surfaces_in_another_order() {
    let a = cube(DVec3::ZERO, DVec3::ZERO, 7);
    let origin = DVec3::new(0.1, -0.2, 0.3);
    let mut surfaces = cube(DVec3::ZERO, origin, 7).surfaces().to_vec();
    surfaces.reverse();
    let depths = vec![7; surfaces.len()];
    let b = Scene::new(
        a.materials().to_vec(),
        a.objects().to_vec(),
        surfaces,
        &depths,
        origin,
    )
    .unwrap();
    let found = ByPosition::new((&a, &linear(&a)), (&b, &linear(&b))).errors_by_area();
    assert!(found.errors.power < ROUNDING, "{found:?}");
    assert!((found.compared_share - 1.0).abs() < 1e-12);
    // None of them is where it was.
    let in_place = a
        .surfaces()
        .iter()
        .zip(b.surfaces())
        .filter(|(a, b)| a.corners == b.corners);
    assert_eq!(in_place.count(), 0);
}

#[test]
fn finer_mesh_of_the_same_light_differs_by_a_step_of_the_coarser_one_at_most() {
    let steepest = DVec3::new(1.0, 0.5, 0.25).length();
    let fine = cube(DVec3::ZERO, DVec3::splat(0.5), 11);
    let mut last = f64::INFINITY;
    for depth in [3, 5, 7] {
        let coarse = cube(DVec3::ZERO, DVec3::ZERO, depth);
        let pairs = ByPosition::new((&coarse, &linear(&coarse)), (&fine, &linear(&fine)));
        let found = pairs.errors_by_area();
        // Two points of a patch are at most its longest side apart; 1.25 is the least irradiance.
        let step = steepest * (longest_patch_side(&coarse) + longest_patch_side(&fine));
        assert!(found.errors.power < step / 1.25, "{depth}: {found:?}");
        // Halved sides halve it, but for the finer mesh's own step, an eighth of the last one.
        assert!(
            found.errors.power < 0.7 * last && found.errors.power > 0.0,
            "{depth}: {found:?}"
        );
        last = found.errors.power;
        // The mean over a patch is that at its centroid, but for the finer mesh's steps.
        let steps = steepest * longest_patch_side(&fine);
        for (known, given) in pairs.irradiance().iter().zip(&linear(&coarse).irradiance) {
            assert!(f64::from((known.unwrap() - *given).abs().max_element()) < steps);
        }
    }
}

#[test]
fn what_is_too_bright_on_one_patch_is_found_there() {
    let a = closed_cube(4);
    let right = solution(&a, |_| Rgb::ONE);
    let mut shown = right.clone();
    shown.irradiance[7] = Rgb::splat(1.5);
    let b = cube(DVec3::ZERO, DVec3::X, 4);
    let found = ByPosition::new((&a, &shown), (&b, &right)).errors_by_area();
    // Reflected is half of it: one of 192 patches is off by a quarter where 0.5 is right.
    let power = (0.25_f64.powi(2) / 192.0 / 0.25).sqrt();
    assert!((found.errors.power - power).abs() < ROUNDING, "{found:?}");
    assert!(
        (found.errors.visible - power / 1.05).abs() < ROUNDING,
        "{found:?}"
    );
    let (patch, difference) = found.most.unwrap();
    assert!(patch == PatchId(7) && (difference - 0.25).abs() < ROUNDING);
    assert!(
        found
            .describe(&a)
            .ends_with("most 0.25 W/m^2 too bright on patch 7 of \"all\""),
        "{}",
        found.describe(&a)
    );
    let back = ByPosition::new((&b, &right), (&a, &shown)).errors_by_area();
    let squares = 191.0 * 0.25 + 0.75_f64.powi(2);
    let swapped = (0.25_f64.powi(2) / squares).sqrt();
    assert!((back.errors.power - swapped).abs() < ROUNDING, "{back:?}");
}

#[test]
fn scene_that_is_elsewhere_is_not_compared() {
    let a = cube(DVec3::ZERO, DVec3::ZERO, 3);
    let b = cube(DVec3::new(10.0, 0.0, 0.0), DVec3::ZERO, 3);
    let pairs = ByPosition::new((&a, &linear(&a)), (&b, &linear(&b)));
    let found = pairs.errors_by_area();
    assert!(
        found.compared_share == 0.0 && found.most.is_none(),
        "{found:?}"
    );
    assert!(
        found
            .describe(&a)
            .starts_with("0 % of the area is compared")
    );
    assert!(pairs.irradiance().iter().all(Option::is_none));
}

#[test]
fn backs_and_what_stands_in_another_unit_are_elsewhere_too() {
    let a = cube(DVec3::ZERO, DVec3::ZERO, 3);
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    builder.block(Vec3::NEG_ONE, Vec3::ONE, material, 3);
    let outwards = builder.scene();
    let axes = scene::ModelAxes {
        unit: 0.001,
        up: None,
    };
    let in_millimetres = a.clone().with_axes(axes).unwrap();
    for b in [outwards, in_millimetres] {
        let found = ByPosition::new((&a, &linear(&a)), (&b, &linear(&b))).errors_by_area();
        assert!(found.compared_share == 0.0, "{found:?}");
    }
}

#[test]
fn half_of_a_room_is_compared_where_the_other_scene_has_but_half_of_it() {
    let a = cube(DVec3::ZERO, DVec3::ZERO, 3);
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    builder.room(Vec3::NEG_ONE, Vec3::ONE, &[0, 2, 4], material, 3);
    let b = builder.scene();
    let found = ByPosition::new((&a, &linear(&a)), (&b, &linear(&b))).errors_by_area();
    assert!((found.compared_share - 0.5).abs() < 1e-12, "{found:?}");
    assert!(found.errors.power < ROUNDING, "{found:?}");
}

#[test]
fn what_lies_inside_of_solids_has_no_part() {
    let a = closed_cube(2);
    let right = solution(&a, |_| Rgb::ONE);
    let mut shown = right.clone();
    shown.irradiance[5] = Rgb::ZERO;
    let marked = a.clone().with_inside(vec![PatchId(5)]).unwrap();
    for (a, b) in [(&marked, &a), (&a, &marked)] {
        let pairs = ByPosition::new((a, &shown), (b, &right));
        let found = pairs.errors_by_area();
        assert!(found.errors.power == 0.0, "{found:?}");
        assert!((found.compared_share - 1.0).abs() < 1e-12);
        assert_eq!(pairs.irradiance()[5], None);
    }
    assert!(
        ByPosition::new((&a, &shown), (&a, &right))
            .errors_by_area()
            .errors
            .power
            > 0.0
    );
}

#[test]
fn errors_are_those_of_the_same_surfaces_compared_point_by_point() {
    let (scene, right) = lit_room();
    let mut shown = right.clone();
    for (k, value) in shown.irradiance.iter_mut().enumerate() {
        *value *= 1.0 + 0.02 * (k % 7) as f32;
    }
    let found = ByPosition::new((&scene, &shown), (&scene, &right)).errors_by_area();
    let known = compute::compare::errors((&scene, &shown), (&scene, &right)).unwrap();
    // 40,000 points at other places: a share of 1/200 of the error, were they by chance.
    assert!(
        (found.errors.power / known.power - 1.0).abs() < 0.01,
        "{found:?} {known:?}"
    );
    assert!(
        (found.errors.visible / known.visible - 1.0).abs() < 0.01,
        "{found:?} {known:?}"
    );
}
