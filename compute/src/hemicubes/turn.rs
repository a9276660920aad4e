//! The angle by which each hemicube is turned about its normal.
//!
//! Aligned hemicubes make the same errors at the edges of small bright surfaces on whole rows of patches, which shows as
//! bands; turned ones make errors that average out: docs/ACCURACY.md has the figures. The pixel grid is not shifted
//! besides: its pixels would need delta form factors of their own in every hemicube, and what is left to gain is small.

use std::f64::consts::FRAC_PI_2;

use crate::settings::Turns;

/// Turn of the hemicube of a number, radians: steps of the golden ratio fill the quarter turn after
/// which a hemicube repeats, for any run of numbers as evenly as can be (Weyl's sequence). Seeds start the
/// sequence elsewhere, in steps of another irrational number.
pub(super) fn turn(number: u64, turns: Turns) -> f64 {
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
