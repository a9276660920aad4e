//! Plots of a study: errors against seconds.

use kuva::prelude::*;

use super::table::{Row, Table};

/// Colours of what is varied, in the order in which it comes.
const COLOURS: [&str; 9] = [
    "#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2", "#7f7f7f",
    "#17becf",
];

/// What an error is called in a file's name and on an axis, and which it is.
type Kind = (&'static str, &'static str, fn(&Row) -> Option<f64>);

const KINDS: [Kind; 2] = [
    ("power", "power error, %", |row| row.power),
    ("visible", "visible error, %", |row| row.visible),
];

/// SVGs of a scene: both errors against seconds, by what is varied.
pub(super) fn of_scene(table: &Table, scene: &str) -> Vec<(&'static str, String)> {
    let plot = |(kind, label, error): Kind| {
        let mut knobs: Vec<&str> = Vec::new();
        for row in table.of_scene(scene) {
            if !knobs.contains(&row.knob.as_str()) {
                knobs.push(&row.knob);
            }
        }
        let plots: Vec<Plot> = knobs
            .iter()
            .zip(COLOURS.iter().cycle())
            .filter_map(|(&knob, &colour)| {
                let rows = table.of_scene(scene).filter(|row| row.knob == knob);
                let points: Vec<(f64, f64)> = rows
                    .filter_map(|row| Some((row.seconds, 100.0 * error(row)?)))
                    .filter(|&(seconds, error)| seconds > 0.0 && error > 0.0)
                    .collect();
                let scatter = ScatterPlot::new().with_color(colour).with_legend(knob);
                (!points.is_empty()).then(|| scatter.with_data(points).into())
            })
            .collect();
        if plots.is_empty() {
            return None;
        }
        let layout = Layout::auto_from_plots(&plots)
            .with_title(scene)
            .with_x_label("seconds")
            .with_y_label(label)
            .with_log_x()
            .with_log_y();
        Some((kind, render_to_svg(plots, layout)))
    };
    KINDS.into_iter().filter_map(plot).collect()
}
