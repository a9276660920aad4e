//! Form factor rows from hemicubes drawn on the CPU.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use scene::PatchId;

use super::item_buffer::HemicubeDrawer;
use crate::hemicubes::Hemicubes;
use crate::rows::{BackendError, Entry, RowBatch, RowSource, Unseen};

/// The cpu back end. It draws on the threads of the rayon pool it is called in.
#[derive(Debug)]
pub struct CpuRows<'a> {
    hemicubes: Arc<Hemicubes<'a>>,
}

/// Rows that one thread draws at a time: the fewer, the more even the threads' work.
const ROWS_PER_TASK: usize = 16;

/// Tasks in a batch for each thread: enough to be even, few enough that an interrupt is answered soon.
const TASKS_PER_THREAD: usize = 4;

impl<'a> CpuRows<'a> {
    /// A back end for the hemicubes of one scene.
    pub fn new(hemicubes: &Arc<Hemicubes<'a>>) -> Self {
        Self {
            hemicubes: Arc::clone(hemicubes),
        }
    }
}

impl RowSource for CpuRows<'_> {
    fn draw_rows(&mut self, patches: Range<u32>) -> Result<RowBatch, BackendError> {
        let mut batch = RowBatch::new(patches.start);
        let pieces: Vec<RowBatch> = patches
            .collect::<Vec<_>>()
            .par_chunks(ROWS_PER_TASK)
            .map_init(|| RowDrawer::new(&self.hemicubes), RowDrawer::rows)
            .collect();
        for piece in pieces {
            batch.append(&piece);
        }
        Ok(batch)
    }

    fn preferred_batch(&self) -> u32 {
        (rayon::current_num_threads() * TASKS_PER_THREAD * ROWS_PER_TASK) as u32
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
    hemicubes: &'a Hemicubes<'a>,
    drawer: HemicubeDrawer<'a>,
    merger: Merger,
    row: Vec<Entry>,
}

impl<'a> RowDrawer<'a> {
    /// A drawer of rows.
    pub fn new(hemicubes: &'a Hemicubes<'a>) -> Self {
        let scene = hemicubes.scene();
        Self {
            hemicubes,
            drawer: HemicubeDrawer::new(scene, hemicubes.settings().resolution),
            merger: Merger::new(scene.patch_count()),
            row: Vec::new(),
        }
    }

    /// The row of one patch.
    pub fn row(&mut self, patch: PatchId) -> (&[Entry], Unseen) {
        let size = self.hemicubes.settings().resolution as usize;
        let factors = self
            .hemicubes
            .delta_form_factors(self.hemicubes.count(patch));
        let (nothing, back_face) = (self.merger.nothing(), self.merger.back_face());
        for frame in self.hemicubes.frames(patch) {
            self.drawer
                .draw(patch, &frame, nothing, back_face, |face, j, ids| {
                    self.merger
                        .add(ids, &factors.face(face)[j * size..][..size]);
                });
        }
        self.row.clear();
        let unseen = self.merger.take(&mut self.row);
        (&self.row, unseen)
    }

    fn rows(&mut self, patches: &[u32]) -> RowBatch {
        let mut batch = RowBatch::new(patches[0]);
        for &patch in patches {
            let (row, unseen) = self.row(PatchId(patch));
            batch.push(row, unseen);
        }
        batch
    }
}

/// Sums delta form factors by patch, without hashing: a sum for each patch, and a bit for each that
/// was touched, by which the sums are found again in patch order.
#[derive(Debug)]
struct Merger {
    /// One per patch, then one for nothing and one for back faces.
    units: Vec<u32>,
    /// A bit for each of `units`.
    touched: Vec<u64>,
}

impl Merger {
    fn new(patch_count: u32) -> Self {
        let slots = patch_count as usize + 2;
        Self {
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

    #[inline]
    fn add(&mut self, ids: &[u32], delta_form_factors: &[u32]) {
        let Some(&first) = ids.first() else { return };
        let (mut patch, mut sum) = (first, 0);
        for (&id, &units) in ids.iter().zip(delta_form_factors) {
            if id != patch {
                self.add_run(patch, sum);
                (patch, sum) = (id, 0);
            }
            sum += units;
        }
        self.add_run(patch, sum);
    }

    #[inline]
    fn add_run(&mut self, patch: u32, units: u32) {
        self.units[patch as usize] += units;
        self.touched[patch as usize / 64] |= 1 << (patch % 64);
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
