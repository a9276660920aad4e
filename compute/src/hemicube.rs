//! The hemicube over a point of a patch: its frame, its five faces, its pixels.
//!
//! # Theory
//! Half a cube of edge 2 stands over the point with its axis along the patch's normal (Cohen and
//! Greenberg, "The hemi-cube: a radiosity solution for complex environments", SIGGRAPH 1985). A
//! full face on top and four half faces at the sides are cut into square pixels. In the frame
//! (tangent, bitangent, normal) a pixel of the top face sits at (x, y, 1), one of a side face at
//! (1, y, z), turned about the normal by a multiple of 90 degrees.
//!
//! # Practice
//! A hemicube of resolution R has R x R pixels on top and R x R/2 on each side. They are kept as
//! one picture of width R and height 3R: the top face, then the sides towards +tangent,
//! +bitangent, -tangent and -bitangent; the rows of a side run from the horizon up.
//!
//! # Differences
//! Every hemicube is turned about its normal by an angle of its own. Aligned ones make the same errors
//! at the edges of small bright surfaces on whole rows of patches, which shows as bands; turned ones
//! make errors that average out: docs/ACCURACY.md has the figures. The pixel grid is not shifted besides:
//! its pixels would need delta form factors of their own in every hemicube, and what is left to gain is
//! small.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};
use scene::Patch;

use crate::settings::Turns;

/// The largest resolution, pixels along a face.
pub const MAX_RESOLUTION: u32 = 4096;

/// An orthonormal right-handed frame at a point of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The eye, metres, relative to the scene's origin.
    pub position: DVec3,
    /// Unit vector in the patch's plane.
    pub tangent: DVec3,
    /// normal x tangent.
    pub bitangent: DVec3,
    /// Unit normal of the patch, or of the wall that it is part of.
    pub normal: DVec3,
}

impl Frame {
    /// A frame at `position` on a patch, whose tangent is the patch's reference edge turned about the
    /// normal by `turn` radians: results do not depend on how the model lies in its coordinates.
    pub fn on_patch(patch: &Patch, normal: DVec3, position: DVec3, turn: f64) -> Self {
        let [p0, p1, _] = patch.corners.map(Vec3::as_dvec3);
        // A patch so small that its corners fall together in f32 has no edge to follow.
        let aligned = (p1 - p0)
            .reject_from_normalized(normal)
            .try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        let (sin, cos) = turn.sin_cos();
        let tangent = cos * aligned + sin * normal.cross(aligned);
        Self {
            position,
            tangent,
            bitangent: normal.cross(tangent),
            normal,
        }
    }

    /// A vector of this frame in the scene's axes.
    #[inline]
    pub fn to_scene(&self, vector: DVec3) -> DVec3 {
        vector.x * self.tangent + vector.y * self.bitangent + vector.z * self.normal
    }

    /// A vector of the scene in this frame.
    #[inline]
    pub fn vector_to_local(&self, vector: DVec3) -> DVec3 {
        DVec3::new(
            vector.dot(self.tangent),
            vector.dot(self.bitangent),
            vector.dot(self.normal),
        )
    }

    /// A point in this frame: along tangent, bitangent and normal, metres.
    #[inline]
    pub fn to_local(&self, point: DVec3) -> DVec3 {
        self.vector_to_local(point - self.position)
    }
}

/// Turn of the hemicube of a number, radians: steps of the golden ratio fill the quarter turn after
/// which a hemicube repeats, for any run of numbers as evenly as can be (Weyl's sequence). Seeds start the
/// sequence elsewhere, in steps of another irrational number.
pub fn turn(number: u64, turns: Turns) -> f64 {
    const GOLDEN_RATIO: f64 = 0.618_033_988_749_894_9;
    const ROOT_OF_TWO: f64 = std::f64::consts::SQRT_2;
    match turns {
        Turns::Aligned => 0.0,
        Turns::Seeded(seed) => {
            let quarters = number as f64 * GOLDEN_RATIO + f64::from(seed) * ROOT_OF_TWO;
            quarters.fract() * FRAC_PI_2
        }
    }
}

/// One face as a picture: rays through the centres of square pixels, in the hemicube's frame.
///
/// Pixel (i, j) looks along `forward + x right + y up` with x = left + (i + 1/2) pixel and
/// y = bottom + (j + 1/2) pixel. Also used for cameras.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Unit vector, direction of growing i.
    pub right: DVec3,
    /// Unit vector, direction of growing j.
    pub up: DVec3,
    /// Unit vector into the picture.
    pub forward: DVec3,
    /// Edge of the first column on the plane at distance 1, dimensionless.
    pub left: f64,
    /// Edge of the first row on the plane at distance 1, dimensionless.
    pub bottom: f64,
    /// Side of a pixel on the plane at distance 1, dimensionless.
    pub pixel: f64,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

/// The five faces of a hemicube of resolution R: top, +tangent, +bitangent, -tangent, -bitangent.
pub fn windows(resolution: u32) -> [Window; 5] {
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
