//! The hemicube over a point of a surface: its five faces and their pixels.
//!
//! # Theory
//! Half a cube of edge 2 stands over the point with its axis along the surface's normal (Cohen and
//! Greenberg, "The hemi-cube: a radiosity solution for complex environments", SIGGRAPH 1985). A
//! full face on top and four half faces at the sides are cut into square pixels. In the frame
//! (tangent, bitangent, normal) a pixel of the top face sits at (x, y, 1), one of a side face at
//! (1, y, z), turned about the normal by a multiple of 90 degrees.
//!
//! # Practice
//! A hemicube of resolution R has R x R pixels on top and R x R/2 on each side. They are kept as
//! one picture of width R and height 3R: the top face, then the sides towards +tangent,
//! +bitangent, -tangent and -bitangent; the rows of a side run from the horizon up.

use glam::DVec3;

use crate::Window;

/// The largest resolution, pixels along a face.
pub const MAX_RESOLUTION: u32 = 4096;

/// Faces of a hemicube.
pub const FACES: usize = 5;

/// The five faces of a hemicube of resolution R: top, +tangent, +bitangent, -tangent, -bitangent.
pub fn windows(resolution: u32) -> [Window; FACES] {
    let size = resolution as usize;
    let pixel = 2.0 / f64::from(resolution);
    let side = |forward: DVec3| Window {
        right: DVec3::Z.cross(forward),
        up: DVec3::Z,
        forward,
        left: -1.0,
        bottom: 0.0,
        pixel,
        width: size,
        height: size / 2,
    };
    [
        Window {
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::Z,
            left: -1.0,
            bottom: -1.0,
            pixel,
            width: size,
            height: size,
        },
        side(DVec3::X),
        side(DVec3::Y),
        side(-DVec3::X),
        side(-DVec3::Y),
    ]
}

/// Pixels of a whole hemicube: 3 R^2.
pub fn pixel_count(resolution: u32) -> usize {
    3 * resolution as usize * resolution as usize
}
