//! `compute verify`: how far this program is from the exact answer, case by case.
//!
//! # Theory
//! A row sum of 1 says that nothing was lost, not that anything is right: wrong factors that are
//! normalised sum to 1 too. Only cases whose answers are known tell. The bank holds form factors in
//! closed form ([`closed_forms`], and those of `view_factors.json`), closed rooms, furnaces, solvers
//! against a dense linear solve, and two rooms against a [path tracer](path_tracer).
//!
//! # Practice
//! A case goes the way a scene goes in a run with the same options: [`FormFactors`](crate::FormFactors) has its rows, and
//! [`Solve`](crate::Solve) solves it. The shape
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
use std::time::{Duration, Instant};

use scene::SceneError;
use scene::obj::ObjError;

use crate::quantity::show_duration;
use crate::rows::BackendError;
use crate::settings::{BackendChoice, FormFactorSettings, SolveSettings};
use crate::solve::SolveError;
use case::Case;
use measure::{Measured, Solved, measure, run_of};

/// What `compute verify` is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// What decides the rows, as in a run.
    pub form_factors: FormFactorSettings,
    /// Who draws.
    pub backends: Backends,
    /// A case's name, or a part of some cases' names; `None`: all cases.
    pub case: Option<String>,
    /// How the results are written.
    pub format: Format,
}

/// The back ends to verify.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backends {
    /// What a run has by default: formulas where they will do, the GPU where there is a real one.
    Auto,
    /// What a run has by default, the CPU, and any GPU, a software one too.
    All,
    /// The CPU.
    Cpu,
    /// Any GPU, a software one too.
    Gpu,
}

impl Backends {
    /// What is asked of [`FormFactors`](crate::FormFactors), one for each back end.
    fn choices(self) -> &'static [BackendChoice] {
        match self {
            Self::Auto => &[BackendChoice::Auto],
            Self::Cpu => &[BackendChoice::Cpu],
            Self::Gpu => &[BackendChoice::Gpu],
            Self::All => &[BackendChoice::Auto, BackendChoice::Cpu, BackendChoice::Gpu],
        }
    }
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
    Model(#[from] ObjError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Backend(#[from] BackendError),
    #[error(transparent)]
    Solve(#[from] SolveError),
}

/// A case, measured on one back end.
#[derive(Clone, Debug)]
pub struct Outcome<'a> {
    /// The case.
    pub case: &'a Case,
    /// Who made the rows: `cpu`, `gpu` or `formula`.
    pub backend: &'static str,
    /// The run that was measured.
    pub run: SolveSettings,
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
    let form_factors = settings.form_factors;
    let choices = settings.backends.choices();
    let outcomes = match settings.format {
        Format::Text => {
            let columns = print::Columns::new(cases);
            say(out, &columns.header());
            let outcomes = measure_all(cases, form_factors, choices, |outcome| {
                say(out, &columns.line(outcome));
            })?;
            say(out, &summary(&outcomes, form_factors, start.elapsed()));
            outcomes
        }
        Format::Json => {
            let outcomes = measure_all(cases, form_factors, choices, |_| ())?;
            say(out, &print::json(&outcomes, form_factors)?);
            outcomes
        }
        Format::Markdown => {
            let outcomes = measure_all(cases, form_factors, choices, |_| ())?;
            let document = markdown::document(&outcomes, cases, form_factors, choices)?;
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

fn summary(outcomes: &[Outcome], settings: FormFactorSettings, duration: Duration) -> String {
    let held = outcomes.iter().filter(|outcome| outcome.holds()).count();
    format!(
        "{held} of {} within their tolerances; {}; {}",
        outcomes.len(),
        shown(settings),
        show_duration(duration)
    )
}

/// The settings, as a line has them.
fn shown(settings: FormFactorSettings) -> String {
    let FormFactorSettings {
        resolution,
        maps,
        points,
        lamps,
        ..
    } = settings;
    let [maps, lamps] = [format!("{maps:?}"), format!("{lamps:?}")].map(|name| name.to_lowercase());
    format!("{resolution} pixels, points {points}, {maps} maps, lamps {lamps}")
}

/// Measures each case on each back end, and shows each outcome as soon as it is there.
fn measure_all<'a>(
    cases: &'a [Case],
    settings: FormFactorSettings,
    choices: &[BackendChoice],
    mut show: impl FnMut(&Outcome),
) -> Result<Vec<Outcome<'a>>, VerifyError> {
    let mut outcomes = Vec::with_capacity(cases.len() * choices.len());
    let mut solved = Solved::default();
    for case in cases {
        for &choice in choices {
            let (measured, backend) =
                measure(case, settings, choice, &mut solved).map_err(|source| {
                    VerifyError::Case {
                        case: case.name.clone(),
                        source: Box::new(source),
                    }
                })?;
            let outcome = Outcome {
                case,
                backend,
                run: run_of(case, settings, choice),
                measured,
            };
            show(&outcome);
            outcomes.push(outcome);
        }
    }
    Ok(outcomes)
}
