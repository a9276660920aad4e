//! Solving what stands in for a scene ([`crate::stand_in`]), where it has far more triangles than the light needs, or too few patches.

use scene::{Level, PatchId, Provenance, Solution, State};

use super::{Observer, Position, Remark, Solve, SolveError, Solved, SourcesReport};
use crate::backend::RowOrigin;
use crate::form_factors::area_of_function_sources;
use crate::function::{Errors, FunctionFault, carried_over};
use crate::settings::{SolveSettings, Target};
use crate::stand_in::StandIn;

impl<'a> Solve<'a> {
    /// What is to be solved instead of the scene. What goes on from patches' values begins anew there, so that it has the bits of a
    /// run that was never stopped.
    pub(super) fn stand_in(&self) -> Option<(StandIn<'a>, Target)> {
        let most = self.settings.max_iterations;
        let is_over = self.start.as_ref().is_some_and(|start| {
            let is_of_patches = start.provenance.level.source_area().is_none();
            let had = start.provenance.iterations;
            (start.function.is_some() || is_of_patches) && most.is_some_and(|most| had >= most)
        });
        if is_over {
            return None;
        }
        StandIn::to_solve(self.scene, &self.settings)
    }

    /// Solves this, and tells what its solution is on the scene.
    pub(super) fn run_on(self, stand_in: &StandIn, target: Target) -> Result<Solved, SolveError> {
        let on_scene = OnScene {
            stand_in,
            target,
            settings: self.settings,
        };
        let mut nobody = super::observer::Nobody;
        let mut observer = Mapped {
            on_scene: &on_scene,
            observer: self.observer.unwrap_or(&mut nobody),
        };
        let solved = Solve {
            scene: stand_in.scene(),
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

/// What is known of a stand-in, on the scene that it stands in for.
struct OnScene<'s> {
    stand_in: &'s StandIn<'s>,
    target: Target,
    settings: SolveSettings,
}

impl OnScene<'_> {
    /// The same solution without its function.
    fn irradiances(&self, of_stand_in: &Solution) -> Solution {
        let scene = self.stand_in.original();
        let mut settings = self.settings.solution.recorded(scene.patch_count());
        let recorded = of_stand_in.provenance.settings.as_ref();
        if let Some(origin) = recorded.and_then(RowOrigin::recorded_in) {
            origin.record_in(&mut settings);
        }
        let max_area = area_of_function_sources(scene, self.target);
        Solution {
            irradiance: self.stand_in.values(&of_stand_in.irradiance),
            provenance: Provenance {
                settings: Some(settings),
                level: Level::Sources { max_area },
                ..of_stand_in.provenance.clone()
            },
            state: State::AtRest,
            function: None,
            layers: None,
        }
    }

    fn solution(&self, of_stand_in: &Solution) -> Result<Solution, FunctionFault> {
        let mut solution = self.irradiances(of_stand_in);
        if let Some(function) = &of_stand_in.function {
            solution.function = Some(match self.stand_in {
                StandIn::Walls(walls) => carried_over(function, walls, &self.target)?,
                StandIn::Finer(finer) => finer.put_together(function)?,
            });
            solution.irradiance = solution.mean_irradiance(self.stand_in.original());
            // Vertices are the same where patches are finer.
            solution.layers.clone_from(&of_stand_in.layers);
            for layer in solution
                .layers
                .iter_mut()
                .flat_map(|layers| &mut layers.layers)
            {
                layer.irradiance = self.stand_in.values(&layer.irradiance);
            }
        }
        Ok(solution)
    }

    fn solved(&self, of_stand_in: Solved) -> Result<Solved, SolveError> {
        let scene = self.stand_in.original();
        let solution = self.solution(&of_stand_in.solution)?;
        let lying_in = |patches: &[PatchId]| self.stand_in.lying_in(patches);
        let unlit = lying_in(&of_stand_in.unlit);
        let inside = of_stand_in.inside.as_deref().map(lying_in);
        let mut certificate = of_stand_in.certificate;
        certificate.hidden = lying_in(&certificate.hidden);
        let hidden = certificate.hidden.len() as u32;
        certificate.hidden_patches = certificate.hidden_patches.map(|_| hidden);
        certificate.inside_patches = inside.as_ref().map(|inside| inside.len() as u32);
        let reciprocity = certificate.reciprocity.as_mut();
        let findings = [&mut certificate.opening, &mut certificate.back_faces];
        let worst = findings.into_iter().flatten();
        let worst = worst.map(|finding| &mut finding.worst_patch);
        for patch in worst.chain(reciprocity.map(|found| &mut found.worst_patch)) {
            *patch = self.stand_in.patch_with(PatchId(*patch)).0;
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
                ..SourcesReport::new(self.stand_in.scene().patch_count(), max_area)
            }),
            solution,
            ..of_stand_in
        })
    }
}

/// Who watches a run on a stand-in is told of the scene.
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
