//! What the rows of form factors send to each patch.
//!
//! Areas are rounded to 2^-50 of the largest and form factors to 2^-20 of a unit, so that A_i F_ij are
//! integers: their sums do not depend on the order in which rows are drawn, nor on threads.

use rayon::prelude::*;

use crate::compact_rows::{BLOCK, CompactRows};
use crate::rows::UNITS_PER_ONE;

/// sum_i A_i F_ij for every patch j that is seen and sum_j F_ij for every patch i that sees, over the rows that were
/// added.
#[derive(Clone, Debug)]
pub struct Received {
    /// In units of `unit`, one per patch that has a row.
    areas: Vec<u64>,
    /// m^2.
    unit: f64,
    /// In units of `unit`/`PARTS_PER_ONE`, one per patch that is seen. At most 2^50 2^52 2^24.
    sums: Vec<u128>,
    /// In units of 1/`PARTS_PER_ONE`, one per patch that has a row; 0 for rows that were not added.
    row_sums: Vec<u64>,
}

/// Parts of a unit that count.
const PARTS_PER_UNIT: f64 = (1 << 20) as f64;

/// Parts of a form factor of 1.
const PARTS_PER_ONE: f64 = PARTS_PER_UNIT * UNITS_PER_ONE as f64;

/// A form factor in parts.
fn parts(units: f32) -> u64 {
    (f64::from(units) * PARTS_PER_UNIT) as u64
}

/// Patches whose sums a thread adds up by itself: fewer are not worth the headers of the others'.
const MIN_PATCHES_PER_TASK: usize = 4096;

impl Received {
    /// No rows yet. `areas` has one element per patch that has a row, m^2; `sources` patches can be seen.
    pub fn new(areas: &[f64], sources: u32) -> Self {
        let unit = areas.iter().copied().fold(0.0, f64::max) / (1_u64 << 50) as f64;
        Self {
            areas: areas.iter().map(|area| (area / unit) as u64).collect(),
            unit,
            sums: vec![0; sources as usize],
            row_sums: vec![0; areas.len()],
        }
    }

    /// Adds the rows of those of the batch's patches, counted from its first, that are `new`. They count as they are
    /// kept, so that a row from a file is worth the same as one that has just been drawn.
    pub fn add(&mut self, batch: &CompactRows, new: impl Fn(usize) -> bool) {
        let first = batch.receivers().start as usize;
        let rows: Vec<usize> = (0..batch.receivers().len()).filter(|&k| new(k)).collect();
        let areas = &self.areas;
        let per_task = self
            .sums
            .len()
            .div_ceil(rayon::current_num_threads())
            .max(MIN_PATCHES_PER_TASK)
            .next_multiple_of(BLOCK);
        let tasks = self.sums.par_chunks_mut(per_task).enumerate();
        // What each task adds to the sum of each row.
        let row_sums: Vec<Vec<u64>> = tasks
            .map(|(task, sums)| {
                let start = (task * per_task) as u32;
                let sources = start..start + sums.len() as u32;
                let add = |&k: &usize| {
                    let area = u128::from(areas[first + k]);
                    let mut row_sum = 0;
                    batch.row(k).for_each_in(sources.clone(), |entry| {
                        let parts = parts(entry.units);
                        row_sum += parts;
                        sums[(entry.source - start) as usize] += area * u128::from(parts);
                    });
                    row_sum
                };
                rows.iter().map(add).collect()
            })
            .collect();
        for (n, k) in rows.into_iter().enumerate() {
            self.row_sums[first + k] = row_sums.iter().map(|sums| sums[n]).sum();
        }
    }

    /// sum_i A_i F_ij, m^2.
    pub fn area(&self, patch: usize) -> f64 {
        self.sums[patch] as f64 / PARTS_PER_ONE * self.unit
    }

    /// sum_j F_ij of patch i, dimensionless; 0 where its row was not added.
    pub fn row_sum(&self, patch: usize) -> f64 {
        self.row_sums[patch] as f64 / PARTS_PER_ONE
    }

    /// True where a row that was added sees the patch.
    pub fn is_seen(&self, patch: usize) -> bool {
        self.sums[patch] > 0
    }
}

#[cfg(test)]
mod tests {
    use scene::Rgb;

    use super::*;
    use crate::compact_rows::Exact;
    use crate::rows::{Entry, Row, RowBatch, Unseen};

    /// More patches than one task adds up, and rows with gaps, one of which does not count.
    #[test]
    fn tasks_add_up_what_one_loop_does() {
        let count = 3 * MIN_PATCHES_PER_TASK + 17;
        let areas: Vec<f64> = (0..count).map(|j| 1.0 / (1.0 + j as f64)).collect();
        let mut batch = RowBatch::new(5);
        let mut expected = vec![0.0; count];
        for k in 0..40 {
            let row: Vec<Entry> = (k..count)
                .step_by(1 + 7 * k)
                .map(|j| Entry {
                    source: j as u32,
                    units: (j * k + 1) as f32,
                })
                .collect();
            if k != 3 {
                for entry in &row {
                    expected[entry.source as usize] +=
                        areas[5 + k] * f64::from(entry.units) / f64::from(UNITS_PER_ONE);
                }
            }
            batch.push(Row {
                entries: row,
                unseen: Unseen::default(),
            });
        }
        // What lamps receive is kept bit for bit.
        let batch = CompactRows::encode(&batch, &Exact::new(&vec![Rgb::ONE; count]));
        let pool = rayon::ThreadPoolBuilder::new().num_threads(4).build();
        let mut received = Received::new(&areas, count as u32);
        pool.unwrap().install(|| received.add(&batch, |k| k != 3));
        for (j, expected) in expected.iter().enumerate() {
            // 40 additions of f64; the integer sums are exact but for the areas' rounding by 2^-50 of the
            // largest, which is at most 45 of those added.
            let error = (received.area(j) - expected).abs();
            assert!(error <= 1e-13 * expected, "{j}: {error}");
        }
        for k in 0..40 {
            let expected: f64 = batch.row(k).into_iter().map(|e| f64::from(e.units)).sum();
            let expected = if k == 3 {
                0.0
            } else {
                expected / f64::from(UNITS_PER_ONE)
            };
            // Each entry is a whole number of parts here, so that both sums are exact up to one rounding.
            assert!(
                (received.row_sum(5 + k) - expected).abs() <= 1e-15 * expected,
                "{k}"
            );
        }
    }
}
