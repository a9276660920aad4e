//! Form factor rows, kept while they fit a memory budget and drawn again when they do not.
//!
//! Where there are files of rows ([`crate::row_file`]), those that they have are read instead of drawn. All rows count in
//! the form in which they are kept, so that it makes no difference for any bit, nor for what rows certify, who drew them.

mod statistics;

use std::collections::BTreeMap;
use std::io;
use std::ops::Range;
use std::sync::Arc;
use std::time::{Duration, Instant};

use crate::backend::{Choice, RowOrigin};
use crate::cancel::CancelToken;
use crate::compact_rows::{self, CompactRows, Exact, Stored};
use crate::hemicubes::Hemicubes;
use crate::received::Received;
use crate::receivers::ReceiverId;
use crate::row_file::{RowFileRemark, RowState, StoredRows};
use crate::rows::{BackendError, Row, RowBatch, RowSource, Unseen};
use crate::sources::Sources;

pub use statistics::RowStatistics;

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
    /// One per patch; `None`: neither drawn nor read in this run.
    unseen: Vec<Option<Unseen>>,
    /// What the rows that were drawn or read in this run send to each patch.
    received: Received,
    statistics: RowStatistics,
    /// Patches whose rows are taken to be empty and are not drawn; one per patch.
    unlit: Vec<bool>,
    /// Rows in files.
    stored: Option<StoredRows>,
    cancel: CancelToken,
    choice: Choice,
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
            stored: None,
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

    /// The same, with rows in files.
    #[must_use]
    pub fn with_stored(self, stored: Option<StoredRows>) -> Self {
        Self { stored, ..self }
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
        let stored = self.stored.as_ref();
        RowStatistics {
            files: stored.map_or(Duration::ZERO, StoredRows::duration),
            ..self.statistics
        }
    }

    /// What each patch does not see as patches, where its row was drawn or read in this run.
    pub fn unseen(&self) -> &[Option<Unseen>] {
        &self.unseen
    }

    /// What the rows that were drawn or read in this run send to each patch, each row once.
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

    /// Draws or reads the rows that were not in this run, but for those that nobody needs.
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

    /// A batch that holds the row of `patch`, which exists; where the row must be drawn or read, the batch
    /// starts with it, and those that follow are drawn or read along.
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
        if let Some((batch, states)) = self.read(patch..next_kept) {
            self.statistics.read_rows += self.lit_in(&batch.receivers());
            return Ok(self.take_up(batch, &states));
        }
        let mut end = patch;
        let mut rows = 0;
        while end < next_kept && rows < u64::from(most) && (end == patch || !self.is_stored(end)) {
            rows += u64::from(!self.unlit[end as usize]);
            end += 1;
        }
        let start = Instant::now();
        let drawn = self.draw(patch..end)?;
        let batch = CompactRows::encode(&drawn, &self.exact);
        self.statistics.duration += start.elapsed();
        let states = (patch..end).enumerate().map(|(k, patch)| {
            if self.unlit[patch as usize] {
                RowState::Unlit
            } else {
                RowState::Drawn(drawn.unseen(k))
            }
        });
        let states: Vec<RowState> = states.collect();
        self.statistics.drawn_rows += self.lit_in(&(patch..end));
        Ok(self.take_up(batch, &states))
    }

    /// How many of these rows somebody may need.
    fn lit_in(&self, patches: &Range<u32>) -> u64 {
        let unlit = &self.unlit[patches.start as usize..patches.end as usize];
        unlit.iter().filter(|&&unlit| !unlit).count() as u64
    }

    /// True where the row of a patch is needed and need not be drawn.
    fn is_stored(&self, patch: u32) -> bool {
        let stored = self.stored.as_ref();
        !self.unlit[patch as usize] && stored.is_some_and(|stored| stored.contains(patch))
    }

    /// The first of these rows and those that follow it in a file, and what there is of each; `None` where the first is in
    /// none. Rows that nobody needs are empty, whatever a file says of them.
    fn read(&mut self, patches: Range<u32>) -> Option<(CompactRows, Vec<RowState>)> {
        if !self.is_stored(patches.start) {
            return None;
        }
        let block = self.stored.as_mut()?.read(patches.start)?;
        let range = block.rows.receivers();
        let (mut rows, mut states) = (Vec::new(), Vec::new());
        for patch in patches.start..patches.end.min(range.end) {
            let k = (patch - range.start) as usize;
            let (row, state) = match block.states[k] {
                _ if self.unlit[patch as usize] => (Stored::default(), RowState::Unlit),
                state @ RowState::Drawn(_) => (block.rows.stored(k), state),
                RowState::Missing | RowState::Unlit => break,
            };
            rows.push(row);
            states.push(state);
        }
        Some((CompactRows::of_stored(patches.start, &rows), states))
    }

    /// Counts a batch that has been drawn or read, and keeps it where it fits; `states` has one element per row, none of
    /// them missing.
    fn take_up(&mut self, batch: CompactRows, states: &[RowState]) -> &CompactRows {
        let range = batch.receivers();
        let unseen = &mut self.unseen[range.start as usize..range.end as usize];
        self.received.add(&batch, |k| {
            unseen[k].is_none() && matches!(states[k], RowState::Drawn(_))
        });
        for (unseen, state) in unseen.iter_mut().zip(states) {
            if let RowState::Drawn(drawn) = state {
                *unseen = Some(*drawn);
            }
        }
        self.begin_file();
        if let Some(stored) = &mut self.stored {
            stored.add(&batch, states);
        }
        let rows = self.lit_in(&range);
        if self.statistics.kept_bytes + batch.bytes() <= self.budget_bytes {
            self.statistics.kept_bytes += batch.bytes();
            self.statistics.kept_rows += rows;
            self.statistics.kept_entries += batch.entries();
            self.kept.entry(range.start).or_insert(batch)
        } else {
            self.statistics.left_out_rows += rows;
            self.statistics.left_out_bytes += batch.bytes();
            self.passing = batch;
            &self.passing
        }
    }

    /// Once the run has lasted long enough, begins to keep rows in a file: those that are in memory first.
    fn begin_file(&mut self) {
        let Some(stored) = self.stored.as_mut().filter(|stored| stored.is_due()) else {
            return;
        };
        stored.begin();
        for batch in self.kept.values() {
            let range = batch.receivers();
            let range = range.start as usize..range.end as usize;
            let unseen = self.unseen[range.clone()].iter();
            let states = unseen
                .zip(&self.unlit[range])
                .map(|(unseen, &unlit)| match *unseen {
                    _ if unlit => RowState::Unlit,
                    Some(unseen) => RowState::Drawn(unseen),
                    None => RowState::Missing,
                });
            stored.add(batch, &states.collect::<Vec<_>>());
        }
    }

    /// Has all rows in their file, if the run has lasted long enough: at a checkpoint, and where the run ends before it is
    /// done.
    pub fn save(&mut self) {
        self.begin_file();
        self.flush();
    }

    /// The same where the run is done, and a file that has not been begun is not worth it any more.
    pub fn flush(&mut self) {
        if let Some(stored) = &mut self.stored {
            stored.flush();
        }
    }

    /// Removes the file that rows are kept in, so that its disk has room for something else; false where there is none.
    pub fn remove_file(&mut self) -> bool {
        self.stored.as_mut().is_some_and(StoredRows::remove)
    }

    /// What a user should know of files of rows and has not been told.
    pub fn take_remarks(&mut self) -> Vec<RowFileRemark> {
        let stored = self.stored.as_mut();
        stored.map_or_else(Vec::new, StoredRows::take_remarks)
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
