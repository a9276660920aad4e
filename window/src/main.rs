//! The program `display-window`: a window onto a scene and its solution.

use std::process::ExitCode;

fn main() -> ExitCode {
    match window::open(window::cli::parse()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("display-window: error: {error}");
            ExitCode::FAILURE
        }
    }
}
