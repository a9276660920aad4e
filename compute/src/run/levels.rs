//! The levels of a run: solving among coarse sources, then among patches or by gathering from sources.

use std::sync::Arc;

use scene::{Level, Provenance, Rgb, Scene, Solution, State};

use super::{Goal, Run, solver};
use crate::interrupt;
use crate::report::{SourcesReport, StoppedBy};
use crate::row_cache::{RowCache, RowStatistics};
use crate::settings::SourceArea;
use crate::solver::Solver;
use crate::two_levels::{self, GatherOnce, OnSources};

/// How a run goes on.
pub(super) enum Levels {
    /// Not at all: this has had the iterations that were asked for.
    Enough(Solution),
    /// Among all patches, from this solution.
    One(Solution),
    /// By gathering from sources.
    Two(Box<TwoLevels>),
}

/// What solving among sources has come to.
pub(super) struct TwoLevels {
    /// As a solution of the patches.
    solution: Solution,
    result: anyhow::Result<StoppedBy>,
    report: SourcesReport,
    /// Of its sources.
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

/// What a run has come to.
pub(super) struct Solved {
    pub solution: Solution,
    pub result: anyhow::Result<StoppedBy>,
    /// Where there are sources that are coarser than the patches, what is to be told of them, and their rows.
    pub sources: Option<(SourcesReport, RowStatistics)>,
}

impl Run<'_> {
    /// Solves among sources that are coarser than the patches, if there are to be any, from what the file holds;
    /// they are given as a scene of their own.
    ///
    /// # Errors
    /// A back end that does not open.
    pub(super) fn solve_among_sources(
        &mut self,
        scene: &Scene,
        solution: Option<Solution>,
    ) -> anyhow::Result<(Levels, Option<Scene>)> {
        let provenance = solution.as_ref().map(|solution| &solution.provenance);
        let had = provenance.map_or(0, |provenance| provenance.iterations);
        let most = self.settings.max_iterations;
        let is_enough = most.is_some_and(|most| had >= most);
        if is_enough && provenance.is_none_or(|provenance| provenance.level.source_area().is_none())
        {
            // Who asks for none wants the form factors.
            if most != Some(0) {
                let file = self.settings.input.display();
                eprintln!("compute: nothing to do: {file} has had {had} iterations");
            }
            // As it is: these settings have done nothing to it.
            let solution = solution.unwrap_or_else(|| self.start_from(scene, None));
            return Ok((Levels::Enough(solution), None));
        }
        let mut start = self.start_from(scene, solution);
        let residual = start.provenance.residuals.last();
        let is_solved = residual.is_some_and(|&residual| residual <= self.settings.tolerance);
        if let Level::Gathering { max_area, .. } = start.provenance.level {
            if is_solved || is_enough {
                let sources = two_levels::sources(scene, max_area);
                let levels = TwoLevels {
                    report: SourcesReport::new(sources.patch_count(), max_area),
                    result: Ok(if is_solved {
                        StoppedBy::Tolerance
                    } else {
                        StoppedBy::Iterations
                    }),
                    rows: RowStatistics::default(),
                    solution: start,
                };
                return Ok((Levels::Two(Box::new(levels)), Some(sources)));
            }
            start.provenance.level = Level::Sources { max_area };
        }
        let is_of_sources = start.provenance.level.source_area().is_some();
        match self.settings.solution.source_area {
            _ if is_solved && !is_of_sources => {}
            SourceArea::Auto if start.provenance.level == Level::PatchesAfterSources => {}
            SourceArea::AtMost(area) => {
                // No source is larger than all, and a file holds no infinity.
                let area = area.min(scene.area());
                let sources = two_levels::sources(scene, area);
                if sources.patch_count() < scene.patch_count() {
                    let levels = self.solve_on(scene, &sources, area, start, Coarser::None)?;
                    return Ok((Levels::Two(Box::new(levels)), Some(sources)));
                }
            }
            SourceArea::Auto if scene.patch_count() > two_levels::MOST_ON_ONE_LEVEL => {
                return self.try_sources(scene, start);
            }
            SourceArea::Auto | SourceArea::Patches => {}
        }
        if is_of_sources {
            let provenance = Provenance {
                level: Level::Patches,
                ..start.provenance
            };
            start = irradiances(start.irradiance, &provenance);
        }
        Ok((Levels::One(start), None))
    }

    /// Solves among finer and finer sources until the error that they bring is small, from where the file is.
    fn try_sources(
        &mut self,
        scene: &Scene,
        mut start: Solution,
    ) -> anyhow::Result<(Levels, Option<Scene>)> {
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
        for area in two_levels::areas_to_try(scene) {
            let sources = two_levels::sources(scene, area);
            let count = sources.patch_count();
            if count > scene.patch_count() / 2 {
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
            let levels = self.solve_on(scene, &sources, area, start, coarser)?;
            let error = levels.report.estimated_error;
            let is_good = error.is_some_and(|error| error <= two_levels::MOST_ERROR);
            if levels.is_stopped() || is_good {
                return Ok((Levels::Two(Box::new(levels)), Some(sources)));
            }
            coarser = Coarser::Solved(levels.solution.irradiance.clone());
            start = irradiances(levels.solution.irradiance, &provenance);
        }
        provenance.level = Level::PatchesAfterSources;
        Ok((
            Levels::One(irradiances(start.irradiance, &provenance)),
            None,
        ))
    }

    /// The irradiances, one per patch, that one after the other of some sources comes to, as it did in an earlier run that
    /// went on to `finer` ones. The output stays as it is.
    fn solve_again(
        &mut self,
        scene: &Scene,
        areas: &[f64],
        finer: &Solution,
    ) -> anyhow::Result<Again> {
        let provenance = before_sources(&finer.provenance);
        let mut irradiance = if provenance.iterations > 0 {
            // What they began with is not known any more.
            finer.irradiance.clone()
        } else {
            Solution::dark(scene).irradiance
        };
        for &area in areas {
            let sources = two_levels::sources(scene, area);
            let hemicubes = Arc::new(self.hemicubes(&sources, &sources));
            let (_, mut rows) = self.rows(&hemicubes, self.settings.memory_bytes)?;
            let make = |start| solver(self.settings.solution.solver, &sources, start);
            let start = irradiances(irradiance, &provenance);
            let mut on_sources = OnSources::new(scene, &sources, area, start, make);
            let stopped_by = self.iterate(scene, &mut on_sources, &mut rows, Goal::Again)?;
            self.drawn_before = self.drawn_before.with_drawing_of(&rows.statistics());
            if !is_end(stopped_by) {
                return Ok(Again::Stopped(stopped_by));
            }
            irradiance = on_sources.snapshot().irradiance;
        }
        Ok(Again::Solved(irradiance))
    }

    /// Solves among these sources, of at most `area`, m^2, and estimates what error they bring if there are
    /// `coarser` ones.
    fn solve_on(
        &mut self,
        scene: &Scene,
        sources: &Scene,
        area: f64,
        start: Solution,
        coarser: Coarser,
    ) -> anyhow::Result<TwoLevels> {
        let hemicubes = Arc::new(self.hemicubes(sources, sources));
        let (_, mut rows) = self.rows(&hemicubes, self.settings.memory_bytes)?;
        let make = |start| solver(self.settings.solution.solver, sources, start);
        let mut on_sources = OnSources::new(scene, sources, area, start, make);
        let result = self.iterate(scene, &mut on_sources, &mut rows, Goal::Convergence);
        let mut levels = TwoLevels {
            report: SourcesReport::new(sources.patch_count(), area),
            result,
            rows: RowStatistics::default(),
            solution: on_sources.snapshot(),
        };
        let coarser = match coarser {
            _ if levels.is_stopped() => None,
            Coarser::None => None,
            Coarser::Solved(irradiance) => Some(irradiance),
            Coarser::Earlier(areas) => match self.solve_again(scene, &areas, &levels.solution) {
                Ok(Again::Solved(irradiance)) => Some(irradiance),
                Ok(Again::Stopped(stopped_by)) => {
                    levels.result = Ok(stopped_by);
                    None
                }
                Err(error) => {
                    levels.result = Err(error);
                    None
                }
            },
        };
        if let Some(coarser) = coarser {
            let irradiance = on_sources.among_sources().irradiance;
            let coarser = two_levels::restricted(scene, sources, &coarser);
            match two_levels::estimated_error(sources, &mut rows, &irradiance, &coarser) {
                Ok(Some(error)) => levels.report.estimated_error = Some(error),
                Ok(None) => levels.result = Ok(StoppedBy::Interrupt),
                Err(error) => levels.result = Err(error.into()),
            }
        }
        levels.rows = rows.statistics();
        self.drawn_before = self.drawn_before.with_drawing_of(&levels.rows);
        // What comes next may fail before there is anything else to write.
        self.checkpoint(scene, &levels.solution, |warning| eprintln!("{warning}"));
        Ok(levels)
    }

    /// Solves among all patches, or lets them gather from solved sources, with `rows`.
    pub(super) fn solve(&mut self, levels: Levels, rows: &mut RowCache) -> Solved {
        let (scene, sources) = (rows.hemicubes().receivers(), rows.hemicubes().sources());
        let levels = match levels {
            Levels::Enough(solution) => {
                let stopped_by = if interrupt::requested() {
                    StoppedBy::Interrupt
                } else {
                    StoppedBy::Iterations
                };
                return Solved {
                    solution,
                    result: Ok(stopped_by),
                    sources: None,
                };
            }
            Levels::One(start) => {
                let mut solver = solver(self.settings.solution.solver, scene, start);
                return Solved {
                    result: self.iterate(scene, solver.as_mut(), rows, Goal::Convergence),
                    solution: solver.snapshot(),
                    sources: None,
                };
            }
            Levels::Two(levels) => *levels,
        };
        let is_stopped = levels.is_stopped();
        let TwoLevels {
            mut solution,
            mut result,
            mut report,
            rows: rows_of_sources,
        } = levels;
        if !is_stopped {
            let mut gather = GatherOnce::new(scene, sources, report.max_area, solution);
            match self.iterate(scene, &mut gather, rows, Goal::OnePass) {
                // The sources' reason is the run's.
                Ok(StoppedBy::Tolerance) => {}
                stopped => result = stopped,
            }
            report.gathered_share = gather.share_done();
            solution = gather.snapshot();
        }
        Solved {
            solution,
            result,
            sources: Some((report, rows_of_sources)),
        }
    }
}

impl Levels {
    /// The solution of the patches from which the run goes on.
    pub(super) fn start(&self) -> &Solution {
        match self {
            Self::Enough(start) | Self::One(start) => start,
            Self::Two(levels) => &levels.solution,
        }
    }
}

impl TwoLevels {
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
fn irradiances(irradiance: Vec<Rgb>, provenance: &Provenance) -> Solution {
    Solution {
        irradiance,
        provenance: provenance.clone(),
        state: State::AtRest,
    }
}
