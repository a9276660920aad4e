//! Opening the window, which is a program of its own: what makes pictures and exports needs neither a screen nor a graphics card.

use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// The window's program, beside this one.
const PROGRAM: &str = "display-window";

/// Why there is no window.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum WindowError {
    #[error(
        "the window is a program of its own, and {} is not there; cargo build --release -p window makes it. Or give --out \
         IMAGE.png|.exr for a picture, --export FILE.ply|.glb|.obj|.csv for the patches, --by object for a table or --compare FILE",
        path.display()
    )]
    Missing { path: PathBuf },
    #[error("{}: cannot start: {source}", path.display())]
    Start {
        path: PathBuf,
        source: std::io::Error,
    },
}

/// Shows a file in a window until it is closed. What is wrong then has been told.
pub fn open(file: &Path) -> Result<ExitCode, WindowError> {
    let name = format!("{PROGRAM}{}", std::env::consts::EXE_SUFFIX);
    let own = std::env::current_exe().unwrap_or_default();
    let path = own.with_file_name(name);
    if !path.is_file() {
        return Err(WindowError::Missing { path });
    }
    match Command::new(&path).arg(file).status() {
        Ok(status) if status.success() => Ok(ExitCode::SUCCESS),
        Ok(_) => Ok(ExitCode::FAILURE),
        Err(source) => Err(WindowError::Start { path, source }),
    }
}
