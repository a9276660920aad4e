//! All strategies show the same.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use scene::{PatchId, Scene, SurfaceId};
use test_scenes::{bumpy_sphere, furnished_sphere, stone};
use visibility::hemicube::MAX_RESOLUTION;
use visibility::item_buffer::{BACK_FACE, HemicubeDrawer, NOTHING};
use visibility::{Drawable, Frame, Strategy};

/// All is drawn; what is small is specks; rays are cast for all.
fn all_strategies(scene: &Scene) -> [Arc<Drawable<'_>>; 3] {
    [Strategy::Spans, Strategy::Specks, Strategy::Rays]
        .map(|strategy| Arc::new(Drawable::with_strategy(scene, strategy)))
}

/// The surface of a patch, and a frame at its centroid, turned by an angle of its own.
fn stand_on(scene: &Scene, patch: PatchId) -> (SurfaceId, Frame) {
    let geometry = scene.patch(patch);
    let normal = scene.surface(geometry.surface).normal();
    let turn = 0.7 * f64::from(patch.0);
    let frame = Frame::on_patch(&geometry, normal, geometry.centroid(), turn);
    (geometry.surface, frame)
}

/// Where the two see different surfaces, these have an edge in common, or a corner: the pixel lies on it. Patches of
/// a surface are looked up in the same way.
#[test]
fn specks_and_rays_show_what_is_drawn_but_on_edges() {
    // Where pixels are so large all clusters but the nearest are distant.
    for (max_area, resolution) in [(f64::INFINITY, 64), (0.002, 64), (0.002, 16)] {
        let scene = stone(&furnished_sphere(), max_area);
        let drawables = all_strategies(&scene);
        let mut drawers = drawables
            .each_ref()
            .map(|d| HemicubeDrawer::new(d, resolution));
        let (mut pixels, mut differing, mut backs) = (0, [0; 2], [0; 2]);
        let step = (scene.patch_count() / 40) as usize;
        for patch in (0..scene.patch_count()).step_by(step).map(PatchId) {
            let (own, frame) = stand_on(&scene, patch);
            let [drawn, others @ ..] = drawers.each_mut().map(|d| d.item_buffer(own, &frame));
            pixels += drawn.len();
            for (k, other) in others.iter().enumerate() {
                backs[k] += other.iter().filter(|&&id| id == BACK_FACE).count();
                for (&a, &b) in drawn.iter().zip(other).filter(|(a, b)| a != b) {
                    differing[k] += 1;
                    assert!(a < NOTHING && b < NOTHING, "{k}, {patch:?}: {a} and {b}");
                    let [a, b] = [a, b].map(|id| scene.mesh().surface_of(PatchId(id)));
                    let near = are_neighbours(&scene, a, b);
                    assert!(near, "{k}, {patch:?}: {a:?} and {b:?}");
                }
            }
        }
        println!("{differing:?} of {pixels} pixels differ");
        assert!(!backs.contains(&0), "no back was seen");
        // Margins move edges by some 8e-7 m, which from a metre is 3e-5 of the 32 pixels of a radian, and a
        // pixel has some three pixels of edges in it: 1e-4 of the pixels, or twice that. Larger pixels have more
        // edges in them, which are moved by less.
        let most = pixels / 5000;
        assert!(
            differing.iter().all(|&n| n < most),
            "{differing:?} of {pixels}"
        );
    }
}

fn are_neighbours(scene: &Scene, a: SurfaceId, b: SurfaceId) -> bool {
    let [a, b] = [a, b].map(|id| scene.surface(id).corners);
    a.iter().any(|corner| b.contains(corner))
}

#[test]
fn nothing_is_seen_between_triangles() {
    let scene = stone(&bumpy_sphere(24), f64::INFINITY);
    for drawable in &all_strategies(&scene) {
        let mut drawer = HemicubeDrawer::new(drawable, 128);
        for patch in (0..scene.patch_count()).step_by(97).map(PatchId) {
            let (own, frame) = stand_on(&scene, patch);
            let ids = drawer.item_buffer(own, &frame);
            assert!(!ids.contains(&NOTHING), "{patch:?}");
            // Bumps are seen from their fronts alone.
            assert!(!ids.contains(&BACK_FACE), "{patch:?}");
        }
    }
}

/// Triangles at the same place, and a hierarchy that cannot tell them apart: the first in the scene wins.
#[test]
fn the_first_of_equals_is_seen() {
    let [a, b, c] = [Vec3::ZERO, Vec3::X, Vec3::Y];
    let above = [Vec3::Z, Vec3::Z + Vec3::Y, Vec3::Z + Vec3::X];
    let scene = stone(&[[a, b, c], above, above, above, above, above, above], 1.0);
    let drawables = all_strategies(&scene);
    let (own, frame) = stand_on(&scene, PatchId(0));
    for drawable in &drawables {
        let ids = HemicubeDrawer::new(drawable, 32).item_buffer(own, &frame);
        assert!(ids.iter().all(|&id| id == 1 || id == NOTHING));
        assert!(ids.contains(&1));
    }
}

/// A corner in the last half pixel of the last face and one below the horizon are just as far apart as the largest
/// hemicube is wide.
#[test]
fn regression_a_surface_overhead_is_seen_at_the_highest_resolution() {
    let own = [
        Vec3::new(-1.0, -1.0, 0.0),
        Vec3::new(1.0, -1.0, 0.0),
        Vec3::new(0.0, 2.0, 0.0),
    ];
    let over = [
        Vec3::new(0.9999, -1.0, 2e-4),
        Vec3::new(-0.5, 1.2, -1e-5),
        Vec3::new(-1.0, 1.0, -1e-5),
    ];
    let below = |x: f32| {
        [
            Vec3::new(x, 0.0, -9.0),
            Vec3::new(x + 0.5, 0.0, -9.0),
            Vec3::new(x, 1.0, -9.0),
        ]
    };
    let scene = stone(&[own, over, below(0.0), below(2.0), below(4.0)], 1e9);
    let frame = Frame {
        position: DVec3::ZERO,
        tangent: DVec3::X,
        bitangent: DVec3::Y,
        normal: DVec3::Z,
    };
    let seen = all_strategies(&scene).map(|drawable| {
        let mut seen = 0;
        let mut drawer = HemicubeDrawer::new(&drawable, MAX_RESOLUTION);
        drawer.draw(SurfaceId(0), &frame, NOTHING, BACK_FACE, |_, _, ids| {
            seen += ids.iter().filter(|&&id| id != NOTHING).count();
        });
        seen
    });
    assert!(seen[0] > 0 && seen == [seen[0]; 3], "{seen:?}");
}
