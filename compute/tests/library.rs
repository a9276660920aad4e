//! The library's entrance: what is wrong with its arguments is an error, not a panic.

use compute::Solve;
use compute::solve::SolveFault;
use scene::{Rgb, Scene, Solution};
use test_scenes::furnace;

fn fault(scene: &Scene, resolution: u32, start: Option<Solution>) -> SolveFault {
    let solve = Solve::new(scene).resolution(resolution).start(start);
    let error = solve.run().err().unwrap();
    assert!(error.solution.is_none());
    error.cause
}

#[test]
fn a_resolution_that_is_none_is_an_error() {
    let scene = furnace(0.5, 1.0, 0.5);
    for value in [0, 1, 31, 4098, u32::MAX] {
        let fault = fault(&scene, value, None);
        assert!(
            matches!(fault, SolveFault::Resolution { value: v } if v == value),
            "{fault}"
        );
        assert!(
            fault.to_string().contains("even number from 2 to 4096"),
            "{fault}"
        );
    }
}

#[test]
fn a_start_that_is_no_solution_of_the_scene_is_an_error() {
    let scene = furnace(0.5, 1.0, 0.5);
    let larger = furnace(0.5, 1.0, 0.01);
    let mut bad = Solution::dark(&scene);
    bad.irradiance[0] = Rgb::splat(f32::NAN);
    for start in [Solution::dark(&larger), bad] {
        let fault = fault(&scene, 32, Some(start));
        assert!(matches!(fault, SolveFault::Start(_)), "{fault}");
    }
}
