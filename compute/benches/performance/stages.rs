//! What the stages cost: hemicubes on one core, iterations over kept rows.

use std::fmt::Write;

use genx::Model;
use scene::Scene;

use crate::arguments::{Plan, Section, command_of};
use crate::iteration::{self, Iteration, iterations, read_bandwidth};
use crate::machine::cores;
use crate::measure::{Row, Timing, item_buffer, one_a_patch, pixels, row};
use crate::scenes;
use crate::text::{count, figures, heading, number_of, percent, table};

/// Pixels of the item buffers and the rows.
const PIXELS: [u32; 2] = [100, 128];

/// Hemicubes of one scene at one resolution.
#[derive(Debug)]
pub struct Drawing {
    /// Of the scene.
    pub name: &'static str,
    /// Of the scene.
    pub patches: u32,
    /// Of the scene.
    pub surfaces: usize,
    /// Along a face.
    pub resolution: u32,
    /// Of a hemicube.
    pub pixels: f64,
    /// Item buffer with look-up.
    pub item_buffer: Timing,
    /// Item buffer, look-up and merging.
    pub row: Row,
}

/// Iterations over one scene's rows.
#[derive(Debug)]
pub struct Gathering {
    /// Of the scene.
    pub name: &'static str,
    /// Of the scene.
    pub patches: u32,
    /// What it took.
    pub iteration: Iteration,
}

/// Reading of memory, for comparison.
#[derive(Clone, Copy, Debug)]
pub struct Read {
    /// Threads that read.
    pub threads: usize,
    /// Bytes a second.
    pub bandwidth: f64,
}

/// What was measured.
#[derive(Debug)]
pub struct Stages {
    pub drawings: Vec<Drawing>,
    pub gatherings: Vec<Gathering>,
    pub reads: Vec<Read>,
}

impl Stages {
    /// Measures.
    pub fn measure(plan: &Plan) -> anyhow::Result<Self> {
        let mut stages = Self {
            drawings: Vec::new(),
            gatherings: Vec::new(),
            reads: Vec::new(),
        };
        let mut threads = vec![1, cores()];
        threads.dedup();
        for &threads in &threads {
            let bandwidth = read_bandwidth(plan, threads)?;
            stages.reads.push(Read { threads, bandwidth });
        }
        let cornell: &[f64] = plan.choose(&[1e-3], &[1e-3, 6e-5, 4e-6]);
        let hall: &[f64] = plan.choose(&[30.0], &[5.0, 1.0, 0.25]);
        for (name, model, areas) in [
            ("Cornell box", Model::Cornell, cornell),
            ("hall", Model::Hall, hall),
        ] {
            for (k, &area) in areas.iter().enumerate() {
                let scene = scenes::model(model.clone(), area)?;
                eprintln!(
                    "performance: stages, {name}, {} patches",
                    count(scene.patch_count().into())
                );
                for resolution in PIXELS {
                    let drawing = Drawing::measure(plan, name, &scene, resolution)?;
                    stages.drawings.push(drawing);
                }
                // The rows of the finer ones would take minutes and all memory.
                if k == 0 {
                    for iteration in iterations(plan, &scene, &threads)? {
                        stages.gatherings.push(Gathering {
                            name,
                            patches: scene.patch_count(),
                            iteration,
                        });
                    }
                }
            }
        }
        Ok(stages)
    }

    /// Bytes a second that so many threads can read.
    pub fn bandwidth(&self, threads: usize) -> f64 {
        self.reads
            .iter()
            .find(|read| read.threads == threads)
            .map_or(f64::NAN, |read| read.bandwidth)
    }
}

impl Drawing {
    fn measure(
        plan: &Plan,
        name: &'static str,
        scene: &Scene,
        resolution: u32,
    ) -> anyhow::Result<Self> {
        let hemicubes = one_a_patch(scene, resolution);
        Ok(Self {
            name,
            patches: scene.patch_count(),
            surfaces: scene.surfaces().len(),
            resolution,
            pixels: pixels(&hemicubes),
            item_buffer: item_buffer(plan, &hemicubes)?,
            row: row(plan, &hemicubes)?,
        })
    }

    fn cells(&self) -> Vec<String> {
        let ns = |timing: Timing| figures(1e9 * timing.median / self.pixels);
        let ms = |timing: Timing| figures(1e3 * timing.median);
        let fastest = |timing: Timing| figures(1e3 * timing.fastest);
        vec![
            self.name.to_owned(),
            count(self.surfaces as u64),
            count(self.patches.into()),
            self.resolution.to_string(),
            ms(self.item_buffer),
            fastest(self.item_buffer),
            ns(self.item_buffer),
            ms(self.row.timing),
            fastest(self.row.timing),
            ns(self.row.timing),
            figures(self.row.entries),
        ]
    }
}

/// The section.
pub fn section(stages: &Stages) -> String {
    let mut text = heading("Stages");
    write!(
        text,
        "Hemicubes one after the other on one core, 64 of them spread over the scene, one a patch, the \
         same in each repetition ({}). The item buffer is drawn with the look-up of the patches; the whole row is \
         that and merging its pixels into form factors. The same surfaces with more patches show what patches cost.\n\n",
        command_of(Section::Stages)
    )
    .ok();
    let header = [
        "scene",
        "surfaces",
        "patches",
        "pixels",
        "item buffer, ms",
        "fastest",
        "ns a pixel",
        "whole row, ms",
        "fastest",
        "ns a pixel",
        "entries a row",
    ];
    let rows: Vec<Vec<String>> = stages.drawings.iter().map(Drawing::cells).collect();
    text.push_str(&table(&header, 1, &rows));
    write!(
        text,
        "\nAn iteration reads all kept rows and gathers by them; here rows of one hemicube of {} pixels a patch. \
         Beside it, what the same threads reach when they only read memory and sum it. Rows that fit the last \
         cache can be read faster than that.\n\n",
        iteration::PIXELS
    )
    .ok();
    let header = [
        "scene",
        "patches",
        "threads",
        "rows, MB",
        "bytes an entry",
        "iteration, ms",
        "million entries/s",
        "GB/s",
        "of the bandwidth",
    ];
    let mut rows: Vec<Vec<String>> = stages
        .gatherings
        .iter()
        .map(|gathering| gathering.cells(stages))
        .collect();
    for read in &stages.reads {
        let mut row = vec!["memory read".to_owned(), String::new()];
        row.push(read.threads.to_string());
        row.extend(std::iter::repeat_with(String::new).take(4));
        row.push(figures(read.bandwidth / 1e9));
        row.push(percent(1.0));
        rows.push(row);
    }
    text.push_str(&table(&header, 1, &rows));
    writeln!(text, "\nThis machine has {}.", number_of(cores(), "core")).ok();
    text
}

impl Gathering {
    fn cells(&self, stages: &Stages) -> Vec<String> {
        let Iteration {
            threads,
            seconds,
            entries,
            bytes,
        } = self.iteration;
        let rate = bytes as f64 / seconds;
        vec![
            self.name.to_owned(),
            count(self.patches.into()),
            threads.to_string(),
            figures(bytes as f64 / 1e6),
            figures(bytes as f64 / entries as f64),
            figures(1e3 * seconds),
            figures(entries as f64 / seconds / 1e6),
            figures(rate / 1e9),
            percent(rate / stages.bandwidth(threads)),
        ]
    }
}
