//! Making the scene, writing it, and saying what it is.

use std::collections::BTreeSet;
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::Path;

use anyhow::bail;
use genx::Made;
use scene::file::{OutputLock, is_same_file};
use scene::{ObjectId, Scene};

use crate::cli::Request;
use crate::list;
use crate::printable::printable;

/// Does what was asked for.
pub fn run(request: &Request) -> anyhow::Result<()> {
    // First, so that a missing folder or another program's lock is known before any work.
    let _lock = OutputLock::acquire(&request.out)?;
    let made = genx::make(&request.settings)?;
    if let Some(read) = made
        .files
        .iter()
        .find(|read| is_same_file(read, &request.out))
    {
        bail!(
            "OUT is a file of the model, {}; choose another name",
            read.display()
        );
    }
    scene::file::save(&request.out, &made.scene, None)?;
    for warning in &made.warnings {
        eprintln!("genx: warning: {}", printable(warning));
    }
    let mut text = summary(&request.out, &made);
    if request.is_listed {
        text += &list::of(&made.scene);
    }
    // The file is written: a reader that has gone away is no failure.
    std::io::stdout().write_all(text.as_bytes()).ok();
    Ok(())
}

fn summary(out: &Path, made: &Made) -> String {
    let scene = &made.scene;
    let mut text = String::new();
    let mut line = |name: &str, value: String| {
        // Writing to a string does not fail.
        writeln!(text, "{name:15}{value}").ok();
    };
    line("file", out.display().to_string());
    if let Some(imported) = made.imported {
        line(
            "imported",
            format!(
                "{} faces, {} of them polygons, cut into triangles",
                imported.faces, imported.polygons
            ),
        );
    }
    line("objects", scene.objects().len().to_string());
    line("materials", scene.materials().len().to_string());
    line("surfaces", scene.surfaces().len().to_string());
    line("patches", scene.patch_count().to_string());
    let (smallest, largest) = patch_areas(scene);
    line("patch area", format!("{smallest:.6e} to {largest:.6e} m^2"));
    line("area", format!("{} m^2", scene.area()));
    let [low, high] = scene.bounds().map(glam::Vec3::as_dvec3);
    let glam::DVec3 { x, y, z } = high - low;
    line("extent", format!("{x} x {y} x {z} m"));
    if !scene.openings().is_empty() {
        let (area, names) = openings(scene);
        line("openings", format!("{area} m^2, of {}", names.join(", ")));
    }
    let power = scene.emitted_power();
    line(
        "emitted power",
        format!("{} {} {} W (red, green, blue)", power.x, power.y, power.z),
    );
    text
}

/// The area of what was taken out, m^2, and the names of the objects that it was part of, each in quotes, once.
fn openings(scene: &Scene) -> (f64, Vec<String>) {
    let openings = scene.openings().iter();
    // Each has two sides.
    let area = openings.clone().map(|opening| 0.5 * opening.area());
    let objects: BTreeSet<u32> = openings.map(|opening| opening.object.0).collect();
    let names = objects
        .into_iter()
        .map(|object| format!("{:?}", scene.object(ObjectId(object))));
    (area.sum(), names.collect())
}

/// Smallest and largest area of a patch, m^2.
fn patch_areas(scene: &Scene) -> (f64, f64) {
    scene
        .patch_areas()
        .into_iter()
        .fold((f64::INFINITY, 0.0), |(low, high), area| {
            (low.min(area), high.max(area))
        })
}
