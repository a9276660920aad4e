//! Delta form factors: what each pixel of a hemicube contributes to a form factor.
//!
//! # Theory
//! A pixel of the top face at (x, y, 1) sees dF = dA / (pi r^4), r^2 = 1 + x^2 + y^2; a pixel of a
//! side face at (1, y, z) sees dF = z dA / (pi r^4), r^2 = 1 + y^2 + z^2 (Cohen and Greenberg,
//! SIGGRAPH 1985, section 4). Both integrals over a rectangle have closed forms. With
//! s(t) = sqrt(1 + t^2), the antiderivatives in both coordinates are
//!
//! top:  (x/s(x) atan(y/s(x)) + y/s(y) atan(x/s(y))) / (2 pi)
//! side: -atan(y/s(z)) / (2 pi s(z))
//!
//! so the pixels of a hemicube sum to exactly 1, at every resolution, with no normalising.
//!
//! # Practice
//! A form factor is the sum of the delta form factors of the pixels that see a patch. They are kept
//! as integers in units of 1/[`UNITS_PER_ONE`](crate::rows::UNITS_PER_ONE): sums of integers do not depend on their order, so
//! every back end and every number of threads gives the same bits, a closed room's row sums to
//! exactly 1, and a GPU can sum with atomic integers. A unit is about 2^-32 of a row, however
//! many hemicubes a row has; rounding is carried on from pixel to pixel, so any run of pixels is right to one unit.
//!
//! # Differences
//! The thesis multiplies by 1/r on top and z/r^2 at the sides and normalises the sum to 1. It
//! forgets that a pixel's solid angle falls with 1/r^3, and so overweights the rim. That map is
//! here as [`Maps::Thesis`], to compare.

use std::f64::consts::PI;

use crate::settings::Maps;

/// The delta form factors of a hemicube, as integers.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DeltaFormFactors {
    /// Pixels along a face.
    resolution: u32,
    /// R x R, rows along x.
    top: Vec<u32>,
    /// R x R/2, rows from the horizon up; the same for all four sides.
    side: Vec<u32>,
    /// Sums along the rows, R + 1 a row: of the pixels before each.
    top_sums: Vec<u32>,
    side_sums: Vec<u32>,
}

impl DeltaFormFactors {
    /// The table for a resolution, which is even and at least 2. All pixels of one hemicube sum to
    /// `units_per_hemicube` exactly.
    pub fn new(maps: Maps, resolution: u32, units_per_hemicube: u32) -> Self {
        let size = resolution as usize;
        let [top, side] = multipliers(maps, resolution);
        let side_units = (f64::from(units_per_hemicube) * side.iter().sum::<f64>()).round() as u64;
        let top_units = u64::from(units_per_hemicube) - 4 * side_units;
        let (top, side) = (quantise(&top, top_units), quantise(&side, side_units));
        Self {
            resolution,
            top_sums: sums(&top, size),
            side_sums: sums(&side, size),
            top,
            side,
        }
    }

    /// Pixels along a face.
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// The table of one of the five faces, in the order of [`visibility::hemicube::windows`], row by row.
    pub fn face(&self, face: usize) -> &[u32] {
        if face == 0 { &self.top } else { &self.side }
    }

    /// Row j of a face as sums of the pixels before each, R + 1 of them: differences are sums over runs of pixels.
    pub fn row_sums(&self, face: usize, j: usize) -> &[u32] {
        let sums = if face == 0 {
            &self.top_sums
        } else {
            &self.side_sums
        };
        let stride = self.resolution as usize + 1;
        &sums[j * stride..][..stride]
    }
}

/// The multipliers of the top face and of a side, dimensionless, in the layout of [`DeltaFormFactors::face`], before they
/// become integers. A hemicube sums to 1. The resolution is even and at least 2.
pub fn multipliers(maps: Maps, resolution: u32) -> [Vec<f64>; 2] {
    let size = resolution as usize;
    let (top, side) = match maps {
        Maps::Exact => exact(size),
        Maps::Thesis => thesis(size),
    };
    [top, side]
}

/// Sums of the values before each place in rows of `size`, the place after the last included.
fn sums(values: &[u32], size: usize) -> Vec<u32> {
    values
        .chunks_exact(size)
        .flat_map(|row| {
            let mut sum = 0;
            std::iter::once(0).chain(row.iter().map(move |value| {
                sum += value;
                sum
            }))
        })
        .collect()
}

/// The closed forms, for the top and one side.
fn exact(size: usize) -> (Vec<f64>, Vec<f64>) {
    let s = |t: f64| (1.0 + t * t).sqrt();
    let top =
        |x: f64, y: f64| (x / s(x) * (y / s(x)).atan() + y / s(y) * (x / s(y)).atan()) / (2.0 * PI);
    let side = |y: f64, z: f64| -(y / s(z)).atan() / (2.0 * PI * s(z));
    (
        integrals(size, -1.0, size, top),
        integrals(size, 0.0, size / 2, side),
    )
}

/// Integrals over all pixels of a face whose first row starts at `bottom`, by their antiderivative.
fn integrals(
    size: usize,
    bottom: f64,
    rows: usize,
    antiderivative: impl Fn(f64, f64) -> f64,
) -> Vec<f64> {
    let pixel = 2.0 / size as f64;
    let edge_values = |j: usize| -> Vec<f64> {
        let v = bottom + j as f64 * pixel;
        (0..=size)
            .map(|i| antiderivative(-1.0 + i as f64 * pixel, v))
            .collect()
    };
    let mut below = edge_values(0);
    let mut values = Vec::with_capacity(size * rows);
    for j in 1..=rows {
        let above = edge_values(j);
        values.extend((0..size).map(|i| above[i + 1] - above[i] - below[i + 1] + below[i]));
        below = above;
    }
    values
}

/// The thesis's multipliers at the pixels' centres, normalised so that a hemicube sums to 1.
fn thesis(size: usize) -> (Vec<f64>, Vec<f64>) {
    let pixel = 2.0 / size as f64;
    let centre = |i: usize| (i as f64 + 0.5) * pixel;
    let grid = |rows: usize, value: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        (0..size * rows)
            .map(|k| value(centre(k % size) - 1.0, centre(k / size)))
            .collect()
    };
    let mut top = grid(size, &|x, y| 1.0 / (1.0 + x * x + (y - 1.0).powi(2)).sqrt());
    let mut side = grid(size / 2, &|y, z| z / (1.0 + y * y + z * z));
    let total = top.iter().sum::<f64>() + 4.0 * side.iter().sum::<f64>();
    for value in top.iter_mut().chain(&mut side) {
        *value /= total;
    }
    (top, side)
}

/// Integers in proportion to `values` that sum to `units`, the rounding error carried along.
fn quantise(values: &[f64], units: u64) -> Vec<u32> {
    let scale = units as f64 / values.iter().sum::<f64>();
    let mut sum = 0.0;
    let mut given = 0_u64;
    let mut quantised: Vec<u32> = values
        .iter()
        .map(|value| {
            sum += value * scale;
            let share = (sum.round() as u64).saturating_sub(given);
            given += share;
            share as u32
        })
        .collect();
    // The f64 sum may end a unit or so off; the pixels of a face's last row can take that.
    if let Some(last) = quantised
        .iter_mut()
        .rev()
        .find(|q| u64::from(**q) + units >= given)
    {
        *last = (u64::from(*last) + units - given) as u32;
    }
    quantised
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNITS: u32 = u32::MAX;

    fn total(factors: &DeltaFormFactors) -> u64 {
        (0..5)
            .flat_map(|face| factors.face(face))
            .map(|&f| u64::from(f))
            .sum()
    }

    #[test]
    fn hemicube_sums_to_one_at_every_resolution() {
        for maps in [Maps::Exact, Maps::Thesis] {
            for resolution in [2, 4, 6, 50, 100, 128, 500, 1024] {
                for units in [UNITS, UNITS / 3, UNITS / 64] {
                    let factors = DeltaFormFactors::new(maps, resolution, units);
                    assert_eq!(total(&factors), u64::from(units), "{maps:?} {resolution}");
                }
            }
        }
    }

    /// The closed forms sum to 1 by themselves: f64 rounding of 3 R^2 differences of numbers below 1
    /// stays under 3 R^2 2^-53 = 2e-12 for R = 100.
    #[test]
    fn closed_forms_need_no_normalising() {
        for size in [2, 10, 100] {
            let (top, side) = exact(size);
            let sum = top.iter().sum::<f64>() + 4.0 * side.iter().sum::<f64>();
            assert!((sum - 1.0).abs() < 2e-12, "{sum}");
        }
    }

    /// Midpoint rule with n x n points a pixel: relative error is under (pixel/n)^2 times a second
    /// derivative that is below 10 for both integrands on these ranges.
    #[test]
    fn closed_forms_agree_with_quadrature() {
        let (size, n) = (10, 40);
        let (top, side) = exact(size);
        let pixel = 2.0 / size as f64;
        let quadrature = |i: usize, j: usize, bottom: f64, f: &dyn Fn(f64, f64) -> f64| {
            let step = pixel / n as f64;
            (0..n * n)
                .map(|k| {
                    let u = -1.0 + i as f64 * pixel + ((k % n) as f64 + 0.5) * step;
                    let v = bottom + j as f64 * pixel + ((k / n) as f64 + 0.5) * step;
                    f(u, v) * step * step
                })
                .sum::<f64>()
        };
        let tolerance = 10.0 * (pixel / n as f64).powi(2);
        for (k, value) in top.iter().enumerate() {
            let expected = quadrature(k % size, k / size, -1.0, &|x, y| {
                1.0 / (PI * (1.0 + x * x + y * y).powi(2))
            });
            assert!(
                (value / expected - 1.0).abs() < tolerance,
                "top {k}: {value} {expected}"
            );
        }
        for (k, value) in side.iter().enumerate() {
            let expected = quadrature(k % size, k / size, 0.0, &|y, z| {
                z / (PI * (1.0 + y * y + z * z).powi(2))
            });
            assert!(
                (value / expected - 1.0).abs() < tolerance,
                "side {k}: {value} {expected}"
            );
        }
    }

    #[test]
    fn quantised_runs_are_right_to_one_unit() {
        let (top, _) = exact(64);
        let factors = DeltaFormFactors::new(Maps::Exact, 64, UNITS);
        let (mut exact_sum, mut sum) = (0.0, 0.0);
        for (value, &units) in top.iter().zip(factors.face(0)) {
            exact_sum += value * f64::from(UNITS);
            sum += f64::from(units);
            // One unit, and one more for what the split between top and sides rounds away.
            assert!((exact_sum - sum).abs() <= 2.0, "{exact_sum} {sum}");
        }
    }

    /// From the centre of the top face to its corner 1/r^4 falls by 9, 1/r by sqrt(3). Pixel centres
    /// are 1/100 away from both, which moves either ratio by under 4/100.
    #[test]
    fn thesis_maps_overweight_the_rim() {
        let fall = |maps| {
            let factors = DeltaFormFactors::new(maps, 100, UNITS);
            f64::from(factors.face(0)[50 * 100 + 50]) / f64::from(factors.face(0)[0])
        };
        assert!((fall(Maps::Exact) / 9.0 - 1.0).abs() < 0.04);
        assert!((fall(Maps::Thesis) / 3_f64.sqrt() - 1.0).abs() < 0.04);
    }
}
