//! The document on accuracy: the cases, what the thesis's maps make of them, and how errors fall.

mod sweeps;

use std::fmt::Write;

use super::case::{Case, Measure};
use super::print::{error, number};
use super::{Outcome, VerifyError, measure_all, shown};
use crate::settings::{BackendChoice, ClosedForms, FormFactorSettings, LampViews, Maps};

/// The whole document. The tables of errors are drawn by the first back end.
pub fn document(
    outcomes: &[Outcome],
    cases: &[Case],
    settings: FormFactorSettings,
    choices: &[BackendChoice],
) -> Result<String, VerifyError> {
    let mut text = format!(
        "# Accuracy\n\n\
         How far this program is from answers that are known, case by case. Written by\n\n\
         ```\ncompute verify --markdown > docs/ACCURACY.md\n```\n\n\
         at {}. A case goes the whole way a scene goes. Errors are relative, and absolute where 0 is \
         expected; a tolerance is what the default settings should reach, and why is said below the \
         table. Row sums cannot replace these cases: factors that are wrong and then normalised sum \
         to 1 as well.\n",
        shown(settings)
    );
    let backends = unique(outcomes.iter().map(|outcome| outcome.backend));
    for backend in backends {
        heading(&mut text, &format!("Cases, {backend}"));
        let of_backend: Vec<&Outcome> = outcomes.iter().filter(|o| o.backend == backend).collect();
        cases_table(&mut text, &of_backend);
    }
    tolerances(&mut text, cases);
    // What follows is about hemicubes.
    let settings = FormFactorSettings {
        closed_forms: ClosedForms::Off,
        ..settings
    };
    thesis(&mut text, outcomes, cases, settings, choices)?;
    sweeps::errors(&mut text, cases, settings, choices[0])?;
    sweeps::means(&mut text, cases, settings, choices[0])?;
    text.push_str(CERTIFICATES);
    Ok(text.trim_end().to_owned())
}

/// What the lines that a run prints of itself mean.
const CERTIFICATES: &str = "
## What a run certifies

These cases tell about the program. About a scene, each run tells what can be known without its exact
answer; `--report` has all of it, and `--strict` makes a miss of a tolerance a failure (exit code 1).

| figure | what it says | when it is off |
|---|---|---|
| row sums (closure) | what a patch sees of other patches, of openings and of back faces sums to 1 | never by more than rounding, 1e-7: pixels are counted in integers |
| openings | mean share of the patches' views that sees nothing; in a scene that looks closed, the object beside the hole | walls do not meet, a face is missing |
| back faces | mean share that sees the backs of surfaces, which are black; the object whose backs they are | a face is wound the wrong way, a solid is open, walls cross |
| reciprocity | what all patches send to patch j against what j sees of them, root mean square by area: errors that normalising would hide | a patch is large for its surroundings: smaller patches, more `--points`, a higher resolution |
| imbalance | power emitted less absorbed less lost, as a share of that emitted | not converged, or not reciprocal |
| estimated error | how far the iteration is from where it goes, told by its residuals | reflectances near 1: a smaller `--tolerance` |

Reciprocity is a bound in practice: form factors cannot be better than it says but for luck. It cannot see what both
sides share, in a symmetric scene most of the errors; the table above can.
";

/// Each value once, in the order of first occurrence.
fn unique<T: PartialEq>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for value in values {
        if !found.contains(&value) {
            found.push(value);
        }
    }
    found
}

fn heading(text: &mut String, title: &str) {
    line(text, &["\n## ", title, "\n"].concat());
}

fn line(text: &mut String, content: &str) {
    // Writing to a string cannot fail.
    writeln!(text, "{content}").ok();
}

/// A row of a table; a bar in a cell would end it.
fn row(text: &mut String, cells: &[&str]) {
    let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
    line(text, &format!("| {} |", cells.join(" | ")));
}

fn cases_table(text: &mut String, outcomes: &[&Outcome]) {
    let held = outcomes.iter().filter(|outcome| outcome.holds()).count();
    line(
        text,
        &format!(
            "{held} of {} are within their tolerances.\n",
            outcomes.len()
        ),
    );
    row(
        text,
        &[
            "case",
            "quantity",
            "expected",
            "source",
            "computed",
            "error",
            "tolerance",
            "verdict",
        ],
    );
    line(text, "|---|---|--:|---|--:|--:|--:|---|");
    for outcome in outcomes {
        let Outcome { case, measured, .. } = outcome;
        let verdict = if outcome.holds() { "ok" } else { "**miss**" };
        row(
            text,
            &[
                &case.name,
                &case.quantity,
                &number(measured.expected),
                &case.source,
                &number(measured.computed),
                &error(measured.expected, measured.error()),
                &error(measured.expected, case.tolerance.relative),
                verdict,
            ],
        );
    }
}

fn tolerances(text: &mut String, cases: &[Case]) {
    heading(text, "Tolerances");
    row(text, &["tolerance", "what it covers", "cases"]);
    line(text, "|--:|---|--:|");
    for tolerance in unique(cases.iter().map(|case| case.tolerance)) {
        let count = cases.iter().filter(|c| c.tolerance == tolerance).count();
        let shown = format!("{:.1e}", tolerance.relative);
        row(text, &[&shown, tolerance.reason, &count.to_string()]);
    }
}

/// Whether the pixels' multipliers can change what is measured: closed rooms sum to 1 with any.
fn depends_on_maps(case: &Case) -> bool {
    matches!(
        case.measure,
        Measure::FormFactor { .. } | Measure::Irradiance { .. } | Measure::Reflected { .. }
    )
}

fn thesis(
    text: &mut String,
    outcomes: &[Outcome],
    cases: &[Case],
    settings: FormFactorSettings,
    choices: &[BackendChoice],
) -> Result<(), VerifyError> {
    heading(text, "The thesis's multipliers");
    line(
        text,
        "The same cases with `--maps thesis`: 1/r on top and z/r^2 at the sides, normalised. Row sums \
         and furnaces cannot tell the difference and are left out.\n",
    );
    let settings = FormFactorSettings {
        maps: Maps::Thesis,
        // The thesis has none.
        lamps: LampViews::Off,
        ..settings
    };
    let of_thesis = measure_all(cases, settings, &choices[..1], |_| ())?;
    row(
        text,
        &[
            "case",
            "expected",
            "thesis",
            "its error",
            "error of exact maps",
        ],
    );
    line(text, "|---|--:|--:|--:|--:|");
    for outcome in of_thesis.iter().filter(|o| depends_on_maps(o.case)) {
        let exact = outcomes.iter().find(|o| o.case.name == outcome.case.name);
        let measured = outcome.measured;
        row(
            text,
            &[
                &outcome.case.name,
                &number(measured.expected),
                &number(measured.computed),
                &error(measured.expected, measured.error()),
                &exact.map_or_else(String::new, |o| {
                    error(o.measured.expected, o.measured.error())
                }),
            ],
        );
    }
    Ok(())
}
