//! What the window says, asked of its accessibility tree as a screen reader asks.

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use display::{Mode, Quantity};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use scene::layers::{Lamp, Layer, LayerKind, Layers};
use scene::{PatchId, Rgb, Scene, Solution};
use test_scenes::colourful_room;
use window::App;
use window::loaded::Loaded;
use window::pick::Facts;
use window::watch::Watch;

/// A busy machine reads a small file within this.
const PATIENCE: Duration = Duration::from_mins(1);

fn window(file: &Path) -> Harness<'static, App> {
    let app = App::new(Watch::new(file.to_owned(), || ()), None);
    Harness::builder()
        .with_size([1280.0, 1100.0])
        .build_ui_state(|ui, app: &mut App| app.show(ui), app)
}

fn wait_until(harness: &mut Harness<'static, App>, is_so: impl Fn(&Harness<'static, App>) -> bool) {
    let start = Instant::now();
    while !is_so(harness) {
        assert!(start.elapsed() < PATIENCE, "it never came");
        std::thread::sleep(Duration::from_millis(20));
        harness.step();
    }
}

fn solved(scene: &Scene) -> Solution {
    let mut solution = Solution::dark(scene);
    for (k, irradiance) in solution.irradiance.iter_mut().enumerate() {
        *irradiance = Rgb::new(1.0, 2.0, 3.0) + k as f32;
    }
    solution
}

fn opened(folder: &Path) -> Harness<'static, App> {
    let file = folder.join("room.rad");
    let scene = colourful_room(0.5);
    scene::file::save(&file, &scene, Some(&solved(&scene))).unwrap();
    let mut harness = window(&file);
    wait_until(&mut harness, |harness| harness.state().is_open());
    harness.step();
    harness
}

#[test]
fn a_click_on_a_mode_shows_it() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    for mode in [
        Mode::FalseColor,
        Mode::Filmic,
        Mode::Ids,
        Mode::Linear,
        Mode::Log,
    ] {
        harness.get_by_label(&mode.to_string()).click();
        harness.step();
        harness.step();
        assert_eq!(harness.state().looks().mode, mode);
    }
}

#[test]
fn a_click_on_a_quantity_shows_it_and_the_legend_names_it_and_its_unit() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    harness.get_by_label("false-color").click();
    harness.step();
    harness.get_by_label("irradiance").click();
    harness.step();
    harness.get_by_label("luminous units").click();
    harness.step();
    harness.step();
    assert_eq!(harness.state().looks().shown.quantity, Quantity::Irradiance);
    assert!(harness.query_by_label("illuminance").is_some());
    assert!(harness.query_by_label("lx").is_some());
}

#[test]
fn what_the_file_lacks_cannot_be_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    for (quantity, is_there) in [
        (Quantity::Direct, false),
        (Quantity::Indirect, false),
        (Quantity::Error, false),
        (Quantity::Emission, true),
        (Quantity::Reflectance, true),
    ] {
        let label = quantity.to_string();
        let is_disabled = harness.get_by_label(&label).accesskit_node().is_disabled();
        assert_eq!(is_disabled, !is_there, "{label}");
        harness.get_by_label(&label).click();
        harness.step();
        harness.step();
        assert_eq!(harness.state().looks().shown.quantity == quantity, is_there);
    }
}

#[test]
fn the_panel_says_what_is_known_of_the_picked_patch() {
    let folder = tempfile::tempdir().unwrap();
    let mut harness = opened(folder.path());
    assert!(harness.query_by_label_contains("click a patch").is_some());
    let scene = colourful_room(0.5);
    let solution = solved(&scene);
    let loaded = Loaded::new(scene, Some(solution));
    let facts = Facts::of(&loaded, PatchId(7)).unwrap();
    harness.state_mut().pick(Some(PatchId(7)));
    harness.step();
    for (name, value) in facts.lines() {
        for said in [name, &value] {
            assert!(harness.query_all_by_label(said).next().is_some(), "{said}");
        }
    }
    // H of patch 7, as stored.
    assert!(harness.query_by_label("8  9  10 W/m²").is_some());
}

#[test]
fn a_missing_file_is_told_by_name_and_shown_once_it_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("room.rad");
    let mut harness = window(&file);
    wait_until(&mut harness, |h| {
        h.query_by_label("room.rad cannot be shown").is_some()
    });
    assert!(harness.query_by_label_contains("cannot read").is_some());
    scene::file::save(&file, &colourful_room(0.5), None).unwrap();
    harness.get_by_label("load again").click();
    wait_until(&mut harness, |harness| harness.state().is_open());
}

#[test]
fn a_broken_file_is_told_with_its_fault() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("broken.rad");
    fs::write(&file, "no scene at all").unwrap();
    let mut harness = window(&file);
    wait_until(&mut harness, |h| {
        h.query_by_label("broken.rad cannot be shown").is_some()
    });
    assert!(
        harness
            .query_by_label_contains("not a radiosity file")
            .is_some()
    );
}

#[test]
fn what_was_shown_stays_until_a_changed_file_is_whole() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("room.rad");
    let mut harness = opened(folder.path());
    let count = |scene: &Scene| format!("{} patches", scene.patch_count());
    let (before, after) = (colourful_room(0.5), colourful_room(0.1));
    fs::write(&file, "half of a file").unwrap();
    wait_until(&mut harness, |h| {
        h.query_by_label_contains("not shown anew").is_some()
    });
    assert!(harness.query_by_label_contains(&count(&before)).is_some());
    fs::remove_file(&file).unwrap();
    harness.step();
    assert!(harness.query_by_label_contains(&count(&before)).is_some());
    scene::file::save(&file, &after, None).unwrap();
    wait_until(&mut harness, |h| {
        h.query_by_label_contains(&count(&after)).is_some()
    });
    assert!(harness.query_by_label_contains("not shown anew").is_none());
}

/// Half of the light each, of one lamp and of another one.
fn in_layers(scene: &Scene) -> Solution {
    let mut solution = solved(scene);
    let half: Vec<Rgb> = solution.irradiance.iter().map(|&h| 0.5 * h).collect();
    let layer = |name: &str, material| Layer {
        name: name.to_owned(),
        lamp: Some(Lamp::Material(material)),
        irradiance: half.clone(),
        vertices: Vec::new(),
    };
    solution.layers = Some(Layers {
        kind: LayerKind::Lamps,
        layers: vec![layer("lantern", 1), layer("panel", 2)],
    });
    solution
}

#[test]
fn a_lamp_that_is_dimmed_brings_less_at_once_and_the_range_stays() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("room.rad");
    let scene = colourful_room(0.5);
    scene::file::save(&file, &scene, Some(&in_layers(&scene))).unwrap();
    let mut harness = window(&file);
    wait_until(&mut harness, |harness| harness.state().is_open());
    harness.step();
    assert!(harness.query_by_label("Lamps").is_some());
    let received = |harness: &Harness<'static, App>| {
        let shown = harness.state().shown().unwrap();
        shown.solution.as_ref().unwrap().irradiance[5]
    };
    let (all, before) = (received(&harness), harness.state().range());
    harness.state_mut().mixer().unwrap().set(1, 0.0);
    harness.step();
    harness.step();
    assert_eq!(received(&harness), 0.5 * all);
    assert_eq!(harness.state().range(), before);
    harness.get_by_label("all as they are").click();
    harness.step();
    harness.step();
    assert_eq!(received(&harness), all);
}
