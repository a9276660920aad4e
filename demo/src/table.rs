//! The table of results.

use crate::solve::Summary;

/// One line a scene.
pub fn format(results: &[(&str, Summary)]) -> String {
    let mut lines = vec![format!(
        "{:10}{:>9}{:>10}{:>9}{:>11}{:>10}{:>12}{:>13}{:>15}{:>10}{:>9}",
        "scene",
        "patches",
        "surfaces",
        "sources",
        "hemicubes",
        "vertices",
        "iterations",
        "power error",
        "visible error",
        "drawing",
        "in all"
    )];
    lines.extend(results.iter().map(|(name, summary)| line(name, summary)));
    lines.join("\n")
}

fn line(name: &str, s: &Summary) -> String {
    format!(
        "{name:10}{:>9}{:>10}{:>9}{:>11}{:>10}{:>12}{:>11.2} %{:>13.2} %{:>8.2} s{:>7.2} s",
        s.patches,
        s.surfaces,
        s.sources,
        s.hemicubes,
        s.vertices,
        s.iterations,
        100.0 * s.error.power,
        100.0 * s.error.visible,
        s.drawing_secs,
        s.total_secs
    )
}
