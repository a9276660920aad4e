//! What a hand with a mouse and keys does to the camera.

use display::Camera;
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Sense, Vec2, pos2};
use egui_kittest::Harness;
use glam::DVec3;
use window::camera_control::{CameraControl, Pose};
use window::gestures;
use window::saved_views::SavedViews;

type State = (CameraControl, SavedViews);

fn harness() -> Harness<'static, State> {
    let camera = Camera::new(DVec3::new(1.0, 2.0, 1.0), DVec3::Y, DVec3::Z, 60.0);
    let control = CameraControl::new(&camera, DVec3::Z, [DVec3::ZERO, DVec3::splat(5.0)]);
    let app = |ui: &mut egui::Ui, (control, views): &mut State| {
        let picture = ui.allocate_response(ui.available_size(), Sense::click_and_drag());
        gestures::apply(ui, &picture, control, views);
    };
    let mut harness = Harness::builder()
        .with_size([400.0, 300.0])
        .build_ui_state(app, (control, SavedViews::default()));
    harness.step();
    harness
}

fn pose(harness: &Harness<'static, State>) -> Pose {
    harness.state().0.pose()
}

fn drag(harness: &mut Harness<'static, State>, button: PointerButton, modifiers: Modifiers) {
    let press = |pos: Pos2, pressed| Event::PointerButton {
        pos,
        button,
        pressed,
        modifiers,
    };
    let (from, to) = (pos2(200.0, 150.0), pos2(260.0, 170.0));
    for events in [
        vec![
            Event::ModifiersChanged(modifiers),
            Event::PointerMoved(from),
        ],
        vec![press(from, true)],
        vec![Event::PointerMoved(to)],
        vec![press(to, false), Event::ModifiersChanged(Modifiers::NONE)],
    ] {
        harness.input_mut().events.extend(events);
        harness.step();
    }
}

fn press(harness: &mut Harness<'static, State>, key: Key, modifiers: Modifiers) {
    harness.key_press_modifiers(modifiers, key);
    harness.step();
    harness.step();
}

/// f64 rounding of some ten operations on numbers up to ten.
const ROUNDING: f64 = 1e-12;

#[test]
fn a_left_drag_turns_about_the_target() {
    let mut harness = harness();
    let before = pose(&harness);
    drag(&mut harness, PointerButton::Primary, Modifiers::NONE);
    let after = pose(&harness);
    assert_eq!(after.target, before.target);
    assert!(after.forward.distance(before.forward) > 0.1);
    // The scene follows the pointer to the right and down: one looks to the right and from above.
    assert!(after.forward.x > 0.0 && after.forward.z < 0.0);
}

#[test]
fn a_middle_drag_and_one_with_shift_move_the_picture() {
    for (button, modifiers) in [
        (PointerButton::Middle, Modifiers::NONE),
        (PointerButton::Primary, Modifiers::SHIFT),
    ] {
        let mut harness = harness();
        let before = pose(&harness);
        drag(&mut harness, button, modifiers);
        let after = pose(&harness);
        assert_eq!(after.forward, before.forward);
        assert!(after.target.x < before.target.x && after.target.z > before.target.z);
    }
}

#[test]
fn a_right_drag_looks_about() {
    let mut harness = harness();
    let before = pose(&harness);
    drag(&mut harness, PointerButton::Secondary, Modifiers::NONE);
    let after = pose(&harness);
    assert!(after.eye().distance(before.eye()) < ROUNDING);
    assert!(after.forward.x > 0.0 && after.forward.z < 0.0);
}

#[test]
fn the_wheel_goes_nearer_and_farther() {
    for (notches, is_nearer) in [(1.0, true), (-1.0, false)] {
        let mut harness = harness();
        let before = pose(&harness);
        harness.hover_at(pos2(200.0, 150.0));
        harness.step();
        harness.event(Event::MouseWheel {
            unit: MouseWheelUnit::Line,
            delta: Vec2::new(0.0, notches),
            phase: egui::TouchPhase::Move,
            source: egui::MouseWheelSource::Wheel,
            modifiers: Modifiers::NONE,
        });
        for _ in 0..10 {
            harness.step();
        }
        let after = pose(&harness);
        assert_eq!(after.target, before.target);
        assert!((after.distance < before.distance) == is_nearer);
        assert!((after.distance / before.distance).ln().abs() > 0.1);
    }
}

#[test]
fn keys_fly_and_home_leads_back() {
    for key in [Key::W, Key::A, Key::S, Key::D, Key::Q, Key::E] {
        let mut harness = harness();
        let before = pose(&harness);
        harness.key_down(key);
        harness.step();
        harness.step();
        harness.key_up(key);
        harness.step();
        assert!(
            pose(&harness).eye().distance(before.eye()) > 1e-3,
            "{key:?}"
        );
        press(&mut harness, Key::Home, Modifiers::NONE);
        assert_eq!(pose(&harness), before);
    }
}

#[test]
fn digits_lead_back_to_the_views_that_they_have_kept() {
    let mut harness = harness();
    let first = pose(&harness);
    press(&mut harness, Key::Num1, Modifiers::COMMAND);
    drag(&mut harness, PointerButton::Primary, Modifiers::NONE);
    let second = pose(&harness);
    press(&mut harness, Key::Num9, Modifiers::COMMAND);
    press(&mut harness, Key::Num1, Modifiers::NONE);
    assert_eq!(pose(&harness), first);
    press(&mut harness, Key::Num9, Modifiers::NONE);
    assert_eq!(pose(&harness), second);
    // Nothing is kept there.
    press(&mut harness, Key::Num5, Modifiers::NONE);
    assert_eq!(pose(&harness), second);
}
