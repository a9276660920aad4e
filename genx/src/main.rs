//! `genx`: makes a scene file from a model. See `genx --help`.

mod cli;
mod list;
mod printable;
mod run;

use std::process::ExitCode;

fn main() -> ExitCode {
    let request = match cli::parse(std::env::args_os()) {
        Ok(request) => request,
        Err(stop) => return ExitCode::from(stop.print()),
    };
    if let Err(error) = run::run(&request) {
        let error = printable::printable(&format!("{error:#}"));
        eprintln!("genx: error: {error}");
        return ExitCode::FAILURE;
    }
    ExitCode::SUCCESS
}
