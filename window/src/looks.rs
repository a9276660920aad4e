//! What of a solution is shown, and how.

use display::tone::Tone;
use display::{Mode, Range, Shown};

/// The stops that an exposure can be moved by.
pub const STOPS: std::ops::RangeInclusive<f32> = -10.0..=10.0;

/// All that the panel lets one choose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Looks {
    /// How values become colours.
    pub mode: Mode,
    /// Which values.
    pub shown: Shown,
    /// One value a patch even where there is an irradiance function.
    pub is_flat: bool,
    /// Factors of two by which all is brighter.
    pub exposure_stops: f32,
    /// The scale's ends where they are chosen by hand, in the unit of what is shown.
    pub range: Option<Range>,
    /// Draw the patches' sides over the picture.
    pub has_wires: bool,
    /// Draw the backs of surfaces, black, rather than look through them.
    pub has_backs: bool,
}

impl Default for Looks {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            shown: Shown::default(),
            is_flat: false,
            exposure_stops: 0.0,
            range: None,
            has_wires: false,
            has_backs: false,
        }
    }
}

impl Looks {
    /// The scale's ends, given those that suit the scene.
    ///
    /// Light that is 2^s as bright on a scale is light on one whose ends are divided by 2^s.
    pub fn exposed(&self, suiting: Range) -> Range {
        let Range { low, high } = self.range.filter(is_sound).unwrap_or(suiting);
        let factor = f64::from(-self.exposure_stops).exp2();
        // A logarithm needs more than 0: a ten-thousandth of the high end is as good as nothing.
        let low = if self.mode == Mode::Log && low <= 0.0 {
            1e-4 * high
        } else {
            low
        };
        Range {
            low: low * factor,
            high: high * factor,
        }
    }

    /// The mapping of values to display light, given the range that suits the scene.
    pub fn tone(&self, suiting: Range) -> Tone {
        Tone::new(self.mode, self.exposed(suiting))
    }
}

/// Whether a range has a low and a high end.
fn is_sound(range: &Range) -> bool {
    range.low.is_finite() && range.high.is_finite() && range.low < range.high && range.high > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    const RANGE: Range = Range {
        low: 0.1,
        high: 8.0,
    };

    #[test]
    fn a_stop_more_shows_a_value_as_its_double_was_shown() {
        for mode in [Mode::Log, Mode::Filmic, Mode::Linear, Mode::FalseColor] {
            let at = |exposure_stops| {
                let looks = Looks {
                    mode,
                    exposure_stops,
                    ..Looks::default()
                };
                looks.tone(RANGE)
            };
            for value in [0.2, 0.9, 3.0] {
                let [more, double] = [(at(1.0), value), (at(0.0), 2.0 * value)]
                    .map(|(tone, value)| tone.scale().position(value));
                // f64 rounding of a few operations.
                assert!((more - double).abs() < 1e-12, "{mode}: {more}, {double}");
            }
        }
    }

    #[test]
    fn ends_by_hand_that_make_no_range_are_left_aside() {
        for (low, high) in [(2.0, 1.0), (1.0, 1.0), (f64::NAN, 1.0), (-2.0, -1.0)] {
            let looks = Looks {
                range: Some(Range { low, high }),
                ..Looks::default()
            };
            assert_eq!(looks.exposed(RANGE), RANGE);
        }
    }

    #[test]
    fn a_logarithm_never_starts_at_nothing() {
        let looks = Looks {
            range: Some(Range {
                low: 0.0,
                high: 5.0,
            }),
            ..Looks::default()
        };
        assert!(looks.exposed(RANGE).low > 0.0);
    }
}
