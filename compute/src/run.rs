//! A whole run: load, solve with checkpoints, write, report.

mod levels;
mod start;

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use scene::file::{self, OutputLock};
use scene::{Scene, Solution};
use visibility::Drawable;

use crate::backend::{self, Backend};
use crate::convex::ConvexRows;
use crate::hemicubes::Hemicubes;
use crate::lamps::with_lamps;
use crate::problem::Problem;
use crate::progress::{Position, Progress};
use crate::quantity::show_size;
use crate::report::{self, BackendReport, Report, RowsReport, Seconds, SettingsReport, StoppedBy};
use crate::row_cache::{RowCache, RowStatistics};
use crate::settings::{BackendChoice, ClosedForms, Settings, SolverChoice};
use crate::solver::convergence::Convergence;
use crate::solver::{Gather, Shoot, Solver, Update, ambient_radiosity};
use crate::{certificate, form_factors_csv, interrupt, unlit, view_factors};
use levels::Solved;

/// Does what was asked for, and says on standard error what a user should know on the way.
///
/// # Errors
/// Files that cannot be read or written, and a back end that cannot go on. What was solved until
/// then has been written to the output, if it can be written.
pub fn run(settings: &Settings) -> anyhow::Result<Report> {
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
    pool.install(|| Run::new(settings).run())
}

/// A run under way.
struct Run<'a> {
    settings: &'a Settings,
    start: Instant,
    seconds: Seconds,
    /// Whether the user knows why the back end is not another one.
    is_remark_said: bool,
    /// Hemicubes and time of rows that are there no more: those of coarse sources.
    drawn_before: RowStatistics,
}

impl<'a> Run<'a> {
    fn new(settings: &'a Settings) -> Self {
        Self {
            settings,
            start: Instant::now(),
            seconds: Seconds::default(),
            is_remark_said: false,
            drawn_before: RowStatistics::default(),
        }
    }

    fn run(mut self) -> anyhow::Result<Report> {
        let settings = self.settings;
        let (scene, solution) = file::load(&settings.input)?;
        self.seconds.load = self.start.elapsed().as_secs_f64();

        let iterations_before = solution.as_ref().map_or(0, |s| s.provenance.iterations);
        let (levels, coarse) = self.solve_among_sources(&scene, solution)?;
        let hemicubes = Arc::new(self.hemicubes(&scene, coarse.as_ref().unwrap_or(&scene)));
        // Rows that patches gather with once are not worth keeping.
        let memory_bytes = coarse.as_ref().map_or(settings.memory_bytes, |_| 0);
        let (name, mut rows) = self.rows(&hemicubes, memory_bytes)?;
        let all_rows = settings.strict
            || settings.form_factors_csv.is_some()
            || settings.view_factors_csv.is_some();
        if !all_rows && let Some(unlit) = unlit::unlit(&hemicubes, levels.start()) {
            rows.leave_out(unlit);
        }
        if let Err(error) = self.write_factors(&scene, &mut rows) {
            if !interrupt::requested() {
                return Err(error);
            }
            // What there is of a solution is still written below.
            eprintln!("compute: {error:#}");
        }
        let Solved {
            solution,
            result,
            sources,
        } = self.solve(levels, &mut rows);
        let saved = self.save(&scene, &solution);
        let mut stopped_by = self.outcome(result, saved)?;
        if settings.strict && !matches!(stopped_by, StoppedBy::Interrupt | StoppedBy::TimeLimit) {
            rows.draw_missing()?;
            if interrupt::requested() {
                stopped_by = StoppedBy::Interrupt;
            }
        }

        let statistics = rows.statistics().with_drawing_of(&self.drawn_before);
        let kept = sources.map_or(statistics, |(_, rows)| rows);
        self.seconds
            .finish(self.start.elapsed(), statistics.duration);
        let (energy, closure, back_face_share) = report::measure(&scene, &solution, &rows);
        let certificate = certificate::certify(
            &rows,
            energy.imbalance,
            solution.provenance.residuals.last().copied(),
        );
        let ambient_radiosity = ambient_radiosity(&Problem::new(&scene), &solution);
        let report = Report {
            version: env!("CARGO_PKG_VERSION"),
            input: settings.input.display().to_string(),
            output: settings.output.display().to_string(),
            settings: SettingsReport::new(settings, rayon::current_num_threads()),
            backend: BackendReport {
                name,
                adapter: rows.describe_source(),
            },
            patches: scene.patch_count(),
            surfaces: scene.surfaces().len(),
            unlit_patches: scene.patch_count() - rows.lit_count(),
            hemicubes_drawn: statistics.hemicubes,
            sources: sources.map(|(report, _)| report),
            rows: RowsReport {
                kept: kept.kept_rows,
                kept_bytes: kept.kept_bytes,
                bytes_per_entry: kept.bytes_per_entry(),
            },
            seconds: self.seconds,
            peak_memory_bytes: report::peak_memory_bytes(),
            iterations: solution.provenance.iterations,
            iterations_before,
            next_iteration_share: solution.next_iteration_share(),
            convergence: Convergence::new(settings.solution.solver, &solution.provenance.residuals),
            residuals: solution.provenance.residuals,
            ambient_radiosity: ambient_radiosity.map(Into::into),
            energy,
            closure,
            back_face_share,
            certificate,
            stopped_by,
        };
        for warning in report.warnings() {
            eprintln!("compute: warning: {warning}");
        }
        if let Some(path) = &settings.report {
            write_report(path, &report)?;
        }
        Ok(report)
    }

    /// The hemicubes of a scene's patches that see those of `sources`.
    fn hemicubes<'s>(&mut self, scene: &'s Scene, sources: &'s Scene) -> Hemicubes<'s> {
        let opening = Instant::now();
        let drawable = Arc::new(Drawable::new(sources));
        let hemicubes = Hemicubes::between(scene, &drawable, self.settings.solution.form_factors);
        self.seconds.open += opening.elapsed().as_secs_f64();
        hemicubes
    }

    /// The rows of hemicubes, drawn as is asked for, and the back end's name.
    fn rows<'s>(
        &mut self,
        hemicubes: &Arc<Hemicubes<'s>>,
        memory_bytes: u64,
    ) -> anyhow::Result<(&'static str, RowCache<'s>)> {
        let opening = Instant::now();
        if let Some(source) = self.closed_forms(hemicubes) {
            self.seconds.open += opening.elapsed().as_secs_f64();
            let rows = RowCache::new(hemicubes, Box::new(source), memory_bytes);
            return Ok(("cpu", rows));
        }
        let Backend {
            name,
            source,
            remark,
        } = backend::open(hemicubes, self.settings.backend)?;
        self.seconds.open += opening.elapsed().as_secs_f64();
        if let Some(remark) = remark
            && !std::mem::replace(&mut self.is_remark_said, true)
        {
            eprintln!("compute: {remark}");
        }
        let source = with_lamps(hemicubes, self.settings.solution.lamps, source);
        Ok((name, RowCache::new(hemicubes, source, memory_bytes)))
    }

    /// Rows that are formulas, where they may be.
    fn closed_forms<'s>(&self, hemicubes: &Arc<Hemicubes<'s>>) -> Option<ConvexRows<'s>> {
        let are_wanted = self.settings.solution.closed_forms == ClosedForms::Auto
            && self.settings.backend == BackendChoice::Auto;
        are_wanted.then(|| ConvexRows::new(hemicubes)).flatten()
    }

    /// Writes the form factors and the view factors between patches that were asked for.
    fn write_factors(&mut self, scene: &Scene, rows: &mut RowCache) -> anyhow::Result<()> {
        if self.settings.form_factors_csv.is_none() && self.settings.view_factors_csv.is_none() {
            return Ok(());
        }
        if rows.hemicubes().sources().patch_count() == scene.patch_count() {
            return self.write_factors_of(scene, rows);
        }
        let hemicubes = Arc::new(self.hemicubes(scene, scene));
        let (_, mut rows) = self.rows(&hemicubes, 0)?;
        self.write_factors_of(scene, &mut rows)
    }

    fn write_factors_of(&self, scene: &Scene, rows: &mut RowCache) -> anyhow::Result<()> {
        if let Some(path) = &self.settings.form_factors_csv {
            form_factors_csv::save(path, rows)?;
        }
        if let Some(path) = &self.settings.view_factors_csv {
            view_factors::save(path, scene, rows)?;
        }
        Ok(())
    }

    /// Iterates until something says stop.
    fn iterate(
        &mut self,
        scene: &Scene,
        solver: &mut dyn Solver,
        rows: &mut RowCache,
        goal: Goal,
    ) -> anyhow::Result<StoppedBy> {
        let settings = self.settings;
        let mut progress =
            Progress::new(settings.tolerance, solver.iterations(), solver.residual());
        let mut last_checkpoint = Instant::now();
        let mut is_shortage_said = false;
        let stopped_by = loop {
            if solver.residual().is_some_and(|r| !r.is_finite()) {
                anyhow::bail!(
                    "radiosities are beyond what f32 holds, 3e38 W/m^2; lower the emission"
                );
            }
            if goal != Goal::OnePass {
                if solver.residual().is_some_and(|r| r <= settings.tolerance) {
                    break StoppedBy::Tolerance;
                }
                if settings
                    .max_iterations
                    .is_some_and(|most| solver.iterations() >= most)
                {
                    break StoppedBy::Iterations;
                }
            }
            if interrupt::requested() {
                break StoppedBy::Interrupt;
            }
            if settings
                .time_limit
                .is_some_and(|limit| self.start.elapsed() >= limit)
            {
                break StoppedBy::TimeLimit;
            }
            let step = solver.step(rows)?;
            let statistics = rows.statistics();
            if goal == Goal::OnePass && step.ends_iteration {
                break StoppedBy::Tolerance;
            }
            if goal == Goal::Convergence
                && !is_shortage_said
                && let Some(shortage) = shortage(&statistics, rows.lit_count())
            {
                progress.say(&shortage);
                is_shortage_said = true;
            }
            progress.show(Position {
                iterations: solver.iterations(),
                is_gathering: goal == Goal::OnePass,
                share_done: step.share_done,
                residual: solver.residual(),
                hemicubes: statistics.hemicubes,
                drawing: statistics.duration,
            });
            if goal != Goal::Again
                && last_checkpoint.elapsed()
                    >= settings.checkpoint_every.max(MIN_CHECKPOINT_INTERVAL)
            {
                self.checkpoint(scene, &solver.snapshot(), |warning| progress.say(warning));
                last_checkpoint = Instant::now();
            }
        };
        progress.finish();
        Ok(stopped_by)
    }

    /// Why the run stopped, or all that went wrong.
    fn outcome(
        &self,
        result: anyhow::Result<StoppedBy>,
        saved: anyhow::Result<()>,
    ) -> anyhow::Result<StoppedBy> {
        match (result, saved) {
            (Ok(stopped_by), Ok(())) => Ok(stopped_by),
            (Ok(_), Err(unsaved)) => Err(unsaved),
            (Err(error), Ok(())) => {
                let output = self.settings.output.display();
                Err(error.context(format!("what was solved so far is in {output}")))
            }
            (Err(error), Err(unsaved)) => Err(error.context(format!("{unsaved:#}; before that"))),
        }
    }

    /// Writes what there is; the work goes on if it cannot, since the disk may have room again by the end.
    fn checkpoint(&mut self, scene: &Scene, solution: &Solution, warn: impl FnOnce(&str)) {
        if let Err(error) = self.save(scene, solution) {
            warn(&format!("compute: warning: no checkpoint: {error:#}"));
        }
    }

    fn save(&mut self, scene: &Scene, solution: &Solution) -> anyhow::Result<()> {
        let start = Instant::now();
        let saved = file::save(&self.settings.output, scene, Some(solution));
        self.seconds.write += start.elapsed().as_secs_f64();
        Ok(saved?)
    }
}

/// What to say where rows do not fit, once as many were drawn as there are: by then it is known.
fn shortage(statistics: &RowStatistics, rows: u32) -> Option<String> {
    let drawn = statistics.kept_rows + statistics.left_out_rows;
    (statistics.left_out_rows > 0 && drawn >= rows.into()).then(|| {
        // A tenth more and a little: rows that were left out more than once may have weighed more in the mean.
        let enough = statistics.bytes_of_all(rows) / 10 * 11 + (1 << 16);
        format!(
            "compute: {} of {rows} rows of form factors are kept, the others are drawn again whenever they are \
             needed; --memory {} would keep all",
            statistics.kept_rows,
            show_size(enough).replace(' ', ""),
        )
    })
}

/// What a solver is run for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Goal {
    /// Until the residual or the iterations are reached.
    Convergence,
    /// The same once more, for what it tells: nothing is written.
    Again,
    /// Until all patches have been gone through once.
    OnePass,
}

/// Checkpoints more often than this would do nothing but write.
const MIN_CHECKPOINT_INTERVAL: Duration = Duration::from_millis(50);

/// A solver among the patches of a scene that goes on from `start`.
fn solver(choice: SolverChoice, scene: &Scene, start: Solution) -> Box<dyn Solver> {
    let problem = Problem::new(scene);
    match choice {
        SolverChoice::Jacobi => Box::new(Gather::new(problem, Update::AfterIteration, start)),
        SolverChoice::GaussSeidel => Box::new(Gather::new(problem, Update::AtOnce, start)),
        SolverChoice::Shooting => Box::new(Shoot::new(problem, start)),
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
