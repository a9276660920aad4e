//! The end of a run: the irradiance function, if one is asked for, and what the solution is worth.

use scene::layers::{Layer, Layers};
use scene::{PatchId, Solution, State, SurfaceId};

use super::corrected::{Corrected, Uncorrected};
use super::levels::irradiances;
use super::{Run, SolveError, SolveFault, Solved, SourcesReport, StoppedBy};
use crate::certificate::{self, Certificate, Known};
use crate::energy::{self, Closure, Energy};
use crate::function::{self, FunctionFault, Gathered, MeansOfPatches, Order, Resolve, SourceLayer};
use crate::problem::Problem;
use crate::receivers::ReceiverId;
use crate::row_cache::{RowCache, RowStatistics};
use crate::rows::BackendError;
use crate::settings::{Target, Wanted};
use crate::solver::ambient_radiosity;
use crate::solver::convergence::Convergence;
use crate::sources::Sources;

/// What an error is asked for of.
enum Refined {
    Function(Gathered),
    Means(MeansOfPatches),
}

/// What there is to say of rows and a solution.
struct Worth {
    energy: Energy,
    closure: Option<Closure>,
    back_face_share: Option<f64>,
    certificate: Certificate,
    unlit: Vec<PatchId>,
    inside: Option<Vec<PatchId>>,
}

impl<'a> Run<'a, '_> {
    /// What a solution is worth that the run has come to. `of_sources` is what there is to tell of coarser sources, and
    /// of their rows, if these are not they.
    pub(super) fn finish<'s>(
        &mut self,
        mut solution: Solution,
        result: Result<StoppedBy, SolveFault>,
        rows: &mut RowCache<'s>,
        of_sources: Option<(SourcesReport, Option<RowStatistics>)>,
    ) -> Result<Solved, SolveError>
    where
        'a: 's,
    {
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
        let mut function = None;
        if let Some(target) = self.settings.target
            && is_over
            && !self.cancel.is_cancelled()
        {
            let is_converged = stopped_by == StoppedBy::Tolerance;
            match self.refine(rows, &solution, target, is_converged) {
                Ok(Some(Refined::Means(means))) => {
                    solution.irradiance = means.irradiance;
                    solution.state = State::AtRest;
                    function = Some(means.report);
                }
                // A run that goes on gathers anew from the irradiances as they were solved.
                Ok(Some(Refined::Function(gathered))) if gathered.is_interrupted() => {
                    solution.function = Some(gathered.function);
                    function = Some(gathered.report);
                    stopped_by = StoppedBy::Interrupt;
                }
                Ok(Some(Refined::Function(gathered))) => {
                    solution.irradiance = gathered.irradiance;
                    solution.state = State::AtRest;
                    solution.function = Some(gathered.function);
                    solution.layers = self.layers(gathered.layers);
                    let next = solution.provenance.iterations.saturating_add(1);
                    if self.settings.max_iterations == Some(next) && !is_converged {
                        // Which patches have then had, too.
                        solution.provenance.iterations = next;
                        solution.irradiance = solution.mean_irradiance(self.scene);
                    }
                    function = Some(gathered.report);
                }
                Ok(None) => stopped_by = StoppedBy::Interrupt,
                Err(error) => return Err(with(&solution, error.into())),
            }
        }
        let is_asked = self.settings.layers.is_some() && self.settings.function().is_none();
        if is_asked && is_over {
            let layers = self.layers_of_patches(rows, &solution);
            solution.layers = layers.map_err(|error| with(&solution, error.into()))?;
        }
        let statistics = rows.statistics().with_drawing_of(&self.drawn_before);
        let kept = of_sources.map_or(statistics, |(_, rows)| rows.unwrap_or(statistics));
        let duration = statistics.duration;
        self.seconds.draw = duration.as_secs_f64();
        self.seconds.write += statistics.files.as_secs_f64();
        self.seconds.finish(self.start.elapsed());
        let has_estimate = function.is_some_and(|function| function.error.is_some());
        let worth = self.worth(rows, &solution, has_estimate);
        let residuals = &solution.provenance.residuals;
        let solver = self.settings.solution.solver;
        let ambient = ambient_radiosity(&Problem::new(self.scene), &solution);
        Ok(Solved {
            radiosity: solution.radiosity(self.scene),
            certificate: worth.certificate,
            stopped_by,
            backend: rows.backend(),
            adapter: rows.describe_source(),
            trial: self.trial,
            unlit_patches: worth.unlit.len() as u32,
            unlit: worth.unlit,
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
            energy: worth.energy,
            closure: worth.closure,
            back_face_share: worth.back_face_share,
            function,
            inside: worth.inside,
            solution,
        })
    }

    /// The layers that are asked for of patches that were solved among themselves; `None` of others, and where it is cancelled.
    fn layers_of_patches(
        &self,
        rows: &mut RowCache,
        solution: &Solution,
    ) -> Result<Option<Layers>, BackendError> {
        if self.cancel.is_cancelled() || !rows.sources().are_patches() {
            return Ok(None);
        }
        let mut solved = Corrected::new(rows, solution.irradiance.clone(), self.settings.tolerance)
            .with_layers(self.settings.layers);
        let layers = solved.layers()?;
        Ok(self.layers(layers.map(|layers| layers.into_iter().map(of_patches).collect())))
    }

    /// Layers as they are asked for.
    fn layers(&self, layers: Option<Vec<Layer>>) -> Option<Layers> {
        let kind = self.settings.layers?;
        // Nothing emits in a scene without lamps.
        let layers = layers.filter(|layers| !layers.is_empty())?;
        Some(Layers { kind, layers })
    }

    /// What rows and a solution of the patches are worth. `has_estimate` says whether the error of its function is known.
    fn worth(&self, rows: &RowCache<'_>, solution: &Solution, has_estimate: bool) -> Worth {
        let are_patches = rows.sources().patches().patch_count() == self.scene.patch_count();
        // What receivers are made of, where they are coarser than the patches.
        let receivers =
            (!are_patches).then(|| Sources::drawn_as(self.scene, rows.sources().drawable()));
        let of_receivers = receivers.as_ref().map(|receivers| Solution {
            irradiance: receivers.restricted(&solution.irradiance),
            ..irradiances(Vec::new(), &solution.provenance)
        });
        let of_receivers = of_receivers.as_ref().unwrap_or(solution);
        let inside = certificate::inside(rows, of_receivers);
        let (energy, closure, back_face_share) = energy::measure(
            rows.sources().patches(),
            of_receivers,
            rows,
            inside.as_deref().unwrap_or_default(),
        );
        let known = Known {
            inside: inside.as_deref(),
            imbalance: energy.imbalance,
            residual: solution.provenance.residuals.last().copied(),
            has_estimate,
            patches: receivers.as_ref(),
        };
        let unlit = (0..).zip(rows.unlit()).filter(|&(_, &is_unlit)| is_unlit);
        Worth {
            energy,
            closure,
            back_face_share,
            certificate: certificate::certify(rows, known),
            unlit: unlit
                .flat_map(|(k, _)| known.patches_in(k).map(PatchId))
                .collect(),
            inside: inside.as_ref().map(|inside| {
                let patches = inside.iter().flat_map(|k| known.patches_in(k.index()));
                patches.map(PatchId).collect()
            }),
        }
    }

    /// What an error is asked for of, made of a solution whose rows these are. `None` where it is cancelled.
    fn refine<'s>(
        &mut self,
        rows: &mut RowCache<'s>,
        solution: &Solution,
        target: Target,
        is_converged: bool,
    ) -> Result<Option<Refined>, FunctionFault>
    where
        'a: 's,
    {
        let trees = rows.sources().patches().mesh().trees();
        let unlit = rows.unlit().to_vec();
        let is_lit = |surface: SurfaceId| {
            let mut patches = trees[surface.index()].patches();
            patches.any(|patch| !unlit[patch as usize])
        };
        let limit = self.settings.time_limit;
        let start = self.start;
        let is_late = |more| limit.is_some_and(|limit| start.elapsed() + more >= limit);
        let observer = &mut *self.observer;
        let mut tell = |vertices, error| observer.function(vertices, error);
        let residuals = &solution.provenance.residuals;
        let convergence = Convergence::new(self.settings.solution.solver, residuals);
        let iterations = match convergence {
            Some(convergence) => Some(convergence.estimated_error),
            // Nothing has changed.
            None if residuals.last() == Some(&0.0) => Some(0.0),
            None => None,
        };
        let order = Order {
            target,
            iterations,
            is_lit: &is_lit,
            is_late: &is_late,
            all_gather: !is_converged,
            cancel: &self.cancel,
        };
        let sources = Sources::drawn_as(self.scene, rows.sources().drawable());
        let irradiance = sources.restricted(&solution.irradiance);
        let form_factors = self.form_factors.of_scene(self.scene);
        let tolerance = self.settings.tolerance;
        let receivers = rows.hemicubes().receivers();
        let points = |k| receivers.point_count(ReceiverId(k));
        let points: Vec<u32> = match target.of {
            Wanted::Function => Vec::new(),
            Wanted::Means | Wanted::MeansAtPoints => (0..receivers.count()).map(points).collect(),
        };
        let mut corrected;
        let resolve: &mut dyn Resolve = if is_converged && rows.sources().are_patches() {
            corrected = Corrected::new(rows, irradiance.clone(), tolerance)
                .with_layers(self.settings.layers);
            &mut corrected
        } else {
            &mut Uncorrected
        };
        if target.of != Wanted::Function {
            let means = function::means_of_patches(
                &form_factors,
                &sources,
                &solution.irradiance,
                &points,
                &order,
                resolve,
            )?;
            return Ok(means.map(Refined::Means));
        }
        let gathered = function::gather(
            &form_factors,
            &sources,
            &irradiance,
            &order,
            resolve,
            &mut tell,
        )?;
        Ok(gathered.map(Refined::Function))
    }
}

/// A layer of sources that are the patches.
fn of_patches(layer: SourceLayer) -> Layer {
    Layer {
        name: layer.name,
        lamp: layer.lamp,
        irradiance: layer.irradiance,
        vertices: Vec::new(),
    }
}
