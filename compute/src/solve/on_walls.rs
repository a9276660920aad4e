//! Solving a scene on its walls, where these are far fewer triangles ([`crate::walls`]).

use scene::{Level, PatchId, Provenance, Solution, State};

use super::{Observer, Position, Remark, Solve, SolveError, Solved, SourcesReport};
use crate::backend::RowOrigin;
use crate::form_factors::area_of_function_sources;
use crate::function::{Errors, FunctionFault, carried_over};
use crate::settings::{SolveSettings, Target};
use crate::walls::Walls;

impl<'a> Solve<'a> {
    /// The walls that are to be solved instead of the scene. What goes on from patches' values begins anew there, so that it has the
    /// bits of a run that was never stopped.
    pub(super) fn walls(&self) -> Option<(Walls<'a>, Target)> {
        let most = self.settings.max_iterations;
        let is_over = self.start.as_ref().is_some_and(|start| {
            start.function.is_some() && most.is_some_and(|most| start.provenance.iterations >= most)
        });
        if is_over {
            return None;
        }
        Walls::to_solve(self.scene, &self.settings)
    }

    /// Solves these walls, and tells what their solution is on the scene.
    pub(super) fn run_on(self, walls: &Walls, target: Target) -> Result<Solved, SolveError> {
        let on_scene = OnScene {
            walls,
            target,
            settings: self.settings,
        };
        let mut nobody = super::observer::Nobody;
        let mut observer = Mapped {
            on_scene: &on_scene,
            observer: self.observer.unwrap_or(&mut nobody),
        };
        let solved = Solve {
            scene: walls.scene(),
            start: None,
            settings: self.settings,
            cancel: self.cancel,
            observer: Some(&mut observer),
            rows: None,
            row_files: self.row_files,
        };
        match solved.run_on_scene() {
            Ok(solved) => on_scene.solved(solved),
            Err(SolveError { cause, solution }) => Err(SolveError {
                cause,
                solution: solution.map(|solution| Box::new(on_scene.irradiances(&solution))),
            }),
        }
    }
}

/// What is known of walls, on the scene whose walls they are.
struct OnScene<'w> {
    walls: &'w Walls<'w>,
    target: Target,
    settings: SolveSettings,
}

impl OnScene<'_> {
    /// The same solution without its function: each patch has what the walls' patch has that it lies in.
    fn irradiances(&self, of_walls: &Solution) -> Solution {
        let scene = self.walls.original();
        let mut settings = self.settings.solution.recorded(scene.patch_count());
        let recorded = of_walls.provenance.settings.as_ref();
        if let Some(origin) = recorded.and_then(RowOrigin::recorded_in) {
            origin.record_in(&mut settings);
        }
        let max_area = area_of_function_sources(scene, self.target);
        Solution {
            irradiance: self.walls.values(&of_walls.irradiance),
            provenance: Provenance {
                settings: Some(settings),
                level: Level::Sources { max_area },
                ..of_walls.provenance.clone()
            },
            state: State::AtRest,
            function: None,
        }
    }

    fn solution(&self, of_walls: &Solution) -> Result<Solution, FunctionFault> {
        let mut solution = self.irradiances(of_walls);
        if let Some(function) = &of_walls.function {
            solution.function = Some(carried_over(function, self.walls, &self.target)?);
            solution.irradiance = solution.mean_irradiance(self.walls.original());
        }
        Ok(solution)
    }

    fn solved(&self, of_walls: Solved) -> Result<Solved, SolveError> {
        let scene = self.walls.original();
        let solution = self.solution(&of_walls.solution)?;
        let lying_in = |of_walls: &[PatchId]| -> Vec<PatchId> {
            let patches = (0..scene.patch_count()).map(PatchId);
            let is_in = |patch: &PatchId| {
                let patch = self.walls.patch_of(*patch);
                of_walls.binary_search(&patch).is_ok()
            };
            patches.filter(is_in).collect()
        };
        let unlit = lying_in(&of_walls.unlit);
        let inside = of_walls.inside.as_deref().map(lying_in);
        let mut certificate = of_walls.certificate;
        // Those of the walls are no patches.
        certificate.hidden_patches = None;
        certificate.inside_patches = inside.as_ref().map(|inside| inside.len() as u32);
        if let Some(reciprocity) = &mut certificate.reciprocity {
            let first = lying_in(&[PatchId(reciprocity.worst_patch)])
                .first()
                .copied();
            reciprocity.worst_patch = first.unwrap_or(PatchId(0)).0;
        }
        let max_area = area_of_function_sources(scene, self.target);
        Ok(Solved {
            radiosity: solution.radiosity(scene),
            certificate,
            unlit_patches: unlit.len() as u32,
            unlit,
            inside,
            sources: Some(SourcesReport {
                gathered_share: None,
                ..SourcesReport::new(self.walls.scene().patch_count(), max_area)
            }),
            solution,
            ..of_walls
        })
    }
}

/// Who watches a run on walls is told of the scene.
struct Mapped<'m> {
    on_scene: &'m OnScene<'m>,
    observer: &'m mut dyn Observer,
}

impl Observer for Mapped<'_> {
    fn progress(&mut self, position: &Position) {
        self.observer.progress(position);
    }

    fn function(&mut self, vertices: u32, error: Option<Errors>) {
        self.observer.function(vertices, error);
    }

    fn remark(&mut self, remark: &Remark) {
        self.observer.remark(remark);
    }

    fn iteration(&mut self, iterations: u64, solution: &dyn Fn() -> Solution) {
        let solution = || self.on_scene.irradiances(&solution());
        self.observer.iteration(iterations, &solution);
    }

    fn checkpoint(&mut self, solution: &Solution, make_room: &mut dyn FnMut() -> bool) {
        let solution = self.on_scene.irradiances(solution);
        self.observer.checkpoint(&solution, make_room);
    }
}
