//! What a user sees on the way: a bar on a terminal, now and then a line elsewhere.

use std::fmt::Write as _;
use std::io::IsTerminal;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use scene::Solution;

use crate::function::Errors;
use crate::quantity::show_duration;
use crate::solve::Position;

/// Between two lines where there is no terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Steps of the bar from start to end of an iteration.
const BAR_STEPS: u64 = 1000;

/// Share of an iteration from which its time is told.
const LEAST_SHARE: f64 = 0.01;

/// The display of a run's progress.
pub struct Progress {
    bar: Option<ProgressBar>,
    start: Instant,
    last_line: Instant,
    tolerance: f64,
    /// When the iteration under way started, or the patches' gathering.
    iteration_start: Instant,
    /// Share of it that was done before.
    share_before: f64,
    /// How long the iteration before took, if it was not the first: that one draws rows, which then may be kept.
    last_iteration: Option<Duration>,
    is_first_iteration: bool,
    is_gathering: bool,
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
            share_before: before.map_or(0.0, Solution::next_iteration_share),
            last_iteration: None,
            is_first_iteration: true,
            is_gathering: false,
            seen: (iterations, residual, None),
        }
    }

    /// Shows where the run is.
    pub fn show(&mut self, position: &Position) {
        let mut position = *position;
        self.follow(&mut position);
        if let Some(bar) = &self.bar {
            bar.set_position((position.share_done * BAR_STEPS as f64) as u64);
            bar.set_message(self.message(&position));
        } else if self.last_line.elapsed() >= LINE_EVERY {
            self.last_line = Instant::now();
            eprintln!("compute: {}", self.message(&position));
        }
    }

    /// Takes note of what has ended and what has begun. At an iteration's end nothing is done of the next.
    fn follow(&mut self, position: &mut Position) {
        let is_next_stage = position.is_gathering != self.is_gathering;
        if position.iterations == self.seen.0 && !is_next_stage {
            return;
        }
        let elapsed = self.iteration_start.elapsed();
        self.iteration_start = Instant::now();
        self.is_gathering = position.is_gathering;
        // Among other sources iterations are counted anew.
        let is_next_iteration = position.iterations == self.seen.0.saturating_add(1);
        if is_next_iteration && !is_next_stage {
            self.last_iteration = (!self.is_first_iteration).then_some(elapsed);
            self.is_first_iteration = false;
            self.share_before = 0.0;
            position.share_done = 0.0;
        } else {
            self.last_iteration = None;
            self.is_first_iteration = true;
            self.share_before = position.share_done;
        }
        self.seen = (position.iterations, position.residual, self.seen.1);
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
        let elapsed = self.iteration_start.elapsed();
        if let Some(left) = self.time_left(position, elapsed) {
            parts.push(if left < Duration::from_secs(1) {
                "less than a second left".to_owned()
            } else {
                format!("about {} left", show_duration(left))
            });
        }
        parts.join(", ")
    }

    /// The rest of this iteration, which has taken so long by now, as many like it as the residual's fall suggests, and
    /// the rows that are to be drawn after them.
    fn time_left(&self, position: &Position, elapsed: Duration) -> Option<Duration> {
        let elapsed = elapsed.as_secs_f64();
        let last = self.last_iteration.map(|last| last.as_secs_f64());
        let share = position.share_done - self.share_before;
        let (whole, rest) = if share > LEAST_SHARE {
            let whole = elapsed / share;
            (whole, whole * (1.0 - position.share_done))
        } else {
            let last = last?;
            (last, (last - elapsed).max(0.0))
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
        let after = match (position.rows_after, position.rows) {
            (0, _) => 0.0,
            (_, 0) => return None,
            (after, drawn) => position.drawing.as_secs_f64() / drawn as f64 * f64::from(after),
        };
        let seconds = rest + whole * iterations_after.max(0.0) + after;
        Duration::try_from_secs_f64(seconds).ok()
    }

    /// Shows how far an irradiance function is: its vertices, and its estimated error once it is known.
    pub fn show_function(&mut self, vertices: u32, error: Option<Errors>) {
        let mut message = format!("light gathers at {vertices} vertices");
        if let Some(Errors { power, visible }) = error {
            let [power, visible] = [power, visible].map(|error| 100.0 * error);
            write!(
                message,
                ", error {power:.2} % power, {visible:.2} % visible"
            )
            .ok();
        }
        write!(message, ", {}", show_duration(self.start.elapsed())).ok();
        if let Some(bar) = &self.bar {
            bar.set_position(0);
            bar.set_message(message);
        } else if self.last_line.elapsed() >= LINE_EVERY {
            self.last_line = Instant::now();
            eprintln!("compute: {message}");
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn position(iterations: u64, share_done: f64) -> Position {
        Position {
            iterations,
            is_gathering: false,
            share_done,
            residual: None,
            hemicubes: 0,
            rows: 0,
            drawing: Duration::ZERO,
            rows_after: 0,
        }
    }

    /// Seconds left where the iteration under way has taken so many.
    fn left(progress: &Progress, position: &Position, elapsed: f64) -> Option<f64> {
        let left = progress.time_left(position, Duration::from_secs_f64(elapsed));
        left.map(|left| (left.as_secs_f64() * 1e3).round() / 1e3)
    }

    #[test]
    fn time_left_counts_what_this_run_has_done_of_an_iteration() {
        let mut progress = Progress::new(1e-5, None);
        assert_eq!(left(&progress, &position(0, 0.005), 9.0), None);
        assert_eq!(left(&progress, &position(0, 0.25), 10.0), Some(30.0));
        progress.share_before = 0.5;
        assert_eq!(left(&progress, &position(0, 0.75), 10.0), Some(10.0));
    }

    #[test]
    fn time_left_counts_the_rows_that_patches_draw_after_the_iterations() {
        let mut progress = Progress::new(1e-5, None);
        let among_sources = Position {
            rows: 200,
            drawing: Duration::from_secs(4),
            rows_after: 5000,
            ..position(0, 0.5)
        };
        assert_eq!(left(&progress, &among_sources, 5.0), Some(105.0));
        let nothing_drawn = Position {
            rows: 0,
            ..among_sources
        };
        assert_eq!(left(&progress, &nothing_drawn, 5.0), None);
        // Gathering takes its own time, whatever an iteration among sources took.
        progress.last_iteration = Some(Duration::from_millis(1));
        let mut gathering = Position {
            is_gathering: true,
            rows_after: 0,
            ..position(0, 0.1)
        };
        progress.follow(&mut gathering);
        assert_eq!(left(&progress, &gathering, 10.0), None);
        gathering.share_done = 0.3;
        progress.follow(&mut gathering);
        assert_eq!(left(&progress, &gathering, 10.0), Some(35.0));
    }

    #[test]
    fn regression_no_time_left_is_shown_as_none_while_there_is_work() {
        let mut progress = Progress::new(1e-5, None);
        let mut ended = position(1, 1.0);
        progress.follow(&mut ended);
        progress.last_iteration = Some(Duration::ZERO);
        let message = progress.message(&ended);
        assert!(message.ends_with(", less than a second left"), "{message}");
    }
}
