//! The program `compute`: what its commands do with files.

pub mod cli;
mod dry_run;
mod gather;
mod interrupt;
mod progress;
mod run;
mod study;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;

use crate::cancel::CancelToken;
use crate::report::Report;
use crate::settings::{BackendChoice, FormFactorSettings, SolveSettings};
use crate::solve::StoppedBy;
use crate::{verify, view_factors};

/// What the program is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Task {
    /// To solve a scene.
    Solve(Box<Settings>),
    /// To tell what sensors receive in a solved scene.
    Gather(GatherSettings),
    /// To measure what settings cost, and how wrong they are.
    Study(study::StudySettings),
    /// To show how far it is from answers that are known.
    Verify(verify::Settings),
}

/// Which sensors gather, and by which means.
#[derive(Clone, Debug, PartialEq)]
pub struct GatherSettings {
    /// The solved scene.
    pub solved: PathBuf,
    /// Points and normals, as CSV.
    pub sensors: PathBuf,
    /// Where the same go with what they receive.
    pub output: PathBuf,
    /// What decides the form factors.
    pub form_factors: FormFactorSettings,
    /// Who draws.
    pub backend: BackendChoice,
    /// Threads of the CPU; `None`: one for each core.
    pub threads: Option<usize>,
}

/// How a scene is solved, and the files of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The scene, with or without a solution to go on from.
    pub input: PathBuf,
    /// Where the solution goes; may be `input`.
    pub output: PathBuf,
    /// How it is solved.
    pub solve: SolveSettings,
    /// The same where nothing emits, so that form factors are all there is.
    pub solve_without_light: SolveSettings,
    /// What is asked of view factors where form factors are all that is wanted, or all there is.
    pub asked_of_view_factors: Option<view_factors::Asked>,
    /// Threads of the CPU; `None`: one for each core.
    pub threads: Option<usize>,
    /// What rows of form factors may take in a file beside the output, bytes.
    pub rows_file_limit: u64,
    /// Whether that file stays where nothing is left to be drawn.
    pub keep_rows: bool,
    /// Where the report goes.
    pub report: Option<PathBuf>,
    /// Where the form factors go.
    pub form_factors_csv: Option<PathBuf>,
    /// Where the view factors between objects go.
    pub view_factors_csv: Option<PathBuf>,
    /// Whether a certificate beyond its tolerances is a failure.
    pub strict: bool,
    /// Whether it is only told what the run would take.
    pub is_dry_run: bool,
}

/// Does what was asked for.
///
/// # Errors
/// Files that cannot be read or written, and work that cannot go on.
pub fn run(task: &Task) -> anyhow::Result<ExitCode> {
    Ok(match task {
        Task::Verify(settings) => code(verify::run(settings)?),
        Task::Study(settings) => {
            let cancel = CancelToken::new();
            interrupt::listen(&cancel);
            study::run(settings, &cancel)?
        }
        Task::Gather(settings) => {
            let cancel = CancelToken::new();
            interrupt::listen(&cancel);
            gather::gather(settings, &cancel)?
        }
        Task::Solve(settings) => {
            let cancel = CancelToken::new();
            interrupt::listen(&cancel);
            if settings.is_dry_run {
                dry_run::tell(settings, &cancel)?
            } else {
                end(&run::solve(settings, &cancel)?)
            }
        }
    })
}

/// Prints what a run has come to, whose result is written.
fn end(report: &Report) -> ExitCode {
    // A reader that has gone away is no failure.
    writeln!(std::io::stdout(), "{}", report.summary()).ok();
    if report.stopped_by == StoppedBy::Interrupt {
        return ExitCode::from(interrupt::EXIT_CODE);
    }
    let failure = report.strict_failure();
    if let Some(failure) = &failure {
        eprintln!("compute: error: {failure}");
    }
    code(failure.is_none())
}

fn code(is_success: bool) -> ExitCode {
    if is_success {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    }
}
