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

/// The least number with at most `digits` (1 or more) significant digits that is not below a positive one.
pub fn rounded_up(value: f64, digits: i32) -> f64 {
    let exponent = value.log10().floor() as i32 + 1 - digits;
    // A power of ten in the denominator is exact where 10^-n is not.
    let units = if exponent >= 0 {
        value / 10_f64.powi(exponent)
    } else {
        value * 10_f64.powi(-exponent)
    };
    format!("{}e{exponent}", units.ceil())
        .parse()
        .unwrap_or(value)
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

    proptest! {
        #[test]
        fn numbers_are_rounded_up_by_less_than_a_unit_of_their_last_digit(
            mantissa in 1.0_f64..10.0, exponent in -45_i32..39
        ) {
            let value = mantissa * 10_f64.powi(exponent);
            let rounded = rounded_up(value, 2);
            // Within f64 rounding of a few operations.
            prop_assert!(rounded >= value * (1.0 - 1e-15) && rounded < value * 1.1);
            let printed = with_digits(rounded, 17);
            prop_assert!(printed.len() <= "1.2e-45".len(), "{printed}");
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
