//! Laws of interpolation between patches.

mod common;

use common::{Builder, closed_cube};
use display::smooth::VertexValues;
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use scene::{MaterialId, PatchId, Rgb, Scene};

/// f32 rounding of values about 1: the mean over up to 8 patches (f64, rounded once) and the sum of
/// three products.
const ROUNDING: f32 = 8.0 * f32::EPSILON;

const CENTER: [f32; 3] = [1.0 / 3.0; 3];

fn patches(scene: &Scene) -> impl Iterator<Item = PatchId> {
    (0..scene.patch_count()).map(PatchId)
}

fn values_by_surface(scene: &Scene, value: impl Fn(usize) -> f32) -> Vec<Rgb> {
    patches(scene)
        .map(|patch| Rgb::splat(value(scene.mesh().surface_of(patch).index())))
        .collect()
}

/// A square of side 1 at the origin, in the plane z = 0, each of its two triangles bisected so often.
fn unit_square(depth: u32) -> Scene {
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    let square = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    builder.quad(square, material, depth);
    builder.scene()
}

#[test]
fn uniform_furnace_is_as_smooth_as_flat() {
    let scene = closed_cube(5);
    let smooth = VertexValues::new(&scene, &vec![Rgb::new(1.0, 0.5, 0.25); 12 * 32]);
    for patch in patches(&scene) {
        assert!(
            smooth
                .at(patch, CENTER)
                .abs_diff_eq(Rgb::new(1.0, 0.5, 0.25), ROUNDING)
        );
    }
}

#[test]
fn linear_field_is_reproduced_away_from_borders() {
    let scene = unit_square(8);
    let field = |p: DVec3| (1.0 + 2.0 * p.x - 0.5 * p.y) as f32;
    let values: Vec<Rgb> = patches(&scene)
        .map(|p| Rgb::splat(field(scene.patch(p).centroid())))
        .collect();
    let smooth = VertexValues::new(&scene, &values);
    let mut interior = 0;
    for patch in patches(&scene) {
        for (corner, value) in scene.patch(patch).corners.iter().zip(smooth.corners(patch)) {
            let is_inside = corner.truncate().cmpgt(glam::Vec2::ZERO).all()
                && corner.truncate().cmplt(glam::Vec2::ONE).all();
            if is_inside {
                interior += 1;
                let expected = field(corner.as_dvec3());
                assert!(
                    (value.x - expected).abs() <= 4.0 * ROUNDING,
                    "{corner}: {value}"
                );
            }
        }
    }
    assert!(interior > 1000);
}

/// Half of a square lies inside of a solid, and its values take no part in those around.
#[test]
fn what_lies_inside_of_solids_is_left_out() {
    let scene = unit_square(6);
    let (inside, outside): (Vec<PatchId>, Vec<PatchId>) =
        patches(&scene).partition(|&p| scene.patch(p).centroid().x < 0.5);
    let mut values = vec![Rgb::ZERO; scene.patch_count() as usize];
    for patch in &outside {
        values[patch.index()] = Rgb::ONE;
    }
    let scene = scene.with_inside(inside).unwrap();
    let smooth = VertexValues::new(&scene, &values);
    for patch in outside {
        let corners = smooth.corners(patch);
        assert!(
            corners
                .iter()
                .all(|value| value.abs_diff_eq(Rgb::ONE, ROUNDING)),
            "{corners:?}"
        );
    }
    assert!(
        patches(&scene).all(|patch| smooth.corners(patch).iter().all(|value| value.is_finite()))
    );
}

#[test]
fn smoothing_never_crosses_a_crease() {
    // The walls of a cube have a value each; 90 degrees lie between them.
    let scene = closed_cube(4);
    let values = values_by_surface(&scene, |surface| (surface / 2) as f32);
    let smooth = VertexValues::new(&scene, &values);
    for patch in patches(&scene) {
        assert_eq!(smooth.corners(patch), [values[patch.index()]; 3]);
    }
}

#[test]
fn smoothing_never_crosses_a_material_border() {
    let mut builder = Builder::default();
    let materials: [MaterialId; 3] = [
        builder.material(0.5, 0.0),
        builder.material(0.6, 0.0),
        builder.material(0.6, 1.0),
    ];
    for (k, material) in materials.into_iter().enumerate() {
        let (a, b) = (k as f32, k as f32 + 1.0);
        builder.quad(
            [[a, 0., 0.], [b, 0., 0.], [b, 1., 0.], [a, 1., 0.]],
            material,
            4,
        );
    }
    let scene = builder.scene();
    let values = values_by_surface(&scene, |surface| (surface / 2) as f32);
    let smooth = VertexValues::new(&scene, &values);
    for patch in patches(&scene) {
        assert_eq!(smooth.corners(patch), [values[patch.index()]; 3]);
    }
}

/// Ends of the fold below: coordinates whose halves have no exact f32.
const FOLD: [f32; 2] = [0.123_456_7, 0.987_654_3];

/// Two quads that meet at a line along y, folded by an angle, each with its own depth.
fn folded(degrees: f32, depths: [u32; 2]) -> Scene {
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let [a, b] = FOLD;
    builder.quad(
        [[-1., a, 0.], [0., a, 0.], [0., b, 0.], [-1., b, 0.]],
        material,
        depths[0],
    );
    builder.quad(
        [[0., a, 0.], [cos, a, sin], [cos, b, sin], [0., b, 0.]],
        material,
        depths[1],
    );
    builder.scene()
}

#[test]
fn gentle_folds_are_smoothed_and_sharp_ones_are_not() {
    for (degrees, is_smooth) in [(0.0, true), (22.5, true), (45.0, false), (170.0, false)] {
        let scene = folded(degrees, [4, 4]);
        let values = values_by_surface(&scene, |surface| (surface / 2) as f32);
        let smooth = VertexValues::new(&scene, &values);
        let crosses = patches(&scene).any(|p| smooth.corners(p) != [values[p.index()]; 3]);
        assert_eq!(crosses, is_smooth, "{degrees} degrees");
    }
}

#[test]
fn value_is_continuous_over_an_edge_that_one_side_bisects_more() {
    for depths in [[4, 4], [2, 3], [4, 6], [7, 2], [0, 5]] {
        let scene = folded(0.0, depths);
        let field = |p: DVec3| (1.0 + (7.0 * p.x).sin() * (11.0 * p.y).cos()) as f32;
        let values: Vec<Rgb> = patches(&scene)
            .map(|p| Rgb::splat(field(scene.patch(p).centroid())))
            .collect();
        let smooth = VertexValues::new(&scene, &values);
        // The values of points on the fold, as each patch along it has them.
        let mut at_edge = vec![Vec::new(); 256];
        for patch in patches(&scene) {
            let [a, b, c] = scene.patch(patch).corners;
            let [va, vb, vc] = smooth.corners(patch);
            for (p, q, vp, vq) in [(a, b, va, vb), (b, c, vb, vc), (c, a, vc, va)] {
                if p.x == 0.0 && q.x == 0.0 {
                    for (k, at) in at_edge.iter_mut().enumerate() {
                        let y = FOLD[0] + (FOLD[1] - FOLD[0]) * (k as f32 + 0.5) / 256.0;
                        let t = (y - p.y) / (q.y - p.y);
                        if (0.0..=1.0).contains(&t) {
                            at.push(vp.lerp(vq, t).x);
                        }
                    }
                }
            }
        }
        for (k, at) in at_edge.iter().enumerate() {
            assert!(at.len() == 2, "point {k} has {} sides", at.len());
            assert!(
                at.iter().all(|v| (v - at[0]).abs() <= 100.0 * ROUNDING),
                "{depths:?}, {k}: {at:?}"
            );
        }
    }
}

proptest! {
    #[test]
    fn smooth_values_stay_within_those_of_the_patches(
        seeds in prop::collection::vec(0.0_f32..100.0, 2 * 2 * 16)
    ) {
        let scene = folded(10.0, [4, 4]);
        let values: Vec<Rgb> = seeds.iter().map(|&v| Rgb::new(v, 2.0 * v, 1.0)).collect();
        let least = values.iter().copied().fold(Rgb::INFINITY, Vec3::min);
        let greatest = values.iter().copied().fold(Rgb::NEG_INFINITY, Vec3::max);
        let smooth = VertexValues::new(&scene, &values);
        for patch in patches(&scene) {
            for local in [CENTER, [1.0, 0.0, 0.0], [0.5, 0.5, 0.0], [0.2, 0.1, 0.7]] {
                let value = smooth.at(patch, local);
                let slack = ROUNDING * greatest;
                prop_assert!(value.cmpge(least - slack).all() && value.cmple(greatest + slack).all());
            }
        }
    }
}
