//! Runs of equal values in a row of pixels.

use fearless_simd::{Simd, prelude::*};

/// Hands out the runs of a row: the value, the first pixel, the pixel after the last.
#[inline(always)]
pub fn for_each_run<S: Simd>(simd: S, values: &[u32], mut take: impl FnMut(u32, usize, usize)) {
    if values.is_empty() {
        return;
    }
    let lanes = S::u32s::LEN;
    let mut start = 0;
    let mut from = 1;
    while from + lanes <= values.len() {
        let here = S::u32s::from_slice(simd, &values[from..from + lanes]);
        let left = S::u32s::from_slice(simd, &values[from - 1..from - 1 + lanes]);
        let mut ends = (!here.simd_eq(left)).to_bitmask();
        while ends != 0 {
            let end = from + ends.trailing_zeros() as usize;
            take(values[start], start, end);
            start = end;
            ends &= ends - 1;
        }
        from += lanes;
    }
    for end in from..values.len() {
        if values[end] != values[end - 1] {
            take(values[start], start, end);
            start = end;
        }
    }
    take(values[start], start, values.len());
}

#[cfg(test)]
mod tests {
    use fearless_simd::{Level, dispatch};
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn runs_cover_a_row_and_are_as_long_as_can_be(
            values in prop::collection::vec(0_u32..3, 0..80)
        ) {
            let mut runs = Vec::new();
            dispatch!(Level::new(), simd => for_each_run(simd, &values, |value, start, end| {
                runs.push((value, start, end));
            }));
            let mut next = 0;
            for (k, &(value, start, end)) in runs.iter().enumerate() {
                prop_assert!(start == next && end > start);
                prop_assert!(values[start..end].iter().all(|&v| v == value));
                prop_assert!(k == 0 || runs[k - 1].0 != value);
                next = end;
            }
            prop_assert_eq!(next, values.len());
        }
    }
}
