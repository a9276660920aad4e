//! Form factor rows from hemicubes drawn on the CPU.

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use fearless_simd::{Level, Simd, dispatch, prelude::*, u32x8};
use fearless_simd_macros::simd;
use rayon::prelude::*;
use thread_local::ThreadLocal;
use visibility::hemicube::pixel_count;
use visibility::item_buffer::HemicubeDrawer;
use visibility::runs::for_each_run;

use crate::hemicubes::Hemicubes;
use crate::receivers::ReceiverId;
use crate::rows::{BackendError, Entry, Row, RowBatch, RowSource, Unseen};

/// The cpu back end. It draws on the threads of the rayon pool it is called in.
pub struct CpuRows<'a> {
    hemicubes: Arc<Hemicubes<'a>>,
    /// One for each thread that has drawn.
    drawers: ThreadLocal<RefCell<RowDrawer<'a>>>,
}

/// Pixels in a batch for each thread, and rows at most: enough that the threads' work is even, few enough that an
/// interrupt is answered soon.
const PIXELS_PER_THREAD: usize = 1 << 21;
const MOST_ROWS_PER_THREAD: usize = 64;

impl<'a> CpuRows<'a> {
    /// A back end for the hemicubes of one scene.
    pub fn new(hemicubes: &Arc<Hemicubes<'a>>) -> Self {
        Self {
            hemicubes: Arc::clone(hemicubes),
            drawers: ThreadLocal::new(),
        }
    }
}

impl RowSource for CpuRows<'_> {
    fn draw_rows(&mut self, receivers: Range<u32>) -> Result<RowBatch, BackendError> {
        let first = receivers.start;
        let rows = receivers
            .into_par_iter()
            .with_max_len(1)
            .map(|receiver| {
                let drawer = self
                    .drawers
                    .get_or(|| RefCell::new(RowDrawer::new(&self.hemicubes)));
                drawer.borrow_mut().row(ReceiverId(receiver))
            })
            .collect();
        Ok(RowBatch::of(first, rows))
    }

    fn preferred_batch(&self) -> u32 {
        let pixels = pixel_count(self.hemicubes.resolution());
        let rows = (PIXELS_PER_THREAD / pixels).clamp(1, MOST_ROWS_PER_THREAD);
        (rayon::current_num_threads() * rows) as u32
    }

    fn describe(&self) -> String {
        let threads = rayon::current_num_threads();
        format!(
            "cpu, {threads} thread{}",
            if threads == 1 { "" } else { "s" }
        )
    }
}

/// Draws rows one after the other, for one thread.
#[derive(Debug)]
pub struct RowDrawer<'a> {
    hemicubes: Arc<Hemicubes<'a>>,
    drawer: HemicubeDrawer<'a>,
    merger: Merger,
    /// Of the last row: the next one has about as many.
    entry_count: usize,
}

impl<'a> RowDrawer<'a> {
    /// A drawer of rows.
    pub fn new(hemicubes: &Arc<Hemicubes<'a>>) -> Self {
        let resolution = hemicubes.resolution();
        Self {
            hemicubes: Arc::clone(hemicubes),
            drawer: HemicubeDrawer::new(hemicubes.drawable(), resolution),
            merger: Merger::new(hemicubes.sources().count()),
            entry_count: 0,
        }
    }

    /// The row of one receiver.
    pub fn row(&mut self, receiver: ReceiverId) -> Row {
        let receivers = self.hemicubes.receivers();
        let frames = receivers.frames(receiver);
        let factors = self.hemicubes.delta_form_factors(frames.len() as u32);
        let own = receivers.surface(receiver);
        let (nothing, back_face) = (self.merger.nothing(), self.merger.back_face());
        for frame in frames {
            self.drawer
                .draw(own, &frame, nothing, back_face, |face, j, ids| {
                    self.merger.add(ids, factors.row_sums(face, j));
                });
        }
        let mut entries = Vec::with_capacity(self.entry_count + self.entry_count / 8);
        let unseen = self.merger.take(&mut entries);
        self.entry_count = entries.len();
        Row { entries, unseen }
    }
}

/// Sums delta form factors by patch, without hashing: a sum for each patch, and a mark for each block of patches, in
/// which those that were touched are found again in patch order.
#[derive(Debug)]
struct Merger {
    level: Level,
    patch_count: u32,
    /// One per patch, then one for nothing and one for back faces; whole blocks.
    units: Vec<u32>,
    /// One for each block of `units`.
    is_touched: Vec<bool>,
}

/// Patches in a block.
const BLOCK: usize = 64;

/// Sums that are looked at together.
const LANES: usize = 8;

impl Merger {
    fn new(patch_count: u32) -> Self {
        let blocks = (patch_count as usize + 2).div_ceil(BLOCK);
        Self {
            level: Level::new(),
            patch_count,
            units: vec![0; blocks * BLOCK],
            is_touched: vec![false; blocks],
        }
    }

    fn nothing(&self) -> u32 {
        self.patch_count
    }

    fn back_face(&self) -> u32 {
        self.patch_count + 1
    }

    /// Adds a row of pixels, whose delta form factors are given as sums.
    fn add(&mut self, ids: &[u32], sums: &[u32]) {
        let Self {
            level,
            units,
            is_touched,
            ..
        } = self;
        dispatch!(*level, simd => for_each_run(simd, ids, #[inline(always)] |patch, start, end| {
            units[patch as usize] += sums[end] - sums[start];
            is_touched[patch as usize / BLOCK] = true;
        }));
    }

    /// Hands out the non-zero sums in patch order and starts anew.
    fn take(&mut self, row: &mut Vec<Entry>) -> Unseen {
        let unseen = Unseen {
            open: std::mem::take(&mut self.units[self.patch_count as usize]),
            back_face: std::mem::take(&mut self.units[self.patch_count as usize + 1]),
        };
        dispatch!(self.level, simd => self.take_entries(simd, row));
        unseen
    }

    #[simd]
    fn take_entries<S: Simd>(&mut self, simd: S, row: &mut Vec<Entry>) {
        let blocks = self.units.chunks_exact_mut(BLOCK);
        for (k, (block, is_touched)) in blocks.zip(&mut self.is_touched).enumerate() {
            if !std::mem::take(is_touched) {
                continue;
            }
            let mut is_used = 0_u64;
            for (lanes, units) in block.chunks_exact(LANES).enumerate() {
                let units = u32x8::from_slice(simd, units);
                is_used |= (!units.simd_eq(0)).to_bitmask() << (lanes * LANES);
            }
            while is_used != 0 {
                let index = is_used.trailing_zeros();
                is_used &= is_used - 1;
                row.push(Entry {
                    source: (k * BLOCK) as u32 + index,
                    units: std::mem::take(&mut block[index as usize]) as f32,
                });
            }
        }
    }
}
