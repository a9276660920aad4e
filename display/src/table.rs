//! A table of what objects show, receive and emit.

use std::fmt::Write as _;

use glam::DVec3;
use scene::{Rgb, Scene, Solution};

use crate::luminance::luminance;
use crate::number::with_digits;
use crate::quantity::{LUMENS_PER_WATT, Shown};
use crate::settings::Rows;

/// Digits of a number.
const DIGITS: usize = 4;

/// A row.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// The object's or the material's.
    pub name: String,
    /// Of its patches, without those inside of solids.
    pub patches: u32,
    /// The same, m^2.
    pub area: f64,
    /// The smallest luminance of what is shown, its mean over the area, and the largest.
    pub luminance: [f64; 3],
    /// Power that arrives, W, or lm: see [`crate::quantity`].
    pub received: f64,
    /// Power that is emitted, W, or lm.
    pub emitted: f64,
}

/// The rows, in the scene's order, of those that have patches. `values` are what is shown, one per patch.
pub fn rows(
    scene: &Scene,
    solution: Option<&Solution>,
    shown: Shown,
    values: &[Rgb],
    by: Rows,
) -> Vec<Row> {
    let names: Vec<&str> = match by {
        Rows::Objects => scene.objects().iter().map(String::as_str).collect(),
        Rows::Materials => scene.materials().iter().map(|m| m.name.as_str()).collect(),
    };
    let mut rows: Vec<Row> = names
        .into_iter()
        .map(|name| Row {
            name: name.to_owned(),
            patches: 0,
            area: 0.0,
            luminance: [f64::INFINITY, 0.0, 0.0],
            received: 0.0,
            emitted: 0.0,
        })
        .collect();
    let areas = scene.patch_areas();
    let irradiance = solution.map(|solution| solution.mean_irradiance(scene));
    let is_inside = scene.is_inside();
    for (surface, tree) in scene.surfaces().iter().zip(scene.mesh().trees()) {
        let row = match by {
            Rows::Objects => surface.object.index(),
            Rows::Materials => surface.material.index(),
        };
        let row = &mut rows[row];
        let emission = scene.material(surface.material).emission;
        for patch in tree.patches().map(|patch| patch as usize) {
            if is_inside[patch] {
                continue;
            }
            let (area, light) = (areas[patch], f64::from(luminance(values[patch])));
            let [least, sum, most] = &mut row.luminance;
            (*least, *most) = (least.min(light), most.max(light));
            *sum += area * light;
            row.patches += 1;
            row.area += area;
            row.emitted += area * power(emission, shown.is_luminous);
            let received = irradiance.as_ref().map(|irradiance| irradiance[patch]);
            row.received += area * received.map_or(0.0, |h| power(h, shown.is_luminous));
        }
    }
    rows.retain(|row| row.patches > 0);
    for row in &mut rows {
        row.luminance[1] /= row.area;
    }
    rows
}

/// What a square metre of some exitance or irradiance makes, W or lm.
fn power(value: Rgb, is_luminous: bool) -> f64 {
    if is_luminous {
        f64::from(LUMENS_PER_WATT * luminance(value))
    } else {
        value.as_dvec3().dot(DVec3::splat(1.0 / 3.0))
    }
}

/// The rows for a terminal: a line of headings, a line each, and the sum of the powers.
pub fn text(rows: &[Row], shown: Shown, by: Rows) -> String {
    let unit = shown.plain_unit();
    let power = if shown.is_luminous { "lm" } else { "W" };
    let of = |what: &str| format!("{what} {unit}").trim_end().to_owned();
    let first = match by {
        Rows::Objects => "object",
        Rows::Materials => "material",
    };
    let mut cells = vec![[
        first.to_owned(),
        "patches".to_owned(),
        "area m^2".to_owned(),
        of("minimum"),
        of("mean"),
        of("maximum"),
        format!("received {power}"),
        format!("emitted {power}"),
    ]];
    let number = |value: f64| with_digits(value, DIGITS);
    cells.extend(rows.iter().map(|row| {
        let [least, mean, most] = row.luminance.map(number);
        [
            row.name.clone(),
            row.patches.to_string(),
            number(row.area),
            least,
            mean,
            most,
            number(row.received),
            number(row.emitted),
        ]
    }));
    let sum = |of: fn(&Row) -> f64| number(rows.iter().map(of).sum());
    cells.push([
        "all".to_owned(),
        rows.iter().map(|row| row.patches).sum::<u32>().to_string(),
        sum(|row| row.area),
        String::new(),
        String::new(),
        String::new(),
        sum(|row| row.received),
        sum(|row| row.emitted),
    ]);
    aligned(&cells)
}

/// Names to the left, numbers to the right.
fn aligned<const N: usize>(cells: &[[String; N]]) -> String {
    let width = |column: usize| {
        let widths = cells.iter().map(|row| row[column].chars().count());
        widths.max().unwrap_or(0)
    };
    let widths: [usize; N] = std::array::from_fn(width);
    let mut text = String::new();
    for row in cells {
        write!(text, "{:<1$}", row[0], widths[0]).ok();
        for (cell, width) in row.iter().zip(widths).skip(1) {
            write!(text, "  {cell:>width$}").ok();
        }
        text.push('\n');
    }
    text
}
