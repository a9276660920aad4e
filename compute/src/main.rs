//! `compute`: solves a scene. See `compute --help`.

use std::process::ExitCode;

use compute::program::{self, cli};

fn main() -> ExitCode {
    program::run(&cli::parse()).unwrap_or_else(|error| {
        eprintln!("compute: error: {error:#}");
        ExitCode::FAILURE
    })
}
