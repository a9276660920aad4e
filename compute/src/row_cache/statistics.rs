//! What rows have cost.

use std::time::Duration;

/// What drawing has cost.
#[derive(Clone, Copy, Debug, Default)]
pub struct RowStatistics {
    /// Hemicubes drawn, those drawn again included.
    pub hemicubes: u64,
    /// Time spent drawing and merging.
    pub duration: Duration,
    /// Memory of the rows that are kept, bytes.
    pub kept_bytes: u64,
    /// Rows that are kept.
    pub kept_rows: u64,
    /// Their entries.
    pub kept_entries: u64,
    /// Rows that did not fit, each counted as often as it was drawn or read.
    pub left_out_rows: u64,
    /// Their memory, bytes.
    pub left_out_bytes: u64,
    /// Rows that were drawn, each counted as often as it was drawn.
    pub drawn_rows: u64,
    /// Rows that were read from a file instead of drawn, each counted as often as it was read.
    pub read_rows: u64,
    /// Time spent reading and writing files of rows.
    pub files: Duration,
}

impl RowStatistics {
    /// Memory an entry of the kept rows takes, bytes; `None` where none is kept.
    pub fn bytes_per_entry(&self) -> Option<f64> {
        (self.kept_entries > 0).then(|| self.kept_bytes as f64 / self.kept_entries as f64)
    }

    /// The same rows, with what drawing and reading others has cost counted too.
    #[must_use]
    pub fn with_drawing_of(&self, others: &Self) -> Self {
        Self {
            hemicubes: self.hemicubes + others.hemicubes,
            duration: self.duration + others.duration,
            drawn_rows: self.drawn_rows + others.drawn_rows,
            read_rows: self.read_rows + others.read_rows,
            files: self.files + others.files,
            ..*self
        }
    }

    /// About the memory that all of so many rows would take, bytes, told by those that were drawn.
    pub fn bytes_of_all(&self, rows: u32) -> u64 {
        let bytes = (self.kept_bytes + self.left_out_bytes) as f64;
        let drawn = self.kept_rows + self.left_out_rows;
        (bytes / drawn.max(1) as f64 * f64::from(rows)) as u64
    }
}
