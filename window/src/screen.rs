//! The picture in the window: when it is drawn anew, with how many samples, and what a click on it picks.

use std::time::{Duration, Instant};

use eframe::egui_wgpu::RenderState;
use egui::{PointerButton, Rect, Sense, TextureId, Ui, pos2};
use scene::PatchId;

use crate::camera_control::CameraControl;
use crate::gestures;
use crate::looks::Looks;
use crate::pace::Pace;
use crate::renderer::Renderer;
use crate::saved_views::SavedViews;
use crate::view::Asked;

/// Where pictures are drawn.
pub struct Screen {
    /// What draws them.
    pub renderer: Renderer,
    state: RenderState,
    texture: Option<TextureId>,
    /// What was drawn last.
    drawn: Option<Asked>,
    /// When the camera moved last; `None` before.
    moved: Option<Instant>,
    /// When the last frame began, if the camera moved in it.
    frame_in_motion: Option<Instant>,
}

/// What is drawn, and what a hand on the picture changes.
pub struct Subject<'a> {
    /// The camera.
    pub control: &'a mut CameraControl,
    /// Views that are kept.
    pub views: &'a mut SavedViews,
    /// How it is shown.
    pub looks: Looks,
    /// The patch that is outlined.
    pub picked: &'a mut Option<PatchId>,
}

impl Screen {
    /// In a window.
    pub fn new(state: RenderState) -> Self {
        Self {
            renderer: Renderer::new(&state.device, &state.queue),
            state,
            texture: None,
            drawn: None,
            moved: None,
            frame_in_motion: None,
        }
    }

    /// Has the picture drawn anew, as something else is shown.
    pub fn renew(&mut self) {
        self.drawn = None;
    }

    /// Shows the picture over all the room there is.
    pub fn show(&mut self, ui: &mut Ui, subject: Subject, pace: &mut Pace, now: Instant) {
        if let Some(began) = self.frame_in_motion.take() {
            pace.frame_in_motion(now.saturating_duration_since(began));
        }
        let picture = ui.allocate_response(ui.available_size(), Sense::click_and_drag());
        let Subject {
            control,
            views,
            looks,
            picked,
        } = subject;
        let before = control.camera();
        let is_flying = gestures::apply(ui, &picture, control, views);
        let camera = control.camera();
        // The panel may have moved it before.
        let was_drawn_at = self.drawn.map_or(before, |asked| asked.camera);
        let is_moving = is_flying || camera != was_drawn_at;
        if is_moving {
            self.moved = Some(now);
        }
        let rest = self
            .moved
            .map_or(Duration::MAX, |moved| now.saturating_duration_since(moved));
        let pixels = picture.rect.size() * ui.pixels_per_point();
        let size = [pixels.x, pixels.y].map(|side| side.round().max(1.0) as u32);
        let mut asked = Asked {
            camera,
            scene_size: control.scene_size(),
            size,
            samples: pace.samples(rest, size),
            looks,
            picked: *picked,
        };
        if picture.clicked_by(PointerButton::Primary)
            && let Some(pointer) = picture.interact_pointer_pos()
        {
            // What is picked is what all pixels would show.
            asked.samples = asked.samples.max(1.0);
            self.draw(&asked);
            let place = (pointer - picture.rect.min) / picture.rect.size();
            *picked = self.renderer.patch_at([place.x, place.y]);
            asked.picked = *picked;
        }
        self.draw(&asked);
        if is_moving {
            self.frame_in_motion = Some(now);
            ui.ctx().request_repaint();
        } else if let Some(wait) = Pace::next(rest) {
            ui.ctx().request_repaint_after(wait);
        }
        if let Some(texture) = self.texture {
            let whole = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
            ui.painter()
                .image(texture, picture.rect, whole, egui::Color32::WHITE);
        }
    }

    /// Draws a picture unless it is there already.
    fn draw(&mut self, asked: &Asked) {
        if self.drawn.as_ref() == Some(asked) {
            return;
        }
        let new_texture = self.renderer.draw(asked);
        self.drawn = Some(*asked);
        let Some(view) = new_texture else {
            return;
        };
        let mut renderer = self.state.renderer.write();
        let (device, filter) = (&self.state.device, wgpu::FilterMode::Linear);
        match self.texture {
            Some(id) => renderer.update_egui_texture_from_wgpu_texture(device, &view, filter, id),
            None => self.texture = Some(renderer.register_native_texture(device, &view, filter)),
        }
    }
}
