//! Rows as a file keeps them: the same headers and numbers, checked before anything decodes them.

use super::{BLOCK, CompactRows, EXPONENT_BIAS, End, Header, LANES, MOST_SKIPPED, MOST_STEP, WIDE};
use crate::rows::UNITS_PER_ONE;

/// One row as it is stored. What has this type can be decoded.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stored<'a> {
    /// One per block.
    headers: &'a [u32],
    /// Of all blocks.
    numbers: &'a [u16],
    entries: u64,
}

/// A narrow block's largest storage.
const MOST_STORAGE: u32 = (MOST_STEP.to_bits() >> 23) - 127 + EXPONENT_BIAS as u32;

/// What the entries of a row sum to at most. One hemisphere has half of it; the thesis's multipliers and lamps' views count
/// somewhat more.
const MOST_UNITS: f64 = 2.0 * UNITS_PER_ONE as f64;

/// The header that skips as many blocks as it can, and has no entry itself.
const SKIP: u32 = MOST_SKIPPED << 16;

/// The upper halves of all finite f32 that are not negative are below this: the exponent's bits.
const NOT_FINITE: u16 = 0x7f80;

impl<'a> Stored<'a> {
    /// The row of these headers and numbers, whoever wrote them; `None` where they are not what a row of entries
    /// of `sources` patches can be: patches in order and all there, units finite, not negative and no more than a hemisphere can have, no number missing or
    /// left over.
    pub fn checked(headers: &'a [u32], numbers: &'a [u16], sources: u32) -> Option<Self> {
        let mut left = numbers;
        let mut next_block = 0;
        let mut units = 0.0;
        for &bits in headers {
            let header = Header::new(bits);
            let block = next_block + u64::from(header.skipped);
            next_block = block + 1;
            // Decoding reads the radiosities of a block even where it has no entry.
            let patches = u64::from(sources)
                .checked_sub(block * BLOCK as u64)
                .filter(|&patches| patches > 0)?;
            if u64::from(header.bits) >> patches.min(BLOCK as u64) != 0 {
                return None;
            }
            if header.bits == 0 {
                if bits != SKIP {
                    return None;
                }
                continue;
            }
            let of_block = left;
            for half in 0..2 {
                let count = (header.bits >> (LANES * half) & 0xff).count_ones() as usize;
                let numbers;
                if header.storage == WIDE {
                    (_, left) = left.split_at_checked(count)?;
                    (numbers, left) = left.split_at_checked(count)?;
                    if numbers.iter().any(|&upper| upper >= NOT_FINITE) {
                        return None;
                    }
                } else {
                    (numbers, left) = left.split_at_checked(count)?;
                    let is_step = (1..=MOST_STORAGE).contains(&header.storage);
                    if !is_step || numbers.contains(&0) {
                        return None;
                    }
                }
            }
            header.decode(0, of_block, |entry| units += f64::from(entry.units));
        }
        let is_row = left.is_empty() && units <= MOST_UNITS;
        is_row.then(|| Self::new(headers, numbers))
    }

    /// Of a row that was encoded or checked.
    pub(super) fn new(headers: &'a [u32], numbers: &'a [u16]) -> Self {
        let entries = headers.iter().map(|&bits| Header::new(bits).bits);
        Self {
            headers,
            numbers,
            entries: entries.map(|bits| u64::from(bits.count_ones())).sum(),
        }
    }

    /// One per block of the row.
    pub fn headers(self) -> &'a [u32] {
        self.headers
    }

    /// Of all blocks.
    pub fn numbers(self) -> &'a [u16] {
        self.numbers
    }
}

impl CompactRows {
    /// The batch's k-th row as it is stored. It depends on that row alone, not on the batch.
    pub fn stored(&self, k: usize) -> Stored<'_> {
        let row = self.row(k);
        let start = k
            .checked_sub(1)
            .map_or(0, |before| self.ends[before].number);
        Stored::new(row.headers, &row.numbers[..self.ends[k].number - start])
    }

    /// The rows of consecutive patches, the first of which is `first`'s, as they were stored; takes no more
    /// memory than they need.
    pub fn of_stored(first: u32, stored: &[Stored]) -> Self {
        let headers = stored.iter().map(|row| row.headers.len()).sum();
        let numbers: usize = stored.iter().map(|row| row.numbers.len()).sum();
        let mut rows = Self {
            first,
            ends: Vec::with_capacity(stored.len()),
            headers: Vec::with_capacity(headers),
            numbers: Vec::with_capacity(numbers + LANES),
            entries: stored.iter().map(|row| row.entries).sum(),
        };
        for row in stored {
            rows.headers.extend_from_slice(row.headers);
            rows.numbers.extend_from_slice(row.numbers);
            rows.ends.push(End {
                header: rows.headers.len(),
                number: rows.numbers.len(),
            });
        }
        rows.numbers.extend_from_slice(&[0; LANES]);
        rows
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;
    use proptest::collection::vec;
    use proptest::prelude::*;

    use super::*;
    use crate::compact_rows::{Channels, Exact, Gatherer};
    use crate::rows::{Entry, Row, RowBatch};

    /// Patches of the rows here: more than one header can skip, and no whole number of blocks.
    const SOURCES: u32 = 5000;

    /// A row, narrow and wide, with gaps of all lengths.
    fn any_rows() -> impl Strategy<Value = CompactRows> {
        let gap = prop_oneof![6 => 1..3_u32, 2 => 1..40_u32, 1 => 1..5000_u32];
        let units = prop_oneof![4 => 1.0..1e5_f32, 1 => 1e6..1e8_f32, 1 => 1e-20..1e-3_f32];
        let row = vec((gap, units), 0..60).prop_map(|steps| {
            let mut patch = 0;
            let entries = steps.into_iter().map(|(gap, units)| {
                patch += gap;
                Entry {
                    source: patch - 1,
                    units,
                }
            });
            Row {
                entries: entries.take_while(|e| e.source < SOURCES).collect(),
                ..Row::default()
            }
        });
        vec(row, 1..5).prop_map(|rows| {
            let exact = Exact::new(&vec![Vec3::ZERO; SOURCES as usize]);
            CompactRows::encode(&RowBatch::of(7, rows), &exact)
        })
    }

    /// What is checked decodes to entries in order, of sources, finite and not negative, and is gathered.
    fn decodes(stored: Stored) {
        let rows = CompactRows::of_stored(0, &[stored]);
        let entries: Vec<Entry> = rows.row(0).into_iter().collect();
        assert_eq!(entries.len() as u64, rows.entries());
        assert!(entries.is_sorted_by(|a, b| a.source < b.source));
        assert!(entries.iter().all(|e| e.source < SOURCES));
        assert!(
            entries
                .iter()
                .all(|e| e.units.is_finite() && e.units.is_sign_positive())
        );
        let channels = Channels::new((0..SOURCES as usize).map(|_| Vec3::ONE));
        let gathered = Gatherer::default().gather(rows.row(0), &channels);
        assert!(gathered.is_finite());
    }

    proptest! {
        #[test]
        fn rows_put_together_are_those_that_were_stored(rows in any_rows()) {
            let count = rows.receivers().len();
            let stored: Vec<Stored> = (0..count).map(|k| rows.stored(k)).collect();
            for row in &stored {
                let checked = Stored::checked(row.headers(), row.numbers(), SOURCES);
                prop_assert_eq!(checked, Some(*row));
                decodes(*row);
            }
            let again = CompactRows::of_stored(7, &stored);
            prop_assert_eq!(again.receivers(), rows.receivers());
            prop_assert_eq!(again.entries(), rows.entries());
            prop_assert_eq!(again.bytes(), rows.bytes());
            for (k, row) in stored.iter().enumerate() {
                prop_assert_eq!(again.stored(k), *row);
                prop_assert!(again.row(k).into_iter().eq(rows.row(k)));
            }
            // A part of a batch is the same rows.
            let part = CompactRows::of_stored(8, &stored[1..]);
            prop_assert!((1..count).all(|k| part.stored(k - 1) == stored[k]));
        }

        #[test]
        fn rows_of_any_bits_are_refused_or_decode(
            headers in vec(any::<u32>(), 0..4),
            numbers in vec(any::<u16>(), 0..40),
        ) {
            if let Some(stored) = Stored::checked(&headers, &numbers, SOURCES) {
                decodes(stored);
            }
        }

        #[test]
        fn rows_with_one_bit_changed_are_refused_or_decode(
            rows in any_rows(),
            at in any::<prop::sample::Index>(),
            bit in 0..32_u32,
        ) {
            let row = rows.stored(0);
            let (mut headers, mut numbers) = (row.headers().to_vec(), row.numbers().to_vec());
            if headers.is_empty() {
                return Ok(());
            }
            let in_headers = headers.clone();
            headers[at.index(in_headers.len())] ^= 1 << bit;
            if let Some(stored) = Stored::checked(&headers, &numbers, SOURCES) {
                decodes(stored);
            }
            let at = at.index(numbers.len());
            numbers[at] ^= 1 << (bit % 16);
            if let Some(stored) = Stored::checked(&in_headers, &numbers, SOURCES) {
                decodes(stored);
            }
        }
    }

    #[test]
    fn what_no_row_has_is_refused() {
        let is_row =
            |headers: &[u32], numbers: &[u16]| Stored::checked(headers, numbers, SOURCES).is_some();
        let narrow = 64 << 24;
        assert!(is_row(&[], &[]));
        assert!(is_row(&[narrow | 0b101], &[7, 9]));
        // A number that is missing, left over or 0.
        assert!(!is_row(&[narrow | 0b101], &[7]));
        assert!(!is_row(&[narrow | 0b101], &[7, 9, 1]));
        assert!(!is_row(&[narrow | 0b101], &[7, 0]));
        assert!(!is_row(&[], &[1]));
        // Steps that are not made.
        assert!(!is_row(&[1], &[1]));
        assert!(is_row(&[MOST_STORAGE << 24 | 1], &[1]));
        assert!(!is_row(&[(MOST_STORAGE + 1) << 24 | 1], &[1]));
        // Infinity, NaN, a negative number.
        let wide = WIDE << 24 | 1;
        // A hemisphere, and far more than one.
        assert!(is_row(&[wide], &[0, 0x4f80]));
        for upper in [0x7f7f, 0x7f80, 0x7fc0, 0x8000] {
            assert!(!is_row(&[wide], &[0, upper]));
        }
        // No entry, without being a skip; skips to and past the last patch's block, 312.
        assert!(!is_row(&[narrow], &[]));
        let after_skip = |skipped: u32, bits| [SKIP, narrow | skipped << 16 | bits];
        assert!(is_row(&after_skip(56, 1 << 7), &[1]));
        assert!(!is_row(&after_skip(56, 1 << 8), &[1]));
        assert!(!is_row(&after_skip(57, 1), &[1]));
        assert!(!is_row(&[SKIP, SKIP], &[]));
    }
}
