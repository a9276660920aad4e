//! What to measure.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use clap::{Parser, ValueEnum};
use compute::quantity::parse_duration;

/// What `cargo bench` passes, and `cargo test` does not.
const BENCH: &str = "--bench";

/// Measures, and writes docs/PERFORMANCE.md.
#[derive(Debug, Parser)]
#[command(
    name = "performance",
    bin_name = "cargo bench -p compute --bench performance --"
)]
struct Arguments {
    /// Given by cargo
    #[arg(long, hide = true)]
    #[allow(dead_code)] // looked for before the others are read
    bench: bool,
    /// Small sizes, in a minute or so; to standard output
    #[arg(long)]
    quick: bool,
    /// This section alone, to standard output; may be given again
    #[arg(long, value_name = "SECTION")]
    only: Vec<Section>,
    /// Write to FILE instead
    #[arg(long, value_name = "FILE")]
    out: Option<PathBuf>,
    /// What a run of the program may take
    #[arg(long, value_name = "TIME", default_value = "20min", value_parser = parse_duration)]
    time_limit: Duration,
    /// What the document may take, for example 90min: of the thesis's table the cheapest runs are done
    /// first, and those that would take longer are listed as not run
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    budget: Option<Duration>,
}

/// A section of the document.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Section {
    /// What it is measured on.
    Machine,
    /// The thesis's table.
    Thesis,
    /// The reference scenes.
    Reference,
    /// The solvers.
    Solvers,
    /// Back ends.
    Gpu,
    /// Stages on one core.
    Stages,
    /// How costs grow.
    Scaling,
    /// What limits each stage.
    Limits,
}

/// What was asked for, and since when.
#[derive(Debug)]
pub struct Plan {
    /// Small sizes.
    pub quick: bool,
    /// Another file than the document.
    pub out: Option<PathBuf>,
    /// Of a run of the program.
    pub time_limit: Duration,
    /// Of the whole document.
    pub budget: Option<Duration>,
    start: Instant,
    only: Vec<Section>,
}

impl Plan {
    /// From the process's arguments; `None` where they are not those of `cargo bench`.
    pub fn parse() -> Option<Self> {
        // First: what `cargo test` passes on is for tests.
        if !std::env::args().any(|argument| argument == BENCH) {
            return None;
        }
        let arguments = Arguments::parse();
        Some(Self {
            quick: arguments.quick,
            out: arguments.out,
            time_limit: arguments.time_limit,
            budget: arguments.budget,
            start: Instant::now(),
            only: arguments.only,
        })
    }

    /// True where the section was asked for.
    pub fn wants(&self, section: Section) -> bool {
        self.only.is_empty() || self.only.contains(&section)
    }

    /// True where nothing is left out or made smaller.
    pub fn is_whole(&self) -> bool {
        !self.quick && self.only.is_empty()
    }

    /// One of two values: that of a quick document, or that of a whole one.
    pub fn choose<T>(&self, quick: T, whole: T) -> T {
        if self.quick { quick } else { whole }
    }

    /// True where this much more fits the budget.
    pub fn affords(&self, seconds: f64) -> bool {
        self.budget.is_none_or(|budget| {
            self.start.elapsed().as_secs_f64() + seconds <= budget.as_secs_f64()
        })
    }
}

/// The command that was given, as a user types it.
pub fn command() -> String {
    // The path differs from machine to machine; `--bench` is cargo's.
    let given: Vec<String> = std::env::args().skip(1).filter(|a| a != BENCH).collect();
    let command = "cargo bench -p compute --bench performance";
    if given.is_empty() {
        command.to_owned()
    } else {
        format!("{command} -- {}", given.join(" "))
    }
}

/// The command that prints one section.
pub fn command_of(section: Section) -> String {
    let name = section
        .to_possible_value()
        .map_or_else(String::new, |value| value.get_name().to_owned());
    format!("`cargo bench -p compute --bench performance -- --only {name}`")
}
