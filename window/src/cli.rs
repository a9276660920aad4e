//! The command line.

use std::path::PathBuf;

use clap::Parser;

/// Shows a scene and its solution in a window.
///
/// The file is read again whenever it changes, as while `compute` writes to it. Exit codes: 0 done, 1 failed, 2 wrong usage.
#[derive(Debug, Parser)]
#[command(name = "display-window", version)]
struct Arguments {
    /// The scene, with or without a solution.
    file: PathBuf,
}

/// The file that is asked for. Ends the program where none is.
pub fn parse() -> PathBuf {
    Arguments::parse().file
}
