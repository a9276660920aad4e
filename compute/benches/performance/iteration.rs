//! Iterations over kept rows, and how fast memory can be read at all.

use std::hint::black_box;

use compute::cpu::CpuRows;
use compute::problem::Problem;
use compute::row_cache::RowCache;
use compute::solver::{Gather, Solver, Update};
use rayon::ThreadPoolBuilder;
use rayon::prelude::*;
use scene::{Scene, Solution};

use crate::arguments::Plan;
use crate::measure::{one_a_patch, repeat};

/// Pixels of the hemicubes that the rows are from.
pub const PIXELS: u32 = 100;

/// Iterations over the kept rows of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Iteration {
    /// Threads that gather.
    pub threads: usize,
    /// Seconds of one.
    pub seconds: f64,
    /// Entries of all rows.
    pub entries: u64,
    /// Memory of all rows, bytes.
    pub bytes: u64,
}

/// Draws a scene's rows and iterates over them, on each of these numbers of threads.
pub fn iterations(plan: &Plan, scene: &Scene, threads: &[usize]) -> anyhow::Result<Vec<Iteration>> {
    let hemicubes = one_a_patch(scene, PIXELS);
    let source = Box::new(CpuRows::new(&hemicubes));
    let mut rows = RowCache::new(&hemicubes, source, u64::MAX);
    rows.for_each_row(|_, _| Ok(()))?;
    let statistics = rows.statistics();
    let start = Solution::dark(scene);
    let mut solver = Gather::new(Problem::new(scene), Update::AfterIteration, start);
    threads
        .iter()
        .map(|&threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
            let timing = pool.install(|| {
                repeat(plan, || {
                    while !solver.step(&mut rows)?.ends_iteration {}
                    Ok(())
                })
            })?;
            Ok(Iteration {
                threads,
                seconds: timing.median,
                entries: statistics.kept_entries,
                bytes: statistics.kept_bytes,
            })
        })
        .collect()
}

/// Bytes that [`read_bandwidth`] reads: many times what caches hold.
const READ_BYTES: usize = 1 << 30;

/// Numbers that one thread sums at a time.
const CHUNK: usize = 1 << 17;

/// Bytes a second that so many threads read and sum, one after the other.
pub fn read_bandwidth(plan: &Plan, threads: usize) -> anyhow::Result<f64> {
    let count = plan.choose(READ_BYTES / 4, READ_BYTES) / size_of::<u64>();
    let numbers: Vec<u64> = (0..count as u64).collect();
    let pool = ThreadPoolBuilder::new().num_threads(threads).build()?;
    let timing = pool.install(|| {
        repeat(plan, || {
            black_box(numbers.par_chunks(CHUNK).map(sum).sum::<u64>());
            Ok(())
        })
    })?;
    Ok(size_of_val(numbers.as_slice()) as f64 / timing.median)
}

/// The sum of numbers whose sum wraps nowhere, in lanes so that additions do not wait for each other.
fn sum(numbers: &[u64]) -> u64 {
    let mut lanes = [0; 32];
    let (chunks, rest) = numbers.as_chunks();
    for chunk in chunks {
        for (lane, number) in lanes.iter_mut().zip(chunk as &[u64; 32]) {
            *lane += number;
        }
    }
    lanes.iter().chain(rest).sum()
}
