//! `compute`: solves a scene. See `compute --help`.

use std::io::Write;
use std::process::ExitCode;

use compute::report::StoppedBy;
use compute::{cli, interrupt, run};

fn main() -> ExitCode {
    let settings = cli::parse();
    interrupt::listen();
    match run::run(&settings) {
        Ok(report) => {
            // The result is written: a reader that has gone away is no failure.
            writeln!(std::io::stdout(), "{}", report.summary()).ok();
            let interrupted = report.stopped_by == StoppedBy::Interrupt;
            ExitCode::from(if interrupted { interrupt::EXIT_CODE } else { 0 })
        }
        Err(error) => {
            eprintln!("compute: error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
