//! Form factors that a formula gives, and the cases made of them.
//!
//! Formulas by their numbers in J. R. Howell, "A Catalog of Radiation Heat Transfer Configuration
//! Factors".

use std::f64::consts::PI;

use glam::DVec3;

use super::case::{
    COARSE, Case, Expected, Measure, NOTHING, OCCLUDED, PATCHES, Tolerance, UNOCCLUDED,
};
use super::shapes::{self, SceneBuilder, horizontal};

/// C-11: between two identical rectangles of sides `a` and `b`, parallel and directly opposed at
/// distance `c`.
pub fn opposed_rectangles(a: f64, b: f64, c: f64) -> f64 {
    let (x, y) = (a / c, b / c);
    let (x1, y1) = ((1.0 + x * x).sqrt(), (1.0 + y * y).sqrt());
    2.0 / (PI * x * y)
        * ((x1 * y1 / (1.0 + x * x + y * y).sqrt()).ln()
            + x * y1 * (x / y1).atan()
            + y * x1 * (y / x1).atan()
            - x * x.atan()
            - y * y.atan())
}

/// C-14: from a rectangle of sides `common` and `from` to one of sides `common` and `to` at a right
/// angle, which meets it along the common side.
pub fn rectangles_at_right_angle(common: f64, from: f64, to: f64) -> f64 {
    let (w, h) = (from / common, to / common);
    let (w2, h2) = (w * w, h * h);
    let sum = w2 + h2;
    let logarithms = ((1.0 + w2) * (1.0 + h2) / (1.0 + sum)).ln()
        + w2 * (w2 * (1.0 + sum) / ((1.0 + w2) * sum)).ln()
        + h2 * (h2 * (1.0 + sum) / ((1.0 + h2) * sum)).ln();
    (w * (1.0 / w).atan() + h * (1.0 / h).atan() - sum.sqrt() * (1.0 / sum.sqrt()).atan()
        + 0.25 * logarithms)
        / (PI * w)
}

/// All cases whose values are computed here.
pub(super) fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for separation in [2.0, 1.0, 0.5, 0.25, 0.1] {
        cases.push(coaxial_squares(separation));
    }
    cases.extend(cube("cube of 2 triangles a wall", 2, COARSE));
    cases.extend(cube("cube of 128 triangles a wall", PATCHES, UNOCCLUDED));
    cases.push(box_with_plate());
    cases.extend(half_blocked_squares());
    cases.extend(cube_in_cube());
    cases
}

fn form_factor(
    name: &str,
    [from, to]: [&'static str; 2],
    expected: f64,
    source: &str,
    tolerance: Tolerance,
    scene: &SceneBuilder,
) -> Case {
    Case {
        name: name.into(),
        quantity: format!("form factor, {from} to {to}"),
        measure: Measure::FormFactor { from, to },
        expected: Expected::Value(expected),
        source: source.into(),
        tolerance,
        scene: scene.clone(),
    }
}

const UNIT: [f64; 2] = [0.0, 1.0];

fn coaxial_squares(separation: f64) -> Case {
    let scene = SceneBuilder::default()
        .dark("lower", PATCHES, &horizontal(UNIT, UNIT, 0.0, true))
        .dark("upper", 1, &horizontal(UNIT, UNIT, separation, false));
    form_factor(
        &format!("coaxial unit squares, separation {separation}"),
        ["lower", "upper"],
        opposed_rectangles(1.0, 1.0, separation),
        "Howell C-11",
        UNOCCLUDED,
        &scene,
    )
}

/// A closed unit cube, whose opposite and adjacent walls see each other.
fn cube(name: &str, patches: u32, tolerance: Tolerance) -> [Case; 2] {
    let [floor, ceiling, wall, walls @ ..] = shapes::faces(DVec3::ZERO, DVec3::ONE, false);
    let scene = SceneBuilder::default()
        .dark("floor", patches, &floor)
        .dark("ceiling", patches, &ceiling)
        .dark("wall", patches, &wall)
        .dark("other walls", 3 * patches, &walls.concat());
    [
        form_factor(
            &format!("{name}, opposite"),
            ["floor", "ceiling"],
            opposed_rectangles(1.0, 1.0, 1.0),
            "Howell C-11",
            tolerance,
            &scene,
        ),
        form_factor(
            &format!("{name}, adjacent"),
            ["floor", "wall"],
            rectangles_at_right_angle(1.0, 1.0, 1.0),
            "Howell C-14",
            tolerance,
            &scene,
        ),
    ]
}

/// Form factor from floor to ceiling past the plate of [`box_with_plate`]. Whatever sees the plate
/// would see the ceiling behind it, so this is C-11 between floor and ceiling less C-13 from floor to
/// plate.
pub(super) const PAST_PLATE: f64 = 0.282_887_514;

/// A closed box of 2 x 2 x 1 m with a plate of 0.9 x 0.9 m at three quarters of its height.
fn box_with_plate() -> Case {
    let [floor, ceiling, walls @ ..] = shapes::faces(DVec3::ZERO, DVec3::new(2.0, 2.0, 1.0), false);
    let plate = horizontal([0.55, 1.45], [0.55, 1.45], 0.75, true);
    let scene = SceneBuilder::default()
        .dark("floor", PATCHES, &floor)
        .dark("ceiling", 1, &ceiling)
        .dark("plate", 1, &shapes::two_sided(plate))
        .dark("walls", 1, &walls.concat());
    form_factor(
        "box with a plate between floor and ceiling",
        ["floor", "ceiling"],
        PAST_PLATE,
        "Howell C-11 less C-13; View3D 0.282833",
        OCCLUDED,
        &scene,
    )
}

/// From a unit square to a square of half its side, over one of its corners at half its side: a
/// quarter of what the small one sees of the large one, by reciprocity.
pub(super) const SQUARE_TO_PLATE: f64 = 0.103_813_5;

/// Unit squares at distance 1, a plate of half their side over one corner at half the distance.
fn half_blocked_squares() -> [Case; 3] {
    const HALF: [f64; 2] = [0.0, 0.5];
    let square = horizontal(UNIT, UNIT, 0.0, true);
    let plate = shapes::two_sided(horizontal(HALF, HALF, 0.5, false));
    let far = horizontal(UNIT, UNIT, 1.0, false);
    let (underside, top) = plate.split_at(2);
    let scene = |from_square: u32, from_plate: u32| {
        SceneBuilder::default()
            .dark("square", from_square, &square)
            .dark("plate", from_plate, underside)
            .dark("plate's back", 1, top)
            .dark("far square", 1, &far)
    };
    let case = |name: &str, objects, expected, source: &str, tolerance, scene: &SceneBuilder| {
        let name = format!("half-blocked unit squares, {name}");
        form_factor(&name, objects, expected, source, tolerance, scene)
    };
    let view3d = "View3D, example square-obstruction";
    [
        case(
            "past the plate",
            ["square", "far square"],
            0.149_870,
            view3d,
            OCCLUDED,
            &scene(PATCHES, 1),
        ),
        case(
            "square to plate",
            ["square", "plate"],
            SQUARE_TO_PLATE,
            "shadow projection + 2-D integral; View3D 0.103813",
            UNOCCLUDED,
            &scene(PATCHES, 1),
        ),
        case(
            "plate to square",
            ["plate", "square"],
            4.0 * SQUARE_TO_PLATE,
            "reciprocity; View3D 0.415254",
            UNOCCLUDED,
            &scene(1, PATCHES),
        ),
    ]
}

/// A cube of 0.4 m floating off centre in a cube of 1 m. The small one is convex and sees the
/// large one alone; the rest follows from reciprocity and closure.
fn cube_in_cube() -> [Case; 4] {
    let low = DVec3::new(0.2, 0.25, 0.3);
    let large = shapes::faces(DVec3::ZERO, DVec3::ONE, false).concat();
    let small = shapes::faces(low, low + 0.4, true).concat();
    let scene = SceneBuilder::default()
        .dark("large", 6 * PATCHES, &large)
        .dark("small", 6 * PATCHES, &small);
    let to_small = shapes::area(&small) / shapes::area(&large);
    let case = |objects, expected, source: &str, tolerance| {
        let [from, to] = objects;
        let name = format!("cube in a cube, {from} to {to}");
        form_factor(&name, objects, expected, source, tolerance, &scene)
    };
    [
        case(
            ["small", "large"],
            1.0,
            "closure: the small one is convex",
            super::case::CLOSED,
        ),
        case(["small", "small"], 0.0, "convex", NOTHING),
        case(
            ["large", "small"],
            to_small,
            "reciprocity: ratio of the areas",
            OCCLUDED,
        ),
        case(["large", "large"], 1.0 - to_small, "closure", OCCLUDED),
    ]
}
