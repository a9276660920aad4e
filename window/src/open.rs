//! Opening a window on the screen.

use std::path::PathBuf;
use std::sync::Arc;

use eframe::egui_wgpu::{WgpuConfiguration, WgpuSetup, WgpuSetupCreateNew};
use eframe::{NativeOptions, Renderer};
use egui::ViewportBuilder;

use crate::app::App;
use crate::screen::Screen;
use crate::watch::Watch;

/// Size of the window at first, points.
const SIZE: [f32; 2] = [1280.0, 720.0];

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum OpenError {
    #[error("no screen: {why}; display FILE --out IMAGE.png makes a picture without one")]
    NoScreen { why: String },
    #[error(
        "no graphics: {why}; install a driver of Vulkan, in software mesa-vulkan-drivers, or make a picture with display FILE --out IMAGE.png"
    )]
    NoGraphics { why: String },
}

/// Shows a file in a window until it is closed.
///
/// # Errors
/// No screen, or no driver that draws on it. What is wrong with the file is told in the window.
pub fn open(file: PathBuf) -> Result<(), OpenError> {
    let name = file.file_name().unwrap_or(file.as_os_str());
    let title = format!("{} - display", name.to_string_lossy());
    let options = NativeOptions {
        viewport: ViewportBuilder::default()
            .with_title(&title)
            .with_inner_size(SIZE),
        renderer: Renderer::Wgpu,
        wgpu_options: WgpuConfiguration {
            wgpu_setup: graphics(),
            ..WgpuConfiguration::default()
        },
        ..NativeOptions::default()
    };
    let create: eframe::AppCreator = Box::new(move |context| {
        let waker = context.egui_ctx.clone();
        let watch = Watch::new(file, move || waker.request_repaint());
        let state = context.wgpu_render_state.clone();
        Ok(Box::new(App::new(watch, state.map(Screen::new))))
    });
    eframe::run_native(&title, options, create).map_err(|error| {
        let why = last_cause(&error.to_string());
        match error {
            eframe::Error::Winit(_) | eframe::Error::WinitEventLoop(_) => {
                OpenError::NoScreen { why }
            }
            _ => OpenError::NoGraphics { why },
        }
    })
}

/// The first-class interfaces only, on which vertex shaders read buffers; and all the memory that the driver lets one bind.
fn graphics() -> WgpuSetup {
    let mut setup = WgpuSetupCreateNew::without_display_handle();
    setup.instance_descriptor.backends = wgpu::Backends::PRIMARY;
    setup.device_descriptor = Arc::new(|adapter| wgpu::DeviceDescriptor {
        label: Some("display-window"),
        required_limits: adapter.limits(),
        ..wgpu::DeviceDescriptor::default()
    });
    WgpuSetup::CreateNew(setup)
}

/// What is to the point of a message that names files of a library and its types first.
fn last_cause(message: &str) -> String {
    let words: Vec<&str> = message.split_whitespace().collect();
    let line = words.join(" ");
    let mut parts = line.rsplit(": ");
    // An empty list of details is none.
    let cause = parts.find(|&part| part != "{}").unwrap_or(&line);
    cause.trim_end_matches('.').to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cause_is_told_in_one_line_without_what_a_library_says_of_itself() {
        let message = "winit EventLoopError: os error at /a/mod.rs:765: neither A nor\n B is set.";
        assert_eq!(last_cause(message), "neither A nor B is set");
        assert_eq!(last_cause("no adapter"), "no adapter");
        assert_eq!(last_cause("error: no surface: {}"), "no surface");
    }
}
