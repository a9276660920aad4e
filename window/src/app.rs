//! The window, from one frame to the next.

use std::time::{Duration, Instant};

use display::{Mode, Range};
use egui::{CentralPanel, Key, Panel, Ui};
use glam::Vec3;
use scene::PatchId;

use crate::camera_control::CameraControl;
use crate::legend;
use crate::loaded::Loaded;
use crate::looks::Looks;
use crate::mixer::Mixer;
use crate::pace::Pace;
use crate::saved_views::SavedViews;
use crate::screen::{Screen, Subject};
use crate::values::Values;
use crate::watch::{PERIOD, Watch};
use crate::{panels, status};

/// Width of the panel, points.
const PANEL_WIDTH: f32 = 320.0;

/// All that a window holds.
pub struct App {
    watch: Watch,
    looks: Looks,
    opened: Option<Opened>,
    /// Why the file as it is now is not shown.
    fault: Option<String>,
    picked: Option<PatchId>,
    views: SavedViews,
    pace: Pace,
    /// Where pictures are drawn; tests of the panels have none.
    screen: Option<Screen>,
}

/// A file that is shown.
struct Opened {
    /// As it is in the file.
    loaded: Box<Loaded>,
    mixer: Mixer,
    /// As it is mixed.
    shown: Loaded,
    control: CameraControl,
    values: Values,
    /// What the values are of.
    looks: Looks,
    /// The same.
    mixed: Mixer,
}

/// The values of a file as it is mixed. Their range is that of all light, so that what is dimmed looks so.
fn values(loaded: &Loaded, shown: &Loaded, mixer: &Mixer, looks: &Looks) -> Result<Values, String> {
    let of = |loaded| Values::new(loaded, looks).map_err(|error| error.to_string());
    let mut values = of(shown)?;
    if mixer.is_mixed() {
        values.range = of(loaded)?.range;
    }
    Ok(values)
}

impl App {
    /// A window onto a file.
    pub fn new(watch: Watch, screen: Option<Screen>) -> Self {
        Self {
            watch,
            looks: Looks::default(),
            opened: None,
            fault: None,
            picked: None,
            views: SavedViews::default(),
            pace: Pace::default(),
            screen,
        }
    }

    /// The looks that are chosen.
    pub fn looks(&self) -> &Looks {
        &self.looks
    }

    /// Whether a file is shown.
    pub fn is_open(&self) -> bool {
        self.opened.is_some()
    }

    /// What is shown, as it is mixed.
    pub fn shown(&self) -> Option<&Loaded> {
        self.opened.as_ref().map(|opened| &opened.shown)
    }

    /// The ends of a scale that suits what is shown, if a file is.
    pub fn range(&self) -> Option<Range> {
        self.opened.as_ref().map(|opened| opened.values.range)
    }

    /// The sliders of the layers, if a file is shown.
    pub fn mixer(&mut self) -> Option<&mut Mixer> {
        self.opened.as_mut().map(|opened| &mut opened.mixer)
    }

    /// Picks a patch, or none.
    pub fn pick(&mut self, patch: Option<PatchId>) {
        self.picked = patch;
    }

    /// One frame.
    pub fn show(&mut self, ui: &mut Ui) {
        let now = Instant::now();
        self.take_news(now);
        if ui.input(|input| input.key_pressed(Key::F5)) {
            self.watch.read_again();
        }
        if self.opened.is_some() {
            self.show_panel(ui);
            self.mix();
            self.renew_values();
            self.show_legend(ui);
            self.show_picture(ui, now);
        } else {
            let name = self.watch.name();
            let fault = self.fault.as_deref().filter(|_| !self.watch.is_reading());
            let again =
                CentralPanel::default().show(ui, |ui| status::nothing_to_see(ui, &name, fault));
            if again.inner {
                self.watch.read_again();
            }
        }
        ui.ctx().request_repaint_after(PERIOD);
    }

    /// Shows what has been read.
    fn take_news(&mut self, now: Instant) {
        match self.watch.poll(now) {
            None => {}
            Some(Err(fault)) => self.fault = Some(fault),
            Some(Ok(loaded)) => self.fault = self.open(loaded).err(),
        }
    }

    fn open(&mut self, loaded: Box<Loaded>) -> Result<(), String> {
        self.looks.shown = loaded.available(self.looks.shown);
        let mixer = Mixer::new(&loaded, self.opened.as_ref().map(|before| &before.mixer));
        let shown = mixer.mixed(&loaded).map_err(|error| error.to_string())?;
        let values = values(&loaded, &shown, &mixer, &self.looks)?;
        self.set_scene(&shown, &values)?;
        let bounds = loaded.scene.bounds().map(Vec3::as_dvec3);
        let start = CameraControl::new(&loaded.camera, loaded.up, bounds);
        // A file that is read again is the same scene mostly: one stays where one is.
        let control = self.opened.take().map_or(start, |before| before.control);
        self.picked = self
            .picked
            .filter(|patch| patch.0 < loaded.scene.patch_count());
        self.opened = Some(Opened {
            loaded,
            shown,
            mixed: mixer.clone(),
            mixer,
            control,
            values,
            looks: self.looks,
        });
        Ok(())
    }

    /// Gives all of a scene to the graphics card.
    fn set_scene(&mut self, shown: &Loaded, values: &Values) -> Result<(), String> {
        let Some(screen) = &mut self.screen else {
            return Ok(());
        };
        let tone = self.looks.tone(values.range);
        let (scene, solution) = (&shown.scene, shown.solution.as_ref());
        let set = screen.renderer.set_scene(scene, solution, values, tone);
        set.map_err(|error| error.to_string())?;
        screen.renew();
        Ok(())
    }

    fn show_panel(&mut self, ui: &mut Ui) {
        let Some(opened) = &mut self.opened else {
            return;
        };
        let name = self.watch.name();
        let panel = Panel::right("panel")
            .default_size(PANEL_WIDTH)
            .show(ui, |ui| {
                // What is picked is always in sight, the rest is scrolled to.
                Panel::bottom("picked").show(ui, |ui| {
                    panels::picked(ui, &opened.shown, self.picked);
                });
                egui::ScrollArea::vertical().show(ui, |ui| {
                    let fault = self.fault.as_deref();
                    let again = status::file(ui, &name, &opened.loaded, fault, &self.pace);
                    ui.separator();
                    panels::looks(ui, &mut self.looks, &opened.loaded, opened.values.range);
                    opened.mixer.show(ui);
                    ui.separator();
                    panels::camera(ui, &mut opened.control, &mut self.views);
                    again
                })
            });
        if panel.inner.inner {
            self.watch.read_again();
        }
    }

    /// Makes what other sliders ask for.
    fn mix(&mut self) {
        let Some(mut opened) = self.opened.take_if(|opened| opened.mixed != opened.mixer) else {
            return;
        };
        opened.mixed = opened.mixer.clone();
        let mixed = opened
            .mixer
            .mixed(&opened.loaded)
            .map_err(|error| error.to_string());
        let mixed = mixed.and_then(|shown| {
            let values = values(&opened.loaded, &shown, &opened.mixer, &self.looks)?;
            self.set_scene(&shown, &values)?;
            (opened.shown, opened.values, opened.looks) = (shown, values, self.looks);
            Ok(())
        });
        self.fault = mixed.err();
        self.opened = Some(opened);
    }

    /// Makes the values that other looks ask for.
    fn renew_values(&mut self) {
        let Some(opened) = &mut self.opened else {
            return;
        };
        if opened.looks == self.looks {
            return;
        }
        let is_other = Values::differ(&opened.looks, &self.looks);
        if is_other {
            match values(&opened.loaded, &opened.shown, &opened.mixer, &self.looks) {
                Ok(values) => opened.values = values,
                Err(error) => {
                    self.fault = Some(error);
                    self.looks = opened.looks;
                    return;
                }
            }
        }
        opened.looks = self.looks;
        if let Some(screen) = &mut self.screen {
            let tone = self.looks.tone(opened.values.range);
            if is_other {
                let set = screen.renderer.set_values(&opened.values, tone);
                self.fault = set.err().map(|error| error.to_string());
            } else {
                screen.renderer.set_tone(tone);
            }
            screen.renew();
        }
    }

    fn show_legend(&self, ui: &mut Ui) {
        let (Some(opened), Mode::FalseColor) = (&self.opened, self.looks.mode) else {
            return;
        };
        let tone = self.looks.tone(opened.values.range);
        let panel = Panel::right("legend").exact_size(legend::WIDTH);
        panel.show(ui, |ui| legend::show(ui, &tone, self.looks.shown));
    }

    fn show_picture(&mut self, ui: &mut Ui, now: Instant) {
        let Self {
            opened,
            screen,
            views,
            pace,
            picked,
            ..
        } = self;
        let Some(opened) = opened else {
            return;
        };
        CentralPanel::no_frame().show(ui, |ui| {
            let Some(screen) = screen else {
                return;
            };
            let subject = Subject {
                control: &mut opened.control,
                views,
                looks: opened.looks,
                picked,
            };
            screen.show(ui, subject, pace, now);
            if let Some(failure) = screen.renderer.failure() {
                ui.colored_label(
                    egui::Color32::RED,
                    format!("the graphics card failed: {failure}"),
                );
            }
        });
    }
}

impl eframe::App for App {
    fn ui(&mut self, ui: &mut Ui, _frame: &mut eframe::Frame) {
        self.show(ui);
    }

    fn auto_save_interval(&self) -> Duration {
        Duration::MAX
    }
}
