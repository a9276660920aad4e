//! Form factor rows, kept while they fit a memory budget and drawn again when they do not.

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::backend::{Choice, RowOrigin};
use crate::cancel::CancelToken;
use crate::certificate::Received;
use crate::compact_rows::{self, CompactRows, Exact};
use crate::hemicubes::Hemicubes;
use crate::receivers::ReceiverId;
use crate::rows::{BackendError, Row, RowBatch, RowSource, Unseen};
use crate::sources::Sources;

/// All rows of a scene, as far as anybody asks for them.
pub struct RowCache<'a> {
    hemicubes: Arc<Hemicubes<'a>>,
    source: Box<dyn RowSource + 'a>,
    patch_count: u32,
    budget_bytes: u64,
    /// Batches by their first patch.
    kept: BTreeMap<u32, CompactRows>,
    /// The last batch that did not fit.
    passing: CompactRows,
    exact: Exact,
    /// One per patch; `None`: not drawn in this run.
    unseen: Vec<Option<Unseen>>,
    /// What the rows that were drawn in this run send to each patch.
    received: Received,
    statistics: RowStatistics,
    /// Patches whose rows are taken to be empty and are not drawn; one per patch.
    unlit: Vec<bool>,
    cancel: CancelToken,
    choice: Choice,
}

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
    /// Rows that did not fit, each counted as often as it was drawn.
    pub left_out_rows: u64,
    /// Their memory, bytes.
    pub left_out_bytes: u64,
}

impl RowStatistics {
    /// Memory an entry of the kept rows takes, bytes; `None` where none is kept.
    pub fn bytes_per_entry(&self) -> Option<f64> {
        (self.kept_entries > 0).then(|| self.kept_bytes as f64 / self.kept_entries as f64)
    }

    /// The same rows, with what drawing others has cost counted too.
    #[must_use]
    pub fn with_drawing_of(&self, others: &Self) -> Self {
        Self {
            hemicubes: self.hemicubes + others.hemicubes,
            duration: self.duration + others.duration,
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

impl<'a> RowCache<'a> {
    /// No rows yet.
    pub fn new(
        hemicubes: &Arc<Hemicubes<'a>>,
        source: Box<dyn RowSource + 'a>,
        budget_bytes: u64,
    ) -> Self {
        let sources = hemicubes.sources();
        let patches = sources.patches();
        let patch_count = patches.patch_count();
        Self {
            hemicubes: Arc::clone(hemicubes),
            source,
            patch_count,
            budget_bytes,
            kept: BTreeMap::new(),
            passing: CompactRows::new(),
            exact: Exact::new(&sources.scene().patch_emissions()),
            unseen: vec![None; patch_count as usize],
            received: Received::new(&patches.patch_areas(), sources.count()),
            statistics: RowStatistics::default(),
            unlit: vec![false; patch_count as usize],
            cancel: CancelToken::new(),
            choice: Choice::default(),
        }
    }

    /// The same, whose drawing of many rows ends early where the token says so.
    #[must_use]
    pub fn with_cancel(self, cancel: &CancelToken) -> Self {
        Self {
            cancel: cancel.clone(),
            ..self
        }
    }

    /// The same, with how its back end was chosen.
    #[must_use]
    pub fn with_choice(self, choice: Choice) -> Self {
        Self { choice, ..self }
    }

    /// How the back end was chosen.
    pub fn choice(&self) -> &Choice {
        &self.choice
    }

    /// Where the rows come from.
    pub fn origin(&self) -> RowOrigin {
        RowOrigin::of(&*self.source)
    }

    /// Tells work on many rows to end early.
    pub fn cancel(&self) -> &CancelToken {
        &self.cancel
    }

    /// Takes the rows of some patches to be empty, whose irradiance is known to be 0, see [`crate::unlit`]; `unlit`
    /// has one element per patch.
    pub fn leave_out(&mut self, unlit: Vec<bool>) {
        self.unlit = unlit;
    }

    /// True for each patch whose row nobody needs, one per patch.
    pub fn unlit(&self) -> &[bool] {
        &self.unlit
    }

    /// How many rows somebody may need.
    pub fn lit_count(&self) -> u32 {
        self.unlit.iter().filter(|&&unlit| !unlit).count() as u32
    }

    /// The hemicubes that the rows come from.
    pub fn hemicubes(&self) -> &Hemicubes<'a> {
        &self.hemicubes
    }

    /// What the patches see.
    pub fn sources(&self) -> &Sources<'a> {
        self.hemicubes.sources()
    }

    /// False where the rows are formulas.
    pub fn has_hemicubes(&self) -> bool {
        self.source.draws_hemicubes()
    }

    /// The back end's name, `cpu` or `gpu`.
    pub fn backend(&self) -> &'static str {
        self.source.backend()
    }

    /// What the back end calls itself.
    pub fn describe_source(&self) -> String {
        self.source.describe()
    }

    /// What drawing has cost so far.
    pub fn statistics(&self) -> RowStatistics {
        self.statistics
    }

    /// What each patch does not see as patches, where its row was drawn in this run.
    pub fn unseen(&self) -> &[Option<Unseen>] {
        &self.unseen
    }

    /// What the rows that were drawn in this run send to each patch, each row once.
    pub fn received(&self) -> &Received {
        &self.received
    }

    /// Hands out the rows of all patches in patch order, drawing those that are not kept.
    ///
    /// # Errors
    /// What `take` and the back end say; [`io::ErrorKind::Interrupted`] where the token says so.
    pub fn for_each_row(
        &mut self,
        mut take: impl FnMut(u32, compact_rows::Row) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut patch = 0;
        while patch < self.patch_count {
            if self.cancel.is_cancelled() {
                return Err(io::ErrorKind::Interrupted.into());
            }
            let batch = self.batch_with(patch).map_err(io::Error::other)?;
            let range = batch.receivers();
            for from in patch..range.end {
                take(from, batch.row((from - range.start) as usize))?;
            }
            patch = range.end;
        }
        Ok(())
    }

    /// Draws the rows that were not drawn in this run, but for those that nobody needs.
    pub fn draw_missing(&mut self) -> Result<(), BackendError> {
        while let Some(patch) = self.first_missing() {
            if self.cancel.is_cancelled() {
                break;
            }
            self.batch_with(patch as u32)?;
        }
        Ok(())
    }

    fn first_missing(&self) -> Option<usize> {
        let mut rows = self.unseen.iter().zip(&self.unlit);
        rows.position(|(unseen, &unlit)| unseen.is_none() && !unlit)
    }

    /// A batch that holds the row of `patch`, which exists; where the row must be drawn, the batch
    /// starts with it, and those that follow are drawn along.
    pub fn batch_with(&mut self, patch: u32) -> Result<&CompactRows, BackendError> {
        let most = self.source.preferred_batch().max(1);
        self.batch_of(patch, most)
    }

    /// The same for one who does not go on with the rows that follow: once rows do not fit any more, none are
    /// drawn along, since they would not be kept.
    pub fn batch_for_one(&mut self, patch: u32) -> Result<&CompactRows, BackendError> {
        if self.statistics.left_out_rows > 0 {
            self.batch_of(patch, 1)
        } else {
            self.batch_with(patch)
        }
    }

    fn batch_of(&mut self, patch: u32, most: u32) -> Result<&CompactRows, BackendError> {
        let before = self.kept.range(..=patch).next_back();
        if let Some((&first, batch)) = before
            && batch.receivers().contains(&patch)
        {
            return Ok(&self.kept[&first]);
        }
        if self.passing.receivers().contains(&patch) {
            return Ok(&self.passing);
        }
        let next_kept = self
            .kept
            .range(patch..)
            .next()
            .map_or(self.patch_count, |(&first, _)| first);
        let mut end = patch;
        let mut rows = 0;
        while end < next_kept && rows < u64::from(most) {
            rows += u64::from(!self.unlit[end as usize]);
            end += 1;
        }
        let start = Instant::now();
        let drawn = self.draw(patch..end)?;
        let batch = CompactRows::encode(&drawn, &self.exact);
        self.statistics.duration += start.elapsed();
        let unseen = &mut self.unseen[patch as usize..end as usize];
        let unlit = &self.unlit[patch as usize..end as usize];
        self.received
            .add(&drawn, |k: usize| unseen[k].is_none() && !unlit[k]);
        for (k, unseen) in unseen.iter_mut().enumerate().filter(|(k, _)| !unlit[*k]) {
            *unseen = Some(drawn.unseen(k));
        }
        if self.statistics.kept_bytes + batch.bytes() <= self.budget_bytes {
            self.statistics.kept_bytes += batch.bytes();
            self.statistics.kept_rows += rows;
            self.statistics.kept_entries += batch.entries();
            Ok(self.kept.entry(patch).or_insert(batch))
        } else {
            self.statistics.left_out_rows += rows;
            self.statistics.left_out_bytes += batch.bytes();
            self.passing = batch;
            Ok(&self.passing)
        }
    }

    /// Draws the rows of consecutive patches that somebody needs; the others are empty.
    fn draw(&mut self, patches: Range<u32>) -> Result<RowBatch, BackendError> {
        let unlit = &self.unlit[patches.start as usize..patches.end as usize];
        let has_hemicubes = self.source.draws_hemicubes();
        let number = |patch| {
            if has_hemicubes {
                self.hemicubes.receivers().first_point(ReceiverId(patch))
            } else {
                0
            }
        };
        if !unlit.contains(&true) {
            self.statistics.hemicubes += number(patches.end) - number(patches.start);
            return self.source.draw_rows(patches);
        }
        let mut batch = RowBatch::new(patches.start);
        let mut first = patches.start;
        for run in unlit.chunk_by(|a, b| a == b) {
            let end = first + run.len() as u32;
            if run[0] {
                for _ in run {
                    batch.push(Row::default());
                }
            } else {
                batch.append(self.source.draw_rows(first..end)?);
                self.statistics.hemicubes += number(end) - number(first);
            }
            first = end;
        }
        Ok(batch)
    }

    /// The rows of consecutive patches, beginning with a batch that holds the row of `patch`, which exists:
    /// kept ones of about so many bytes, or one batch that must be drawn.
    pub fn batches_with(
        &mut self,
        patch: u32,
        bytes: u64,
    ) -> Result<Vec<&CompactRows>, BackendError> {
        let first = self.batch_with(patch)?;
        let mut end = first.receivers().end;
        let start = first.receivers().start;
        if !self.kept.contains_key(&start) {
            return Ok(vec![&self.passing]);
        }
        let mut left = bytes;
        let run = self.kept.range(start..).take_while(|&(&first, batch)| {
            let goes_on = first == start || (first == end && left > 0);
            end = batch.receivers().end;
            left = left.saturating_sub(batch.bytes());
            goes_on
        });
        Ok(run.map(|(_, batch)| batch).collect())
    }
}
