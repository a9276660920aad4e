//! The loop around a solver.

use std::time::{Duration, Instant};

use super::{Position, Remark, Run, SolveFault, StoppedBy};
use crate::row_cache::{RowCache, RowStatistics};
use crate::solver::Solver;

/// What a solver is run for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Goal {
    /// Until the residual or the iterations are reached.
    Convergence,
    /// The same among coarser sources than the patches, which gather afterwards.
    ConvergenceAmongSources,
    /// The same once more, for what it tells: no checkpoint is handed out.
    Again,
    /// Until all patches have been gone through once.
    OnePass,
}

/// Checkpoints more often than this would do nothing but write.
const MIN_CHECKPOINT_INTERVAL: Duration = Duration::from_millis(50);

impl Run<'_, '_> {
    /// Iterates until something says stop. What has been drawn is then in its file, if there is one.
    pub(super) fn iterate(
        &mut self,
        solver: &mut dyn Solver,
        rows: &mut RowCache,
        goal: Goal,
    ) -> Result<StoppedBy, SolveFault> {
        let result = self.iterate_on(solver, rows, goal);
        if matches!(result, Ok(StoppedBy::Tolerance)) {
            rows.flush();
        } else {
            rows.save();
        }
        self.tell(rows);
        result
    }

    fn iterate_on(
        &mut self,
        solver: &mut dyn Solver,
        rows: &mut RowCache,
        goal: Goal,
    ) -> Result<StoppedBy, SolveFault> {
        let settings = self.settings;
        let interval = settings.checkpoint_every.max(MIN_CHECKPOINT_INTERVAL);
        let mut last_checkpoint = Instant::now();
        let mut is_shortage_said = false;
        let rows_after = match goal {
            Goal::Convergence | Goal::OnePass => 0,
            _ if settings.function().is_some() => 0,
            Goal::ConvergenceAmongSources | Goal::Again => self.scene.patch_count(),
        };
        loop {
            if solver.residual().is_some_and(|r| !r.is_finite()) {
                return Err(SolveFault::Overflow);
            }
            if goal != Goal::OnePass {
                if solver.residual().is_some_and(|r| r <= settings.tolerance) {
                    return Ok(StoppedBy::Tolerance);
                }
                let most = self.solver_iterations();
                if most.is_some_and(|most| solver.iterations() >= most) {
                    return Ok(StoppedBy::Iterations);
                }
            }
            if self.cancel.is_cancelled() {
                return Ok(StoppedBy::Interrupt);
            }
            let limit = settings.time_limit;
            if limit.is_some_and(|limit| self.start.elapsed() >= limit) {
                return Ok(StoppedBy::TimeLimit);
            }
            let step = solver.step(rows)?;
            let statistics = rows.statistics();
            if goal == Goal::OnePass && step.ends_iteration {
                return Ok(StoppedBy::Tolerance);
            }
            let keeps_rows = matches!(goal, Goal::Convergence | Goal::ConvergenceAmongSources);
            if keeps_rows
                && !is_shortage_said
                && let Some(shortage) = shortage(&statistics, rows.lit_count())
            {
                self.observer.remark(&shortage);
                is_shortage_said = true;
            }
            self.tell(rows);
            self.observer.progress(&Position {
                iterations: solver.iterations(),
                is_gathering: goal == Goal::OnePass,
                share_done: step.share_done,
                residual: solver.residual(),
                hemicubes: statistics.hemicubes,
                rows: statistics.drawn_rows,
                drawing: statistics.duration,
                rows_after,
            });
            if goal == Goal::Convergence && step.ends_iteration {
                let solution = || solver.snapshot();
                self.observer.iteration(solver.iterations(), &solution);
            }
            if goal != Goal::Again && last_checkpoint.elapsed() >= interval {
                self.checkpoint(&solver.snapshot(), rows);
                last_checkpoint = Instant::now();
            }
        }
    }

    /// The iterations that a solver does: where a function is asked for, its gathering is the last one.
    pub(super) fn solver_iterations(&self) -> Option<u64> {
        let most = self.settings.max_iterations;
        let gatherings = u64::from(self.settings.function().is_some());
        most.map(|most| most.saturating_sub(gatherings))
    }

    /// Hands out what there is, and keeps the rows that it came from.
    pub(super) fn checkpoint(&mut self, solution: &scene::Solution, rows: &mut RowCache) {
        let start = Instant::now();
        self.observer
            .checkpoint(solution, &mut || rows.remove_file());
        self.seconds.write += start.elapsed().as_secs_f64();
        rows.save();
        self.tell(rows);
    }

    /// Says what is to be said about files of rows.
    pub(super) fn tell(&mut self, rows: &mut RowCache) {
        for remark in rows.take_remarks() {
            self.observer.remark(&Remark::RowFile(remark));
        }
    }
}

/// What to say where rows do not fit, once as many were drawn as there are: by then it is known.
fn shortage(statistics: &RowStatistics, rows: u32) -> Option<Remark> {
    let drawn = statistics.kept_rows + statistics.left_out_rows;
    (statistics.left_out_rows > 0 && drawn >= rows.into()).then(|| Remark::Shortage {
        kept: statistics.kept_rows,
        rows,
        // A tenth more and a little: rows that were left out more than once may have weighed more in the mean.
        enough: statistics.bytes_of_all(rows) / 10 * 11 + (1 << 16),
    })
}
