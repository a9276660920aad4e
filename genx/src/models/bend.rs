//! Model 3: light bending round an obstacle into a region that no direct light reaches.
//!
//! A corridor in the shape of a U: two legs with a thick wall between them, joined at their far
//! ends. One end of the first leg glows like a window. In the second leg only the part near the
//! bend sees the window; everything behind is lit by reflections alone.
//!
//! ```text
//!  z
//!  9 +-----------------+
//!    |                 |      plan, metres; the ceiling is 3 m high
//!  6 |     +-----+     |
//!    |     |     |     |
//!    |  1  |     |  2  |
//!    |     |     |     |
//!  0 +=====+     +-----+
//!    0     3    4.8   7.8  x  ===== the window
//! ```

use scene::Rgb;

use super::{emission_or, reflectance_or};
use crate::Settings;
use crate::builder::Builder;
use crate::grid::Grid;

/// Default area threshold, m^2.
pub const MAX_AREA: f64 = 0.05;

/// Brighter than the general default, since only reflections reach the second leg.
const REFLECTANCE: Rgb = Rgb::splat(0.7);

pub fn build(settings: &Settings) -> Builder {
    let mut builder = Builder::default();
    let room = builder.look("room", reflectance_or(settings, REFLECTANCE), Rgb::ZERO);
    let obstacle = builder.look("obstacle", reflectance_or(settings, REFLECTANCE), Rgb::ZERO);
    let window = builder.look(
        "window",
        reflectance_or(settings, REFLECTANCE),
        emission_or(settings, Rgb::ONE),
    );

    // The thinnest wall whose end, 3 m high, still is within 1 : sqrt(3) measures 1.74 m.
    let mut grid = Grid::new([
        vec![0.0, 3.0, 4.8, 7.8],
        vec![0.0, 3.0],
        vec![0.0, 3.0, 6.0, 9.0],
    ]);
    grid.fill(|[x, _, z]| x == 1 && z < 2);
    for face in grid.faces() {
        let at_start = face.plane.axis == 2 && face.plane.at == 0.0;
        let look = match face.solid {
            Some(_) => obstacle,
            None if at_start && face.empty[0] == 0 => window,
            None => room,
        };
        builder.rectangle(face.plane, face.u, face.v, look);
    }
    builder
}
