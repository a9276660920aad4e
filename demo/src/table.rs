//! The table of results.

use crate::solve::Summary;

/// One line a scene.
pub fn format(results: &[(&str, Summary)]) -> String {
    let mut lines = vec![format!(
        "{:10}{:>9}{:>10}{:>11}{:>12}{:>11}{:>20}{:>11}{:>10}{:>10}",
        "scene",
        "patches",
        "surfaces",
        "hemicubes",
        "iterations",
        "residual",
        "row sums",
        "imbalance",
        "drawing",
        "in all"
    )];
    lines.extend(results.iter().map(|(name, summary)| line(name, summary)));
    lines.join("\n")
}

fn line(name: &str, s: &Summary) -> String {
    let closure = s
        .closure
        .map_or_else(String::new, |c| format!("{:.6}..{:.6}", c.min, c.max));
    let imbalance = s
        .imbalance
        .map_or_else(String::new, |share| format!("{:.3} %", 100.0 * share));
    format!(
        "{name:10}{:>9}{:>10}{:>11}{:>12}{:>11.2e}{closure:>20}{imbalance:>11}{:>8.2} s{:>8.2} s",
        s.patches, s.surfaces, s.hemicubes, s.iterations, s.residual, s.drawing_secs, s.total_secs
    )
}
