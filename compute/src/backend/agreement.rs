//! How much the rows of two back ends may differ.
//!
//! # Theory
//! Corners are f64 on the CPU and f32 on the GPU, so a pixel's ray that passes an edge of a surface or a patch within
//! rounding may meet one side on the one and the other on the other. Such a pixel moves its delta form factor from one
//! source to another: of two rows f and g, in units, both of which sum to one, the share
//!
//! d = sum_j |f_j - g_j| / (2 one)
//!
//! has moved, openings and back faces being two more sources j. In the mean over rows d is the share of pixels that
//! differ, as these lie anywhere in the hemicubes.

use crate::rows::{Entry, RowBatch, UNITS_PER_ONE, Unseen};

/// Pixels that may differ, of all pixels of hemicubes of 100 pixels and more. Tuned: the most measured is 0.02 %
/// (llvmpipe, 788 patches at 100 pixels, where by symmetry many edges pass pixels' centres exactly); others may round
/// otherwise.
pub const MAX_DIFFERENT_SHARE: f64 = 0.001;

/// Pixels along a face from which on [`MAX_DIFFERENT_SHARE`] was measured.
const FINE: f64 = 100.0;

/// The most that may have moved between the back ends' rows, in the mean, dimensionless. Of R x R pixels some R lie on
/// an edge, so the share of pixels that can differ falls with 1/R; for fine ones the bound stays as it was measured.
pub fn bound(resolution: u32) -> f64 {
    MAX_DIFFERENT_SHARE * (FINE / f64::from(resolution)).max(1.0)
}

/// Which share of each row has moved between two batches of the same receivers, one per receiver, dimensionless.
///
/// # Panics
/// Where the receivers are others.
pub fn moved(a: &RowBatch, b: &RowBatch) -> Vec<f64> {
    assert_eq!(a.receivers(), b.receivers());
    (0..a.receivers().len())
        .map(|k| {
            let units = of_entries(a.row(k), b.row(k)) + of_unseen(a.unseen(k), b.unseen(k));
            units / (2.0 * f64::from(UNITS_PER_ONE))
        })
        .collect()
}

/// The sum of all differences, in units; both rows are in the order of the sources.
fn of_entries(a: &[Entry], b: &[Entry]) -> f64 {
    let (mut a, mut b) = (a.iter().peekable(), b.iter().peekable());
    let mut sum = 0.0;
    loop {
        let next = match (a.peek(), b.peek()) {
            (None, None) => return sum,
            (Some(entry), None) | (None, Some(entry)) => entry.source,
            (Some(p), Some(q)) => p.source.min(q.source),
        };
        let units = |entry: Option<&Entry>| entry.map_or(0.0, |entry| f64::from(entry.units));
        let p = units(a.next_if(|entry| entry.source == next));
        let q = units(b.next_if(|entry| entry.source == next));
        sum += (p - q).abs();
    }
}

fn of_unseen(a: Unseen, b: Unseen) -> f64 {
    f64::from(a.open.abs_diff(b.open)) + f64::from(a.back_face.abs_diff(b.back_face))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::rows::Row;

    /// A row that sees so many eighths of each source, of openings and of back faces.
    fn row(eighths: &[(u32, u32)], open: u32, back_face: u32) -> RowBatch {
        let eighth = UNITS_PER_ONE / 8;
        let entries = eighths.iter().map(|&(source, eighths)| Entry {
            source,
            units: (eighths * eighth) as f32,
        });
        let row = Row {
            entries: entries.collect(),
            unseen: Unseen {
                open: open * eighth,
                back_face: back_face * eighth,
            },
        };
        RowBatch::of(3, vec![row])
    }

    #[track_caller]
    fn assert_moved(a: &RowBatch, b: &RowBatch, eighths: f64) {
        for found in [moved(a, b), moved(b, a)] {
            // An eighth is a whole number of units, which f32 holds to 2^-24.
            assert!((found[0] - eighths / 8.0).abs() < 1e-6, "{found:?}");
        }
    }

    #[test]
    fn what_moved_is_counted_once_wherever_it_went() {
        let all = row(&[(1, 4), (5, 4)], 0, 0);
        assert_moved(&all, &all, 0.0);
        assert_moved(&all, &row(&[(1, 3), (5, 5)], 0, 0), 1.0);
        assert_moved(&all, &row(&[(1, 4), (4, 1), (5, 3)], 0, 0), 1.0);
        assert_moved(&all, &row(&[(5, 4), (9, 4)], 0, 0), 4.0);
        assert_moved(&all, &row(&[(1, 4), (5, 3)], 1, 0), 1.0);
        assert_moved(&all, &row(&[(1, 4), (5, 2)], 1, 1), 2.0);
        assert_moved(&all, &row(&[], 8, 0), 8.0);
    }

    #[test]
    fn coarse_pixels_are_allowed_more_and_fine_ones_never_less() {
        assert!(bound(2) > bound(50) && bound(50) > bound(100));
        for fine in [100, 128, 4096] {
            assert!(bound(fine).to_bits() == MAX_DIFFERENT_SHARE.to_bits());
        }
    }
}
