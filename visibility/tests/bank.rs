//! Every strategy sees in every pixel what the reference sees there, or within a hair of there.

use std::sync::Arc;

use scene::{PatchId, Scene, SurfaceId};
use visibility::item_buffer::HemicubeDrawer;
use visibility::reference::{self, Reference};
use visibility::{Drawable, Eye, Frame, Strategy, hemicube};

/// Pixels along a face.
const RESOLUTION: u32 = 32;

/// Hemicubes a scene.
const HEMICUBES: u32 = 12;

/// How far from a pixel's centre, in pixels, a ray may see what is said of the pixel: fronts are drawn larger by 1/256
/// at most, and where a surface gives way to its neighbour is right to 1/1024.
const HAIR: f64 = 1.5 / 256.0;

/// What the reference sees a hair beside a pixel's centre, in some directions and distances.
fn beside(reference: &Reference, pixel: usize) -> Vec<u32> {
    let size = RESOLUTION as usize;
    let (i, j) = (pixel % size, pixel / size);
    let (face, j) = if j < size {
        (0, j)
    } else {
        (1 + (j - size) / (size / 2), (j - size) % (size / 2))
    };
    let window = hemicube::windows(RESOLUTION)[face];
    let ray = window.direction(i, j);
    let steps = [1.0, 0.25, 1.0 / 16.0].map(|share| share * HAIR * window.pixel);
    let around = (0..16).map(|k| f64::from(k) * std::f64::consts::TAU / 16.0);
    around
        .flat_map(|angle| steps.map(|step| (step * angle.cos(), step * angle.sin())))
        .map(|(x, y)| reference.along(ray + x * window.right + y * window.up))
        .collect()
}

/// A hemicube, and what the reference sees through it.
struct Expected<'a> {
    own: SurfaceId,
    frame: Frame,
    ids: Vec<u32>,
    reference: Reference<'a>,
}

/// Hemicubes all over a scene.
fn expected(scene: &Scene) -> Vec<Expected<'_>> {
    let patches = (0..HEMICUBES).map(|k| PatchId(scene.patch_count() / HEMICUBES * k));
    patches
        .map(|patch| {
            let geometry = scene.patch(patch);
            let own = geometry.surface;
            let normal = scene.surface(own).normal();
            let turn = 0.7 * f64::from(patch.0);
            let frame = Frame::on_patch(&geometry, normal, geometry.centroid(), turn);
            Expected {
                own,
                frame,
                ids: reference::item_buffer(scene, own, &frame, RESOLUTION),
                reference: Reference::new(scene, &Eye::with_horizon(&frame, own)),
            }
        })
        .collect()
}

/// How a strategy's pictures differ from what is expected: pixels in all, those that differ, and those among them that
/// see what the reference sees nowhere within a hair.
fn compare(scene: &Scene, strategy: Strategy, expected: &[Expected]) -> [usize; 3] {
    let drawable = Arc::new(Drawable::with_strategy(scene, strategy));
    let mut drawer = HemicubeDrawer::new(&drawable, RESOLUTION);
    let mut counts = [0; 3];
    for hemicube in expected {
        let seen = drawer.item_buffer(hemicube.own, &hemicube.frame);
        counts[0] += seen.len();
        for (pixel, (&id, &expected)) in seen.iter().zip(&hemicube.ids).enumerate() {
            if id != expected {
                counts[1] += 1;
                counts[2] += usize::from(!beside(&hemicube.reference, pixel).contains(&id));
            }
        }
    }
    counts
}

#[test]
fn every_strategy_sees_what_the_reference_sees() {
    for (name, scene) in test_scenes::bank() {
        let expected = expected(&scene);
        for strategy in [
            Strategy::Cheapest,
            Strategy::Spans,
            Strategy::Specks,
            Strategy::Rays,
        ] {
            let [pixels, differing, wrong] = compare(&scene, strategy, &expected);
            println!("{name}, {strategy:?}: {differing} of {pixels} pixels differ");
            assert_eq!(wrong, 0, "{name}, {strategy:?}");
        }
    }
}

/// A corner that is a hundredth of a metre off is seen in some pixels, and in none of them is that a hair.
#[test]
fn a_moved_corner_makes_them_disagree() {
    let (_, scene) = test_scenes::bank().swap_remove(0);
    let expected = expected(&scene);
    let mut surfaces = scene.surfaces().to_vec();
    let last = surfaces.len() - 1;
    surfaces[last].corners[0].z += 0.01;
    let moved = test_scenes::scene(scene.materials().to_vec(), surfaces, 0.3);
    let [_, _, wrong] = compare(&moved, Strategy::Cheapest, &expected);
    assert!(wrong > 0);
}
