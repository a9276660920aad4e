//! Levels: solving among coarse sources, then among patches or by gathering from the sources.

use std::sync::Arc;

use scene::{Level, Provenance, Rgb, Scene, Solution, State};
use visibility::Drawable;

use super::iterate::Goal;
use super::{Remark, Run, SolveError, SolveFault, Solved, SourcesReport, StoppedBy};
use crate::form_factors::{FormFactors, Levels, Needed};
use crate::row_cache::{RowCache, RowStatistics};
use crate::solver::Solver;
use crate::sources::Sources;
use crate::two_levels::{self, GatherOnce, OnSources};

/// How a run goes on.
pub(super) enum Next {
    /// Not at all: this has had the iterations that were asked for.
    Nothing(Solution),
    /// Among all patches, from this solution.
    Patches(Solution),
    /// The patches gather from sources.
    Gather(Box<OfSources>),
    /// Among sources of at most this area, m^2, from this solution, and then the function is gathered from them.
    Function(f64, Solution),
}

/// What solving among sources has come to.
pub(super) struct OfSources {
    /// As a solution of the patches.
    solution: Solution,
    result: Result<StoppedBy, SolveFault>,
    report: SourcesReport,
    rows: RowStatistics,
}

/// What is known of coarser sources than those to be solved among.
enum Coarser {
    /// There are none.
    None,
    /// Their irradiances, one per patch.
    Solved(Vec<Rgb>),
    /// That an earlier run has solved among such of at most these areas, m^2, one after the other.
    Earlier(Vec<f64>),
}

impl Coarser {
    /// An earlier run has solved among these, too.
    fn and_earlier(self, area: f64) -> Self {
        let mut areas = match self {
            Self::Earlier(areas) => areas,
            Self::None | Self::Solved(_) => Vec::new(),
        };
        areas.push(area);
        Self::Earlier(areas)
    }
}

/// What solving once more has come to.
enum Again {
    /// Irradiances, one per patch.
    Solved(Vec<Rgb>),
    Stopped(StoppedBy),
}

impl<'a> Run<'a, '_> {
    /// Goes on from `start` as far as there are coarser sources to be solved among.
    pub(super) fn begin(&mut self, start: Option<Solution>) -> Result<Next, SolveError> {
        let provenance = start.as_ref().map(|start| &start.provenance);
        let had = provenance.map_or(0, |provenance| provenance.iterations);
        let most = self.settings.max_iterations;
        let is_enough = most.is_some_and(|most| had >= most);
        // Among sources, unless vertices have gathered from them, that is not the end.
        let is_at_end = start.as_ref().is_none_or(|start| {
            start.function.is_some() || start.provenance.level.source_area().is_none()
        });
        if is_enough && is_at_end {
            // Who asks for none wants the form factors.
            if most != Some(0) {
                self.observer.remark(&Remark::NothingToDo(had));
            }
            // As it is: these settings have done nothing to it.
            return Ok(Next::Nothing(match start {
                Some(start) => start,
                None => self.start_from(None),
            }));
        }
        let mut start = self.start_from(start);
        let residual = start.provenance.residuals.last();
        let is_solved = residual.is_some_and(|&residual| residual <= self.settings.tolerance);
        let has_function = self.settings.function().is_some();
        if let Level::Gathering { max_area, .. } = start.provenance.level {
            if (is_solved || is_enough) && !has_function {
                let sources = two_levels::sources(self.scene, max_area);
                return Ok(Next::Gather(Box::new(OfSources {
                    report: SourcesReport::new(sources.patch_count(), max_area),
                    result: Ok(if is_solved {
                        StoppedBy::Tolerance
                    } else {
                        StoppedBy::Iterations
                    }),
                    rows: RowStatistics::default(),
                    solution: start,
                })));
            }
            start.provenance.level = Level::Sources { max_area };
        }
        let is_of_sources = start.provenance.level.source_area().is_some();
        let source_area = self.settings.solution.source_area;
        let levels = match self.settings.function() {
            Some(target) => self.form_factors.levels_of_function(source_area, target),
            None => self.form_factors.levels(source_area),
        };
        match levels {
            Levels::Sources(area) if has_function => {
                if start.provenance.level.source_area() != Some(area) {
                    let provenance = before_sources(&start.provenance);
                    start = irradiances(start.irradiance, &provenance);
                }
                return Ok(Next::Function(area, start));
            }
            _ if is_solved && !is_of_sources => {}
            Levels::Automatic if start.provenance.level == Level::PatchesAfterSources => {}
            Levels::Sources(area) => {
                let sources = two_levels::sources(self.scene, area);
                let solved = self.solve_on(&sources, area, start, Coarser::None)?;
                return Ok(Next::Gather(Box::new(solved)));
            }
            Levels::Automatic => return self.try_sources(start),
            Levels::Patches => {}
        }
        if is_of_sources {
            let provenance = Provenance {
                level: Level::Patches,
                ..start.provenance
            };
            start = irradiances(start.irradiance, &provenance);
        }
        Ok(Next::Patches(start))
    }

    /// Solves among finer and finer sources until the error that they bring is small, from where the start is.
    fn try_sources(&mut self, mut start: Solution) -> Result<Next, SolveError> {
        let under_way = start.provenance.level.source_area();
        let mut provenance = before_sources(&start.provenance);
        if under_way.is_none() {
            // Those of a solution that has been gathered count.
            provenance.iterations = start.provenance.iterations;
            start = irradiances(start.irradiance, &provenance);
        }
        // How many sources were tried before, and what is known of them.
        let mut before = None;
        let mut coarser = Coarser::None;
        for area in two_levels::areas_to_try(self.scene) {
            let sources = two_levels::sources(self.scene, area);
            let count = sources.patch_count();
            if count > self.scene.patch_count() / 2 {
                break;
            }
            if before.is_some_and(|before| !two_levels::is_refinement(count, before)) {
                continue;
            }
            before = Some(count);
            if under_way.is_some_and(|under_way| area > under_way) {
                coarser = coarser.and_earlier(area);
                continue;
            }
            let solved = self.solve_on(&sources, area, start, coarser)?;
            let error = solved.report.estimated_error;
            let is_good = error.is_some_and(|error| error <= two_levels::MOST_ERROR);
            if solved.is_stopped() || is_good {
                return Ok(Next::Gather(Box::new(solved)));
            }
            coarser = Coarser::Solved(solved.solution.irradiance.clone());
            start = irradiances(solved.solution.irradiance, &provenance);
        }
        provenance.level = Level::PatchesAfterSources;
        Ok(Next::Patches(irradiances(start.irradiance, &provenance)))
    }

    /// The irradiances, one per patch, that one after the other of some sources comes to, as it did in an earlier run that
    /// went on to `finer` ones. No checkpoint is handed out.
    fn solve_again(&mut self, areas: &[f64], finer: &Solution) -> Result<Again, SolveFault> {
        let provenance = before_sources(&finer.provenance);
        let mut irradiance = if provenance.iterations > 0 {
            // What they began with is not known any more.
            finer.irradiance.clone()
        } else {
            Solution::dark(self.scene).irradiance
        };
        for &area in areas {
            let coarse = two_levels::sources(self.scene, area);
            let start = irradiances(irradiance, &provenance);
            // No file: that is of the finer sources.
            let form_factors = self.form_factors.of_scene(&coarse).with_row_files(None);
            let (mut solver, mut rows) = self.open_on(&form_factors, area, start)?;
            let stopped_by = self.iterate(&mut solver, &mut rows, Goal::Again)?;
            self.drawn_before = self.drawn_before.with_drawing_of(&rows.statistics());
            if !is_end(stopped_by) {
                return Ok(Again::Stopped(stopped_by));
            }
            irradiance = solver.snapshot().irradiance;
        }
        Ok(Again::Solved(irradiance))
    }

    /// A solver among coarse sources of at most `area`, m^2, whose form factors are given, that goes on from `start`, and
    /// their rows.
    fn open_on<'s>(
        &mut self,
        form_factors: &FormFactors<'s>,
        area: f64,
        start: Solution,
    ) -> Result<(OnSources<'s>, RowCache<'s>), SolveFault>
    where
        'a: 's,
    {
        let coarse = form_factors.scene();
        let drawable = Arc::new(Drawable::new(coarse));
        let among_themselves = Sources::drawn_as(coarse, &drawable);
        let rows = self.open(form_factors, among_themselves, Needed::All)?;
        let make = |start| self.solver(coarse, start);
        let sources = Sources::drawn_as(self.scene, &drawable);
        let start = self.recorded(start);
        Ok((OnSources::new(sources, area, start, make), rows))
    }

    /// Solves among coarse sources of at most `area`, m^2, and estimates what error they bring if there are `coarser`
    /// ones.
    fn solve_on(
        &mut self,
        coarse: &Scene,
        area: f64,
        start: Solution,
        coarser: Coarser,
    ) -> Result<OfSources, SolveError> {
        let form_factors = self.form_factors.of_scene(coarse);
        // What coarser sources have come to.
        let before = start.irradiance.iter().any(|&h| h != Rgb::ZERO);
        let before = before.then(|| Box::new(start.clone()));
        let opened = self.open_on(&form_factors, area, start);
        let (mut solver, mut rows) = opened.map_err(|cause| SolveError {
            cause,
            solution: before,
        })?;
        let result = self.iterate(&mut solver, &mut rows, Goal::ConvergenceAmongSources);
        let mut solved = OfSources {
            report: SourcesReport::new(coarse.patch_count(), area),
            result,
            rows: RowStatistics::default(),
            solution: solver.snapshot(),
        };
        let coarser = match coarser {
            _ if solved.is_stopped() => None,
            Coarser::None => None,
            Coarser::Solved(irradiance) => Some(irradiance),
            Coarser::Earlier(areas) => match self.solve_again(&areas, &solved.solution) {
                Ok(Again::Solved(irradiance)) => Some(irradiance),
                Ok(Again::Stopped(stopped_by)) => {
                    solved.result = Ok(stopped_by);
                    None
                }
                Err(error) => {
                    solved.result = Err(error);
                    None
                }
            },
        };
        if let Some(coarser) = coarser {
            let irradiance = solver.among_sources().irradiance;
            let coarser = solver.sources().restricted(&coarser);
            match two_levels::estimated_error(&mut rows, &irradiance, &coarser) {
                Ok(Some(error)) => solved.report.estimated_error = Some(error),
                Ok(None) => solved.result = Ok(StoppedBy::Interrupt),
                Err(error) => solved.result = Err(error.into()),
            }
        }
        solved.rows = rows.statistics();
        self.drawn_before = self.drawn_before.with_drawing_of(&solved.rows);
        // What comes next may fail before there is anything else to write.
        self.checkpoint(&solved.solution, &mut rows);
        Ok(solved)
    }

    /// Solves among sources of at most `area`, m^2, from `start`, and gathers the function from them.
    pub(super) fn function_of_sources(
        &mut self,
        area: f64,
        start: Solution,
    ) -> Result<Solved, SolveError> {
        let coarse = two_levels::sources(self.scene, area);
        let form_factors = self.form_factors.of_scene(&coarse);
        let (mut solver, mut rows) = self.open_on(&form_factors, area, start)?;
        let result = self.iterate(&mut solver, &mut rows, Goal::ConvergenceAmongSources);
        let report = SourcesReport {
            gathered_share: None,
            ..SourcesReport::new(coarse.patch_count(), area)
        };
        self.finish(solver.snapshot(), result, &mut rows, Some((report, None)))
    }

    /// Lets the patches gather from solved sources, unless something has stopped these.
    pub(super) fn gather(&mut self, of_sources: OfSources) -> Result<Solved, SolveError> {
        let is_stopped = of_sources.is_stopped();
        let OfSources {
            mut solution,
            mut result,
            mut report,
            rows: rows_of_sources,
        } = of_sources;
        if let Err(cause) = result {
            let solution = Some(Box::new(solution));
            return Err(SolveError { cause, solution });
        }
        let coarse = two_levels::sources(self.scene, report.max_area);
        let sources = Sources::coarse(self.scene, &coarse);
        let needed = self.needed(&solution);
        let opened = self.open(&self.form_factors.clone(), sources, needed);
        let mut rows = opened.map_err(|error| SolveError {
            cause: error.into(),
            solution: Some(Box::new(solution.clone())),
        })?;
        if !is_stopped {
            let start = self.recorded(solution);
            let mut gather = GatherOnce::new(rows.sources(), report.max_area, start);
            match self.iterate(&mut gather, &mut rows, Goal::OnePass) {
                // The sources' reason is the run's.
                Ok(StoppedBy::Tolerance) => {}
                stopped => result = stopped,
            }
            report.gathered_share = Some(gather.share_done());
            solution = gather.snapshot();
        }
        let of_sources = Some((report, Some(rows_of_sources)));
        self.finish(solution, result, &mut rows, of_sources)
    }
}

impl OfSources {
    /// True where something has stopped the sources' solver before its end.
    fn is_stopped(&self) -> bool {
        !self.result.as_ref().is_ok_and(|&reason| is_end(reason))
    }
}

/// True where a solver has come to the end that it was to come to.
fn is_end(stopped_by: StoppedBy) -> bool {
    matches!(stopped_by, StoppedBy::Tolerance | StoppedBy::Iterations)
}

/// What is known of a solution among some sources is not so among others, but for its irradiances: this is what
/// the next ones begin with.
fn before_sources(provenance: &Provenance) -> Provenance {
    let iterations = provenance.residuals.len() as u64;
    Provenance {
        iterations: provenance.iterations.saturating_sub(iterations),
        residuals: Vec::new(),
        level: Level::Patches,
        ..provenance.clone()
    }
}

/// A solution of which no more is known.
pub(super) fn irradiances(irradiance: Vec<Rgb>, provenance: &Provenance) -> Solution {
    Solution {
        irradiance,
        provenance: provenance.clone(),
        state: State::AtRest,
        function: None,
        layers: None,
    }
}
