//! What a hand does with mouse and keys, as moves of the camera.
//!
//! | gesture | move |
//! |---|---|
//! | left drag | orbit |
//! | middle drag, shift and left drag | pan |
//! | wheel | zoom |
//! | right drag | look about |
//! | W A S D, Q E | fly ahead, left, back, right; down, up |
//! | Home | the start |
//! | 1 to 9 | a saved view; with Ctrl it is saved |

use egui::{Key, PointerButton, Response, Ui};

use crate::camera_control::{CameraControl, Course};
use crate::saved_views::SavedViews;

/// Half a turn for a drag over a picture's height.
const RADIANS_PER_HEIGHT: f64 = std::f64::consts::PI;
/// The factor of the distance for a wheel's notch of 50 points is about three quarters. Tuned by hand.
const ZOOM_PER_POINT: f64 = 0.006;
/// Flight in a second, as a share of the scene's size. Tuned by hand on rooms.
const FLIGHT: f64 = 0.15;
/// The longest time that a frame's flight counts for, seconds.
const LONGEST_FRAME: f64 = 0.25;

const DIGITS: [Key; 9] = [
    Key::Num1,
    Key::Num2,
    Key::Num3,
    Key::Num4,
    Key::Num5,
    Key::Num6,
    Key::Num7,
    Key::Num8,
    Key::Num9,
];

/// Moves the camera as the hand over a picture asks. True if some key is held that moves it on.
pub fn apply(
    ui: &Ui,
    picture: &Response,
    control: &mut CameraControl,
    views: &mut SavedViews,
) -> bool {
    drag(ui, picture, control);
    if picture.hovered() {
        let wheel = ui.input(|input| f64::from(input.smooth_scroll_delta.y));
        if wheel != 0.0 {
            control.zoom((-ZOOM_PER_POINT * wheel).exp());
        }
    }
    // Letters that are typed into a field move nothing.
    if ui.ctx().egui_wants_keyboard_input() {
        return false;
    }
    recall(ui, control, views);
    fly(ui, control)
}

fn drag(ui: &Ui, picture: &Response, control: &mut CameraControl) {
    let delta = picture.drag_delta();
    if delta == egui::Vec2::ZERO {
        return;
    }
    let height = f64::from(picture.rect.height().max(1.0));
    let [right, down] = [delta.x, delta.y].map(|points| f64::from(points) / height);
    let is_shifted = ui.input(|input| input.modifiers.shift);
    if picture.dragged_by(PointerButton::Middle)
        || picture.dragged_by(PointerButton::Primary) && is_shifted
    {
        control.pan(right, -down);
    } else if picture.dragged_by(PointerButton::Primary) {
        // The scene follows the pointer, so that the line of sight goes the other way.
        control.orbit(-RADIANS_PER_HEIGHT * right, -RADIANS_PER_HEIGHT * down);
    } else if picture.dragged_by(PointerButton::Secondary) {
        control.look(-RADIANS_PER_HEIGHT * right, -RADIANS_PER_HEIGHT * down);
    }
}

fn recall(ui: &Ui, control: &mut CameraControl, views: &mut SavedViews) {
    ui.input(|input| {
        if input.key_pressed(Key::Home) {
            control.reset();
        }
        for (index, &key) in DIGITS.iter().enumerate() {
            if !input.key_pressed(key) {
                continue;
            }
            if input.modifiers.command {
                views.store(index, control.pose());
            } else if let Some(pose) = views.recall(index) {
                control.go_to(pose);
            }
        }
    });
}

fn fly(ui: &Ui, control: &mut CameraControl) -> bool {
    let (course, seconds): (Course, f64) = ui.input(|input| {
        let along = |more: Key, less: Key| {
            let is_down = |key| f64::from(u8::from(input.key_down(key)));
            is_down(more) - is_down(less)
        };
        let course = [
            along(Key::D, Key::A),
            along(Key::E, Key::Q),
            along(Key::W, Key::S),
        ];
        let is_free = !input.modifiers.command && !input.modifiers.alt;
        let course = if is_free { course } else { [0.0; 3] };
        (course, f64::from(input.unstable_dt).min(LONGEST_FRAME))
    });
    let is_flying = course.iter().any(|&axis| axis != 0.0);
    if is_flying {
        control.fly(course, FLIGHT * control.scene_size() * seconds);
    }
    is_flying
}
