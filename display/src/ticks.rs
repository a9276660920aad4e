//! Where a legend's ticks stand, and what they say: round numbers 1, 2 and 5 times powers of ten.

use crate::number::with_digits;
use crate::scale::Scale;

/// A tick of a scale.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Its place on the scale, 0 to 1.
    pub position: f64,
    /// What it says; `None` for a minor one.
    pub label: Option<String>,
}

/// The ticks of a scale, from the low end up, of which at most `max_labels` (at least 2) say
/// something.
pub fn ticks(scale: &Scale, max_labels: usize) -> Vec<Tick> {
    if scale.is_logarithmic() {
        // A short range, or one with room for few labels, may hold no power of ten.
        for digits in [&[1, 2, 5][..], &[1, 3], &[1]] {
            let labels = decimal_numbers(scale, digits).count();
            if (2..=max_labels).contains(&labels) {
                return logarithmic(scale, digits, 1);
            }
        }
        let decades = decimal_numbers(scale, &[1]).count();
        if decades > max_labels {
            return logarithmic(scale, &[1], decades.div_ceil(max_labels) as i32);
        }
    }
    linear(scale, max_labels)
}

/// The numbers d 10^n within the range, as (d, n), ascending.
fn decimal_numbers<'a>(scale: &Scale, digits: &'a [i32]) -> impl Iterator<Item = (i32, i32)> + 'a {
    let scale = *scale;
    let range = scale.range();
    let decades = range.low.log10().floor() as i32..=range.high.log10().ceil() as i32;
    decades
        .flat_map(move |n| digits.iter().map(move |&d| (d, n)))
        .filter(move |&(d, n)| is_inside(scale.position(value(d, n))))
}

fn value(digit: i32, exponent: i32) -> f64 {
    // A power of ten in the denominator is exact where 10^-n is not.
    if exponent < 0 {
        f64::from(digit) / 10_f64.powi(-exponent)
    } else {
        f64::from(digit) * 10_f64.powi(exponent)
    }
}

/// On the scale, its ends included: they may be off by the rounding of a few f64 operations.
fn is_inside(position: f64) -> bool {
    const ROUNDING: f64 = 1e-12;
    (-ROUNDING..=1.0 + ROUNDING).contains(&position)
}

fn logarithmic(scale: &Scale, labelled: &[i32], every: i32) -> Vec<Tick> {
    let all = decimal_numbers(scale, &[1, 2, 3, 4, 5, 6, 7, 8, 9]);
    all.map(|(d, n)| Tick {
        position: scale.position(value(d, n)).clamp(0.0, 1.0),
        label: (labelled.contains(&d) && n.rem_euclid(every) == 0).then(|| label(value(d, n))),
    })
    .collect()
}

/// Ticks at multiples of the least round step that keeps to the number of labels.
fn linear(scale: &Scale, max_labels: usize) -> Vec<Tick> {
    let range = scale.range();
    let span = range.high - range.low;
    let first_exponent = span.log10().floor() as i32 - 2;
    let mut steps = (first_exponent..first_exponent + 5).flat_map(|n| [1, 2, 5].map(|d| (d, n)));
    let multiples = |step: f64| (range.high / step).floor() - (range.low / step).ceil() + 1.0;
    let Some((d, n)) = steps.find(|&(d, n)| multiples(value(d, n)) <= max_labels as f64) else {
        return Vec::new();
    };
    let step = value(d, n);
    let first = (range.low / step).ceil() as i64;
    (first..)
        // Multiplied and divided in this order, 3 steps of 0.1 are 0.3.
        .map(|k| {
            let k = k as f64 * f64::from(d);
            if n < 0 {
                k / 10_f64.powi(-n)
            } else {
                k * 10_f64.powi(n)
            }
        })
        .map(|value| (value, scale.position(value)))
        .take_while(|&(_, position)| is_inside(position))
        // Where the range is as fine as f64 itself, neighbouring multiples may be equal.
        .take(max_labels)
        .map(|(value, position)| Tick {
            position: position.clamp(0.0, 1.0),
            label: Some(label(value)),
        })
        .collect()
}

/// All digits that a tick can need, without those of f64's rounding.
fn label(value: f64) -> String {
    with_digits(value, 12)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Range;
    use proptest::prelude::*;

    fn labels(scale: &Scale, max: usize) -> Vec<String> {
        ticks(scale, max)
            .into_iter()
            .filter_map(|t| t.label)
            .collect()
    }

    proptest! {
        #[test]
        fn ticks_are_inside_ascending_and_few_and_say_where_they_are(
            low in 1e-6_f64..1e6, factor in 1.01_f64..1e9, max in 3_usize..15, log: bool
        ) {
            let range = Range { low, high: low * factor };
            let scale = if log { Scale::logarithmic(range) } else { Scale::linear(range) };
            let ticks = ticks(&scale, max);
            prop_assert!(ticks.is_sorted_by(|a, b| a.position < b.position));
            let labelled: Vec<_> = ticks.iter().filter(|t| t.label.is_some()).collect();
            prop_assert!((1..=max).contains(&labelled.len()), "{labelled:?}");
            for tick in &ticks {
                prop_assert!((0.0..=1.0).contains(&tick.position));
                if let Some(label) = &tick.label {
                    let said = scale.position(label.parse().unwrap());
                    prop_assert!((said - tick.position).abs() < 1e-9, "{label}");
                }
            }
        }
    }

    #[test]
    fn linear_ticks_are_round() {
        let scale = Scale::linear(Range {
            low: 0.0,
            high: 0.35,
        });
        assert_eq!(
            labels(&scale, 8),
            ["0", "0.05", "0.1", "0.15", "0.2", "0.25", "0.3", "0.35"]
        );
        assert_eq!(labels(&scale, 4), ["0", "0.1", "0.2", "0.3"]);
    }

    #[test]
    fn logarithmic_ticks_are_1_2_5_where_they_fit() {
        let scale = Scale::logarithmic(Range {
            low: 0.15,
            high: 20.0,
        });
        assert_eq!(labels(&scale, 8), ["0.2", "0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(labels(&scale, 6), ["0.3", "1", "3", "10"]);
        assert_eq!(labels(&scale, 3), ["1", "10"]);
    }

    #[test]
    fn labels_of_extreme_ranges_are_short() {
        for (low, high) in [
            (1e-30, 1e30),
            (2e-31, 7e-30),
            (1.5e29, 1.2e30),
            (1e-38, 1e38),
        ] {
            let range = Range { low, high };
            for scale in [Scale::logarithmic(range), Scale::linear(range)] {
                for label in labels(&scale, 8) {
                    assert!(label.len() <= "2.5e-30".len(), "{label}");
                }
            }
        }
    }

    #[test]
    fn very_long_ranges_leave_decades_out() {
        let scale = Scale::logarithmic(Range {
            low: 1e-6,
            high: 1e6,
        });
        assert_eq!(labels(&scale, 5), ["1e-6", "0.001", "1", "1000", "1e6"]);
    }
}
