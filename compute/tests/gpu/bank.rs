//! Both rasters see in every pixel what the reference sees there, or within a hair of there.

use compute::gpu::Raster;
use compute::gpu::structs::MOST_MARGIN;
use compute::receivers::ReceiverId;
use scene::Scene;
use test_scenes::{Difference, VIEW_RESOLUTION, Views};

use crate::{open_with, settings};

/// How far from a pixel's centre, in pixels, a ray may see what is said of the pixel. Fronts are drawn larger by 16 units
/// in the last place, at most [`MOST_MARGIN`], and rounding takes up to 30 of these units (see [`FRONT_FACE_OUTSET`]), by
/// which the borders between patches are off too. Measured is less than one [`MOST_MARGIN`].
///
/// [`FRONT_FACE_OUTSET`]: compute::gpu::structs::FRONT_FACE_OUTSET
const HAIR: f64 = (16.0 + 30.0) / 16.0 * MOST_MARGIN as f64;

fn compare(scene: &Scene, raster: Raster, views: &Views) -> Difference {
    let mut gpu = open_with(scene, settings(VIEW_RESOLUTION), Some(raster));
    views.compare(HAIR, |patch, frame| {
        gpu.item_buffer(ReceiverId(patch.0), frame).unwrap()
    })
}

pub fn both_rasters_see_what_the_reference_sees() {
    for (name, scene) in test_scenes::bank() {
        let views = Views::of(&scene);
        for raster in [Raster::Pipeline, Raster::Compute] {
            let difference = compare(&scene, raster, &views);
            println!("{name}, {raster:?}: {difference}");
            assert_eq!(difference.wrong, 0, "{name}, {raster:?}: {difference}");
        }
    }
}

pub fn a_moved_corner_makes_them_disagree() {
    let (scene, moved) = test_scenes::moved_corner();
    let difference = compare(&moved, Raster::Pipeline, &Views::of(&scene));
    assert!(difference.wrong > 0, "{difference}");
}
