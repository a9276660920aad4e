//! Sliders for the layers of a solution: lamps are dimmed and coloured, bounces are left out, and nothing is solved anew.

use egui::{Slider, Ui};
use scene::layers::{LayerKind, Layers};
use scene::{Rgb, SceneError};

use crate::loaded::Loaded;

/// How many times as bright a layer can be made.
const LEVELS: std::ops::RangeInclusive<f32> = 0.0..=2.0;

/// The factors of a file's layers; none where it has no layers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mixer {
    kind: Option<LayerKind>,
    faders: Vec<Fader>,
}

/// The factor of one layer.
#[derive(Clone, Debug, PartialEq)]
struct Fader {
    name: String,
    /// How many times as much of it there is.
    level: f32,
    /// By channel, 1 in all that are as they are in the file.
    color: [f32; 3],
}

impl Mixer {
    /// All layers of a file as they are there, or where these sliders of the same layers are.
    pub fn new(loaded: &Loaded, before: Option<&Self>) -> Self {
        let layers = loaded.solution.as_ref().and_then(|s| s.layers.as_ref());
        let Some(Layers { kind, layers }) = layers else {
            return Self::default();
        };
        let faders = layers.iter().map(|layer| Fader {
            name: layer.name.clone(),
            level: 1.0,
            color: [1.0; 3],
        });
        let fresh = Self {
            kind: Some(*kind),
            faders: faders.collect(),
        };
        let is_same = |before: &&Self| {
            let names = |mixer: &Self| -> Vec<String> {
                mixer
                    .faders
                    .iter()
                    .map(|fader| fader.name.clone())
                    .collect()
            };
            before.kind == fresh.kind && names(before) == names(&fresh)
        };
        before.filter(is_same).cloned().unwrap_or(fresh)
    }

    /// Whether a layer is not as it is in the file.
    pub fn is_mixed(&self) -> bool {
        self.factors().iter().any(|&factor| factor != Rgb::ONE)
    }

    /// One per layer.
    pub fn factors(&self) -> Vec<Rgb> {
        let factor = |fader: &Fader| fader.level * Rgb::from_array(fader.color);
        self.faders.iter().map(factor).collect()
    }

    /// What there is to be seen with these factors.
    ///
    /// # Errors
    /// Light that no f32 holds.
    pub fn mixed(&self, loaded: &Loaded) -> Result<Loaded, SceneError> {
        let solution = loaded.solution.as_ref().filter(|_| self.is_mixed());
        match solution.and_then(|s| s.mixed(&loaded.scene, &self.factors())) {
            None => Ok(loaded.clone()),
            Some(mixed) => {
                let (scene, solution) = mixed?;
                Ok(Loaded {
                    scene,
                    solution: Some(solution),
                    ..*loaded
                })
            }
        }
    }

    /// The sliders, if there are layers.
    pub fn show(&mut self, ui: &mut Ui) {
        let Some(kind) = self.kind else {
            return;
        };
        ui.separator();
        ui.strong(match kind {
            LayerKind::Lamps => "Lamps",
            LayerKind::Bounces => "Bounces",
        });
        for fader in &mut self.faders {
            ui.horizontal(|ui| {
                let button = ui.color_edit_button_rgb(&mut fader.color);
                button.on_hover_text(format!("the colour of \"{}\"", fader.name));
                ui.add(Slider::new(&mut fader.level, LEVELS).text(fader.name.as_str()));
            });
        }
        if ui
            .add_enabled(self.is_mixed(), egui::Button::new("all as they are"))
            .clicked()
        {
            for fader in &mut self.faders {
                (fader.level, fader.color) = (1.0, [1.0; 3]);
            }
        }
    }

    /// Gives a layer a factor, by its number.
    pub fn set(&mut self, layer: usize, level: f32) {
        if let Some(fader) = self.faders.get_mut(layer) {
            fader.level = level;
        }
    }
}
