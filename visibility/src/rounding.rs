//! How far off what is computed from coordinates may be, since these are f32.

use glam::{DVec3, Vec3};
use scene::{Scene, Surface};

/// Units in the last place (2^-24 relative) by which f32 coordinates are taken to be uncertain.
pub const COORDINATE_ULPS: f64 = 4.0 / (1 << 24) as f64;

/// Front faces are drawn this much too large, in pixels, so that a ray through an edge or a corner
/// meets a front whatever the rounding, where surfaces only touch (T-junctions) too: above the f64
/// rounding of a crossing, 2^-53 times some thousands of pixels, and far below a pixel.
pub(crate) const FRONT_FACE_OUTSET: f64 = 1e-9;

/// The most that margins for rounded corners may move an edge, in pixels: what is so far away that its own
/// coordinates are less certain than that is not to grow by it.
pub(crate) const MOST_MARGIN: f64 = 1.0 / 256.0;

/// Back faces are drawn this much too deep, so that a pixel on the silhouette of a solid, where a
/// front and a back face meet at equal depth, sees the front: well above the rounding of an f32
/// depth (2^-24) and of its steps along a row, well below any wall's thickness.
const BACK_FACE_RETREAT: f64 = 1.0 - 1.0 / (1 << 19) as f64;

/// Boxes are larger than what is in them by this many of the scene's plane tolerance: by the margins of
/// fronts, and by the rounding of coordinates and of rays to f32.
pub(crate) const BOX_MARGIN: f64 = 8.0;

/// What the inverse depth of a front or a back is multiplied by.
#[inline(always)]
pub(crate) fn retreat(is_back_face: bool) -> f64 {
    if is_back_face { BACK_FACE_RETREAT } else { 1.0 }
}

/// A point's distance from a plane through others like it is uncertain by at most about this, metres: by
/// some units in the last place of the scene's largest coordinate. Where it matters
/// [`is_in_plane`] is sharper.
pub fn plane_tolerance(scene: &Scene) -> f64 {
    let [low, high] = scene.bounds();
    f64::from(low.abs().max(high.abs()).max_element()) * COORDINATE_ULPS
}

/// True where a distance of `height` metres from a plane is no more than rounding: `tolerance`, which is
/// [`plane_tolerance`], and what the coordinates themselves are uncertain by, each along its own axis.
/// In a scene with things far away the second is far less for all the others. `normal` is the plane's,
/// a unit vector; `reach` is the largest magnitude of the coordinates, metres.
pub fn is_in_plane(height: f64, tolerance: f64, normal: DVec3, reach: DVec3) -> bool {
    height <= tolerance && height <= COORDINATE_ULPS * normal.abs().dot(reach)
}

/// Largest magnitude of a surface's coordinates, by axis, metres.
pub fn reach(surface: &Surface) -> DVec3 {
    let [p0, p1, p2] = surface.corners.map(Vec3::abs);
    p0.max(p1).max(p2).as_dvec3()
}

/// How much too large a front is drawn at one edge, so that a ray between pieces whose common corners are the
/// same but for rounding meets one of them. A corner that is off by s across the edge's plane q_i x q_j moves
/// that plane by s times the other corner's length at most; no ray through a hemicube's pixel is longer than
/// sqrt(3). `across` is given in the axes of the corners and in the scene's, corners relative to the eye and as
/// magnitudes of their coordinates, metres.
#[inline(always)]
pub(crate) fn margin(
    across: DVec3,
    in_scene: DVec3,
    (from, from_magnitude): (DVec3, DVec3),
    (to, to_magnitude): (DVec3, DVec3),
) -> f64 {
    const LONGEST_RAY: f64 = 1.732_050_807_568_877_2;
    let length = across.length();
    if length == 0.0 {
        return 0.0;
    }
    let in_scene = in_scene.abs();
    let off_from = in_scene.dot(from_magnitude);
    let off_to = in_scene.dot(to_magnitude);
    LONGEST_RAY * COORDINATE_ULPS * (off_from * to.length() + off_to * from.length()) / length
}
