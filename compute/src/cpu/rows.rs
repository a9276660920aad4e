//! Form factor rows from hemicubes drawn on the CPU.

use std::cell::RefCell;
use std::ops::Range;
use std::sync::Arc;

use fearless_simd::{Level, dispatch};
use rayon::prelude::*;
use scene::PatchId;
use thread_local::ThreadLocal;

use super::item_buffer::HemicubeDrawer;
use super::runs::for_each_run;
use crate::hemicube::pixel_count;
use crate::hemicubes::Hemicubes;
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
    fn draw_rows(&mut self, patches: Range<u32>) -> Result<RowBatch, BackendError> {
        let first = patches.start;
        let rows = patches
            .into_par_iter()
            .with_max_len(1)
            .map(|patch| {
                let drawer = self
                    .drawers
                    .get_or(|| RefCell::new(RowDrawer::new(&self.hemicubes)));
                let mut drawer = drawer.borrow_mut();
                let (entries, unseen) = drawer.row(PatchId(patch));
                Row {
                    entries: entries.to_vec(),
                    unseen,
                }
            })
            .collect();
        Ok(RowBatch::of(first, rows))
    }

    fn preferred_batch(&self) -> u32 {
        let pixels = pixel_count(self.hemicubes.settings().resolution);
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
    row: Vec<Entry>,
}

impl<'a> RowDrawer<'a> {
    /// A drawer of rows.
    pub fn new(hemicubes: &Arc<Hemicubes<'a>>) -> Self {
        let resolution = hemicubes.settings().resolution;
        Self {
            hemicubes: Arc::clone(hemicubes),
            drawer: HemicubeDrawer::new(hemicubes.drawable(), resolution),
            merger: Merger::new(hemicubes.sources().patch_count()),
            row: Vec::new(),
        }
    }

    /// The row of one patch.
    pub fn row(&mut self, patch: PatchId) -> (&[Entry], Unseen) {
        let factors = self
            .hemicubes
            .delta_form_factors(self.hemicubes.count(patch));
        let own = self.hemicubes.surface_of(patch);
        let (nothing, back_face) = (self.merger.nothing(), self.merger.back_face());
        for frame in self.hemicubes.frames(patch) {
            self.drawer
                .draw(own, &frame, nothing, back_face, |face, j, ids| {
                    self.merger.add(ids, factors.row_sums(face, j));
                });
        }
        self.row.clear();
        let unseen = self.merger.take(&mut self.row);
        (&self.row, unseen)
    }
}

/// Sums delta form factors by patch, without hashing: a sum for each patch, and a bit for each that
/// was touched, by which the sums are found again in patch order.
#[derive(Debug)]
struct Merger {
    level: Level,
    /// One per patch, then one for nothing and one for back faces.
    units: Vec<u32>,
    /// A bit for each of `units`.
    touched: Vec<u64>,
}

impl Merger {
    fn new(patch_count: u32) -> Self {
        let slots = patch_count as usize + 2;
        Self {
            level: Level::new(),
            units: vec![0; slots],
            touched: vec![0; slots.div_ceil(64)],
        }
    }

    fn nothing(&self) -> u32 {
        self.units.len() as u32 - 2
    }

    fn back_face(&self) -> u32 {
        self.units.len() as u32 - 1
    }

    /// Adds a row of pixels, whose delta form factors are given as sums.
    fn add(&mut self, ids: &[u32], sums: &[u32]) {
        let Self {
            level,
            units,
            touched,
        } = self;
        dispatch!(*level, simd => for_each_run(simd, ids, #[inline(always)] |patch, start, end| {
            units[patch as usize] += sums[end] - sums[start];
            touched[patch as usize / 64] |= 1 << (patch % 64);
        }));
    }

    /// Hands out the non-zero sums in patch order and starts anew.
    fn take(&mut self, row: &mut Vec<Entry>) -> Unseen {
        let (nothing, back_face) = (self.nothing(), self.back_face());
        let mut unseen = Unseen::default();
        for (k, word) in self.touched.iter_mut().enumerate() {
            while *word != 0 {
                let patch = k as u32 * 64 + word.trailing_zeros();
                *word &= *word - 1;
                let units = std::mem::take(&mut self.units[patch as usize]);
                if patch == nothing {
                    unseen.open = units;
                } else if patch == back_face {
                    unseen.back_face = units;
                } else if units != 0 {
                    row.push(Entry {
                        patch,
                        units: units as f32,
                    });
                }
            }
        }
        unseen
    }
}
