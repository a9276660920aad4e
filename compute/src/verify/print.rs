//! Results as a line a case, and as JSON.

use serde::Serialize;

use super::case::Case;
use super::{Outcome, VerifyError};
use crate::settings::{FormFactorSettings, LampViews, Maps, Points};

/// Widths of the text columns, so that lines can be printed one by one.
pub struct Columns {
    name: usize,
    quantity: usize,
    source: usize,
}

impl Columns {
    /// Columns wide enough for these cases.
    pub fn new(cases: &[Case]) -> Self {
        let widest = |text: fn(&Case) -> &str| {
            cases
                .iter()
                .map(|case| text(case).chars().count())
                .max()
                .unwrap_or(0)
                .max(8)
        };
        Self {
            name: widest(|case| &case.name),
            quantity: widest(|case| &case.quantity),
            source: widest(|case| &case.source),
        }
    }

    /// What the columns are.
    pub fn header(&self) -> String {
        self.row(
            ["case", "quantity", "expected", "source"],
            ["back end", "computed", "error", "tolerance", "verdict"],
        )
    }

    /// One outcome.
    pub fn line(&self, outcome: &Outcome) -> String {
        let Outcome { case, measured, .. } = outcome;
        self.row(
            [
                &case.name,
                &case.quantity,
                &number(measured.expected),
                &case.source,
            ],
            [
                outcome.backend,
                &number(measured.computed),
                &error(measured.expected, measured.error()),
                &error(measured.expected, case.tolerance.relative),
                outcome.verdict(),
            ],
        )
    }

    fn row(&self, [name, quantity, expected, source]: [&str; 4], rest: [&str; 5]) -> String {
        let [backend, computed, error, tolerance, verdict] = rest;
        let Self {
            name: w0,
            quantity: w1,
            source: w2,
        } = self;
        format!(
            "{name:w0$}  {quantity:w1$}  {expected:>11}  {source:w2$}  {backend:8}  {computed:>11}  \
             {error:>10}  {tolerance:>10}  {verdict}"
        )
    }
}

/// Six digits or more that matter.
pub fn number(value: f64) -> String {
    if value == 0.0 || (1e-3..1e6).contains(&value.abs()) {
        format!("{value:.7}")
    } else {
        format!("{value:.5e}")
    }
}

/// A relative error in percent, or the absolute one of what should be 0.
pub fn error(expected: f64, error: f64) -> String {
    if expected == 0.0 {
        return if error == 0.0 {
            "0".into()
        } else {
            format!("{error:.1e}")
        };
    }
    let percent = 100.0 * error;
    if percent == 0.0 || percent >= 0.001 {
        format!("{percent:.3} %")
    } else {
        format!("{percent:.0e} %")
    }
}

/// A case as JSON.
#[derive(Serialize)]
struct Line<'a> {
    name: &'a str,
    quantity: &'a str,
    source: &'a str,
    backend: &'a str,
    resolution: u32,
    points: Points,
    maps: Maps,
    lamps: LampViews,
    /// Of the run that it measures: `compute IN OUT OPTIONS`.
    options: String,
    expected: f64,
    computed: f64,
    /// Relative; absolute where 0 is expected.
    error: f64,
    tolerance: f64,
    tolerance_reason: &'a str,
    verdict: &'a str,
}

/// An array, one object a line.
pub fn json(outcomes: &[Outcome], settings: FormFactorSettings) -> Result<String, VerifyError> {
    let lines: Vec<String> = outcomes
        .iter()
        .map(|outcome| {
            serde_json::to_string(&Line {
                name: &outcome.case.name,
                quantity: &outcome.case.quantity,
                source: &outcome.case.source,
                backend: outcome.backend,
                resolution: settings.resolution,
                points: settings.points,
                maps: settings.maps,
                lamps: settings.lamps,
                options: outcome.run.options(),
                expected: outcome.measured.expected,
                computed: outcome.measured.computed,
                error: outcome.measured.error(),
                tolerance: outcome.case.tolerance.relative,
                tolerance_reason: outcome.case.tolerance.reason,
                verdict: outcome.verdict(),
            })
        })
        .collect::<Result<_, _>>()?;
    Ok(format!("[\n{}\n]", lines.join(",\n")))
}
