//! Solving a scene: the library's entrance.
//!
//! [`Solve`] says what is solved and how, [`Solve::run`] does it, [`Solved`] has the solution and what it is worth. A run
//! is watched by an [`Observer`] and stopped by a [`CancelToken`]. Form factors come from [`FormFactors`]; a scene is
//! solved among its patches, or among coarser sources from which the patches then gather (`levels.rs`).

mod corrected;
mod finish;
mod iterate;
mod layers;
mod levels;
mod observer;
mod on_stand_in;
mod outcome;
mod start;

use std::time::Instant;

use scene::{PatchId, Rgb, Scene, SceneError, Solution};
use visibility::hemicube::MAX_RESOLUTION;

use crate::backend::Trial;
use crate::cancel::CancelToken;
use crate::certificate::Certificate;
use crate::energy::{Closure, Energy};
use crate::form_factors::{FormFactors, Needed};
use crate::function::{FunctionFault, FunctionReport};
use crate::problem::Problem;
use crate::row_cache::{RowCache, RowStatistics};
use crate::row_file::{RowFileRemark, RowFiles};
use crate::rows::BackendError;
use crate::settings::{Points, SolveSettings, SolverChoice};
use crate::solver::convergence::Convergence;
use crate::solver::{Gather, Shoot, Solver, StartUp, Update};
use crate::sources::Sources;
use iterate::Goal;
use levels::Next;

pub use observer::{Observer, Position, Remark};
pub use outcome::{Seconds, SourcesReport, StoppedBy};

/// Why a scene could not be solved to the end.
#[derive(Debug, thiserror::Error)]
#[error("{cause}")]
pub struct SolveError {
    /// What went wrong.
    #[source]
    pub cause: SolveFault,
    /// What was solved until then; `None` where nothing was begun.
    pub solution: Option<Box<Solution>>,
}

/// What can go wrong.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum SolveFault {
    #[error(transparent)]
    Backend(#[from] BackendError),
    #[error(transparent)]
    Function(#[from] FunctionFault),
    #[error("radiosities are beyond what f32 holds, 3e38 W/m^2; lower the emission")]
    Overflow,
    #[error("resolution {value} must be an even number from 2 to {MAX_RESOLUTION}")]
    Resolution { value: u32 },
    #[error("the start is no solution of the scene: {0}")]
    Start(SceneError),
}

impl<E: Into<SolveFault>> From<E> for SolveError {
    fn from(error: E) -> Self {
        Self {
            cause: error.into(),
            solution: None,
        }
    }
}

/// A scene to be solved.
///
/// ```
/// # let scene = genx::make(&genx::Settings::new(genx::Model::Furnace)).unwrap().scene;
/// let solved = compute::Solve::new(&scene).resolution(32).run()?;
/// assert!(solved.certificate().violations.is_empty());
/// let radiosity = solved.radiosity();
/// # assert_eq!(radiosity.len(), scene.patch_count() as usize);
/// # Ok::<(), compute::solve::SolveError>(())
/// ```
pub struct Solve<'a> {
    scene: &'a Scene,
    start: Option<Solution>,
    settings: SolveSettings,
    cancel: CancelToken,
    observer: Option<&'a mut dyn Observer>,
    /// Rows that somebody has drawn already.
    rows: Option<RowCache<'a>>,
    row_files: Option<RowFiles>,
}

/// A solution and what it is worth.
#[derive(Clone, Debug)]
pub struct Solved {
    solution: Solution,
    /// One per patch, W/m^2.
    radiosity: Vec<Rgb>,
    certificate: Certificate,
    /// Why it ended.
    pub stopped_by: StoppedBy,
    /// The back end's name, `cpu` or `gpu`.
    pub backend: &'static str,
    /// Threads, or the adapter's name.
    pub adapter: String,
    /// What the back ends were compared by before one was taken; `None` where no GPU was tried.
    pub trial: Option<Trial>,
    /// Patches that no light can reach, whose rows were neither needed nor drawn.
    pub unlit_patches: u32,
    /// Which they are, ascending.
    unlit: Vec<PatchId>,
    /// What drawing has cost; of the rows that are kept, those that the iterations used.
    pub rows: RowStatistics,
    /// The sources, where they are coarser than the patches.
    pub sources: Option<SourcesReport>,
    /// Seconds by stage.
    pub seconds: Seconds,
    /// Iterations that the start has had.
    pub iterations_before: u64,
    /// What the residuals tell of the way that is left; `None` where there are too few of them.
    pub convergence: Option<Convergence>,
    /// What a radiosity is likely to lack, over the patch's reflectance, W/m^2; shooting only.
    pub ambient_radiosity: Option<[f64; 3]>,
    /// Power balance.
    pub energy: Energy,
    /// Row sums; `None` where no row was drawn.
    pub closure: Option<Closure>,
    /// Mean share of a hemisphere that sees back faces, by area; `None` as above.
    pub back_face_share: Option<f64>,
    /// What the irradiance function came to; `None` where none was asked for, or the run ended before.
    pub function: Option<FunctionReport>,
    /// The patches that lie inside of solids, ascending; `None` unless all rows of lit patches were drawn, and before the
    /// solution is near its end.
    pub inside: Option<Vec<PatchId>>,
}

impl<'a> Solve<'a> {
    /// A scene, to be solved among its patches, as the program `compute` does by `--quality mesh`; see
    /// [`Quality::settings`](crate::settings::Quality::settings) for others.
    pub fn new(scene: &'a Scene) -> Self {
        Self {
            scene,
            start: None,
            settings: SolveSettings::default(),
            cancel: CancelToken::new(),
            observer: None,
            rows: None,
            row_files: None,
        }
    }

    /// All settings at once.
    #[must_use]
    pub fn settings(mut self, settings: SolveSettings) -> Self {
        self.settings = settings;
        self
    }

    /// Pixels along a hemicube's face: even, 2 to 4096.
    #[must_use]
    pub fn resolution(mut self, resolution: u32) -> Self {
        self.settings.solution.form_factors.resolution = resolution;
        self
    }

    /// Where a patch's hemicubes stand.
    #[must_use]
    pub fn points(mut self, points: Points) -> Self {
        self.settings.solution.form_factors.points = points;
        self
    }

    /// How the equation is solved.
    #[must_use]
    pub fn solver(mut self, solver: SolverChoice) -> Self {
        self.settings.solution.solver = solver;
        self
    }

    /// The relative residual to stop at, dimensionless.
    #[must_use]
    pub fn tolerance(mut self, tolerance: f64) -> Self {
        self.settings.tolerance = tolerance;
        self
    }

    /// The iterations to stop after, those that the start has had included.
    #[must_use]
    pub fn iterations(mut self, iterations: u64) -> Self {
        self.settings.max_iterations = Some(iterations);
        self
    }

    /// Goes on from a solution of the scene. One that was made with other settings gives its irradiances alone.
    #[must_use]
    pub fn start(mut self, start: Option<Solution>) -> Self {
        self.start = start;
        self
    }

    /// Rows of [`FormFactors::rows`] that are drawn already, in part or all, with these settings.
    #[must_use]
    pub fn rows(mut self, rows: Option<RowCache<'a>>) -> Self {
        self.rows = rows;
        self
    }

    /// Looks for rows in these files, and keeps there what is drawn, so that a run that goes on need not draw it again. They
    /// stay: once the solution is safe, [`row_file::remove`](crate::row_file::remove) takes them away. Without them no row
    /// is written.
    #[must_use]
    pub fn row_files(mut self, files: Option<RowFiles>) -> Self {
        self.row_files = files;
        self
    }

    /// Stops the run where the token says so.
    #[must_use]
    pub fn cancel(mut self, cancel: &CancelToken) -> Self {
        self.cancel = cancel.clone();
        self
    }

    /// Tells somebody how the run goes.
    #[must_use]
    pub fn observer(mut self, observer: &'a mut dyn Observer) -> Self {
        self.observer = Some(observer);
        self
    }

    /// Solves the scene, on the threads of the rayon pool it is called in.
    ///
    /// # Errors
    /// A resolution that is none and a start that is no solution of the scene; a back end that does not open or cannot go
    /// on, and radiosities that no f32 holds. The error has what was solved until then.
    pub fn run(self) -> Result<Solved, SolveError> {
        let resolution = self.settings.solution.form_factors.resolution;
        if !resolution.is_multiple_of(2) || !(2..=MAX_RESOLUTION).contains(&resolution) {
            return Err(SolveFault::Resolution { value: resolution }.into());
        }
        let start_is_good = self.start.as_ref().map(|start| start.validate(self.scene));
        start_is_good.transpose().map_err(SolveFault::Start)?;
        match self.stand_in() {
            Some((stand_in, target)) => self.run_on(&stand_in, target),
            None => self.run_on_scene(),
        }
    }

    /// The same on the scene as it is.
    fn run_on_scene(self) -> Result<Solved, SolveError> {
        let mut nobody = observer::Nobody;
        let Self {
            scene,
            start,
            settings,
            cancel,
            observer,
            rows,
            row_files,
        } = self;
        let form_factors =
            FormFactors::new(scene, settings.solution.form_factors, settings.drawing)
                .going_on(start.as_ref(), settings.solution)
                .with_cancel(&cancel)
                .with_row_files(row_files);
        let run = Run {
            scene,
            form_factors,
            settings,
            cancel,
            observer: observer.unwrap_or(&mut nobody),
            start: Instant::now(),
            seconds: Seconds::default(),
            is_remark_said: false,
            are_files_told: false,
            trial: None,
            drawn_before: RowStatistics::default(),
        };
        run.run(start, rows)
    }
}

impl Solved {
    /// The solution, from which another run can go on.
    pub fn solution(&self) -> &Solution {
        &self.solution
    }

    /// Radiosities B = E + rho H, W/m^2, one per patch.
    pub fn radiosity(&self) -> &[Rgb] {
        &self.radiosity
    }

    /// Irradiances H, W/m^2, one per patch.
    pub fn irradiance(&self) -> &[Rgb] {
        &self.solution.irradiance
    }

    /// What the form factors and the solution are worth.
    pub fn certificate(&self) -> &Certificate {
        &self.certificate
    }

    /// The solution alone.
    pub fn into_solution(self) -> Solution {
        self.solution
    }
}

/// A run under way.
struct Run<'a, 'o> {
    scene: &'a Scene,
    form_factors: FormFactors<'a>,
    settings: SolveSettings,
    cancel: CancelToken,
    observer: &'o mut dyn Observer,
    start: Instant,
    seconds: Seconds,
    /// Whether the user knows why the back end is not another one.
    is_remark_said: bool,
    /// Whether the user knows what files of rows there were. From then on they are this run's.
    are_files_told: bool,
    /// What told which back end it is.
    trial: Option<Trial>,
    /// Hemicubes and time of rows that are there no more: those of coarse sources.
    drawn_before: RowStatistics,
}

impl<'a> Run<'a, '_> {
    fn run(
        mut self,
        start: Option<Solution>,
        rows: Option<RowCache<'a>>,
    ) -> Result<Solved, SolveError> {
        let iterations_before = start.as_ref().map_or(0, |s| s.provenance.iterations);
        let solved = match self.begin(start)? {
            Next::Nothing(solution) => {
                if solution.function.is_some() {
                    // It has been gathered in the last of these iterations.
                    self.settings.target = None;
                }
                let mut rows = self.rows(rows, &solution)?;
                let stopped_by = if self.cancel.is_cancelled() {
                    StoppedBy::Interrupt
                } else {
                    StoppedBy::Iterations
                };
                self.finish(solution, Ok(stopped_by), &mut rows, None)
            }
            Next::Patches(start) => {
                let mut rows = self.rows(rows, &start)?;
                let (function, before) = (start.function.clone(), start.irradiance.clone());
                let mut solver = self.solver(self.scene, self.recorded(start));
                let result = self.iterate(solver.as_mut(), &mut rows, Goal::Convergence);
                let mut solution = solver.snapshot();
                // It is that of these irradiances.
                solution.function = function.filter(|_| solution.irradiance == before);
                self.finish(solution, result, &mut rows, None)
            }
            Next::Gather(of_sources) => self.gather(*of_sources),
            Next::Function(area, start) => self.function_of_sources(area, start),
        };
        solved.map(|solved| Solved {
            iterations_before,
            ..solved
        })
    }

    /// The rows of patches to patches, for a solution that goes on from this one: those that are given, if any.
    fn rows(
        &mut self,
        given: Option<RowCache<'a>>,
        start: &Solution,
    ) -> Result<RowCache<'a>, SolveError> {
        if let Some(rows) = given {
            self.opened(&rows);
            return Ok(rows);
        }
        let form_factors = self.form_factors.clone();
        let sources = Sources::patches_of(self.scene);
        Ok(self.open(&form_factors, sources, self.needed(start))?)
    }

    /// Whose rows are needed in a run that goes on from this solution.
    fn needed<'s>(&self, start: &'s Solution) -> Needed<'s> {
        if self.settings.all_rows {
            Needed::All
        } else {
            Needed::Lit(start)
        }
    }

    /// Opens rows to some sources, and says what a user should know of that.
    fn open<'s>(
        &mut self,
        form_factors: &FormFactors<'s>,
        sources: Sources<'s>,
        needed: Needed,
    ) -> Result<RowCache<'s>, BackendError> {
        let opening = Instant::now();
        let mut rows = form_factors.rows_to(sources, needed)?;
        self.seconds.open += opening.elapsed().as_secs_f64();
        self.opened(&rows);
        for remark in rows.take_remarks() {
            if !self.are_files_told || matches!(remark, RowFileRemark::NotKept(_)) {
                self.observer.remark(&Remark::RowFile(remark));
            }
        }
        self.are_files_told = true;
        Ok(rows)
    }

    /// Goes on with the back end of these rows, and says what a user should know of it.
    fn opened(&mut self, rows: &RowCache) {
        self.form_factors = self.form_factors.clone().after(rows);
        let choice = rows.choice();
        self.trial = self.trial.or(choice.trial);
        if let Some(remark) = &choice.remark
            && !std::mem::replace(&mut self.is_remark_said, true)
        {
            self.observer.remark(&Remark::Backend(remark.clone()));
        }
    }

    /// The same start, which says where the rows come from with which a solver goes on.
    fn recorded(&self, mut start: Solution) -> Solution {
        let origin = self.form_factors.origin();
        if let (Some(settings), Some(origin)) = (&mut start.provenance.settings, origin) {
            origin.record_in(settings);
        }
        start
    }

    /// A solver among the patches of a scene that goes on from `start`.
    fn solver<'s>(&self, scene: &'s Scene, start: Solution) -> Box<dyn Solver + 's> {
        let update = match self.settings.solution.solver {
            SolverChoice::Jacobi => Update::AfterIteration,
            SolverChoice::GaussSeidel => Update::AtOnce,
            SolverChoice::Shooting => return Box::new(Shoot::new(Problem::new(scene), start)),
        };
        let is_dark = start.irradiance.iter().all(|&h| h == Rgb::ZERO);
        let is_first = is_dark && start.provenance.iterations == 0;
        let gather = Gather::new(Problem::new(scene), update, start);
        if is_first {
            Box::new(StartUp::new(gather, Problem::new(scene)))
        } else {
            Box::new(gather)
        }
    }
}
