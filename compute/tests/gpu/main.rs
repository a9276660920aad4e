//! Laws of the gpu back end, and its agreement with its twin on the cpu and with the reference. Ignored without an
//! adapter; with `REQUIRE_GPU=1` they fail instead.

mod bank;
mod closure;
mod lost_device;
mod model;
mod rasters;
mod rows;
mod twins;

use std::sync::{Arc, LazyLock};

use compute::gpu::adapter::Gpu;
use compute::gpu::{GpuRows, Raster};
use compute::hemicubes::Hemicubes;
use compute::rows::BackendError;
use compute::settings::AdapterChoice;
use compute::settings::{FormFactorSettings, Points};
use scene::Scene;
use test_needs::{ExitCode, laws, run};

fn main() -> ExitCode {
    run(laws![an_adapter =>
        bank::both_rasters_see_what_the_reference_sees,
        bank::a_moved_corner_makes_them_disagree,
        closure::walls_that_touch_without_sharing_corners_leak_nothing,
        closure::walls_that_touch_only_within_rounding_leak_nothing,
        closure::walls_seen_from_near_their_edges_leak_nothing,
        closure::backs_of_a_closed_body_hide_everything,
        closure::an_opening_is_as_large_as_the_cpu_sees_it,
        lost_device::a_lost_device_is_an_error_from_then_on_and_no_panic,
        rasters::both_rasters_give_the_same_item_buffers,
        rasters::both_rasters_see_all_of_more_surfaces_than_a_workgroup_has_threads,
        rasters::a_moved_surface_makes_the_rasters_disagree,
        rasters::both_rasters_give_the_same_rows,
        rasters::the_raster_that_was_taken_is_told,
        rows::rows_are_the_sums_of_their_item_buffers_to_the_bit,
        rows::a_hemicube_larger_than_a_texture_is_drawn_in_parts,
        rows::rows_of_half_a_million_patches_are_complete,
        rows::closed_room_sees_itself_completely,
        rows::rows_depend_on_no_batch_size_and_on_no_run,
        rows::no_rows_are_asked_for_and_none_come,
        twins::twins_see_the_same_but_for_pixels_on_edges,
        twins::regression_twins_see_the_same_in_a_room_far_from_something,
        twins::a_moved_surface_makes_the_twins_disagree,
        twins::backs_and_openings_are_seen_where_the_cpu_sees_them,
        twins::twins_form_factors_agree,
    ])
}

/// The need of all of them. An adapter that there is and that cannot be used is a failure of the tests.
fn an_adapter() -> Result<(), String> {
    static IS_THERE: LazyLock<bool> = LazyLock::new(|| {
        let opened = Gpu::open(AdapterChoice::Any);
        !matches!(opened, Err(BackendError::NoAdapter))
    });
    test_needs::adapter(*IS_THERE)
}

fn settings(resolution: u32) -> FormFactorSettings {
    FormFactorSettings {
        points: Points::CENTROID,
        ..FormFactorSettings::new(resolution)
    }
}

/// A back end on the best adapter.
fn open(scene: &Scene, settings: FormFactorSettings) -> GpuRows<'_> {
    open_with(scene, settings, None)
}

/// The same with a raster of one's own choice, where one is given.
fn open_with(scene: &Scene, settings: FormFactorSettings, raster: Option<Raster>) -> GpuRows<'_> {
    let hemicubes = Arc::new(Hemicubes::new(scene, settings));
    GpuRows::with_raster(&hemicubes, AdapterChoice::Any, raster)
        .unwrap_or_else(|error| panic!("{error}"))
}
