//! Laws of rows as they are kept.

use compute::compact_rows::{Channels, CompactRows, Exact, Gatherer, MOST_STEP, WIDE_UNITS};
use compute::rows::{Entry, Row, RowBatch, UNITS_PER_ONE, Unseen};
use glam::DVec3;
use proptest::collection::vec;
use proptest::prelude::*;
use scene::Rgb;

/// Patches of the rows here: more than a header can skip.
const PATCHES: u32 = 12_000;

/// A narrow step is less than this share of the block's largest entry: the next power of two of a 65,533rd.
const STEP_SHARE: f64 = 2.0 / 65_533.0;

/// Entries with gaps of all lengths and units of all sizes, whole and broken.
fn any_row() -> impl Strategy<Value = Vec<Entry>> {
    let gap = prop_oneof![
        8 => Just(1_u32),
        3 => 1..20_u32,
        1 => 1..6000_u32,
    ];
    let units = (0.0..30.0_f64, any::<bool>()).prop_map(|(log, is_whole)| {
        let units = log.exp2() as f32 * 1.3;
        if is_whole { units.round() } else { units / 7.0 }
    });
    vec((gap, units), 0..600).prop_map(|steps| {
        let mut patch = 0;
        let mut row = Vec::new();
        for (gap, units) in steps {
            patch += gap;
            if patch > PATCHES {
                break;
            }
            let patch = patch - 1;
            row.push(Entry {
                source: patch,
                units,
            });
        }
        row
    })
}

fn batch(rows: &[Vec<Entry>]) -> RowBatch {
    let mut batch = RowBatch::new(3);
    for row in rows {
        batch.push(Row {
            entries: row.clone(),
            unseen: Unseen::default(),
        });
    }
    batch
}

/// A few emitters.
fn emission() -> Vec<Rgb> {
    let emits = |patch: u32| (100..120).contains(&patch) || patch == PATCHES - 1;
    (0..PATCHES)
        .map(|p| if emits(p) { Rgb::X } else { Rgb::ZERO })
        .collect()
}

fn decoded(rows: &CompactRows, k: usize) -> Vec<Entry> {
    rows.row(k).into_iter().collect()
}

fn units(row: &[Entry]) -> f64 {
    row.iter().map(|entry| f64::from(entry.units)).sum()
}

fn blocks(row: &[Entry]) -> impl Iterator<Item = &[Entry]> {
    row.chunk_by(|a, b| a.source / 16 == b.source / 16)
}

/// The most that a narrow block's step may be, units; 0 where it is stored as it is.
fn most_step(block: &[Entry], emission: &[Rgb]) -> f64 {
    let first = (block[0].source / 16 * 16) as usize;
    let most = block.iter().map(|e| e.units).fold(0.0, f32::max);
    let emits = emission[first..first + 16].iter().any(|&e| e != Rgb::ZERO);
    if emits || most >= WIDE_UNITS {
        0.0
    } else {
        (STEP_SHARE * f64::from(most)).min(MOST_STEP.into())
    }
}

proptest! {
    /// An entry is off by half a step of its own and one that was handed on to it; none vanishes.
    #[test]
    fn decoded_rows_have_the_same_patches_and_nearly_the_units(rows in vec(any_row(), 0..20)) {
        let emission = emission();
        let compact = CompactRows::encode(&batch(&rows), &Exact::new(&emission));
        prop_assert_eq!(compact.receivers(), 3..3 + rows.len() as u32);
        prop_assert_eq!(compact.entries(), rows.iter().map(Vec::len).sum::<usize>() as u64);
        for (k, row) in rows.iter().enumerate() {
            let found = decoded(&compact, k);
            prop_assert_eq!(found.len(), row.len());
            for (before, after) in blocks(row).zip(blocks(&found)) {
                let bound = 1.5 * most_step(before, &emission);
                for (before, after) in before.iter().zip(after) {
                    prop_assert_eq!(before.source, after.source);
                    let error = (f64::from(before.units) - f64::from(after.units)).abs();
                    prop_assert!(error <= bound, "{:?} {:?} {}", before, after, bound);
                    prop_assert!(after.units > 0.0);
                }
            }
        }
    }

    /// What is left out at the end of a row is half the largest step, and what entries of less than
    /// three halves of a step, which are not let vanish, could not hand on.
    #[test]
    fn rows_keep_their_sums(row in any_row()) {
        let emission = emission();
        let compact = CompactRows::encode(&batch(std::slice::from_ref(&row)), &Exact::new(&emission));
        let mut bound = f64::from(MOST_STEP) / 2.0;
        for block in blocks(&row) {
            let step = most_step(block, &emission);
            let small = block.iter().filter(|e| f64::from(e.units) < 1.5 * step);
            bound += 2.0 * step * small.count() as f64;
        }
        let error = (units(&row) - units(&decoded(&compact, 0))).abs();
        prop_assert!(error <= bound, "{} {}", error, bound);
    }

    /// f64 sums of the decoded entries' exact products, in another order.
    #[test]
    fn gathering_is_the_sum_over_the_decoded_entries(row in any_row(), seed in 0..1000_u32) {
        let radiosity = |j: u32| {
            let value = |channel: u32| (j.wrapping_mul(2_654_435_761) ^ seed.wrapping_mul(40_503 + channel)) as f32;
            Rgb::new(value(0), value(1), value(2))
        };
        let compact = CompactRows::encode(&batch(std::slice::from_ref(&row)), &Exact::new(&emission()));
        let channels = Channels::new((0..PATCHES as usize).map(|j| radiosity(j as u32)));
        let found = Gatherer::default().gather(compact.row(0), &channels);
        let decoded = decoded(&compact, 0);
        let expected: DVec3 = decoded
            .iter()
            .map(|entry| f64::from(entry.units) * radiosity(entry.source).as_dvec3())
            .sum();
        // Each of at most so many additions rounds by half a unit in the last place, of sums of what is not negative.
        let bound = 2.0 * row.len() as f64 * f64::EPSILON / 2.0 * expected;
        prop_assert!((found - expected).abs().cmple(bound).all(), "{found} {expected}");
    }

    /// The memory counted is that of the arrays: 2 or 4 bytes an entry, 4 a block, and 16 a row.
    #[test]
    fn memory_is_what_blocks_and_entries_take(rows in vec(any_row(), 1..20)) {
        let compact = CompactRows::encode(&batch(&rows), &Exact::new(&emission()));
        let entries: usize = rows.iter().map(Vec::len).sum();
        let blocks: usize = rows.iter().map(|row| blocks(row).count()).sum();
        // A header skips 255 blocks, and one more that is empty by itself.
        let most_blocks = blocks + rows.len() * (PATCHES as usize / 16 / 256);
        let fixed = size_of::<CompactRows>() + 16 * rows.len() + 2 * 8;
        let least = (fixed + 2 * entries + 4 * blocks) as u64;
        let most = (fixed + 4 * entries + 4 * most_blocks) as u64;
        prop_assert!((least..=most).contains(&compact.bytes()), "{least} {} {most}", compact.bytes());
    }
}

#[test]
fn whole_rows_sum_to_one_after_rounding() {
    // A row as of a patch in a room: 3000 entries whose sum is a form factor of 1.
    let mut left = UNITS_PER_ONE;
    let row: Vec<Entry> = (0..3000_u32)
        .map(|patch| {
            let units = if patch == 2999 {
                left
            } else {
                (left / (3000 - patch)) / 3 * 2 + 7 * (patch % 11)
            };
            left -= units;
            Entry {
                source: patch,
                units: units as f32,
            }
        })
        .collect();
    let compact = CompactRows::encode(&batch(std::slice::from_ref(&row)), &Exact::new(&emission()));
    let error = (units(&row) - units(&decoded(&compact, 0))).abs();
    assert!(error <= f64::from(MOST_STEP) / 2.0, "{error}");
}
