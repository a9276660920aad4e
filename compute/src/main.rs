//! `compute`: solves a scene. See `compute --help`.

use std::io::Write;
use std::process::ExitCode;

use compute::report::StoppedBy;
use compute::settings::Settings;
use compute::{cli, interrupt, run, verify};

fn main() -> ExitCode {
    match cli::parse() {
        cli::Task::Solve(settings) => solve(&settings),
        cli::Task::Verify(settings) => match verify::run(&settings) {
            Ok(true) => ExitCode::SUCCESS,
            Ok(false) => ExitCode::FAILURE,
            Err(error) => {
                eprintln!("compute: error: {error}");
                ExitCode::FAILURE
            }
        },
    }
}

fn solve(settings: &Settings) -> ExitCode {
    interrupt::listen();
    match run::run(settings) {
        Ok(report) => {
            // The result is written: a reader that has gone away is no failure.
            writeln!(std::io::stdout(), "{}", report.summary()).ok();
            if report.stopped_by == StoppedBy::Interrupt {
                return ExitCode::from(interrupt::EXIT_CODE);
            }
            report
                .strict_failure()
                .map_or(ExitCode::SUCCESS, |failure| {
                    eprintln!("compute: error: {failure}");
                    ExitCode::FAILURE
                })
        }
        Err(error) => {
            eprintln!("compute: error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
