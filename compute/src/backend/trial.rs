//! The same hemicubes on both back ends, before one of them draws all.

use std::ops::Range;
use std::time::{Duration, Instant};

use serde::Serialize;

use super::agreement;
use crate::hemicubes::Hemicubes;
use crate::receivers::ReceiverId;
use crate::rows::{BackendError, RowSource};

/// Places in the scene at which rows are compared.
const PLACES: u32 = 12;
/// Hemicubes at a place, about: rows of consecutive receivers.
const HEMICUBES_AT_A_PLACE: u64 = 4;
/// No more rows are compared once those of one back end have taken so long: scenes may have millions of surfaces.
const LONG_ENOUGH: Duration = Duration::from_millis(250);
/// How long each back end's speed is measured, at least.
const TIMED: Duration = Duration::from_millis(100);

/// What the same hemicubes have come to on the CPU and on a GPU.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Trial {
    /// Hemicubes whose rows were compared.
    pub hemicubes: u64,
    /// How fast the CPU draws and merges.
    pub cpu_hemicubes_per_second: f64,
    /// How fast the GPU does.
    pub gpu_hemicubes_per_second: f64,
    /// Share of a row that the GPU sees elsewhere than the CPU, in the mean, 0 to 1, see [`agreement`].
    pub difference: f64,
    /// What it may be.
    pub bound: f64,
}

impl Trial {
    /// Compares both, with rows from all over the scene; `None` where there are no receivers.
    ///
    /// # Errors
    /// A back end that does not draw.
    pub fn of(
        hemicubes: &Hemicubes,
        cpu: &mut dyn RowSource,
        gpu: &mut dyn RowSource,
    ) -> Result<Option<Self>, BackendError> {
        if hemicubes.receivers().count() == 0 {
            return Ok(None);
        }
        let (mut moved, mut rows, mut drawn) = (0.0, 0, 0);
        let (mut cpu_time, mut gpu_time) = (Duration::ZERO, Duration::ZERO);
        for receivers in sample(hemicubes) {
            let start = Instant::now();
            let on_cpu = cpu.draw_rows(receivers.clone())?;
            cpu_time += start.elapsed();
            let start = Instant::now();
            let on_gpu = gpu.draw_rows(receivers.clone())?;
            // Drivers put some things off until the first drawing.
            if drawn > 0 {
                gpu_time += start.elapsed();
            }
            moved += agreement::moved(&on_cpu, &on_gpu).iter().sum::<f64>();
            rows += receivers.len();
            drawn += count(hemicubes, &receivers);
            if cpu_time.max(gpu_time) >= LONG_ENOUGH {
                break;
            }
        }
        Ok(Some(Self {
            hemicubes: drawn,
            cpu_hemicubes_per_second: speed(hemicubes, cpu, TIMED)?,
            gpu_hemicubes_per_second: speed(hemicubes, gpu, TIMED)?,
            difference: moved / rows as f64,
            bound: agreement::bound(hemicubes.resolution()),
        }))
    }

    /// What the GPU does, as a sentence goes on after its name, if its rows are not the CPU's.
    pub fn disagreement(&self) -> Option<String> {
        // What is no number is no agreement.
        let agree = self.difference <= self.bound;
        (!agree).then(|| {
            let [percent, most] = [self.difference, self.bound].map(|share| 100.0 * share);
            format!(
                "draws other rows than the CPU: {percent:.2} % of what a patch sees is elsewhere, more than {most:.2} %"
            )
        })
    }

    /// The same, if it is not faster than the CPU.
    pub fn slowness(&self) -> Option<String> {
        let [gpu, cpu] = [self.gpu_hemicubes_per_second, self.cpu_hemicubes_per_second];
        let is_faster = gpu > cpu;
        (!is_faster)
            .then(|| format!("is slower here, {gpu:.0} against {cpu:.0} hemicubes a second"))
    }
}

/// Runs of receivers from all over the scene, such that the first few of them are so too; all receivers, where they are
/// few.
fn sample(hemicubes: &Hemicubes) -> Vec<Range<u32>> {
    let receivers = hemicubes.receivers().count();
    let hemicubes_a_row = (hemicubes.total() / u64::from(receivers)).max(1);
    let rows = (HEMICUBES_AT_A_PLACE / hemicubes_a_row).max(1) as u32;
    if receivers <= PLACES * rows {
        let starts = (0..receivers).step_by(rows as usize);
        return starts
            .map(|start| start..(start + rows).min(receivers))
            .collect();
    }
    (0..PLACES).map(|k| place(k, rows, receivers)).collect()
}

/// The k-th of some places for so many of all receivers. Multiples of the golden ratio, modulo 1, fall into the largest
/// gaps that those before them have left.
fn place(k: u32, rows: u32, receivers: u32) -> Range<u32> {
    /// The golden ratio less 1, times 2^32.
    const GOLDEN: u32 = 0x9E37_79B9;
    let room = u64::from(receivers - rows) + 1;
    let start = ((u64::from(k.wrapping_mul(GOLDEN)) * room) >> 32) as u32;
    start..start + rows
}

/// How many hemicubes receivers have.
fn count(hemicubes: &Hemicubes, receivers: &Range<u32>) -> u64 {
    let first = |receiver| hemicubes.receivers().first_point(ReceiverId(receiver));
    first(receivers.end) - first(receivers.start)
}

/// How many hemicubes a back end draws and merges in a second, measured for that long at least. Batches begin with one
/// row, and grow to what it likes to be asked for; so none takes much longer than all before it.
///
/// # Errors
/// A back end that does not draw.
///
/// # Panics
/// Where there are no receivers.
pub fn speed(
    hemicubes: &Hemicubes,
    source: &mut dyn RowSource,
    least: Duration,
) -> Result<f64, BackendError> {
    let receivers = hemicubes.receivers().count();
    let (mut drawn, mut rows) = (0, 1);
    let start = Instant::now();
    for k in 0.. {
        let batch = place(k, rows, receivers);
        drawn += count(hemicubes, &batch);
        source.draw_rows(batch)?;
        if start.elapsed() >= least {
            break;
        }
        rows = (2 * rows)
            .min(source.preferred_batch().max(1))
            .min(receivers);
    }
    Ok(drawn as f64 / start.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::{FormFactorSettings, Points};

    fn sample_of(area: f64, points: Points) -> (u32, Vec<Range<u32>>) {
        let scene = test_scenes::colourful_room(area);
        let settings = FormFactorSettings {
            points,
            ..FormFactorSettings::new(16)
        };
        let hemicubes = Hemicubes::new(&scene, settings);
        (scene.patch_count(), sample(&hemicubes))
    }

    #[test]
    fn rows_are_from_all_over_the_scene_however_few_of_them_are_drawn() {
        let (patches, runs) = sample_of(0.01, Points::CENTROID);
        assert_eq!(runs.len(), PLACES as usize);
        for seen in [3, 6, 12] {
            let mut starts: Vec<u32> = runs[..seen].iter().map(|run| run.start).collect();
            starts.extend([0, patches]);
            starts.sort_unstable();
            let gap = starts.windows(2).map(|pair| pair[1] - pair[0]).max();
            // Golden gaps are at most some 1.4 of even ones; those at the ends at most as wide.
            let even = f64::from(patches) / seen as f64;
            assert!(f64::from(gap.unwrap()) < 2.0 * even, "{seen}: {runs:?}");
        }
        assert!(runs.iter().all(|run| run.len() == 4 && run.end <= patches));
    }

    #[test]
    fn a_few_dozen_hemicubes_are_drawn_whatever_a_patch_has() {
        for (points, rows) in [
            (Points::CENTROID, 4),
            (Points::Bisected { bisections: 1 }, 2),
            (Points::ThreePoint { bisections: 0 }, 1),
            (Points::Bisected { bisections: 4 }, 1),
        ] {
            let (_, runs) = sample_of(0.1, points);
            let count: usize = runs.iter().map(Range::len).sum();
            assert_eq!(count, 12 * rows, "{points}");
        }
    }

    #[test]
    fn all_of_few_rows_are_drawn() {
        let (patches, runs) = sample_of(f64::INFINITY, Points::CENTROID);
        assert!(patches < 48, "{patches}");
        let drawn: Vec<u32> = runs.into_iter().flatten().collect();
        assert_eq!(drawn, (0..patches).collect::<Vec<_>>());
    }
}
