//! Model 1: a cube with a small square lamp shining into it.

use scene::Rgb;

use super::{DEFAULT_REFLECTANCE, emission_or, reflectance_or};
use crate::Settings;
use crate::builder::{Builder, Plane};
use crate::grid::Grid;

/// Default area threshold, m^2.
pub const MAX_AREA: f64 = 0.2;

/// Length of the cube's edges, metres: the thesis's threshold of 2.5 m^2 then shows single patches.
const SIDE: f64 = 10.0;

/// Length of the lamp's edges, metres.
const LAMP: f64 = 2.5;

pub fn build(settings: &Settings) -> Builder {
    let mut builder = Builder::default();
    let grey = Rgb::splat(DEFAULT_REFLECTANCE);
    let cube = builder.look("cube", reflectance_or(settings, grey), Rgb::ZERO);
    let lamp = builder.look(
        "lamp",
        reflectance_or(settings, grey),
        emission_or(settings, Rgb::ONE),
    );

    let ticks = [0.0, 0.5 * SIDE, SIDE];
    let ceiling = Plane {
        axis: 1,
        at: SIDE,
        positive: false,
    };
    for face in Grid::new([ticks.to_vec(), ticks.to_vec(), ticks.to_vec()]).faces() {
        if face.plane != ceiling {
            builder.rectangle(face.plane, face.u, face.v, cube);
        }
    }
    let hole = [0.5 * (SIDE - LAMP), 0.5 * (SIDE + LAMP)];
    builder.frame(ceiling, ticks, ticks, hole, hole, cube);
    builder.rectangle(ceiling, hole, hole, lamp);
    builder
}
