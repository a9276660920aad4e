//! Form factor rows as they are kept: in a third of the memory of plain entries, and gathered faster than those.
//!
//! # Practice
//! A row is a list of blocks of 16 patches in order, those without any entry left out. A block has a header of
//! 32 bits (a bit for each patch that has an entry, how many blocks were left out before it, and how
//! entries are stored) and its entries' numbers of 16 bits:
//!
//! - *narrow*: one number an entry, in steps of a power of two of units, the smallest that will do for the
//!   block's largest entry;
//! - *wide*: two numbers an entry, the bits of an f32.
//!
//! Neighbours in a row are neighbours in the scene and mostly seen together, so a block is nearly full, bits
//! are the shortest way to say which patches there are, and all radiosities of a block are read as they lie,
//! without a gather. They are also seen about as large as each other, so one step serves all.
//!
//! # Precision
//! A block is wide where it has an entry of [`WIDE_UNITS`] or more and where it has an emitting patch: what few
//! patches or lamps send is not averaged away, and stays bit for bit. A narrow step is less than 2^-14 of
//! the block's largest entry, and at most 2^-26 of a form factor of 1. What rounding leaves out of an entry
//! is handed on to those that follow, and what it leaves out of a block to the next one, half a step to each entry at
//! most, so a row keeps its sum to half a step, whatever its length, but for entries below half a step, which are kept as
//! one step, and equal radiosities are gathered as exactly as an f32 holds the result. Unequal ones
//! have an error of about 2^-26 sqrt(n / 12) times their spread, where n entries have the largest
//! step: a row has at most 2^11 entries that large, so that it is 2e-7 at most, a few roundings of an f32.
//!
//! Rows are rounded so whether they are kept or drawn anew each time: the memory changes no bit of a solution.
//!
//! # Measured
//! By `examples/row_speed.rs`, bytes an entry at 100 and at 128 pixels, all counted (plain entries take 8):
//! Cornell box, 2,633 patches, 2.77 and 2.76; hall, 26,928 patches, 2.41 and 2.39, and 134,016 patches, 2.52 and
//! 2.45. 4 bytes of a block's header are a third to half a byte of an entry; wide blocks make the rest. One
//! core of an EPYC gathers 1.2 to 1.6 10^9 entries a second, 1.4 to 2 times as many as of plain
//! entries; instructions limit it, not memory.
//!
//! Decoding is what it costs: with one channel instead of three, as a grey scene would do with, one core gathers 1.97
//! against 1.75 10^9 entries a second of the Cornell box, 1.67 against 1.67 and 1.79 against 1.77 of the
//! hall. So all scenes are gathered in three.
//!
//! Zeros instead of missing entries would save the bits, and cost 2 bytes for each of the 15 to 50 percent of
//! a block that is not seen. Patch numbers as differences of 8 bits cost a byte an entry, and a gather.

mod gatherer;
mod stored;

pub use gatherer::{Channels, Gatherer};
pub use stored::Stored;

use std::ops::Range;

use rayon::prelude::*;
use scene::Rgb;

use crate::rows::{Entry, RowBatch};

/// Patches in a block.
pub const BLOCK: usize = 16;

/// Patches decoded at a time.
const LANES: usize = 8;

/// Entries of so many units and more, about 2^-10 of a form factor of 1, are stored as they are. Below it no
/// step is larger than [`MOST_STEP`].
pub const WIDE_UNITS: f32 = MOST_STEPS * MOST_STEP;

/// The largest step of a narrow block, units. Tuned: with 2^4 the rows of the Cornell box would be mostly wide.
pub const MOST_STEP: f32 = 64.0;

/// What is smaller than this is stored as it is too: its step would not be an ordinary f32.
const LEAST_NARROW_UNITS: f32 = 1.0 / (1_u64 << 40) as f32;

/// The most steps of an entry, before what others hand on to it.
const MOST_STEPS: f32 = 65_533.0;

/// The largest number of blocks that a header skips.
const MOST_SKIPPED: u32 = 255;

/// Header's storage of a wide block.
const WIDE: u32 = 255;

/// A narrow block's storage is its step's logarithm, plus this.
const EXPONENT_BIAS: i32 = 64;

/// Which blocks of patches must be stored as they are: one per block, true where a patch emits.
#[derive(Clone, Debug)]
pub struct Exact(Vec<bool>);

impl Exact {
    /// `emission` has one element per patch.
    pub fn new(emission: &[Rgb]) -> Self {
        let blocks = emission.chunks(BLOCK);
        Self(
            blocks
                .map(|block| block.iter().any(|&e| e != Rgb::ZERO))
                .collect(),
        )
    }
}

/// Rows of consecutive receivers.
#[derive(Clone, Debug)]
pub struct CompactRows {
    first: u32,
    /// Where each row ends in the others, one per row.
    ends: Vec<End>,
    /// One per block.
    headers: Vec<u32>,
    /// The blocks' numbers, and `LANES` more that decoding may read.
    numbers: Vec<u16>,
    entries: u64,
}

#[derive(Clone, Copy, Debug, Default)]
struct End {
    header: usize,
    number: usize,
}

/// One row.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    headers: &'a [u32],
    /// From the row's first to the batch's last.
    numbers: &'a [u16],
}

impl CompactRows {
    /// No rows.
    pub fn new() -> Self {
        Self {
            first: 0,
            ends: Vec::new(),
            headers: Vec::new(),
            numbers: vec![0; LANES],
            entries: 0,
        }
    }

    /// The rows of a batch; takes no more memory than they need.
    pub fn encode(batch: &RowBatch, exact: &Exact) -> Self {
        let pieces: Vec<Encoder> = (0..batch.receivers().len())
            .into_par_iter()
            .with_min_len(8)
            .fold(Encoder::default, |mut encoder, k| {
                encoder.push(batch.row(k), exact);
                encoder
            })
            .collect();
        let total = |length: fn(&Encoder) -> usize| pieces.iter().map(length).sum::<usize>();
        let mut rows = Self {
            first: batch.receivers().start,
            ends: Vec::with_capacity(batch.receivers().len()),
            headers: Vec::with_capacity(total(|piece| piece.headers.len())),
            numbers: Vec::with_capacity(total(|piece| piece.numbers.len()) + LANES),
            entries: pieces.iter().map(|piece| piece.entries).sum(),
        };
        for piece in &pieces {
            let (header, number) = (rows.headers.len(), rows.numbers.len());
            rows.ends.extend(piece.ends.iter().map(|end| End {
                header: header + end.header,
                number: number + end.number,
            }));
            rows.headers.extend_from_slice(&piece.headers);
            rows.numbers.extend_from_slice(&piece.numbers);
        }
        rows.numbers.extend_from_slice(&[0; LANES]);
        rows
    }

    /// The receivers whose rows these are.
    pub fn receivers(&self) -> Range<u32> {
        self.first..self.first + self.ends.len() as u32
    }

    /// The row of the batch's k-th receiver.
    pub fn row(&self, k: usize) -> Row<'_> {
        let start = if k == 0 {
            End::default()
        } else {
            self.ends[k - 1]
        };
        Row {
            headers: &self.headers[start.header..self.ends[k].header],
            numbers: &self.numbers[start.number..],
        }
    }

    /// Entries of all rows.
    pub fn entries(&self) -> u64 {
        self.entries
    }

    /// Memory it takes, bytes.
    pub fn bytes(&self) -> u64 {
        (size_of::<Self>()
            + self.ends.capacity() * size_of::<End>()
            + self.headers.capacity() * size_of::<u32>()
            + self.numbers.capacity() * size_of::<u16>()) as u64
    }
}

impl Default for CompactRows {
    fn default() -> Self {
        Self::new()
    }
}

/// Encodes some rows one after the other.
#[derive(Debug, Default)]
struct Encoder {
    ends: Vec<End>,
    headers: Vec<u32>,
    numbers: Vec<u16>,
    entries: u64,
}

impl Encoder {
    fn push(&mut self, row: &[Entry], exact: &Exact) {
        // What rounding has left out so far, units.
        let mut left_out = 0.0;
        let mut next_block = 0;
        for block in row.chunk_by(|a, b| a.source as usize / BLOCK == b.source as usize / BLOCK) {
            let index = block[0].source / BLOCK as u32;
            let mut skipped = index - next_block;
            while skipped > MOST_SKIPPED {
                self.headers.push(MOST_SKIPPED << 16);
                skipped -= MOST_SKIPPED + 1;
            }
            next_block = index + 1;
            let storage = if exact.0[index as usize] {
                WIDE
            } else {
                storage(block)
            };
            let bits = block
                .iter()
                .fold(0, |bits, entry| bits | 1 << (entry.source % BLOCK as u32));
            self.headers.push(storage << 24 | skipped << 16 | bits);
            if storage == WIDE {
                let halves =
                    block.chunk_by(|a, b| a.source as usize / LANES == b.source as usize / LANES);
                for half in halves {
                    let bits = half.iter().map(|entry| entry.units.to_bits());
                    self.numbers.extend(bits.clone().map(|bits| bits as u16));
                    self.numbers.extend(bits.map(|bits| (bits >> 16) as u16));
                }
            } else {
                left_out = self.push_narrow(block, step(storage).into(), left_out);
            }
        }
        self.entries += row.len() as u64;
        self.ends.push(End {
            header: self.headers.len(),
            number: self.numbers.len(),
        });
    }
}

impl Encoder {
    /// Adds the numbers of a narrow block, to which `left_out` units are handed on, and hands on what it leaves out
    /// itself. The sum up to each entry is rounded, and an entry is the difference of two such sums.
    fn push_narrow(&mut self, block: &[Entry], step: f64, left_out: f64) -> f64 {
        // Added to a number, this leaves its nearest integer in the lowest bits.
        const TO_INTEGER: f64 = 1.5 * (1_u64 << 52) as f64;
        // Half a step more or less at most: what large entries leave out is not put on small ones.
        let count = block.len() as f64;
        let each = (left_out / count).clamp(-0.5 * step, 0.5 * step);
        // Exact, since it is a power of two.
        let per_step = 1.0 / step;
        let (mut sum, mut before, mut given) = (0.0, 0, 0);
        self.numbers.extend(block.iter().map(|entry| {
            sum += f64::from(entry.units) + each;
            let rounded = (sum * per_step + TO_INTEGER).to_bits() as i32;
            // None vanishes.
            let steps = (rounded - before).max(1);
            before = rounded;
            given += steps;
            steps as u16
        }));
        left_out + (sum - each * count) - f64::from(given) * step
    }
}

/// How a block is stored that need not be exact.
fn storage(block: &[Entry]) -> u32 {
    let most = block.iter().map(|entry| entry.units).fold(0.0, f32::max);
    if !(LEAST_NARROW_UNITS..WIDE_UNITS).contains(&most) {
        return WIDE;
    }
    // The power of two at or below most / MOST_STEPS, and the next where that is not enough.
    let exponent = ((most / MOST_STEPS).to_bits() >> 23) as i32 - 127;
    let storage = (exponent + EXPONENT_BIAS) as u32;
    storage + u32::from(most > MOST_STEPS * step(storage))
}

/// The step of a narrow block, units.
#[inline]
fn step(storage: u32) -> f32 {
    f32::from_bits((storage + (127 - EXPONENT_BIAS) as u32) << 23)
}

/// The parts of a header.
#[derive(Clone, Copy, Debug)]
struct Header {
    /// One per patch of the block.
    bits: u32,
    skipped: u32,
    storage: u32,
}

impl Header {
    #[inline]
    fn new(header: u32) -> Self {
        Self {
            bits: header & 0xffff,
            skipped: header >> 16 & MOST_SKIPPED,
            storage: header >> 24,
        }
    }

    /// How many numbers the block has.
    #[inline]
    fn numbers(self) -> usize {
        (self.bits.count_ones() << u32::from(self.storage == WIDE)) as usize
    }

    /// Hands out the entries of the block, whose first source is `first` and whose numbers come first in `numbers`.
    #[inline]
    fn decode(self, first: u32, numbers: &[u16], mut each: impl FnMut(Entry)) {
        let mut numbers = &numbers[..self.numbers()];
        for half in 0..BLOCK / LANES {
            let mut bits = self.bits >> (LANES * half) & 0xff;
            let count = bits.count_ones() as usize;
            let (low, rest) = numbers.split_at(count);
            let high;
            (high, numbers) = if self.storage == WIDE {
                rest.split_at(count)
            } else {
                (low, rest)
            };
            for (&low, &high) in low.iter().zip(high) {
                let units = if self.storage == WIDE {
                    f32::from_bits(u32::from(high) << 16 | u32::from(low))
                } else {
                    f32::from(low) * step(self.storage)
                };
                each(Entry {
                    source: first + (LANES * half) as u32 + bits.trailing_zeros(),
                    units,
                });
                bits &= bits - 1;
            }
        }
    }
}

impl Row<'_> {
    /// Hands out the entries of sources of a range, in order; it begins with a block.
    #[inline]
    pub fn for_each_in(self, sources: Range<u32>, mut each: impl FnMut(Entry)) {
        debug_assert_eq!(sources.start % BLOCK as u32, 0);
        let (mut next_block, mut at) = (0, 0);
        for &header in self.headers {
            let header = Header::new(header);
            let first = (next_block + header.skipped) * BLOCK as u32;
            next_block += header.skipped + 1;
            if first >= sources.end {
                break;
            }
            if first >= sources.start {
                header.decode(first, &self.numbers[at..], |entry| {
                    if entry.source < sources.end {
                        each(entry);
                    }
                });
            }
            at += header.numbers();
        }
    }
}

impl<'a> IntoIterator for Row<'a> {
    type Item = Entry;
    type IntoIter = Entries<'a>;

    fn into_iter(self) -> Entries<'a> {
        Entries {
            row: self,
            next_block: 0,
            decoded: [Entry {
                source: 0,
                units: 0.0,
            }; BLOCK],
            handed_out: 0..0,
        }
    }
}

/// A row's entries in patch order.
#[derive(Clone, Debug)]
pub struct Entries<'a> {
    /// What is left of it.
    row: Row<'a>,
    next_block: u32,
    /// A block's entries.
    decoded: [Entry; BLOCK],
    /// Those of them that are left.
    handed_out: Range<usize>,
}

impl Entries<'_> {
    /// Decodes the next block, if there is one.
    fn decode(&mut self) -> Option<()> {
        let (&header, headers) = self.row.headers.split_first()?;
        let header = Header::new(header);
        let block = self.next_block + header.skipped;
        let mut count = 0;
        header.decode(block * BLOCK as u32, self.row.numbers, |entry| {
            self.decoded[count] = entry;
            count += 1;
        });
        self.row.headers = headers;
        self.row.numbers = &self.row.numbers[header.numbers()..];
        self.next_block = block + 1;
        self.handed_out = 0..count;
        Some(())
    }
}

impl Iterator for Entries<'_> {
    type Item = Entry;

    #[inline]
    fn next(&mut self) -> Option<Entry> {
        loop {
            if let Some(k) = self.handed_out.next() {
                return Some(self.decoded[k]);
            }
            self.decode()?;
        }
    }
}
