//! The fixed pipeline and the compute shader see the same, to the bit. No tolerance anywhere: what a pixel
//! sees follows from the same arithmetic.

use compute::gpu::Raster;
use compute::hemicubes::Hemicubes;
use compute::receivers::ReceiverId;
use compute::rows::RowSource;
use compute::settings::{FormFactorSettings, Points};
use scene::{PatchId, Scene};
use visibility::item_buffer::{BACK_FACE, NOTHING};

use crate::model::{
    Model, fine_patchwork_room, patchwork_room, room, room_far_from_a_box, room_with_block, ruin,
};
use crate::{open, open_with, settings};

/// Pixels that differ between the rasters on some patches, the pipeline drawing the first scene and the compute
/// shader the second; and how many pixels there are, and how many see no patch.
fn compare(on_pipeline: &Scene, on_compute: &Scene, resolution: u32, count: u32) -> [usize; 3] {
    let settings = FormFactorSettings {
        points: Points::Vertices,
        ..settings(resolution)
    };
    let mut pipeline = open_with(on_pipeline, settings, Some(Raster::Pipeline));
    let mut compute = open_with(on_compute, settings, Some(Raster::Compute));
    let hemicubes = Hemicubes::new(on_pipeline, settings);
    let patches = on_pipeline.patch_count();
    let mut counts = [0; 3];
    for k in 0..count {
        let patch = PatchId(k * patches / count);
        // Near a corner, where much is seen at grazing angles.
        let frame = hemicubes.receivers().frames(ReceiverId(patch.0))[k as usize % 3];
        let a = pipeline.item_buffer(ReceiverId(patch.0), &frame).unwrap();
        let b = compute.item_buffer(ReceiverId(patch.0), &frame).unwrap();
        counts[0] += a.iter().zip(&b).filter(|(a, b)| a != b).count();
        counts[1] += a.len();
        counts[2] += a
            .iter()
            .filter(|&&id| matches!(id, NOTHING | BACK_FACE))
            .count();
    }
    counts
}

pub fn both_rasters_give_the_same_item_buffers() {
    let upright = Model {
        is_upright: true,
        ..room_with_block()
    };
    for (name, model, max_area, is_closed) in [
        ("ruin", ruin(), 0.1, false),
        ("block", room_with_block(), 0.1, true),
        ("upright block", upright, 0.1, true),
        ("patchwork", patchwork_room(), 0.1, true),
        ("far box", room_far_from_a_box(), f64::INFINITY, false),
    ] {
        let scene = model.scene(max_area);
        for (resolution, count) in [(2, 24), (50, 12), (128, 6)] {
            let [different, pixels, unseen] = compare(&scene, &scene, resolution, count);
            println!("{name}, {resolution}: {different} of {pixels}, {unseen} see no patch");
            assert_eq!(different, 0, "{name}, {resolution}: of {pixels}");
            assert!(!is_closed || unseen == 0, "{name}, {resolution}: {unseen}");
        }
    }
}

/// Several rounds of a workgroup's threads, and several surfaces for each thread.
pub fn both_rasters_see_all_of_more_surfaces_than_a_workgroup_has_threads() {
    let scene = fine_patchwork_room().scene(f64::INFINITY);
    assert!(scene.surfaces().len() > 5000);
    let [different, pixels, unseen] = compare(&scene, &scene, 100, 6);
    assert_eq!([different, unseen], [0, 0], "of {pixels}");
}

pub fn a_moved_surface_makes_the_rasters_disagree() {
    let scene = room().scene(0.1);
    let mut moved = room();
    // A corner of a box's top, by a thousandth of the box.
    let triangle = moved.triangles.len() - 10;
    moved.triangles[triangle][0].x += 0.0007;
    let [different, ..] = compare(&scene, &moved.scene(0.1), 100, 24);
    assert!(different > 0);
}

pub fn both_rasters_give_the_same_rows() {
    let scene = ruin().scene(0.05);
    let settings = FormFactorSettings {
        points: Points::Auto,
        ..settings(64)
    };
    let rows = |raster| {
        let mut gpu = open_with(&scene, settings, Some(raster));
        gpu.draw_rows(0..30).unwrap()
    };
    assert!(rows(Raster::Pipeline) == rows(Raster::Compute));
}

pub fn the_raster_that_was_taken_is_told() {
    let scene = room().scene(f64::INFINITY);
    let gpu = open(&scene, settings(16));
    let told = gpu.describe();
    let taken = [Raster::Pipeline, Raster::Compute].map(|raster| told.ends_with(raster.describe()));
    assert!(taken[0] != taken[1], "{told}");
    for raster in [Raster::Pipeline, Raster::Compute] {
        let told = open_with(&scene, settings(16), Some(raster)).describe();
        assert!(told.ends_with(raster.describe()), "{told}");
    }
}
