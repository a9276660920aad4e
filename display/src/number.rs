//! Numbers as people read them: few digits, and powers of ten where there would be many zeros.

use crate::settings::Range;

/// Digits that a number has at most, where it need not be told from another one.
const DIGITS: usize = 4;

/// A number with at most `digits` (1 or more) significant digits, rounded.
pub fn with_digits(value: f64, digits: usize) -> String {
    let scientific = format!("{value:.*e}", digits - 1);
    // Parsed again, it has the fewest digits that stand for it.
    let rounded: f64 = scientific.parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e5).contains(&rounded.abs()) {
        format!("{rounded}")
    } else {
        format!("{rounded:e}")
    }
}

/// The ends of a range: with four significant digits, or as many more as it takes to tell them
/// apart.
pub fn ends(range: Range) -> [String; 2] {
    let ends = |digits| [range.low, range.high].map(|value| with_digits(value, digits));
    (DIGITS..17)
        .map(ends)
        .find(|[low, high]| low != high)
        .unwrap_or_else(|| ends(17))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn numbers_have_four_digits_at_most_and_are_as_near_as_those_can_be(
            mantissa in -10.0_f64..10.0, exponent in -40_i32..39
        ) {
            let value = mantissa * 10_f64.powi(exponent);
            let text = with_digits(value, 4);
            prop_assert!(text.len() <= "-1.234e-30".len(), "{text}");
            let digits = text.split('e').next().unwrap().replace(['-', '.'], "");
            prop_assert!(digits.trim_matches('0').len() <= 4, "{text}");
            // Half a unit of the fourth digit.
            prop_assert!((text.parse::<f64>().unwrap() - value).abs() <= 5.001e-4 * value.abs());
        }
    }

    #[test]
    fn ends_are_told_apart() {
        let ends = |low, high| ends(Range { low, high });
        assert_eq!(ends(1e-30, 1.0 / 3e-30), ["1e-30", "3.333e29"]);
        assert_eq!(ends(0.0, 0.1 + 0.2), ["0", "0.3"]);
        assert_eq!(ends(1000.0, 1000.5), ["1000", "1000.5"]);
        let next = ends(1.0, 1.0 + f64::EPSILON);
        assert_ne!(next[0], next[1]);
    }
}
