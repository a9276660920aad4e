//! `compute verify`: how far this program is from the exact answer, case by case.
//!
//! # Theory
//! A row sum of 1 says that nothing was lost, not that anything is right: wrong factors that are
//! normalised sum to 1 too. Only cases whose answers are known tell. The bank holds form factors in
//! closed form ([`closed_forms`], and those of `view_factors.json`), closed rooms, furnaces, solvers
//! against a dense linear solve, and the Cornell box against a [path tracer](path_tracer).
//!
//! # Practice
//! A case goes the way a scene goes: surfaces, bisection mesh, back end, rows, solver. The shape
//! whose rows are drawn has at least [`case::PATCHES`] patches, unless it stands for a point; what
//! it looks at is left whole, for a sum over patches does not depend on how they are cut. Tolerances
//! are those of the default settings, each with the errors it covers; at other settings they are the
//! same, so that the errors can be watched as they fall.

pub mod case;
pub mod closed_forms;
pub mod dense;
#[cfg(test)]
mod exact;
mod markdown;
pub mod measure;
pub mod path_tracer;
mod print;
mod reference;
mod rooms;
pub mod shapes;

use std::io::Write;
use std::sync::Arc;
use std::time::{Duration, Instant};

use scene::SceneError;

use crate::backend;
use crate::hemicubes::Hemicubes;
use crate::quantity::show_duration;
use crate::rows::BackendError;
use crate::settings::{BackendChoice, FormFactorSettings, LampViews};
use case::Case;
use measure::{Measured, Solved, measure};

/// What `compute verify` is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What decides the rows.
    pub accuracy: Accuracy,
    /// Who draws.
    pub backends: Backends,
    /// A case's name, or a part of some cases' names; `None`: all cases.
    pub case: Option<String>,
    /// How the results are written.
    pub format: Format,
}

/// What decides the rows, whoever draws them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Accuracy {
    /// What decides the form factors.
    pub form_factors: FormFactorSettings,
    /// Which lamps get a view of their own.
    pub lamps: LampViews,
}

impl std::fmt::Display for Accuracy {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let FormFactorSettings {
            resolution,
            points,
            maps,
            ..
        } = self.form_factors;
        let [maps, lamps] =
            [format!("{maps:?}"), format!("{:?}", self.lamps)].map(|name| name.to_lowercase());
        write!(
            f,
            "{resolution} pixels, points {points}, {maps} maps, lamps {lamps}"
        )
    }
}

/// The back ends to verify.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backends {
    /// The CPU, and the GPU where there is a real one.
    Available,
    /// The CPU and any GPU, a software one too.
    All,
    /// The CPU.
    Cpu,
    /// Any GPU, a software one too.
    Gpu,
}

/// How results are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// A line a case.
    Text,
    /// An array with one object a case.
    Json,
    /// The document on accuracy.
    Markdown,
}

/// Why the cases could not be measured.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum VerifyError {
    #[error("no case is named like \"{pattern}\"; the cases are:\n  {}", names.join("\n  "))]
    UnknownCase { pattern: String, names: Vec<String> },
    #[error("the table of form factors cannot be read: {0}")]
    Reference(#[from] serde_json::Error),
    #[error("the path tracer's results cannot be read: line {line}")]
    Line { line: usize },
    #[error("case \"{case}\": {source}")]
    Case {
        case: String,
        source: Box<VerifyError>,
    },
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Backend(#[from] BackendError),
}

/// A case, measured on one back end.
#[derive(Clone, Debug)]
pub struct Outcome<'a> {
    /// The case.
    pub case: &'a Case,
    /// The back end's name, `cpu` or `gpu`.
    pub backend: &'static str,
    /// What came out.
    pub measured: Measured,
}

impl Outcome<'_> {
    /// True where the error is within the tolerance; what is no number is not.
    pub fn holds(&self) -> bool {
        self.measured.error() <= self.case.tolerance.relative
    }

    /// `ok` or `miss`.
    pub fn verdict(&self) -> &'static str {
        if self.holds() { "ok" } else { "miss" }
    }
}

/// All cases, in the order in which they are printed.
pub fn bank() -> Result<Vec<Case>, VerifyError> {
    let mut cases = reference::cases()?;
    cases.extend(closed_forms::cases());
    cases.extend(rooms::cases());
    cases.extend(path_tracer::cases()?);
    Ok(cases)
}

/// The case of that name, or all whose names have it in them, in upper or lower case.
pub fn select(pattern: Option<&str>) -> Result<Vec<Case>, VerifyError> {
    let cases = bank()?;
    let Some(pattern) = pattern else {
        return Ok(cases);
    };
    let names = || cases.iter().map(|case| case.name.clone());
    let lower = pattern.to_lowercase();
    let exact = names().any(|name| name == pattern);
    let wanted = |name: &str| {
        if exact {
            name == pattern
        } else {
            name.to_lowercase().contains(&lower)
        }
    };
    if !names().any(|name| wanted(&name)) {
        return Err(VerifyError::UnknownCase {
            pattern: pattern.into(),
            names: names().collect(),
        });
    }
    Ok(cases
        .into_iter()
        .filter(|case| wanted(&case.name))
        .collect())
}

/// Measures the cases that were asked for and writes the results to standard output. True where
/// none misses its tolerance.
pub fn run(settings: &Settings) -> Result<bool, VerifyError> {
    let cases = select(settings.case.as_deref())?;
    run_cases(&cases, settings, &mut std::io::stdout().lock())
}

/// Measures cases and writes the results to `out`. True where none misses its tolerance.
pub fn run_cases(
    cases: &[Case],
    settings: &Settings,
    out: &mut impl Write,
) -> Result<bool, VerifyError> {
    let start = Instant::now();
    let accuracy = settings.accuracy;
    let choices = choices(settings.backends, cases, accuracy)?;
    let outcomes = match settings.format {
        Format::Text => {
            let columns = print::Columns::new(cases);
            say(out, &columns.header());
            let outcomes = measure_all(cases, accuracy, &choices, |outcome| {
                say(out, &columns.line(outcome));
            })?;
            say(out, &summary(&outcomes, accuracy, start.elapsed()));
            outcomes
        }
        Format::Json => {
            let outcomes = measure_all(cases, accuracy, &choices, |_| ())?;
            say(out, &print::json(&outcomes, accuracy)?);
            outcomes
        }
        Format::Markdown => {
            let outcomes = measure_all(cases, accuracy, &choices, |_| ())?;
            let document = markdown::document(&outcomes, cases, accuracy, &choices)?;
            say(out, &document);
            outcomes
        }
    };
    Ok(outcomes.iter().all(Outcome::holds))
}

/// Prints a line or more. A reader that has gone away does not change the verdict.
fn say(out: &mut impl Write, text: &str) {
    writeln!(out, "{text}").ok();
}

fn summary(outcomes: &[Outcome], accuracy: Accuracy, duration: Duration) -> String {
    let held = outcomes.iter().filter(|outcome| outcome.holds()).count();
    format!(
        "{held} of {} within their tolerances; {}; {}",
        outcomes.len(),
        accuracy,
        show_duration(duration)
    )
}

/// What is asked of [`backend::open`], one for each back end.
fn choices(
    backends: Backends,
    cases: &[Case],
    accuracy: Accuracy,
) -> Result<Vec<BackendChoice>, VerifyError> {
    Ok(match backends {
        Backends::Cpu => vec![BackendChoice::Cpu],
        Backends::Gpu => vec![BackendChoice::Gpu],
        Backends::All => vec![BackendChoice::Cpu, BackendChoice::Gpu],
        Backends::Available => {
            let mut choices = vec![BackendChoice::Cpu];
            if let Some(case) = cases.first() {
                let scene = case.scene.build()?;
                let hemicubes = Arc::new(Hemicubes::new(&scene, accuracy.form_factors));
                if backend::open(&hemicubes, BackendChoice::Auto)?.name == "gpu" {
                    choices.push(BackendChoice::Auto);
                }
            }
            choices
        }
    })
}

/// Measures each case on each back end, and shows each outcome as soon as it is there.
fn measure_all<'a>(
    cases: &'a [Case],
    accuracy: Accuracy,
    choices: &[BackendChoice],
    mut show: impl FnMut(&Outcome),
) -> Result<Vec<Outcome<'a>>, VerifyError> {
    let mut outcomes = Vec::with_capacity(cases.len() * choices.len());
    let mut solved = Solved::default();
    for case in cases {
        for &choice in choices {
            let (measured, backend) =
                measure(case, accuracy, choice, &mut solved).map_err(|source| {
                    VerifyError::Case {
                        case: case.name.clone(),
                        source: Box::new(source),
                    }
                })?;
            let outcome = Outcome {
                case,
                backend,
                measured,
            };
            show(&outcome);
            outcomes.push(outcome);
        }
    }
    Ok(outcomes)
}
