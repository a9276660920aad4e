//! A report of `compute --report` as an SVG of up to three charts.
//!
//! | chart | from | axis |
//! |---|---|---|
//! | residual by iteration | `residuals`, `iterations`, `convergence.estimated_error` | logarithmic |
//! | error by cause: power and visible, percent | `function.error` | linear from 0 |
//! | seconds by stage | `seconds` | linear from 0 |
//!
//! A report without one of the first two parts has no such chart. NaN, which JSON has not, is null in a report: such
//! a residual is left out, such a bar has no height and is called unknown. Residuals of 0 have no logarithm and
//! are left out too.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use kuva::prelude::{BarPlot, Figure, Layout, LinePlot, Plot, ScatterPlot, SvgBackend, TickFormat};
use scene::file::{FileError, is_same_file, write_atomically};
use serde_json::{Map, Value};

/// Most residuals that are shown: a chart is hardly as many pixels wide.
const MAX_POINTS: usize = 500;
/// Up to so many residuals have a mark each.
const MAX_MARKS: usize = 40;
/// Residuals below that are 0: far below what sums of f64 can tell from 1.
const MIN_RESIDUAL: f64 = 1e-30;
/// Numbers above that no report has, and no axis needs to.
const MAX_VALUE: f64 = 1e12;
/// Most marks of an axis that are chosen here.
const MAX_TICKS: f64 = 12.0;
/// Longest name that is shown, characters.
const MAX_NAME: usize = 40;

/// Width and height of a chart, pixels.
const CHART: (f64, f64) = (440.0, 340.0);
const POWER_COLOUR: &str = "#1f77b4";
const VISIBLE_COLOUR: &str = "#ff7f0e";
const SECONDS_COLOUR: &str = "#2ca02c";

/// The order in which a run comes by its causes of error and its stages; others follow.
const CAUSES: [&str; 6] = [
    "total",
    "mesh",
    "sources",
    "pixels",
    "iterations",
    "sampling",
];
const STAGES: [&str; 6] = ["load", "open", "draw", "solve", "write", "total"];

/// Reads a report and writes its charts as SVG.
pub fn plot(report: &Path, out: &Path) -> Result<(), PlotError> {
    if is_same_file(report, out) {
        return Err(PlotError::OutputIsInput { path: out.into() });
    }
    let text = std::fs::read(report).map_err(|source| PlotError::Read {
        path: report.into(),
        source,
    })?;
    let fail = |what: String| PlotError::NoReport {
        path: report.into(),
        what,
    };
    let value: Value =
        serde_json::from_slice(&text).map_err(|error| fail(format!("it is no JSON ({error})")))?;
    let svg = svg(&value).map_err(fail)?;
    Ok(write_atomically(out, |out| out.write_all(svg.as_bytes()))?)
}

/// The charts, or what keeps the value from being a report.
fn svg(report: &Value) -> Result<String, String> {
    let report = report.as_object().ok_or("it is no JSON object")?;
    let seconds = object(report, "seconds")?.ok_or("it has no \"seconds\"")?;
    let mut charts = Vec::new();
    if let Some(residuals) = report.get("residuals").filter(|value| !value.is_null()) {
        let residuals = residuals
            .as_array()
            .ok_or("its \"residuals\" are no array")?;
        charts.extend(residual_chart(report, residuals)?);
    }
    if let Some(function) = object(report, "function")?
        && let Some(error) = object(function, "error")?
    {
        charts.extend(error_chart(error)?);
    }
    charts.extend(seconds_chart(seconds)?);
    if charts.is_empty() {
        return Err("its \"seconds\" are empty".into());
    }
    let (plots, layouts): (Vec<_>, Vec<_>) = charts.into_iter().unzip();
    let figure = Figure::new(1, plots.len())
        .with_cell_size(CHART.0, CHART.1)
        .with_plots(plots)
        .with_layouts(layouts)
        .with_title_size(16);
    let input = report.get("input").and_then(Value::as_str);
    let figure = match input {
        Some(input) => figure.with_title(shown(input)),
        None => figure,
    };
    Ok(SvgBackend::new().render_scene(&figure.render()) + "\n")
}

type Chart = (Vec<Plot>, Layout);

/// Logarithms of residuals over the numbers of their iterations; `None` where there is none to show.
fn residual_chart(
    report: &Map<String, Value>,
    residuals: &[Value],
) -> Result<Option<Chart>, String> {
    // A run that went on with other settings has no residuals of the iterations before.
    let iterations = report.get("iterations").and_then(Value::as_u64);
    let first = 1 + iterations.map_or(0, |n| n.saturating_sub(residuals.len() as u64));
    let mut points = Vec::new();
    for (residual, iteration) in residuals.iter().zip(first..) {
        if let Some(residual) = number(residual, "residuals")?.filter(|&r| r >= MIN_RESIDUAL) {
            points.push((iteration as f64, residual.log10()));
        }
    }
    let points = thinned(points);
    if points.is_empty() {
        return Ok(None);
    }
    let estimate = object(report, "convergence")?.and_then(|c| c.get("estimated_error")?.as_f64());
    let title = estimate.map_or_else(
        || "residual by iteration".into(),
        |error| format!("residual by iteration; estimated error {error:.1e}"),
    );
    let [low, high] = decades(&points);
    let span = points[points.len() - 1].0 - points[0].0;
    let mut plots: Vec<Plot> = Vec::new();
    if points.len() <= MAX_MARKS {
        let marks = ScatterPlot::new().with_color(POWER_COLOUR);
        plots.push(marks.with_data(points.clone()).into());
    }
    let line = LinePlot::new().with_color(POWER_COLOUR);
    plots.push(line.with_data(points).into());
    // Not the crate's own logarithmic axis, which ends at 1e-10.
    let power = |decade: f64| format!("{:.0e}", 10.0_f64.powf(decade));
    let mut layout = layout(&plots, &title)
        .with_x_label("iteration")
        .with_y_label("residual, relative")
        .with_y_axis_min(low)
        .with_y_axis_max(high)
        .with_y_tick_step(((high - low) / MAX_TICKS).ceil())
        .with_y_tick_format(TickFormat::Custom(Arc::new(power)));
    if span <= MAX_TICKS {
        layout = layout.with_x_tick_step(1.0);
    }
    Ok(Some((plots, layout)))
}

/// The whole decades that logarithms lie between, one at least.
fn decades(points: &[(f64, f64)]) -> [f64; 2] {
    let logarithms = || points.iter().map(|point| point.1);
    let low = logarithms().fold(f64::INFINITY, f64::min).floor();
    let high = logarithms().fold(f64::NEG_INFINITY, f64::max).ceil();
    [low, high.max(low + 1.0)]
}

/// At most [`MAX_POINTS`] of them, evenly taken, the first and the last included.
fn thinned<T: Copy>(points: Vec<T>) -> Vec<T> {
    if points.len() <= MAX_POINTS {
        return points;
    }
    let last = points.len() - 1;
    (0..MAX_POINTS)
        .map(|k| points[k * last / (MAX_POINTS - 1)])
        .collect()
}

/// Both errors by cause; `None` where there is no cause.
fn error_chart(error: &Map<String, Value>) -> Result<Option<Chart>, String> {
    if error.is_empty() {
        return Ok(None);
    }
    let mut bars = BarPlot::new();
    for name in ordered(error, &CAUSES) {
        let errors = object(error, name)?;
        let of = |kind: &str| match errors.and_then(|errors| errors.get(kind)) {
            Some(value) => number(value, name),
            None => Ok(None),
        };
        let [power, visible] = [of("power")?, of("visible")?];
        let percent = |error: Option<f64>| 100.0 * error.unwrap_or(0.0);
        let values = [
            (percent(power), POWER_COLOUR),
            (percent(visible), VISIBLE_COLOUR),
        ];
        bars = bars.with_group(label(name, power.is_none() || visible.is_none()), values);
    }
    let plots = vec![bars.with_legend(vec!["power", "visible"]).into()];
    let layout = layout(&plots, "error by cause").with_y_label("error, %");
    Ok(Some((plots, layout)))
}

/// Seconds by stage; `None` where there is no stage.
fn seconds_chart(seconds: &Map<String, Value>) -> Result<Option<Chart>, String> {
    if seconds.is_empty() {
        return Ok(None);
    }
    let mut bars = BarPlot::new();
    for name in ordered(seconds, &STAGES) {
        let value = number(&seconds[name], name)?;
        let bar = [(value.unwrap_or(0.0), SECONDS_COLOUR)];
        bars = bars.with_group(label(name, value.is_none()), bar);
    }
    let plots = vec![bars.into()];
    let layout = layout(&plots, "seconds by stage").with_y_label("seconds");
    Ok(Some((plots, layout)))
}

fn layout(plots: &[Plot], title: &str) -> Layout {
    Layout::auto_from_plots(plots)
        .with_title(title)
        .with_title_size(14)
        .with_label_size(12)
        .with_tick_size(10)
}

/// An object's names: the known ones in their order, then the others in theirs.
fn ordered<'m>(map: &'m Map<String, Value>, known: &[&str]) -> Vec<&'m str> {
    let mut names: Vec<&str> = map.keys().map(String::as_str).collect();
    let place = |name: &str| known.iter().position(|&k| k == name);
    names.sort_by_key(|name| place(name).unwrap_or(known.len()));
    names
}

/// A part of a report that is an object; `None` where it is missing or null.
fn object<'m>(
    map: &'m Map<String, Value>,
    name: &str,
) -> Result<Option<&'m Map<String, Value>>, String> {
    match map.get(name) {
        None | Some(Value::Null) => Ok(None),
        Some(Value::Object(object)) => Ok(Some(object)),
        Some(_) => Err(format!("its {name:?} is no object")),
    }
}

/// A number that is not negative; `None` for null, a report's NaN.
fn number(value: &Value, name: &str) -> Result<Option<f64>, String> {
    match value {
        Value::Null => Ok(None),
        _ => match value.as_f64().filter(|v| (0.0..=MAX_VALUE).contains(v)) {
            Some(number) => Ok(Some(number)),
            None => Err(format!(
                "its {name:?} has {value}, where a number from 0 to {MAX_VALUE:e} is needed"
            )),
        },
    }
}

fn label(name: &str, is_unknown: bool) -> String {
    let name = shown(name);
    if is_unknown {
        format!("{name}: unknown")
    } else {
        name
    }
}

/// A name as the plots' crate shows it: short, on one line, without characters that XML cannot have. That crate
/// escapes <, > and &, but takes what is between two dollars for a formula.
fn shown(name: &str) -> String {
    let is_long = name.chars().count() > MAX_NAME;
    let skipped = name.chars().count().saturating_sub(MAX_NAME - 1);
    // A path's end tells more than its start.
    let kept = name.chars().skip(if is_long { skipped } else { 0 });
    let mut text = String::from(if is_long { "…" } else { "" });
    for c in kept {
        match c {
            '$' => text.push_str("\\$"),
            // XML 1.0, section 2.2.
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => text.push('\u{fffd}'),
            c => text.push(c),
        }
    }
    text
}

/// A report that is not plotted.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum PlotError {
    #[error("{}: cannot read: {source}", path.display())]
    Read {
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{}: not a report: {what}; make one with compute --report", path.display())]
    NoReport { path: PathBuf, what: String },
    #[error("{} is the report; choose another name for the output", path.display())]
    OutputIsInput { path: PathBuf },
    #[error(transparent)]
    File(#[from] FileError),
}
