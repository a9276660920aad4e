//! Lines for who runs the program.

use std::io::Write;
use std::path::Path;

/// One line that is no failure, on standard error.
pub fn note(what: &str) {
    eprintln!("display: note: {what}");
}

/// One line about a file that was written, on standard output. Nobody to read it is no failure: the file is there.
pub fn report(path: &Path, what: &str) {
    writeln!(std::io::stdout(), "{}: {what}", path.display()).ok();
}
