//! The angle by which each hemicube is turned about its normal.
//!
//! Aligned hemicubes make the same errors at the edges of small bright surfaces on whole rows of patches, which shows as
//! bands; turned ones make errors that average out: docs/ACCURACY.md has the figures. The pixel grid is not shifted
//! besides: its pixels would need delta form factors of their own in every hemicube, and what is left to gain is small.
//!
//! The angle follows from where the hemicube stands and from the seed, so that neither the order of a file, nor the
//! refinement of other patches, nor things far away change a row. It is not a function of the coordinates alone: in
//! other units, or rounded anew, these have other digits, and the angle must be the same. So it is taken from the
//! place on the surface, in barycentric coordinates, and from the place of the surface, in its own sizes and rounded.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec3, Vec3};
use scene::Surface;

use crate::settings::Seed;

/// Rounding steps of a surface's place, in its sizes: neighbours of one size are a third of it apart or more.
const STEPS: f64 = 8.0;

/// Where the steps begin. Centroids of regular meshes lie at simple fractions, which must not lie between two steps.
const FIRST_STEP: f64 = 0.381_966_011_250_105_2;

/// Turn of the hemicube on a surface at these barycentric coordinates, radians: within the quarter turn after which a
/// hemicube repeats.
pub(crate) fn turn(surface: &Surface, barycentric: DVec3, seed: Seed) -> f64 {
    let Seed::Number(seed) = seed else {
        return 0.0;
    };
    let corners = surface.corners.map(Vec3::as_dvec3);
    let centroid = corners.into_iter().sum::<DVec3>() / 3.0;
    let size = surface.side_lengths().into_iter().fold(0.0, f64::max);
    let step = (STEPS * centroid / size + FIRST_STEP).floor();
    let place = step.to_array().map(|step| step as i64 as u64);
    let within = barycentric.to_array().map(f64::to_bits);
    hashed(seed, place.into_iter().chain(within))
}

/// Turn of the hemicube at a point that is given by its coordinates, metres.
pub(super) fn turn_at(position: DVec3, seed: Seed) -> f64 {
    let Seed::Number(seed) = seed else {
        return 0.0;
    };
    // Adding 0 turns -0 into 0.
    let bits = (position + DVec3::ZERO).to_array().map(f64::to_bits);
    hashed(seed, bits.into_iter())
}

/// An angle that depends on all bits.
fn hashed(seed: u32, words: impl Iterator<Item = u64>) -> f64 {
    let hash = words.fold(u64::from(seed), |hash, bits| mixed(hash ^ bits));
    // As many bits as an f64 holds.
    (hash >> 11) as f64 / (1_u64 << 53) as f64 * FRAC_PI_2
}

/// A step of SplitMix64: each bit of the output depends on all bits of the input (Steele, Lea and Flood, "Fast
/// splittable pseudorandom number generators", OOPSLA 2014).
pub(crate) fn mixed(state: u64) -> u64 {
    let z = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use scene::{MaterialId, ObjectId, bisection};

    use super::*;

    const SIDE: usize = 200;

    /// Half a square of a regular grid.
    fn triangle(i: usize, j: usize, half: usize) -> Surface {
        let at = |di: usize, dj: usize| Vec3::new((i + di) as f32, (j + dj) as f32, 7.0) / 64.0;
        let corners = [
            [at(0, 0), at(1, 1), at(0, 1)],
            [at(1, 1), at(0, 0), at(1, 0)],
        ];
        Surface {
            corners: corners[half],
            material: MaterialId(0),
            object: ObjectId(0),
        }
    }

    /// Of numbers that are uniform and independent, from -1/2 to 1/2, the mean of n products of two is within five
    /// standard deviations of 0, 5 / (12 sqrt(n)), and that of n of them within 5 / sqrt(12 n).
    fn assert_independent(values: &[f64], others: &[f64]) {
        let n = values.len() as f64;
        let mean = values.iter().sum::<f64>() / n;
        assert!(mean.abs() < 5.0 / (12.0 * n).sqrt(), "{mean}");
        let products = values.iter().zip(others).map(|(a, b)| a * b);
        let covariance = products.sum::<f64>() / n;
        assert!(covariance.abs() < 5.0 / (12.0 * n.sqrt()), "{covariance}");
    }

    fn centred(surface: &Surface, barycentric: DVec3, seed: u32) -> f64 {
        turn(surface, barycentric, Seed::Number(seed)) / FRAC_PI_2 - 0.5
    }

    #[test]
    fn neighbouring_surfaces_of_a_regular_mesh_are_turned_independently() {
        let middle = DVec3::splat(1.0 / 3.0);
        let turns = |di: usize, dj: usize, half: usize, seed: u32| -> Vec<f64> {
            (0..SIDE * SIDE)
                .map(|k| triangle(k % SIDE + di, k / SIDE + dj, half))
                .map(|surface| centred(&surface, middle, seed))
                .collect()
        };
        let here = turns(0, 0, 0, 0);
        for (di, dj, half, seed) in [(1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1)] {
            assert_independent(&here, &turns(di, dj, half, seed));
        }
    }

    #[test]
    fn neighbouring_patches_of_a_surface_are_turned_independently() {
        let surface = triangle(3, 5, 0);
        let at = |code: u32| bisection::leaf_corners(14, code).into_iter().sum::<DVec3>() / 3.0;
        let turns: Vec<f64> = (0..1 << 14)
            .map(|code| centred(&surface, at(code), 0))
            .collect();
        assert_independent(&turns[..turns.len() - 1], &turns[1..]);
    }

    /// In inches, and a power of two smaller.
    #[test]
    fn units_change_no_turn() {
        let at = DVec3::new(0.5, 0.3, 0.2);
        for k in 0..SIDE {
            let surface = triangle(k, 3 * k % SIDE, k % 2);
            let expected = turn(&surface, at, Seed::DEFAULT).to_bits();
            for factor in [1.0 / 0.0254, 1.0 / 1024.0] {
                let scaled = Surface {
                    corners: surface.corners.map(|p| factor * p),
                    ..surface
                };
                assert_eq!(turn(&scaled, at, Seed::DEFAULT).to_bits(), expected);
            }
        }
    }
}
