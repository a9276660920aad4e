//! The program `display`: pictures and exports of scenes and solutions.

use std::process::ExitCode;

fn main() -> ExitCode {
    let job = display::cli::parse();
    match display::run(&job) {
        Ok(code) => code,
        Err(error) => {
            eprintln!("display: error: {error:#}");
            ExitCode::FAILURE
        }
    }
}
