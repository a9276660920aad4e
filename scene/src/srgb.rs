//! The sRGB transfer function (IEC 61966-2-1), between encoded values, which files and screens have, and linear
//! ones. All are in [0, 1].

/// sRGB to linear.
#[inline]
pub fn decode(encoded: f32) -> f32 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        ((encoded + 0.055) / 1.055).powf(2.4)
    }
}

/// Linear to sRGB.
#[inline]
pub fn encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 {
        linear * 12.92
    } else {
        1.055 * linear.powf(1.0 / 2.4) - 0.055
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// f32 rounding of some ten operations on values up to 1, of which the powers multiply what came before by up to
    /// 2.4.
    const ROUNDING: f32 = 40.0 * f32::EPSILON;

    proptest! {
        #[test]
        fn encoding_undoes_decoding(encoded in 0.0_f32..=1.0) {
            prop_assert!((encode(decode(encoded)) - encoded).abs() <= ROUNDING);
        }
    }
}
