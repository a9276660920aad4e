//! All form factors as text: `from,to,form_factor`, one line for each that is not zero.

use std::path::Path;

use scene::file::write_atomically;

use crate::row_cache::RowCache;
use crate::rows::UNITS_PER_ONE;

/// Writes the rows of all patches, drawing those that are not kept.
pub fn save(path: &Path, rows: &mut RowCache) -> anyhow::Result<()> {
    write_atomically(path, |out| {
        writeln!(out, "from,to,form_factor")?;
        rows.for_each_row(|from, row| {
            for entry in row {
                let form_factor = f64::from(entry.units) / f64::from(UNITS_PER_ONE);
                writeln!(out, "{from},{},{form_factor}", entry.patch)?;
            }
            Ok(())
        })
    })?;
    Ok(())
}
