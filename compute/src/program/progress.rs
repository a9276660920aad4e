//! What a user sees on the way: a bar on a terminal, now and then a line elsewhere.

use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use scene::Solution;

use crate::quantity::show_duration;
use crate::solve::Position;

/// Between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Steps of the bar from start to end of an iteration.
const BAR_STEPS: u64 = 1000;

/// The display of a run's progress.
pub struct Progress {
    bar: Option<ProgressBar>,
    start: Instant,
    last_line: Instant,
    tolerance: f64,
    /// When the iteration under way started, and how long the one before took.
    iteration_start: Instant,
    last_iteration: Option<Duration>,
    /// Iterations and residual when the last iteration ended, and the residual before that.
    seen: (u64, Option<f64>, Option<f64>),
}

impl Progress {
    /// Starts the display of a run that goes on from a solution, if there is one.
    pub fn new(tolerance: f64, before: Option<&Solution>) -> Self {
        let provenance = before.map(|before| &before.provenance);
        let iterations = provenance.map_or(0, |p| p.iterations);
        let residual = provenance.and_then(|p| p.residuals.last().copied());
        let bar = std::io::stderr().is_terminal().then(|| {
            let style = ProgressStyle::with_template("{bar:30.cyan/dim} {msg}");
            ProgressBar::new(BAR_STEPS)
                .with_style(style.unwrap_or_else(|_| ProgressStyle::default_bar()))
        });
        let now = Instant::now();
        Self {
            bar,
            start: now,
            last_line: now,
            tolerance,
            iteration_start: now,
            last_iteration: None,
            seen: (iterations, residual, None),
        }
    }

    /// Shows where the run is.
    pub fn show(&mut self, position: &Position) {
        if position.iterations != self.seen.0 {
            self.last_iteration = Some(self.iteration_start.elapsed());
            self.iteration_start = Instant::now();
            self.seen = (position.iterations, position.residual, self.seen.1);
        }
        if let Some(bar) = &self.bar {
            bar.set_position((position.share_done * BAR_STEPS as f64) as u64);
            bar.set_message(self.message(position));
        } else if self.last_line.elapsed() >= LINE_EVERY {
            self.last_line = Instant::now();
            eprintln!("compute: {}", self.message(position));
        }
    }

    fn message(&self, position: &Position) -> String {
        let mut parts = vec![if position.is_gathering {
            "patches gather from their sources".to_owned()
        } else {
            format!("iteration {}", position.iterations.saturating_add(1))
        }];
        if self.bar.is_none() {
            parts.push(format!("{:.0} percent", 100.0 * position.share_done));
        }
        if let Some(residual) = position.residual {
            parts.push(format!("residual {residual:.1e}"));
        }
        let drawing = position.drawing.as_secs_f64();
        if drawing > 0.0 {
            parts.push(format!(
                "{:.0} hemicubes/s",
                position.hemicubes as f64 / drawing
            ));
        }
        parts.push(show_duration(self.start.elapsed()));
        if let Some(left) = self.time_left(position) {
            parts.push(format!("about {} left", show_duration(left)));
        }
        parts.join(", ")
    }

    /// The rest of this iteration, and as many like the last as the residual's fall suggests.
    fn time_left(&self, position: &Position) -> Option<Duration> {
        let elapsed = self.iteration_start.elapsed().as_secs_f64();
        let whole = match self.last_iteration {
            Some(last) => last.as_secs_f64().max(elapsed),
            None if position.share_done > 0.01 => elapsed / position.share_done,
            None => return None,
        };
        let iterations_after = match (self.seen.1, self.seen.2) {
            (Some(now), Some(before))
                if now < before && now > self.tolerance && !position.is_gathering =>
            {
                // The iteration under way is the first of them.
                ((self.tolerance.max(1e-12) / now).ln() / (now / before).ln()).ceil() - 1.0
            }
            _ => 0.0,
        };
        let seconds = (whole - elapsed).max(0.0) + whole * iterations_after.max(0.0);
        Duration::try_from_secs_f64(seconds).ok()
    }

    /// Says something without disturbing the bar.
    pub fn say(&self, text: &str) {
        match &self.bar {
            Some(bar) => bar.suspend(|| eprintln!("{text}")),
            None => eprintln!("{text}"),
        }
    }

    /// Ends the display.
    pub fn finish(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}
