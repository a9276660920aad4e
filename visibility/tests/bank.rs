//! Every strategy sees in every pixel what the reference sees there, or within a hair of there.

use std::sync::Arc;

use scene::Scene;
use test_scenes::{Difference, VIEW_RESOLUTION, Views};
use visibility::item_buffer::HemicubeDrawer;
use visibility::{Drawable, Strategy};

/// How far from a pixel's centre, in pixels, a ray may see what is said of the pixel: fronts are drawn larger by 1/256
/// at most, and where a surface gives way to its neighbour is right to 1/1024.
const HAIR: f64 = 1.5 / 256.0;

fn compare(scene: &Scene, strategy: Strategy, views: &Views) -> Difference {
    let drawable = Arc::new(Drawable::with_strategy(scene, strategy));
    let mut drawer = HemicubeDrawer::new(&drawable, VIEW_RESOLUTION);
    views.compare(HAIR, |patch, frame| {
        drawer.item_buffer(scene.mesh().surface_of(patch), frame)
    })
}

#[test]
fn every_strategy_sees_what_the_reference_sees() {
    for (name, scene) in test_scenes::bank() {
        let views = Views::of(&scene);
        for strategy in [
            Strategy::Cheapest,
            Strategy::Spans,
            Strategy::Specks,
            Strategy::Rays,
        ] {
            let difference = compare(&scene, strategy, &views);
            println!("{name}, {strategy:?}: {difference}");
            assert_eq!(difference.wrong, 0, "{name}, {strategy:?}: {difference}");
        }
    }
}

/// A corner that is a hundredth of a metre off is seen in some pixels, and in none of them is that a hair.
#[test]
fn a_moved_corner_makes_them_disagree() {
    let (scene, moved) = test_scenes::moved_corner();
    let difference = compare(&moved, Strategy::Cheapest, &Views::of(&scene));
    assert!(difference.wrong > 0, "{difference}");
}
