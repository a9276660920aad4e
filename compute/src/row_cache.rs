//! Form factor rows, kept while they fit a memory budget and drawn again when they do not.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use scene::Scene;

use crate::rows::{BackendError, RowBatch, RowSource, Unseen};
use crate::settings::FormFactorSettings;

/// All rows of a scene, as far as anybody asks for them.
pub struct RowCache<'a> {
    source: Box<dyn RowSource + 'a>,
    patch_count: u32,
    settings: FormFactorSettings,
    budget_bytes: u64,
    /// Batches by their first patch.
    kept: BTreeMap<u32, RowBatch>,
    /// The last batch that did not fit.
    passing: RowBatch,
    /// One per patch; `None`: not drawn in this run.
    unseen: Vec<Option<Unseen>>,
    statistics: RowStatistics,
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
}

impl<'a> RowCache<'a> {
    /// No rows yet.
    pub fn new(
        scene: &Scene,
        source: Box<dyn RowSource + 'a>,
        settings: FormFactorSettings,
        budget_bytes: u64,
    ) -> Self {
        Self {
            source,
            patch_count: scene.patch_count(),
            settings,
            budget_bytes,
            kept: BTreeMap::new(),
            passing: RowBatch::new(0),
            unseen: vec![None; scene.patch_count() as usize],
            statistics: RowStatistics::default(),
        }
    }

    /// Units of a form factor of 1.
    pub fn units_per_one(&self) -> u32 {
        self.settings.units_per_one()
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

    /// A batch that holds the row of `patch`, which exists; where the row must be drawn, the batch
    /// starts with it.
    pub fn batch_with(&mut self, patch: u32) -> Result<&RowBatch, BackendError> {
        let before = self.kept.range(..=patch).next_back();
        if let Some((&first, batch)) = before
            && batch.patches().contains(&patch)
        {
            return Ok(&self.kept[&first]);
        }
        if self.passing.patches().contains(&patch) {
            return Ok(&self.passing);
        }
        let next_kept = self
            .kept
            .range(patch..)
            .next()
            .map_or(self.patch_count, |(&first, _)| first);
        let end = next_kept.min(patch + self.source.preferred_batch().max(1));
        let start = Instant::now();
        let mut batch = self.source.draw_rows(patch..end)?;
        self.statistics.duration += start.elapsed();
        self.statistics.hemicubes +=
            u64::from(end - patch) * u64::from(self.settings.points.count());
        for k in 0..(end - patch) as usize {
            self.unseen[patch as usize + k] = Some(batch.unseen(k));
        }
        // Shrunk before it is weighed: growing by doubling may have taken twice what it holds.
        batch.shrink();
        if self.statistics.kept_bytes + batch.bytes() <= self.budget_bytes {
            self.statistics.kept_bytes += batch.bytes();
            self.statistics.kept_rows += u64::from(end - patch);
            Ok(self.kept.entry(patch).or_insert(batch))
        } else {
            self.passing = batch;
            Ok(&self.passing)
        }
    }
}
