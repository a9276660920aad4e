//! How errors fall with resolution and points, and what each means of accuracy does.

use super::{heading, line, row};
use crate::settings::{BackendChoice, FormFactorSettings, LampViews, Points, Seed};
use crate::verify::VerifyError;
use crate::verify::case::{Case, Measure};
use crate::verify::measure::{Measured, Solved, measure};
use crate::verify::print::error;

/// Resolutions of the tables of errors, pixels.
const RESOLUTIONS: [u32; 5] = [32, 64, 128, 256, 512];

/// Points of the tables of errors, and their marks in the plots; a mark hides those after it.
const POINTS: [(Points, char); 5] = [
    (Points::Auto, 'a'),
    (Points::ThreePoint { bisections: 0 }, '3'),
    (Points::Bisected { bisections: 2 }, '4'),
    (Points::Vertices, 'v'),
    (Points::CENTROID, 'c'),
];

/// Cases of the tables of errors: coarse and fine, near and far, blocked and not.
const SWEPT: [&str; 7] = [
    "cube of 2 triangles a wall, opposite",
    "cube of 2 triangles a wall, adjacent",
    "cube of 128 triangles a wall, adjacent",
    "coaxial unit squares, separation 0.1",
    "triangles, generic skew",
    "box with a plate between floor and ceiling",
    "cornell box, path tracer",
];

/// Resolutions that a case is swept over: fewer where all rows of a room are drawn.
fn resolutions(case: &Case) -> &'static [u32] {
    if matches!(case.measure, Measure::Reflected { .. }) {
        &RESOLUTIONS[..4]
    } else {
        &RESOLUTIONS
    }
}

/// Tables and plots of errors against resolution and points.
pub(super) fn errors(
    text: &mut String,
    cases: &[Case],
    settings: FormFactorSettings,
    choice: BackendChoice,
) -> Result<(), VerifyError> {
    heading(text, "Error against resolution and points");
    let mut solved = Solved::default();
    line(
        text,
        "Columns are values of `--points`. In the plots each has a mark: a for auto, 3 and 4 for so many \
         points, v for vertices, c for the centroid; where two fall together the first of these is shown.",
    );
    for case in cases.iter().filter(|c| SWEPT.contains(&c.name.as_str())) {
        line(text, &format!("\n{}:\n", case.name));
        let mut header = vec!["pixels".to_owned()];
        header.extend(POINTS.iter().map(|(points, _)| points.to_string()));
        row(text, &header.iter().map(String::as_str).collect::<Vec<_>>());
        line(text, &format!("|--:|{}", "--:|".repeat(POINTS.len())));
        let mut plot = format!("            {SCALE}\n");
        for &resolution in resolutions(case) {
            let mut cells = vec![resolution.to_string()];
            let mut found = Vec::new();
            for (points, mark) in POINTS {
                let settings = FormFactorSettings {
                    resolution,
                    points,
                    ..settings
                };
                let (measured, _) = measure(case, settings, choice, &mut solved)?;
                cells.push(error(measured.expected, measured.error()));
                found.push((measured, mark));
            }
            row(text, &cells.iter().map(String::as_str).collect::<Vec<_>>());
            line(
                &mut plot,
                &format!("{resolution:4} pixels {}", plotted(&found)),
            );
        }
        line(text, &format!("\n```text\n{plot}```"));
    }
    Ok(())
}

/// Columns of a plot for each power of ten.
const DECADE: usize = 15;

/// Marks of the powers of ten, the first at 1e-5; [`DECADE`] columns each.
const SCALE: &str = "0.001 %        0.01 %         0.1 %          1 %            10 %";

/// A line of a plot: errors by their logarithms, from 1e-5 to 1e-1.
fn plotted(found: &[(Measured, char)]) -> String {
    let width = 4 * DECADE + 1;
    let mut columns: Vec<char> = (0..width)
        .map(|k| if k.is_multiple_of(DECADE) { '|' } else { ' ' })
        .collect();
    for (measured, mark) in found.iter().rev() {
        let decades = (measured.error().log10() + 5.0).clamp(0.0, 4.0);
        columns[(decades * DECADE as f64).round() as usize] = *mark;
    }
    columns.into_iter().collect::<String>().trim_end().into()
}

/// What points, turned hemicubes and lamps' views do for a room, one by one.
pub(super) fn means(
    text: &mut String,
    cases: &[Case],
    settings: FormFactorSettings,
    choice: BackendChoice,
) -> Result<(), VerifyError> {
    let rooms: Vec<&Case> = cases
        .iter()
        .filter(|case| matches!(case.measure, Measure::Reflected { .. }))
        .collect();
    if rooms.is_empty() {
        return Ok(());
    }
    heading(text, "What each means of accuracy does");
    let mut solved = Solved::default();
    line(
        text,
        "`--points`, `--seed` (hemicubes aligned, or turned) and `--lamps` for two rooms. The last line is the \
         default.\n",
    );
    let mut header = vec!["points", "seed", "lamps"];
    header.extend(rooms.iter().map(|case| case.name.as_str()));
    row(text, &header);
    line(
        text,
        &format!("|---|---|---|{}", "--:|".repeat(rooms.len())),
    );
    for (points, seed, lamps) in [
        (Points::CENTROID, Seed::Aligned, LampViews::Off),
        (Points::CENTROID, Seed::DEFAULT, LampViews::Off),
        (Points::CENTROID, Seed::DEFAULT, LampViews::Auto),
        (Points::Auto, Seed::Aligned, LampViews::Off),
        (Points::Auto, Seed::DEFAULT, LampViews::Off),
        (Points::Auto, Seed::DEFAULT, LampViews::Auto),
    ] {
        let settings = FormFactorSettings {
            points,
            seed,
            lamps,
            ..settings
        };
        let mut cells = vec![
            points.to_string(),
            seed.to_string(),
            format!("{lamps:?}").to_lowercase(),
        ];
        for case in &rooms {
            let (measured, _) = measure(case, settings, choice, &mut solved)?;
            cells.push(error(measured.expected, measured.error()));
        }
        row(text, &cells.iter().map(String::as_str).collect::<Vec<_>>());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_stand_under_their_errors() {
        let at = |error: f64| Measured {
            expected: 1.0,
            computed: 1.0 + error,
        };
        for (error, label) in [
            (1e-4, "0.01 %"),
            (1e-3, "0.1 %"),
            (1e-2, "1 %"),
            (1e-1, "10 %"),
        ] {
            let line = plotted(&[(at(error), 'x')]);
            // 0.1 % is found in neither 0.01 % nor 0.001 %; a label's start is its place.
            let column = SCALE.find(&format!(" {label}")).unwrap() + 1;
            assert_eq!(line.find('x'), Some(column), "{label}");
        }
        // What is off the scale stands at its ends; the first of equals is seen.
        assert_eq!(
            plotted(&[(at(0.0), 'a'), (at(0.0), 'c')]).find('a'),
            Some(0)
        );
        assert_eq!(plotted(&[(at(5.0), 'x')]).find('x'), Some(60));
    }
}
