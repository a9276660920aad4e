//! The window, from one frame to the next.

use std::time::{Duration, Instant};

use display::Mode;
use egui::{CentralPanel, Key, Panel, Ui};
use glam::Vec3;
use scene::PatchId;

use crate::camera_control::CameraControl;
use crate::legend;
use crate::loaded::Loaded;
use crate::looks::Looks;
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
    loaded: Box<Loaded>,
    control: CameraControl,
    values: Values,
    /// What the values are of.
    looks: Looks,
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
        let values = Values::new(&loaded, &self.looks).map_err(|error| error.to_string())?;
        if let Some(screen) = &mut self.screen {
            let tone = self.looks.tone(values.range);
            let (scene, solution) = (&loaded.scene, loaded.solution.as_ref());
            let set = screen.renderer.set_scene(scene, solution, &values, tone);
            set.map_err(|error| error.to_string())?;
            screen.renew();
        }
        let bounds = loaded.scene.bounds().map(Vec3::as_dvec3);
        let start = CameraControl::new(&loaded.camera, loaded.up, bounds);
        // A file that is read again is the same scene mostly: one stays where one is.
        let control = self.opened.take().map_or(start, |before| before.control);
        self.picked = self
            .picked
            .filter(|patch| patch.0 < loaded.scene.patch_count());
        self.opened = Some(Opened {
            loaded,
            control,
            values,
            looks: self.looks,
        });
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
                    panels::picked(ui, &opened.loaded, self.picked);
                });
                egui::ScrollArea::vertical().show(ui, |ui| {
                    let fault = self.fault.as_deref();
                    let again = status::file(ui, &name, &opened.loaded, fault, &self.pace);
                    ui.separator();
                    panels::looks(ui, &mut self.looks, &opened.loaded, opened.values.range);
                    ui.separator();
                    panels::camera(ui, &mut opened.control, &mut self.views);
                    again
                })
            });
        if panel.inner.inner {
            self.watch.read_again();
        }
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
            match Values::new(&opened.loaded, &self.looks) {
                Ok(values) => opened.values = values,
                Err(error) => {
                    self.fault = Some(error.to_string());
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
