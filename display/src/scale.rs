//! Where on a scale from 0 to 1 a luminance lies, linearly or logarithmically.
//!
//! With the range's ends LO and HI, in W/m^2:
//!
//! linear: t = (Y - LO) / (HI - LO); logarithmic: t = ln(Y / LO) / ln(HI / LO).
//!
//! Y is the [`luminance`], in the unit of what is shown.

pub use crate::luminance::luminance;
use crate::settings::Range;

/// From this quotient of its ends on, false colours are logarithmic. Tuned by eye on the Cornell
/// box, which has 70: on a linear scale most of it has the lowest fifth of the colours.
pub const LOGARITHMIC_FROM: f64 = 30.0;

/// A scale over a range of luminances.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    range: Range,
    is_logarithmic: bool,
    /// t = factor (f(Y) - start), with f the identity or the logarithm.
    start: f64,
    factor: f64,
}

impl Scale {
    /// A linear scale.
    pub fn linear(range: Range) -> Self {
        let factor = 1.0 / (range.high - range.low);
        Self {
            range,
            is_logarithmic: false,
            start: range.low,
            factor,
        }
    }

    /// A logarithmic scale; the range lies above 0.
    pub fn logarithmic(range: Range) -> Self {
        let (start, end) = (range.low.ln(), range.high.ln());
        Self {
            range,
            is_logarithmic: true,
            start,
            factor: 1.0 / (end - start),
        }
    }

    /// Logarithmic where the range's ends differ by [`LOGARITHMIC_FROM`] or more, else linear.
    pub fn suiting(range: Range) -> Self {
        if range.low > 0.0 && range.high / range.low >= LOGARITHMIC_FROM {
            Self::logarithmic(range)
        } else {
            Self::linear(range)
        }
    }

    /// The luminances at the ends, W/m^2.
    pub fn range(&self) -> Range {
        self.range
    }

    /// True for a logarithmic scale.
    pub fn is_logarithmic(&self) -> bool {
        self.is_logarithmic
    }

    /// What people call it.
    pub fn kind(&self) -> &'static str {
        if self.is_logarithmic { "log" } else { "linear" }
    }

    /// Where a luminance lies: 0 at the range's low end, 1 at its high end, not clamped. On a
    /// logarithmic scale, 0 W/m^2 lies at minus infinity.
    #[inline]
    pub fn position(&self, luminance: f64) -> f64 {
        let value = if self.is_logarithmic {
            luminance.max(0.0).ln()
        } else {
            luminance
        };
        (value - self.start) * self.factor
    }
}
