//! All form factors as text: `from,to,form_factor`, one line for each that is not zero.

use std::path::Path;

use scene::file::{FileError, write_atomically};

use crate::row_cache::RowCache;
use crate::rows::UNITS_PER_ONE;

/// Writes the rows of all patches, drawing those that are not kept.
///
/// # Errors
/// A file that cannot be written, and what the back end says.
pub fn save(path: &Path, rows: &mut RowCache) -> Result<(), FileError> {
    write_atomically(path, |out| {
        writeln!(out, "from,to,form_factor")?;
        rows.for_each_row(|from, row| {
            for entry in row {
                let form_factor = f64::from(entry.units) / f64::from(UNITS_PER_ONE);
                writeln!(out, "{from},{},{form_factor}", entry.source)?;
            }
            Ok(())
        })
    })
}
