//! Runs of the program `compute`, each a process of its own, by their reports.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, bail};
use compute::solve::Seconds;
use scene::Scene;
use serde::Deserialize;
use tempfile::TempDir;

use crate::arguments::Plan;
use crate::text::figures;

/// What is read of a report.
#[derive(Debug, Deserialize)]
pub struct Report {
    pub hemicubes_drawn: u64,
    pub seconds: Seconds,
    pub peak_memory_bytes: Option<u64>,
    pub iterations: u64,
    pub next_iteration_share: f64,
    pub residuals: Vec<f64>,
    pub stopped_by: String,
}

/// Headings of [`cells_of_stages`].
pub const STAGES: [&str; 5] = ["total, s", "open", "draw", "solve", "files"];

/// The total and the stages.
pub fn cells_of_stages(seconds: &Seconds) -> Vec<String> {
    let files = seconds.load + seconds.write;
    [
        seconds.total,
        seconds.open,
        seconds.draw,
        seconds.solve,
        files,
    ]
    .map(figures)
    .to_vec()
}

impl Report {
    /// True where the time limit ended it.
    pub fn is_unfinished(&self) -> bool {
        self.stopped_by == "time-limit"
    }

    /// Iterations done, with the share of the last one.
    pub fn iterations_done(&self) -> f64 {
        self.iterations as f64 + self.next_iteration_share
    }

    /// Hemicubes drawn in a second of drawing.
    pub fn hemicubes_per_second(&self) -> f64 {
        self.hemicubes_drawn as f64 / self.seconds.draw.max(1e-9)
    }
}

/// The program, and a folder for its files.
#[derive(Debug)]
pub struct Program {
    folder: TempDir,
    time_limit: String,
}

impl Program {
    /// The program that was built with this one.
    pub fn new(plan: &Plan) -> anyhow::Result<Self> {
        Ok(Self {
            folder: tempfile::tempdir()?,
            time_limit: format!("{}s", plan.time_limit.as_secs_f64()),
        })
    }

    /// Writes a scene to a file for runs.
    pub fn keep(&self, name: &str, scene: &Scene) -> anyhow::Result<PathBuf> {
        let path = self.folder.path().join(name).with_extension("rad");
        scene::file::save(&path, scene, None)?;
        Ok(path)
    }

    /// Solves a scene on the cpu.
    pub fn solve(&self, scene: &Path, pixels: u32, options: &[&str]) -> anyhow::Result<Report> {
        let [out, report] = ["out.rad", "report.json"].map(|name| self.folder.path().join(name));
        let output = Command::new(env!("CARGO_BIN_EXE_compute"))
            .args([scene, &out])
            .arg(pixels.to_string())
            .args([
                "--quality",
                "mesh",
                "--backend",
                "cpu",
                "--time-limit",
                &self.time_limit,
                "--report",
            ])
            .arg(&report)
            .args(options)
            .output()
            .context("compute cannot be started")?;
        if !output.status.success() {
            let said = String::from_utf8_lossy(&output.stderr);
            bail!("compute: {}, {}", output.status, said.trim());
        }
        let json = fs::read(&report).with_context(|| format!("{} is missing", report.display()))?;
        // The next one must not read this one's.
        fs::remove_file(&report)?;
        fs::remove_file(&out)?;
        Ok(serde_json::from_slice(&json)?)
    }
}
