//! Cases in closed rooms: row sums, furnaces, and the solvers against a dense linear solve.

use glam::DVec3;
use scene::{Material, Rgb};

use super::case::{self, CLOSED, Case, Expected, Measure, SHOT, SOLVED};
use super::shapes::{self, SceneBuilder, Triangle, horizontal};
use crate::settings::SolverChoice;

/// All cases in closed rooms.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = vec![
        closure("a room with two floating blocks", &blocks_in_the_air()),
        closure(
            "a room with a block that stands on the floor",
            &block_on_the_floor(),
        ),
        closure("a room with a column from floor to ceiling", &column()),
    ];
    for reflectance in [0.0, 0.2, 0.5, 0.9, 0.99] {
        let name = format!("furnace, reflectance {reflectance}");
        let cube = shapes::faces(DVec3::ZERO, DVec3::ONE, false).concat();
        cases.push(furnace(&name, reflectance, &[cube]));
    }
    cases.push(furnace(
        "furnace with two blocks, reflectance 0.5",
        0.5,
        &blocks_in_the_air(),
    ));
    for (name, solver) in [
        ("jacobi", SolverChoice::Jacobi),
        ("gauss-seidel", SolverChoice::GaussSeidel),
        ("shooting", SolverChoice::Shooting),
    ] {
        cases.push(dense_solve(name, solver));
    }
    cases
}

fn room() -> Vec<Triangle> {
    shapes::faces(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.0), false).concat()
}

/// A room, and two blocks that touch nothing.
fn blocks_in_the_air() -> [Vec<Triangle>; 3] {
    let block =
        |low: [f64; 3], high: [f64; 3]| shapes::faces(low.into(), high.into(), true).concat();
    [
        room(),
        block([1.0, 1.0, 0.5], [1.7, 1.4, 1.3]),
        block([2.5, 0.5, 0.2], [3.1, 2.1, 0.9]),
    ]
}

/// The parts of a rectangle of 4 x 3 m around a hole, at height z. Their corners lie on the edges
/// of their neighbours.
fn around_hole([x0, x1]: [f64; 2], [y0, y1]: [f64; 2], z: f64, up: bool) -> Vec<Triangle> {
    [
        horizontal([0.0, x0], [0.0, 3.0], z, up),
        horizontal([x1, 4.0], [0.0, 3.0], z, up),
        horizontal([x0, x1], [0.0, y0], z, up),
        horizontal([x0, x1], [y1, 3.0], z, up),
    ]
    .concat()
}

/// A block on a cut-out of the floor, without a bottom.
fn block_on_the_floor() -> [Vec<Triangle>; 2] {
    let (low, high) = (DVec3::new(1.1, 0.7, 0.0), DVec3::new(2.3, 1.6, 0.9));
    let [_, ceiling, walls @ ..] = shapes::faces(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.0), false);
    let [_, top, sides @ ..] = shapes::faces(low, high, true);
    let floor = around_hole([low.x, high.x], [low.y, high.y], 0.0, true);
    [
        [floor, ceiling, walls.concat()].concat(),
        [top, sides.concat()].concat(),
    ]
}

/// A column between cut-outs of floor and ceiling.
fn column() -> [Vec<Triangle>; 2] {
    let (low, high) = (DVec3::new(1.3, 1.1, 0.0), DVec3::new(1.9, 1.7, 2.0));
    let [_, _, walls @ ..] = shapes::faces(DVec3::ZERO, DVec3::new(4.0, 3.0, 2.0), false);
    let [_, _, sides @ ..] = shapes::faces(low, high, true);
    let (x, y) = ([low.x, high.x], [low.y, high.y]);
    [
        [
            around_hole(x, y, 0.0, true),
            around_hole(x, y, 2.0, false),
            walls.concat(),
        ]
        .concat(),
        sides.concat(),
    ]
}

/// Patches an object has in a closed room.
const OBJECT_PATCHES: u32 = 192;

/// Names of what stands in a room.
const NAMES: [&str; 3] = ["room", "block", "other block"];

fn scene<const N: usize>(
    objects: &[Vec<Triangle>; N],
    reflectance: f32,
    emission: f32,
) -> SceneBuilder {
    let named = NAMES.iter().zip(objects);
    named.fold(SceneBuilder::default(), |scene, (name, triangles)| {
        scene.object(name, reflectance, emission, OBJECT_PATCHES, triangles)
    })
}

fn closure<const N: usize>(name: &str, objects: &[Vec<Triangle>; N]) -> Case {
    Case {
        name: name.into(),
        quantity: "row sum farthest from 1".into(),
        measure: Measure::Closure,
        expected: Expected::Value(1.0),
        source: "closure".into(),
        tolerance: CLOSED,
        scene: scene(objects, 0.0, 0.0),
    }
}

/// A closed room whose walls all emit E = 1 W/m^2 and reflect alike: B = E / (1 - rho) everywhere.
fn furnace<const N: usize>(name: &str, reflectance: f32, objects: &[Vec<Triangle>; N]) -> Case {
    let rho = f64::from(reflectance);
    Case {
        name: name.into(),
        quantity: "radiosity farthest from B, W/m^2".into(),
        measure: Measure::Radiosity,
        expected: Expected::Value(1.0 / (1.0 - rho)),
        source: "B = E / (1 - rho)".into(),
        tolerance: case::furnace(rho),
        scene: scene(objects, reflectance, 1.0),
    }
}

/// A room of several colours with two blocks, one of which shines.
fn dense_solve(name: &str, solver: SolverChoice) -> Case {
    let materials = [
        ([0.75, 0.5, 0.25], [0.0, 0.0, 0.1]),
        ([0.3, 0.6, 0.1], [0.0; 3]),
        ([0.1, 0.2, 0.3], [10.0, 8.0, 6.0]),
    ];
    let mut scene = SceneBuilder::default();
    for ((name, triangles), (reflectance, emission)) in
        NAMES.iter().zip(blocks_in_the_air()).zip(materials)
    {
        let material = Material {
            name: (*name).into(),
            reflectance: Rgb::from(reflectance),
            emission: Rgb::from(emission),
        };
        scene = scene.with_material(material, OBJECT_PATCHES, &triangles);
    }
    Case {
        name: format!("{name} against a dense solve"),
        quantity: "radiosity farthest from it, W/m^2".into(),
        measure: Measure::DenseSolve { solver },
        expected: Expected::DenseSolution,
        source: "Gaussian elimination on the same rows".into(),
        tolerance: if solver == SolverChoice::Shooting {
            SHOT
        } else {
            SOLVED
        },
        scene,
    }
}
