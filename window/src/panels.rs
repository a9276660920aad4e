//! The panel in which one chooses what is shown, and sees what is picked.

use display::number;
use display::{Channel, Mode, Quantity, Range};
use egui::{DragValue, RadioButton, Slider, Ui};
use scene::PatchId;

use crate::camera_control::CameraControl;
use crate::loaded::Loaded;
use crate::looks::{Looks, STOPS};
use crate::pick::Facts;
use crate::saved_views::{COUNT, SavedViews};

const MODES: [Mode; 5] = [
    Mode::Log,
    Mode::Filmic,
    Mode::Linear,
    Mode::FalseColor,
    Mode::Ids,
];

const QUANTITIES: [Quantity; 8] = [
    Quantity::Radiosity,
    Quantity::Radiance,
    Quantity::Irradiance,
    Quantity::Emission,
    Quantity::Direct,
    Quantity::Indirect,
    Quantity::Reflectance,
    Quantity::Error,
];

const CHANNELS: [(Channel, &str); 5] = [
    (Channel::All, "all"),
    (Channel::Luminance, "luminance"),
    (Channel::Red, "red"),
    (Channel::Green, "green"),
    (Channel::Blue, "blue"),
];

/// What is shown and how. `suiting` is the range that suits the values.
pub fn looks(ui: &mut Ui, looks: &mut Looks, loaded: &Loaded, suiting: Range) {
    mode(ui, looks);
    ui.separator();
    ui.add_enabled_ui(looks.mode != Mode::Ids, |ui| {
        quantity(ui, looks, loaded);
        ui.separator();
        range(ui, looks, suiting);
    });
    ui.separator();
    ui.checkbox(&mut looks.has_wires, "wireframe of patches");
    ui.checkbox(&mut looks.has_backs, "backs of surfaces");
}

fn mode(ui: &mut Ui, looks: &mut Looks) {
    ui.strong("Mode");
    let before = looks.mode;
    ui.horizontal_wrapped(|ui| {
        for mode in MODES {
            ui.radio_value(&mut looks.mode, mode, mode.to_string());
        }
    });
    if looks.mode != before {
        // A range that suits one scale rarely suits another.
        looks.range = None;
    }
}

fn quantity(ui: &mut Ui, looks: &mut Looks, loaded: &Loaded) {
    ui.strong("Quantity");
    let before = (looks.shown.quantity, looks.shown.is_luminous);
    egui::Grid::new("quantities").num_columns(2).show(ui, |ui| {
        for row in QUANTITIES.chunks(2) {
            for &quantity in row {
                let is_shown = looks.shown.quantity == quantity;
                let button = RadioButton::new(is_shown, quantity.to_string());
                let response = ui.add_enabled(loaded.has(quantity), button);
                if response.on_disabled_hover_text(missing(quantity)).clicked() {
                    looks.shown.quantity = quantity;
                }
            }
            ui.end_row();
        }
    });
    ui.horizontal_wrapped(|ui| {
        for (channel, name) in CHANNELS {
            ui.radio_value(&mut looks.shown.channel, channel, name);
        }
    });
    let has_lumens = looks.shown.quantity != Quantity::Reflectance;
    looks.shown.is_luminous &= has_lumens;
    ui.add_enabled_ui(has_lumens, |ui| {
        ui.checkbox(&mut looks.shown.is_luminous, "luminous units");
    });
    ui.add_enabled_ui(loaded.has_function(), |ui| {
        ui.checkbox(&mut looks.is_flat, "one value a patch");
    });
    if (looks.shown.quantity, looks.shown.is_luminous) != before {
        looks.range = None;
    }
}

/// Why a file does not have a quantity.
fn missing(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Error => {
            "nothing has estimated the error of this file; compute --target-error does"
        }
        _ => {
            "the file has no light between patches, which alone tells direct from indirect; compute --quality standard does"
        }
    }
}

fn range(ui: &mut Ui, looks: &mut Looks, suiting: Range) {
    let unit = looks.shown.unit();
    ui.add(Slider::new(&mut looks.exposure_stops, STOPS).text("exposure, stops"));
    let mut is_by_hand = looks.range.is_some();
    ui.checkbox(&mut is_by_hand, "range by hand");
    if is_by_hand {
        let range = looks.range.get_or_insert(suiting);
        for (name, end) in [("low", &mut range.low), ("high", &mut range.high)] {
            ui.horizontal(|ui| {
                let label = ui.label(name);
                // A twentieth of its value or of the scale a step, whatever its unit.
                let speed = 0.01 * end.abs().max(1e-3 * suiting.high.abs());
                let suffix = format!(" {unit}");
                ui.add(
                    DragValue::new(end)
                        .speed(speed)
                        .suffix(suffix)
                        .max_decimals(6),
                )
                .labelled_by(label.id);
            });
        }
    } else {
        looks.range = None;
    }
    let [low, high] = number::ends(looks.exposed(suiting));
    ui.label(format!("{low} to {high} {unit}"));
}

/// Where the camera is.
pub fn camera(ui: &mut Ui, control: &mut CameraControl, views: &mut SavedViews) {
    ui.strong("Camera");
    if ui.button("reset").on_hover_text("Home").clicked() {
        control.reset();
    }
    ui.horizontal_wrapped(|ui| {
        for index in 0..COUNT {
            let key = index + 1;
            let saved = views.recall(index);
            let button = egui::Button::selectable(saved.is_some(), format!("{key}"));
            let response = ui.add(button).on_hover_text(format!(
                "key {key}: back to this view; Ctrl+{key} or a right click: keep the present one"
            ));
            if response.secondary_clicked() || response.clicked() && saved.is_none() {
                views.store(index, control.pose());
            } else if let (true, Some(pose)) = (response.clicked(), saved) {
                control.go_to(pose);
            }
        }
    });
    ui.small(
        "drag: turn; shift or middle: move; wheel: nearer; right: look about; W A S D Q E: fly",
    );
}

/// What is known of the picked patch.
pub fn picked(ui: &mut Ui, loaded: &Loaded, patch: Option<PatchId>) {
    ui.strong("Picked");
    let Some(facts) = patch.and_then(|patch| Facts::of(loaded, patch)) else {
        ui.label("click a patch to see its values");
        return;
    };
    egui::Grid::new("facts").num_columns(2).show(ui, |ui| {
        for (name, value) in facts.lines() {
            ui.label(name);
            ui.label(value);
            ui.end_row();
        }
    });
}
