//! Pictures that the graphics card draws, held against those of `display`. Ignored without an adapter; with `REQUIRE_GPU=1` they
//! fail instead.

mod colors;
mod model;
mod patches;

use std::sync::LazyLock;

use test_needs::{ExitCode, laws, run};

fn main() -> ExitCode {
    run(laws![an_adapter =>
        colors::every_mode_shows_the_colours_of_display,
        colors::every_channel_of_the_function_is_shown_as_display_shows_it,
        colors::another_exposure_would_be_noticed,
        colors::ids_have_the_colours_of_display,
        patches::every_sample_sees_the_patch_that_display_sees,
        patches::backs_hide_what_is_behind_them_if_they_are_drawn,
        patches::a_click_picks_the_patch_that_is_drawn_there,
        patches::an_outline_lies_on_the_picked_patch_alone,
        patches::wires_change_colours_and_no_patch,
        patches::a_picture_of_no_scene_is_empty,
    ])
}

/// The need of all of them.
fn an_adapter() -> Result<(), String> {
    static IS_THERE: LazyLock<bool> = LazyLock::new(|| model::adapter().is_some());
    test_needs::adapter(*IS_THERE)
}
