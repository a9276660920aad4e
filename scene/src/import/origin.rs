//! The place near a model that its positions are taken from, so that they fit f32.

use glam::{DVec3, Vec3};

/// Margin on the largest extent, so that models whose extent is a power of two, which are common,
/// do not change their grid, and with it the origin, by rounding. Tuned: any odd ratio serves.
const EXTENT_MARGIN: f64 = 1.1;

/// The bounding box of a model's positions, metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bounds {
    low: DVec3,
    high: DVec3,
}

impl Bounds {
    pub(crate) const NOTHING: Self = Self {
        low: DVec3::INFINITY,
        high: DVec3::NEG_INFINITY,
    };

    #[must_use]
    pub(crate) fn with(self, position: DVec3) -> Self {
        Self {
            low: self.low.min(position),
            high: self.high.max(position),
        }
    }

    /// The middle, rounded as the module's documentation says.
    pub(crate) fn origin(self) -> DVec3 {
        let Self { low, high } = self;
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
