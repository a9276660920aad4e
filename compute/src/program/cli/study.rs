//! The command line of `compute study`, turned into [`StudySettings`].

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;

use super::backend_parser;
use crate::program::study::StudySettings;
use crate::quantity::parse_duration;
use crate::settings::BackendChoice;

/// Measure what settings cost on scenes of your own, and how wrong they are
///
/// Solves each scene once by every quality and by single settings (resolution, points, multipliers, lamps, solver, levels, the
/// error that is asked for), and compares the light with that of the highest quality, which is solved first. FOLDER gets
/// study.csv, study.json, study.md, plots (SVG) and the references. What is in FOLDER/study.csv already is not run again.
#[derive(Debug, Args)]
pub(super) struct StudyArguments {
    /// Scene files from genx; those of one model with other patches share a reference
    #[arg(value_name = "SCENE", required = true)]
    scenes: Vec<PathBuf>,
    /// Where tables, plots and references go
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
    /// Compare with this solved scene instead
    #[arg(long, value_name = "SOLVED")]
    reference: Option<PathBuf>,
    /// Only runs with this in what they vary or in their options, as in "resolution" or "--quality mesh"
    #[arg(long, value_name = "TEXT", allow_hyphen_values = true)]
    only: Vec<String>,
    /// The longest run
    #[arg(long, value_name = "TIME", default_value = "10min", value_parser = parse_duration)]
    time_limit: Duration,
    /// Who draws: auto, cpu or gpu
    #[arg(long, default_value = "auto", value_parser = backend_parser())]
    backend: BackendChoice,
    /// Threads of the CPU; one for each core if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
}

impl StudyArguments {
    pub fn settings(self) -> StudySettings {
        StudySettings {
            scenes: self.scenes,
            folder: self.out,
            reference: self.reference,
            only: self.only,
            time_limit: self.time_limit,
            backend: self.backend,
            threads: self.threads.map(usize::from),
        }
    }
}
