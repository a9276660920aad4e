//! The end of a run: the irradiance function, if one is asked for, and what the solution is worth.

use scene::function::IrradianceFunction;
use scene::{Solution, SurfaceId};

use super::{Run, SolveError, SolveFault, Solved, SourcesReport, StoppedBy};
use crate::certificate;
use crate::energy;
use crate::function::{self, FunctionFault, FunctionReport, Order};
use crate::problem::Problem;
use crate::row_cache::{RowCache, RowStatistics};
use crate::settings::Target;
use crate::solver::ambient_radiosity;
use crate::solver::convergence::Convergence;

impl<'a> Run<'a, '_> {
    /// What a solution is worth that the run has come to. `of_sources` is what there is to tell of coarser sources, and
    /// their rows.
    pub(super) fn finish(
        &mut self,
        mut solution: Solution,
        result: Result<StoppedBy, SolveFault>,
        rows: &mut RowCache,
        of_sources: Option<(SourcesReport, RowStatistics)>,
    ) -> Result<Solved, SolveError> {
        let with = |solution: &Solution, cause| SolveError {
            cause,
            solution: Some(Box::new(solution.clone())),
        };
        let mut stopped_by = result.map_err(|cause| with(&solution, cause))?;
        let is_over = !matches!(stopped_by, StoppedBy::Interrupt | StoppedBy::TimeLimit);
        if self.settings.all_rows && is_over {
            let drawn = rows.draw_missing();
            if drawn.is_err() || self.cancel.is_cancelled() {
                rows.save();
            } else {
                rows.flush();
            }
            self.tell(rows);
            drawn.map_err(|error| with(&solution, error.into()))?;
            if self.cancel.is_cancelled() {
                stopped_by = StoppedBy::Interrupt;
            }
        }
        let statistics = rows.statistics().with_drawing_of(&self.drawn_before);
        let kept = of_sources.map_or(statistics, |(_, rows)| rows);
        let mut function = None;
        if let Some(target) = self.settings.target
            && is_over
            && !self.cancel.is_cancelled()
        {
            match self.function(rows, &solution, target) {
                Ok(Some((gathered, report))) => {
                    solution.function = Some(gathered);
                    function = Some(report);
                }
                Ok(None) => stopped_by = StoppedBy::Interrupt,
                Err(error) => return Err(with(&solution, error.into())),
            }
        }
        let duration = statistics.duration;
        self.seconds.draw = duration.as_secs_f64();
        self.seconds.write += statistics.files.as_secs_f64();
        self.seconds.finish(self.start.elapsed());
        let inside = certificate::inside(rows, &solution);
        let known = inside.as_deref();
        let (energy, closure, back_face_share) =
            energy::measure(self.scene, &solution, rows, known.unwrap_or_default());
        let residuals = &solution.provenance.residuals;
        let solver = self.settings.solution.solver;
        let ambient = ambient_radiosity(&Problem::new(self.scene), &solution);
        Ok(Solved {
            radiosity: solution.radiosity(self.scene),
            certificate: certificate::certify(
                rows,
                known,
                energy.imbalance,
                residuals.last().copied(),
            ),
            stopped_by,
            backend: rows.backend(),
            adapter: rows.describe_source(),
            trial: self.trial,
            unlit_patches: self.scene.patch_count() - rows.lit_count(),
            rows: RowStatistics {
                hemicubes: statistics.hemicubes,
                duration,
                read_rows: statistics.read_rows,
                files: statistics.files,
                ..kept
            },
            sources: of_sources.map(|(report, _)| report),
            seconds: self.seconds,
            iterations_before: 0,
            convergence: Convergence::new(solver, residuals),
            ambient_radiosity: ambient.map(Into::into),
            energy,
            closure,
            back_face_share,
            function,
            inside,
            solution,
        })
    }

    /// The irradiance function of a solution whose rows these are. `None` where it is cancelled.
    fn function(
        &self,
        rows: &RowCache<'a>,
        solution: &Solution,
        target: Target,
    ) -> Result<Option<(IrradianceFunction, FunctionReport)>, FunctionFault> {
        let trees = self.scene.mesh().trees();
        let is_lit = |surface: SurfaceId| {
            let mut patches = trees[surface.index()].patches();
            patches.any(|patch| !rows.unlit()[patch as usize])
        };
        let limit = self.settings.time_limit;
        let is_late = |more| limit.is_some_and(|limit| self.start.elapsed() + more >= limit);
        let sources = rows.sources().clone();
        let residuals = &solution.provenance.residuals;
        let convergence = Convergence::new(self.settings.solution.solver, residuals);
        // After the first iteration nothing is known.
        let iterations = convergence.map_or(1.0, |convergence| convergence.estimated_error);
        let order = Order {
            target,
            iterations,
            is_lit: &is_lit,
            is_late: &is_late,
            cancel: &self.cancel,
        };
        function::gather(&self.form_factors, sources, solution, &order)
    }
}
