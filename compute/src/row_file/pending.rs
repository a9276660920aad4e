//! Rows of blocks that are not whole yet.

use std::collections::BTreeMap;

use super::layout::{RecordHeader, RowRecord};
use super::{RowState, place};
use crate::compact_rows::Stored;
use crate::rows::Unseen;

/// Rows that wait for the others of their blocks.
#[derive(Debug, Default)]
pub struct Pending {
    blocks: BTreeMap<u32, PendingBlock>,
    /// What all of them take in a file but for the records' headers.
    bytes: u64,
}

/// What there is of a block.
#[derive(Debug, Default)]
pub struct PendingBlock {
    drawn: u64,
    /// Without those that are drawn.
    unlit: u64,
    /// Those that are drawn, by their places in the block.
    rows: BTreeMap<u32, PendingRow>,
}

#[derive(Debug)]
struct PendingRow {
    unseen: Unseen,
    headers: Box<[u32]>,
    numbers: Box<[u16]>,
}

impl PendingRow {
    /// What it takes in a file.
    fn bytes(&self) -> u64 {
        (size_of::<RowRecord>() + size_of_val(&*self.headers) + size_of_val(&*self.numbers)) as u64
    }
}

impl Pending {
    /// Adds a row, unless it is there already.
    pub fn add(&mut self, receiver: u32, row: Stored, state: RowState) {
        let (block, k) = place(receiver);
        let block = self.blocks.entry(block).or_default();
        match state {
            RowState::Missing => {}
            RowState::Unlit => block.unlit |= (1 << k) & !block.drawn,
            RowState::Drawn(_) if block.drawn & 1 << k != 0 => {}
            RowState::Drawn(unseen) => {
                let row = PendingRow {
                    unseen,
                    headers: row.headers().into(),
                    numbers: row.numbers().into(),
                };
                self.bytes += row.bytes();
                block.drawn |= 1 << k;
                block.unlit &= !block.drawn;
                block.rows.insert(k, row);
            }
        }
    }

    /// What the rows take in a file, about.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// The rows of a block that wait, as bits.
    pub fn bits(&self, block: u32) -> u64 {
        let block = self.blocks.get(&block);
        block.map_or(0, |block| block.drawn | block.unlit)
    }

    /// The first block of which there is anything.
    pub fn first(&self) -> Option<u32> {
        self.blocks.keys().next().copied()
    }

    /// What there is of a block; it waits no longer.
    pub fn take(&mut self, block: u32) -> PendingBlock {
        let taken = self.blocks.remove(&block).unwrap_or_default();
        self.bytes -= taken.rows.values().map(PendingRow::bytes).sum::<u64>();
        taken
    }
}

impl PendingBlock {
    /// The record of these rows: its header, and its header and body as they lie in a file.
    pub fn record(&self, block: u32) -> (RecordHeader, Vec<u8>) {
        const HEADER_BYTES: usize = size_of::<RecordHeader>();
        let rows = || self.rows.values();
        let body_bytes = rows().map(PendingRow::bytes).sum::<u64>() as usize;
        let mut record = Vec::with_capacity(HEADER_BYTES + body_bytes);
        record.resize(HEADER_BYTES, 0);
        for row in rows() {
            record.extend_from_slice(bytemuck::bytes_of(&RowRecord {
                open: row.unseen.open,
                back_face: row.unseen.back_face,
                headers: row.headers.len() as u32,
                numbers: row.numbers.len() as u32,
            }));
        }
        for row in rows() {
            record.extend_from_slice(bytemuck::cast_slice(&row.headers));
        }
        for row in rows() {
            record.extend_from_slice(bytemuck::cast_slice(&row.numbers));
        }
        let (head, body) = record.split_at_mut(HEADER_BYTES);
        let header = RecordHeader::new(block, self.drawn, self.unlit, body);
        head.copy_from_slice(bytemuck::bytes_of(&header));
        (header, record)
    }
}
