//! A whole run of the program: load, solve with checkpoints, write, report.

use std::io::ErrorKind;
use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Context;
use scene::file::{self, FileError, FileFault, OutputLock};
use scene::{Rgb, Scene, Solution};

use super::Settings;
use super::progress::Progress;
use crate::cancel::CancelToken;
use crate::form_factors::{FormFactors, Levels, Needed};
use crate::function::Errors;
use crate::report::{Files, Report};
use crate::row_cache::RowCache;
use crate::row_file::{self, RowFileError, RowFileRemark, RowFiles};
use crate::settings::{FormFactorSettings, SolutionSettings};
use crate::solve::{Observer, Position, Remark, Solve, SolveError, StoppedBy};
use crate::view_factors::{AsNear, Asked, ViewFactorsReport};
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
    let row_files = RowFiles::beside(
        &settings.input,
        &settings.output,
        settings.rows_file_limit,
        settings.solve.checkpoint_every,
    );
    let (scene, before) = file::load(&settings.input)?;
    let settings = &of_scene(settings, &scene, before.as_ref());
    let load = start.elapsed();
    let limit = settings.solve.time_limit;
    let is_late = |more| limit.is_some_and(|limit| start.elapsed() + more >= limit);
    let factors = Factors {
        settings,
        scene: &scene,
        before: before.as_ref(),
        row_files: row_files.as_ref(),
        cancel,
        is_late: &is_late,
    };
    let Written {
        rows,
        form_factors,
        view_factors,
    } = match factors.write() {
        Ok(written) => written,
        Err(error) if cancel.is_cancelled() => {
            // What there is of a solution is still written below.
            eprintln!("compute: {error:#}");
            Written::default()
        }
        Err(error) => return Err(error),
    };
    let mut settings = settings.clone();
    if let Some(form_factors) = form_factors {
        settings.solve.solution.form_factors = form_factors;
    }
    let settings = &settings;
    let mut watch = Watch {
        settings,
        scene: &scene,
        progress: Progress::new(settings.solve.tolerance, before.as_ref()),
    };
    let solved = Solve::new(&scene)
        .settings(settings.solve)
        .start(before)
        .rows(rows)
        .row_files(row_files.clone())
        .cancel(cancel)
        .observer(&mut watch)
        .run();
    watch.progress.finish();
    let writing = Instant::now();
    let mut solved = match solved {
        Ok(solved) => solved,
        Err(error) => return Err(save_before(settings, &scene, row_files.as_ref(), error)),
    };
    let mut make_room = || make_room(row_files.as_ref());
    // What was known stays so where not all is seen this time.
    let scene = match solved.inside.take() {
        Some(inside) => scene.with_inside(inside)?,
        None => scene,
    };
    save(settings, &scene, solved.solution(), &mut make_room)?;
    if solved.stopped_by == StoppedBy::Tolerance && !settings.keep_rows {
        remove_rows(row_files.as_ref());
    }
    solved.seconds.write += writing.elapsed().as_secs_f64();
    solved.seconds.load = load.as_secs_f64();
    solved.seconds.finish(start.elapsed());
    let files = Files {
        input: &settings.input,
        output: &settings.output,
    };
    let report = Report::new(&files, &scene, &settings.solve, settings.strict, &solved)
        .with_view_factors(view_factors);
    for warning in report.warnings() {
        eprintln!("compute: warning: {warning}");
    }
    if let Some(path) = &settings.report {
        write_report(path, &report)?;
    }
    Ok(report)
}

/// What is asked of a scene: where it has no light, and has had none, form factors are all there is. So they are where no iteration
/// is wanted but their error is asked for.
pub(super) fn of_scene(settings: &Settings, scene: &Scene, before: Option<&Solution>) -> Settings {
    let mut settings = settings.clone();
    let is_dark = |before: &Solution| before.irradiance.iter().all(|&h| h == Rgb::ZERO);
    let has_no_light = scene.emitted_power().max_element() == 0.0 && before.is_none_or(is_dark);
    let has_no_iteration = settings.solve.max_iterations == Some(0);
    if has_no_light || has_no_iteration && settings.asked_of_view_factors.is_some() {
        settings.solve = settings.solve_without_light;
    } else {
        settings.asked_of_view_factors = None;
    }
    settings
}

/// The form factors and view factors of a run, and where they go.
struct Factors<'s, 'a> {
    settings: &'s Settings,
    scene: &'a Scene,
    before: Option<&'s Solution>,
    row_files: Option<&'s RowFiles>,
    cancel: &'s CancelToken,
    is_late: &'s dyn Fn(Duration) -> bool,
}

/// What came of them.
#[derive(Default)]
struct Written<'a> {
    /// Where the scene is solved with them.
    rows: Option<RowCache<'a>>,
    /// What decides them, where their error did.
    form_factors: Option<FormFactorSettings>,
    view_factors: Option<ViewFactorsReport>,
}

impl<'a> Factors<'_, 'a> {
    /// Writes the form factors and the view factors between patches that were asked for, as one value a patch would have them.
    fn write(&self) -> anyhow::Result<Written<'a>> {
        if let Some(asked) = self.settings.asked_of_view_factors {
            return self.write_as_near_as(asked);
        }
        let settings = self.settings;
        if settings.form_factors_csv.is_none() && settings.view_factors_csv.is_none() {
            return Ok(Written::default());
        }
        let has_function = settings.solve.function().is_some();
        let solution = if has_function {
            settings.solve_without_light.solution
        } else {
            settings.solve.solution
        };
        let form_factors = self
            .form_factors(solution)
            .with_row_files(self.row_files.cloned());
        let mut rows = form_factors.rows(Needed::All)?;
        let form_factors = form_factors.after(&rows);
        let written = self.write_tables(&form_factors, &mut rows);
        if written.is_err() {
            rows.save();
        } else {
            rows.flush();
        }
        for remark in rows.take_remarks() {
            eprintln!("compute: {}", told(&remark));
        }
        written?;
        let is_one_level = form_factors.levels(solution.source_area) == Levels::Patches;
        Ok(Written {
            rows: (is_one_level && !has_function).then_some(rows),
            ..Written::default()
        })
    }

    /// The same as near as is asked for.
    fn write_as_near_as(&self, asked: Asked) -> anyhow::Result<Written<'a>> {
        let solution = self.settings.solve.solution;
        let form_factors = self.form_factors(solution);
        let near = view_factors::as_near_as(asked, self.scene, form_factors, self.is_late)?;
        let AsNear {
            view_factors: found,
            form_factors,
            mut rows,
            report,
        } = near;
        if let Some(path) = &self.settings.form_factors_csv {
            form_factors_csv::save(path, &mut rows)?;
        }
        if let Some(path) = &self.settings.view_factors_csv {
            view_factors::save(path, self.scene, &found)?;
        }
        let is_one_level = form_factors.levels(solution.source_area) == Levels::Patches;
        Ok(Written {
            rows: is_one_level.then_some(rows),
            form_factors: Some(form_factors.settings()),
            view_factors: Some(report),
        })
    }

    fn form_factors(&self, solution: SolutionSettings) -> FormFactors<'a> {
        FormFactors::new(
            self.scene,
            solution.form_factors,
            self.settings.solve.drawing,
        )
        .going_on(self.before, solution)
        .with_cancel(self.cancel)
    }

    fn write_tables(&self, form_factors: &FormFactors, rows: &mut RowCache) -> anyhow::Result<()> {
        if let Some(path) = &self.settings.form_factors_csv {
            form_factors_csv::save(path, rows)?;
        }
        if let Some(path) = &self.settings.view_factors_csv {
            let found = view_factors::view_factors(self.scene, form_factors, rows)?;
            view_factors::save(path, self.scene, &found)?;
        }
        Ok(())
    }
}

/// Writes a solution to the output; where the disk is full, once more after room has been made.
fn save(
    settings: &Settings,
    scene: &Scene,
    solution: &Solution,
    make_room: &mut dyn FnMut() -> bool,
) -> Result<(), FileError> {
    let save = || file::save(&settings.output, scene, Some(solution));
    match save() {
        Err(error) if is_disk_full(&error) && make_room() => save(),
        result => result,
    }
}

/// Whether there is no room, on the disk or for this user.
fn is_disk_full(error: &FileError) -> bool {
    let FileFault::Io { source, .. } = &error.fault else {
        return false;
    };
    matches!(
        source.kind(),
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded
    )
}

/// Removes the rows beside the output where its disk is full; false where there are none.
fn make_room(files: Option<&RowFiles>) -> bool {
    let removed = files.filter(|&files| remove_rows(Some(files)));
    if let Some(files) = removed {
        let remark = RowFileRemark::removed(files.path());
        eprintln!("compute: {}", told(&remark));
    }
    removed.is_some()
}

/// Removes the rows beside the output, an earlier run's too; false where there are none.
fn remove_rows(files: Option<&RowFiles>) -> bool {
    let removed = files.map(|files| row_file::remove(files.path()));
    match removed {
        // What is not of rows was told when rows were looked for.
        None | Some(Err(RowFileError::Foreign { .. })) => false,
        Some(Ok(is_removed)) => is_removed,
        Some(Err(error)) => {
            eprintln!("compute: warning: {error}");
            false
        }
    }
}

/// A remark about files of rows, as it is printed.
fn told(remark: &RowFileRemark) -> String {
    match remark {
        RowFileRemark::NotUsed(_) => remark.to_string(),
        RowFileRemark::NotKept(_) => format!("warning: {remark}"),
    }
}

/// Writes what was solved before something went wrong, and tells all of it.
fn save_before(
    settings: &Settings,
    scene: &Scene,
    row_files: Option<&RowFiles>,
    error: SolveError,
) -> anyhow::Error {
    let SolveError { cause, solution } = error;
    let error = anyhow::Error::from(cause);
    let Some(solution) = solution else {
        return error;
    };
    match save(settings, scene, &solution, &mut || make_room(row_files)) {
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

    fn function(&mut self, vertices: u32, error: Option<Errors>) {
        self.progress.show_function(vertices, error);
    }

    fn remark(&mut self, remark: &Remark) {
        let input = self.settings.input.display();
        self.progress.say(&match remark {
            Remark::Start(_) => format!("compute: {input} {remark}"),
            Remark::NothingToDo(_) => format!("compute: nothing to do: {input} {remark}"),
            Remark::RowFile(remark) => format!("compute: {}", told(remark)),
            Remark::Backend(_) | Remark::Shortage { .. } => format!("compute: {remark}"),
        });
    }

    /// The work goes on if it cannot be written, since the disk may have room again by the end.
    fn checkpoint(&mut self, solution: &Solution, make_room: &mut dyn FnMut() -> bool) {
        if let Err(error) = save(self.settings, self.scene, solution, make_room) {
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
