//! What is told about the file.

use egui::{Color32, RichText, Ui};

use crate::loaded::Loaded;
use crate::pace::Pace;

/// A warning's colour on a dark ground.
const WARNING: Color32 = Color32::from_rgb(255, 170, 90);

/// The whole window where there is nothing to be seen. True if the file is to be read again.
pub fn nothing_to_see(ui: &mut Ui, name: &str, fault: Option<&str>) -> bool {
    ui.vertical_centered(|ui| {
        ui.add_space(0.3 * ui.available_height());
        let Some(fault) = fault else {
            ui.spinner();
            ui.label(format!("reading {name}"));
            return false;
        };
        ui.heading(format!("{name} cannot be shown"));
        ui.label(RichText::new(fault).color(WARNING));
        ui.add_space(10.0);
        load_again(ui)
    })
    .inner
}

/// The button for it. True if the file is to be read again.
fn load_again(ui: &mut Ui) -> bool {
    ui.button("load again").on_hover_text("F5").clicked()
}

/// The file that is shown. True if it is to be read again.
pub fn file(ui: &mut Ui, name: &str, loaded: &Loaded, fault: Option<&str>, pace: &Pace) -> bool {
    ui.strong(name);
    let scene = &loaded.scene;
    let (surfaces, patches) = (scene.surfaces().len(), scene.patch_count());
    let solution = match &loaded.solution {
        None => "not solved".to_owned(),
        Some(solution) => format!("{} iterations", solution.provenance.iterations),
    };
    ui.label(format!(
        "{patches} patches on {surfaces} surfaces, {solution}"
    ));
    let seconds = loaded.duration.as_secs_f32();
    let frames = pace.frames_per_second().map_or_else(String::new, |rate| {
        format!(", {rate:.0} frames/s in motion")
    });
    ui.small(format!("read in {seconds:.1} s{frames}"));
    if let Some(fault) = fault {
        ui.label(RichText::new(format!("changed, and not shown anew: {fault}")).color(WARNING));
    }
    load_again(ui)
}
