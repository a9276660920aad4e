//! What there is to be seen of a run that is stopped early, and that it goes on as if it had never been.

use compute::function::{Errors, FunctionEnd};
use compute::settings::{BackendChoice, Points, Quality, SolveSettings, SolverChoice};
use compute::solve::{Observer, Position, Solved, StoppedBy};
use compute::{CancelToken, Solve};
use glam::DVec3;
use scene::{Rgb, Scene, Solution};
use test_scenes::colourful_room;

/// Stops a run at a moment of its own.
struct Stop<'s> {
    cancel: CancelToken,
    is_now: Box<dyn FnMut(Moment) -> bool + 's>,
}

enum Moment<'m> {
    Step(&'m Position),
    /// With so many vertices.
    Function(u32),
}

impl<'s> Stop<'s> {
    fn when(is_now: impl FnMut(Moment) -> bool + 's) -> Self {
        Self {
            cancel: CancelToken::new(),
            is_now: Box::new(is_now),
        }
    }

    fn run(mut self, scene: &Scene, settings: SolveSettings) -> Solved {
        let solve = Solve::new(scene).settings(settings);
        let cancel = self.cancel.clone();
        let solved = solve.cancel(&cancel).observer(&mut self).run().unwrap();
        assert_eq!(solved.stopped_by, StoppedBy::Interrupt);
        solved
    }
}

impl Observer for Stop<'_> {
    fn progress(&mut self, position: &Position) {
        if (self.is_now)(Moment::Step(position)) {
            self.cancel.cancel();
        }
    }

    fn function(&mut self, vertices: u32, _: Option<Errors>) {
        if (self.is_now)(Moment::Function(vertices)) {
            self.cancel.cancel();
        }
    }
}

/// Among the patches, whose rows are drawn in many steps since none are kept.
fn among_patches(solver: SolverChoice) -> SolveSettings {
    let mut settings = SolveSettings::default();
    settings.drawing.backend = BackendChoice::Cpu;
    settings.drawing.memory_bytes = 0;
    settings.solution.form_factors.resolution = 32;
    settings.solution.form_factors.points = Points::CENTROID;
    settings.solution.solver = solver;
    settings.max_iterations = Some(3);
    settings
}

fn gone_on(scene: &Scene, settings: SolveSettings, from: &Solution) -> Solved {
    let solve = Solve::new(scene).settings(settings);
    solve.start(Some(from.clone())).run().unwrap()
}

/// What has been sent out and not been received, W: all but what is unshot, since the room is closed and rows sum to 1.
fn unshot(scene: &Scene, solution: &Solution) -> DVec3 {
    let areas = scene.patch_areas();
    let (emission, reflectance) = (scene.patch_emissions(), scene.patch_reflectances());
    let patches = areas.iter().zip(emission).zip(reflectance);
    let unshot = patches
        .zip(&solution.irradiance)
        .map(|(((area, e), rho), &h)| area * (e + rho * h - h).as_dvec3());
    unshot.sum()
}

/// Roundings of f32 irradiances, some of them to each of a thousand patches.
const ROUNDING: f64 = 1e-5;

/// In the first iteration the lamps have shot, and what they light; later nothing of that is left.
#[test]
fn a_run_stopped_in_its_first_iteration_shows_what_lamps_light() {
    let scene = colourful_room(0.05);
    let emitted = scene.emitted_power();
    for solver in [SolverChoice::Jacobi, SolverChoice::GaussSeidel] {
        let settings = among_patches(solver);
        let whole = Solve::new(&scene).settings(settings).run().unwrap();
        let mut before = emitted.element_sum();
        for steps in [1, 5, 20] {
            let mut left = steps;
            let is_now = |_: Moment| {
                left -= 1;
                left == 0
            };
            let stopped = Stop::when(is_now).run(&scene, settings);
            let solution = stopped.solution();
            assert_eq!(solution.provenance.iterations, 0);
            assert_eq!(solution.provenance.start_up_shots, steps);
            // Each shot takes from what is unshot more than its patch's walls reflect.
            let left = unshot(&scene, solution).element_sum();
            assert!(left < before, "{steps}: {left} {before}");
            before = left;
            let whole_again = gone_on(&scene, settings, solution);
            assert_eq!(whole_again.solution(), whole.solution(), "{steps}");
        }
        let is_now =
            |moment: Moment| matches!(moment, Moment::Step(position) if position.share_done > 0.0);
        let stopped = Stop::when(is_now).run(&scene, settings);
        let solution = stopped.solution();
        let shots = solution.provenance.start_up_shots;
        let left = unshot(&scene, solution);
        println!("{solver:?}: {shots} shots leave {left} of {emitted}");
        assert!(left.min_element() >= -ROUNDING * emitted.max_element());
        let is_bright = left.element_sum() <= (0.1 + ROUNDING) * emitted.element_sum();
        let most = u64::from(scene.patch_count().div_ceil(32));
        assert!(is_bright || shots == most, "{shots} shots leave {left}");
        assert!(shots <= most);
        assert!(solution.next_iteration_share() > 0.0);
        let whole_again = gone_on(&scene, settings, solution);
        assert_eq!(whole_again.solution(), whole.solution());

        let is_now =
            |moment: Moment| matches!(moment, Moment::Step(position) if position.iterations == 1);
        let stopped = Stop::when(is_now).run(&scene, settings);
        assert_eq!(stopped.solution().provenance.start_up_shots, 0);
    }
}

/// Where vertices gather, the run is stopped with the last function whose error is known, as accurate as is said, and goes on from
/// the sources.
#[test]
fn a_run_stopped_while_vertices_gather_shows_the_function_as_it_is() {
    let scene = colourful_room(0.05);
    let mut settings = Quality::High.settings();
    settings.drawing.backend = BackendChoice::Cpu;
    let whole = Solve::new(&scene).settings(settings).run().unwrap();
    let all = whole.function.unwrap().vertices;

    let is_now = |moment: Moment| matches!(moment, Moment::Step(_));
    let stopped = Stop::when(is_now).run(&scene, settings);
    assert!(stopped.solution().provenance.start_up_shots > 0);
    assert!(
        stopped
            .solution()
            .irradiance
            .iter()
            .any(|&h| h != Rgb::ZERO)
    );
    let mut stops = vec![stopped];
    for share in [2, 1] {
        let is_now = |moment: Moment| matches!(moment, Moment::Function(vertices) if vertices >= all / share);
        stops.push(Stop::when(is_now).run(&scene, settings));
        let stopped = stops.last().unwrap();
        let report = stopped.function.unwrap();
        println!("{report:?}");
        assert_eq!(report.stopped_by, FunctionEnd::Interrupt);
        assert!(report.vertices < all && report.error.is_some());
        let function = stopped.solution().function.as_ref().unwrap();
        assert_eq!(function.mesh().vertex_count(), report.vertices);
    }
    for stopped in &stops {
        let whole_again = gone_on(&scene, settings, stopped.solution());
        assert_eq!(whole_again.solution(), whole.solution());
    }
}
