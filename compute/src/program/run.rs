//! A whole run of the program: load, solve with checkpoints, write, report.

use std::path::Path;
use std::time::Instant;

use anyhow::Context;
use scene::file::{self, OutputLock};
use scene::{Scene, Solution};

use super::Settings;
use super::progress::Progress;
use crate::cancel::CancelToken;
use crate::form_factors::{FormFactors, Levels, Needed};
use crate::report::{Files, Report};
use crate::row_cache::RowCache;
use crate::solve::{Observer, Position, Remark, Solve, SolveError};
use crate::{form_factors_csv, view_factors};

/// Does what was asked for, and says on standard error what a user should know on the way.
///
/// # Errors
/// Files that cannot be read or written, and a back end that cannot go on. What was solved until
/// then has been written to the output, if it can be written.
pub fn solve(settings: &Settings, cancel: &CancelToken) -> anyhow::Result<Report> {
    // First of all, so that a missing folder or another program's lock costs no work.
    let outputs = [
        Some(&settings.output),
        settings.report.as_ref(),
        settings.form_factors_csv.as_ref(),
        settings.view_factors_csv.as_ref(),
    ];
    let _locks: Vec<OutputLock> = outputs
        .into_iter()
        .flatten()
        .map(|path| OutputLock::acquire(path))
        .collect::<Result<_, _>>()?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads.unwrap_or(0))
        .build()
        .context("the threads could not be started")?;
    pool.install(|| solve_and_report(settings, cancel))
}

fn solve_and_report(settings: &Settings, cancel: &CancelToken) -> anyhow::Result<Report> {
    let start = Instant::now();
    let (scene, before) = file::load(&settings.input)?;
    let load = start.elapsed();
    let rows = match write_factors(settings, &scene, before.as_ref(), cancel) {
        Ok(rows) => rows,
        Err(error) if cancel.is_cancelled() => {
            // What there is of a solution is still written below.
            eprintln!("compute: {error:#}");
            None
        }
        Err(error) => return Err(error),
    };
    let mut watch = Watch {
        settings,
        scene: &scene,
        progress: Progress::new(settings.solve.tolerance, before.as_ref()),
    };
    let solved = Solve::new(&scene)
        .settings(settings.solve)
        .start(before)
        .rows(rows)
        .cancel(cancel)
        .observer(&mut watch)
        .run();
    watch.progress.finish();
    let writing = Instant::now();
    let mut solved = match solved {
        Ok(solved) => solved,
        Err(error) => return Err(save_before(settings, &scene, error)),
    };
    file::save(&settings.output, &scene, Some(solved.solution()))?;
    solved.seconds.write += writing.elapsed().as_secs_f64();
    solved.seconds.load = load.as_secs_f64();
    solved.seconds.finish(start.elapsed());
    let files = Files {
        input: &settings.input,
        output: &settings.output,
    };
    let report = Report::new(&files, &scene, &settings.solve, settings.strict, &solved);
    for warning in report.warnings() {
        eprintln!("compute: warning: {warning}");
    }
    if let Some(path) = &settings.report {
        write_report(path, &report)?;
    }
    Ok(report)
}

/// Writes the form factors and the view factors between patches that were asked for. The rows are handed back where the
/// scene is solved among its patches.
fn write_factors<'s>(
    settings: &Settings,
    scene: &'s Scene,
    before: Option<&Solution>,
    cancel: &CancelToken,
) -> anyhow::Result<Option<RowCache<'s>>> {
    if settings.form_factors_csv.is_none() && settings.view_factors_csv.is_none() {
        return Ok(None);
    }
    let solution = settings.solve.solution;
    let form_factors = FormFactors::new(scene, solution.form_factors, settings.solve.drawing)
        .going_on(before, solution)
        .with_cancel(cancel);
    let mut rows = form_factors.rows(Needed::All)?;
    if let Some(path) = &settings.form_factors_csv {
        form_factors_csv::save(path, &mut rows)?;
    }
    if let Some(path) = &settings.view_factors_csv {
        view_factors::save(path, scene, &mut rows)?;
    }
    let is_one_level = form_factors.levels(solution.source_area) == Levels::Patches;
    Ok(is_one_level.then_some(rows))
}

/// Writes what was solved before something went wrong, and tells all of it.
fn save_before(settings: &Settings, scene: &Scene, error: SolveError) -> anyhow::Error {
    let SolveError { cause, solution } = error;
    let error = anyhow::Error::from(cause);
    let Some(solution) = solution else {
        return error;
    };
    match file::save(&settings.output, scene, Some(&solution)) {
        Ok(()) => {
            let output = settings.output.display();
            error.context(format!("what was solved so far is in {output}"))
        }
        Err(unsaved) => error.context(format!("{unsaved:#}; before that")),
    }
}

/// Shows how a run goes, and keeps its checkpoints.
struct Watch<'a> {
    settings: &'a Settings,
    scene: &'a Scene,
    progress: Progress,
}

impl Observer for Watch<'_> {
    fn progress(&mut self, position: &Position) {
        self.progress.show(position);
    }

    fn remark(&mut self, remark: &Remark) {
        let input = self.settings.input.display();
        self.progress.say(&match remark {
            Remark::Start(_) => format!("compute: {input} {remark}"),
            Remark::NothingToDo(_) => format!("compute: nothing to do: {input} {remark}"),
            Remark::Backend(_) | Remark::Shortage { .. } => format!("compute: {remark}"),
        });
    }

    /// The work goes on if it cannot be written, since the disk may have room again by the end.
    fn checkpoint(&mut self, solution: &Solution) {
        if let Err(error) = file::save(&self.settings.output, self.scene, Some(solution)) {
            self.progress
                .say(&format!("compute: warning: no checkpoint: {error:#}"));
        }
    }
}

fn write_report(path: &Path, report: &Report) -> anyhow::Result<()> {
    let json = serde_json::to_vec_pretty(report).context("the report cannot be written as JSON")?;
    file::write_atomically(path, |out| {
        out.write_all(&json)?;
        out.write_all(b"\n")
    })?;
    Ok(())
}
