//! Times of small pieces of work: hemicubes on one core.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use compute::cpu::RowDrawer;
use compute::hemicubes::Hemicubes;
use compute::receivers::ReceiverId;
use compute::settings::{FormFactorSettings, Points};
use scene::{PatchId, Scene};
use visibility::hemicube::pixel_count;
use visibility::item_buffer::{BACK_FACE, HemicubeDrawer, NOTHING};

use crate::arguments::Plan;

/// Hemicubes a repetition, spread over the scene.
const HEMICUBES: u32 = 64;

/// Fewest repetitions of anything.
const LEAST: usize = 3;

/// What something took.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Seconds, the median.
    pub median: f64,
    /// Seconds, the fastest.
    pub fastest: f64,
}

impl Timing {
    /// The same of one part of many.
    fn per(self, parts: f64) -> Self {
        Self {
            median: self.median / parts,
            fastest: self.fastest / parts,
        }
    }
}

/// Does `work` again and again, for half a second (a twentieth in a quick document) and three times at
/// least; the first time is not counted.
pub fn repeat(plan: &Plan, mut work: impl FnMut() -> anyhow::Result<()>) -> anyhow::Result<Timing> {
    work()?;
    let start = Instant::now();
    let most_seconds = plan.choose(0.05, 0.5);
    let mut seconds = Vec::new();
    while seconds.len() < LEAST || start.elapsed().as_secs_f64() < most_seconds {
        let start = Instant::now();
        work()?;
        seconds.push(start.elapsed().as_secs_f64());
    }
    seconds.sort_by(f64::total_cmp);
    Ok(Timing {
        median: seconds[seconds.len() / 2],
        fastest: seconds[0],
    })
}

/// The one in the middle.
pub fn by_median<T>(mut values: Vec<T>, key: impl Fn(&T) -> f64) -> Option<T> {
    values.sort_by(|a, b| key(a).total_cmp(&key(b)));
    (!values.is_empty()).then(|| values.swap_remove(values.len() / 2))
}

/// A scene's hemicubes, one at each patch's centroid.
pub fn one_a_patch(scene: &Scene, resolution: u32) -> Arc<Hemicubes<'_>> {
    let settings = FormFactorSettings {
        points: Points::CENTROID,
        ..FormFactorSettings::new(resolution)
    };
    Arc::new(Hemicubes::new(scene, settings))
}

/// Pixels of one hemicube of these.
pub fn pixels(hemicubes: &Hemicubes) -> f64 {
    pixel_count(hemicubes.resolution()) as f64
}

fn patches(scene: &Scene) -> Vec<PatchId> {
    let count = u64::from(scene.patch_count());
    (0..u64::from(HEMICUBES))
        .map(|k| PatchId((count * k / u64::from(HEMICUBES)) as u32))
        .collect()
}

/// A hemicube's item buffer with the look-up of its patches.
pub fn item_buffer(plan: &Plan, hemicubes: &Arc<Hemicubes>) -> anyhow::Result<Timing> {
    let resolution = hemicubes.resolution();
    let mut drawer = HemicubeDrawer::new(hemicubes.drawable(), resolution);
    let patches = patches(hemicubes.sources().patches());
    let timing = repeat(plan, || {
        for &patch in &patches {
            let frame = hemicubes.receivers().frames(ReceiverId(patch.0))[0];
            drawer.draw(
                hemicubes.receivers().surface(ReceiverId(patch.0)),
                &frame,
                NOTHING,
                BACK_FACE,
                |_, _, ids| {
                    black_box(ids);
                },
            );
        }
        Ok(())
    })?;
    Ok(timing.per(HEMICUBES.into()))
}

/// A whole row of form factors, and what it takes.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Of a hemicube.
    pub timing: Timing,
    /// Mean number of a row's entries.
    pub entries: f64,
    /// Mean size of a row, bytes.
    pub bytes: f64,
}

/// A hemicube drawn and merged into a row.
pub fn row(plan: &Plan, hemicubes: &Arc<Hemicubes>) -> anyhow::Result<Row> {
    let mut drawer = RowDrawer::new(hemicubes);
    let patches = patches(hemicubes.sources().patches());
    let (mut entries, mut bytes) = (0, 0);
    let timing = repeat(plan, || {
        (entries, bytes) = (0, 0);
        for &patch in &patches {
            let row = black_box(drawer.row(ReceiverId(patch.0))).entries;
            entries += row.len();
            bytes += size_of_val(row.as_slice());
        }
        Ok(())
    })?;
    let hemicubes = f64::from(HEMICUBES);
    Ok(Row {
        timing: timing.per(hemicubes),
        entries: entries as f64 / hemicubes,
        bytes: bytes as f64 / hemicubes,
    })
}
