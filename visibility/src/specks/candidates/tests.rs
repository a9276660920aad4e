//! Which pixels are left to be tried.

use fearless_simd::{Level, dispatch};
use proptest::prelude::*;

use super::*;

/// How far a point is inside of a triangle, by its three sides: below 0 outside, in pixels along both axes.
fn inside(x: [f32; 3], y: [f32; 3], [i, j]: [i32; 2]) -> f64 {
    let [x, y] = [x, y].map(|axis| axis.map(f64::from));
    let sides = [0, 1, 2].map(|k| {
        let next = (k + 1) % 3;
        let (dx, dy) = (x[next] - x[k], y[next] - y[k]);
        let across = (f64::from(j) - y[k]) * dx - (f64::from(i) - x[k]) * dy;
        across / (dx.abs() + dy.abs())
    });
    let turned = sides.map(|side| -side);
    let least = |sides: [f64; 3]| sides.into_iter().fold(f64::INFINITY, f64::min);
    least(sides).max(least(turned))
}

proptest! {
    /// All that are inside or within [`GROWTH`] of the sides, and none besides. Of places below 28 pixels f32 takes
    /// differences right to 28 x 2^-24; over the least side's 0.05 and times 28 pixels that is 9.3e-4, and products
    /// round by less.
    #[test]
    fn held_pixels_are_those_inside_or_near(
        x in prop::array::uniform3(-3.0_f32..25.0),
        y in prop::array::uniform3(-3.0_f32..25.0),
        columns in 1..=MOST_PIXELS,
        part in 0.0..1.0_f64,
    ) {
        const ROUNDING: f64 = 1e-3;
        let sides = [0, 1, 2].map(|k: usize| {
            let next = (k + 1) % 3;
            (x[next] - x[k]).abs() + (y[next] - y[k]).abs()
        });
        prop_assume!(sides.iter().all(|&side| side > 0.05));
        let rows = 1 + (part * f64::from(MOST_PIXELS / columns - 1)).round() as i32;
        let level = Level::new();
        let held = dispatch!(level, simd => held(simd, x, y, columns, rows));
        for pixel in 0..32 {
            let at = [pixel % columns, pixel / columns];
            let is_held = held >> pixel & 1 != 0;
            if pixel >= columns * rows {
                prop_assert!(!is_held, "{at:?} is no pixel");
                continue;
            }
            let within = inside(x, y, at) + f64::from(GROWTH);
            prop_assert!(is_held || within < ROUNDING, "{at:?} is lost");
            prop_assert!(!is_held || within > -ROUNDING, "{at:?} is held");
        }
    }
}
