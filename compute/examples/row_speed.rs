//! What kept rows take and how fast they are gathered, beside plain entries and the memory's own speed.
//!
//! `cargo run --release -p compute --example row_speed` prints a line for each scene, resolution and number of
//! threads: bytes an entry, all memory counted; billions of entries and of bytes a second, for
//! gathering compact rows and plain entries of 8 bytes, and for reading the compact rows' memory and doing
//! nothing but adding it up. Each is the best of several passes, rows of up to [`ROWS`] patches, spread over
//! the scene.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use compute::compact_rows::{Channels, CompactRows, Exact, Gatherer};
use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::lamps::with_lamps;
use compute::rows::{Entry, RowBatch};
use compute::settings::{FormFactorSettings, LampViews};
use genx::{Model, Settings};
use glam::DVec3;
use rayon::prelude::*;
use scene::{Rgb, Scene};

/// Rows measured.
const ROWS: u32 = 6000;

/// Rows drawn together.
const BATCH: u32 = 100;

const PASSES: usize = 7;

fn main() -> anyhow::Result<()> {
    println!(
        "| scene | pixels | patches | entries a row | bytes an entry | threads | 1e9 entries/s | GB/s | plain 1e9 entries/s | plain GB/s | memory GB/s |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|");
    let models = [
        ("cornell", Model::Cornell, None),
        ("hall 5", Model::Hall, Some(5.0)),
        ("hall 1", Model::Hall, Some(1.0)),
    ];
    for (name, model, max_area) in models {
        let mut settings = Settings::new(model);
        settings.max_area = max_area;
        let scene = genx::make(&settings)?.scene;
        for resolution in [100, 128] {
            measure(name, &scene, resolution)?;
        }
    }
    Ok(())
}

fn measure(name: &str, scene: &Scene, resolution: u32) -> anyhow::Result<()> {
    let settings = FormFactorSettings::new(resolution);
    let hemicubes = Arc::new(Hemicubes::new(scene, settings));
    let source = Box::new(CpuRows::new(&hemicubes));
    let mut source = with_lamps(&hemicubes, LampViews::Auto, source);
    let patches = scene.patch_count();
    let batches = ROWS.min(patches) / BATCH;
    let drawn: Vec<RowBatch> = (0..batches)
        .map(|k| {
            let first = (u64::from(patches - BATCH) * u64::from(k) / u64::from(batches)) as u32;
            source.draw_rows(first..first + BATCH)
        })
        .collect::<Result<_, _>>()?;
    let exact = Exact::new(&scene.patch_emissions());
    let compact: Vec<CompactRows> = drawn
        .iter()
        .map(|b| CompactRows::encode(b, &exact))
        .collect();
    let bytes = compact.iter().map(CompactRows::bytes).sum::<u64>() as f64;
    let entries = compact.iter().map(CompactRows::entries).sum::<u64>() as f64;

    let radiosity: Vec<Rgb> = (0..patches)
        .map(|i| Rgb::new(1.0, 2.0, (i % 7) as f32))
        .collect();
    let channels = Channels::new(radiosity.iter().copied());
    let gatherer = Gatherer::default();
    let memory = vec![1_u64; (bytes / 8.0) as usize];
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()?;
        let best = |pass: &(dyn Fn() + Sync)| {
            pool.install(|| {
                (0..PASSES)
                    .map(|_| {
                        let start = Instant::now();
                        pass();
                        start.elapsed().as_secs_f64()
                    })
                    .fold(f64::INFINITY, f64::min)
            })
        };
        let compact_secs = best(&|| {
            compact.par_iter().for_each(|batch| {
                for k in 0..batch.receivers().len() {
                    black_box(gatherer.gather(batch.row(k), &channels));
                }
            });
        });
        let plain_secs = best(&|| {
            drawn.par_iter().for_each(|batch| {
                for k in 0..batch.receivers().len() {
                    black_box(gather_plain(batch.row(k), &radiosity));
                }
            });
        });
        let memory_secs = best(&|| {
            memory.par_chunks(1 << 17).for_each(|chunk| {
                black_box(chunk.iter().fold(0_u64, |sum, &x| sum.wrapping_add(x)));
            });
        });
        let giga = |count: f64, secs: f64| 1e-9 * count / secs;
        println!(
            "| {name} | {resolution} | {patches} | {:.0} | {:.2} | {threads} | {:.2} | {:.2} | {:.2} | {:.2} | {:.2} |",
            entries / f64::from(batches * BATCH),
            bytes / entries,
            giga(entries, compact_secs),
            giga(bytes, compact_secs),
            giga(entries, plain_secs),
            giga(8.0 * entries, plain_secs),
            giga(bytes, memory_secs),
        );
    }
    Ok(())
}

fn gather_plain(row: &[Entry], radiosity: &[Rgb]) -> DVec3 {
    row.iter()
        .map(|entry| f64::from(entry.units) * radiosity[entry.source as usize].as_dvec3())
        .sum()
}
