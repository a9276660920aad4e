//! All form factors as text: `from,to,form_factor`, one line for each that is not zero.

use std::io::{BufWriter, Write};
use std::path::Path;

use scene::file::write_atomically;

use crate::interrupt;
use crate::row_cache::RowCache;

/// Writes the rows of all patches, drawing those that are not kept.
pub fn save(path: &Path, rows: &mut RowCache, patch_count: u32) -> anyhow::Result<()> {
    write_atomically(path, |out| {
        let mut out = BufWriter::new(out);
        let units_per_one = f64::from(rows.units_per_one());
        writeln!(out, "from,to,form_factor")?;
        let mut patch = 0;
        while patch < patch_count {
            if interrupt::requested() {
                return Err(std::io::ErrorKind::Interrupted.into());
            }
            let batch = rows.batch_with(patch).map_err(std::io::Error::other)?;
            let range = batch.patches();
            for from in patch..range.end {
                for entry in batch.row((from - range.start) as usize) {
                    let form_factor = f64::from(entry.units) / units_per_one;
                    writeln!(out, "{from},{},{form_factor}", entry.patch)?;
                }
            }
            patch = range.end;
        }
        out.flush()
    })?;
    Ok(())
}
