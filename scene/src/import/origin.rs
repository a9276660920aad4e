//! The place near a model that its positions are taken from, so that they fit f32.

use glam::{DVec3, Vec3};

/// Margin on the largest extent, so that models whose extent is a power of two, which are common,
/// do not change their grid, and with it the origin, by rounding. Tuned: any odd ratio serves.
const EXTENT_MARGIN: f64 = 1.1;

/// The middle of the bounding box, rounded as the module's documentation says.
pub(crate) fn origin_of(positions: impl Iterator<Item = DVec3>) -> DVec3 {
    let (low, high) = positions.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), p| {
        (low.min(p), high.max(p))
    });
    let grid = (EXTENT_MARGIN * (high - low).max_element())
        .log2()
        .ceil()
        .exp2();
    let origin = ((0.5 * low + 0.5 * high) / grid).round() * grid;
    // Not finite only for extents of zero, or beyond f32, where an error follows.
    if origin.is_finite() {
        origin + DVec3::ZERO // no negative zeros
    } else {
        DVec3::ZERO
    }
}

/// A coordinate that single precision cannot have, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Overflow {
    pub value: f64,
    pub from_centre: f64,
}

/// A position from the origin.
pub(crate) fn centred(position: DVec3, origin: DVec3) -> Result<Vec3, Overflow> {
    let centred = (position - origin).as_vec3();
    for axis in 0..3 {
        if !centred[axis].is_finite() {
            return Err(Overflow {
                value: position[axis],
                from_centre: (position - origin)[axis],
            });
        }
    }
    Ok(centred)
}
