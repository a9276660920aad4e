//! How far a solution is from the one that its solver goes to, told by the residuals alone.
//!
//! # Theory
//! In the end each iteration shrinks what is wrong by the same factor q, the rate. The last change is
//! c_k = r_k |B_k| for a residual r_k, and all that are still to come sum to c_k (q + q^2 + ...): as a share
//! of B_k
//!
//! e = r_k q / (1 - q)
//!
//! (Saad, "Iterative methods for sparse linear systems", 2003, section 4.2). Where reflectances are near 1
//! this is not small with the residual: a closed room of reflectance 0.999999 changes by a hundred
//! thousandth in an iteration when a tenth of its radiosity is there. The residuals tell the rate too,
//! since |B_{i-1}| >= |B_i| (1 - r_i), with equality where the change is in proportion to B, as it is when
//! q is near 1. Over a lag of m iterations
//!
//! q^m = c_k / c_{k-m} <= r_k / (r_{k-m} (1 - r_{k-m+1}) ... (1 - r_k))
//!
//! Shooting's residual is the unshot power as a share of what is emitted. Reflected as often as that was,
//! it adds the same share of the radiosity, so there e = r_k.
//!
//! # Practice
//! The state is f32. B = E + rho H rounds three times in each iteration, and an error repeated in each is
//! one of 1 / (1 - q) times as much in the end; no iteration takes it away. A change near the rounding
//! tells no rate, so the lag is doubled until the changes have fallen over it by clearly more than that.

use serde::Serialize;

use crate::settings::SolverChoice;

/// What an iteration's roundings may add to a radiosity, relative: H, rho H and E + rho H, half a unit
/// in the last place of an f32 each.
const ROUNDING: f64 = 3.0 / (1 << 24) as f64;

/// How much more than by rounding the changes must fall over a lag before it tells a rate.
const CLEARLY: f64 = 4.0;

/// The error beyond which a user should know, dimensionless: as much as unoccluded form factors may have.
pub const ERROR_TOLERANCE: f64 = 1e-3;

/// What a solver's residuals tell of the way it still has to go.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Convergence {
    /// Factor q by which an iteration shrinks what is wrong, dimensionless, 0 to 1.
    pub rate: f64,
    /// Estimated difference to the solution the solver goes to, as a share of that, dimensionless, 0 to
    /// 1: root mean square by area.
    pub estimated_error: f64,
    /// What rounding may leave of it after any number of iterations; shooting's is not known and 0.
    pub rounding_error: f64,
}

impl Convergence {
    /// From the residual after each iteration; `None` before the second.
    pub fn new(solver: SolverChoice, residuals: &[f64]) -> Option<Self> {
        let &last = residuals.last()?;
        if solver == SolverChoice::Shooting {
            return Some(Self {
                rate: rate(residuals, |_| 1.0)?,
                estimated_error: last.min(1.0),
                rounding_error: 0.0,
            });
        }
        let rate = rate(residuals, |residual| 1.0 - residual)?;
        Some(Self {
            rate,
            estimated_error: share(last * rate / (1.0 - rate) + ROUNDING / (1.0 - rate)),
            rounding_error: share(ROUNDING / (1.0 - rate)),
        })
    }

    /// About how many more iterations come within `error`, dimensionless; `None` where none do.
    pub fn iterations_to(&self, error: f64) -> Option<u64> {
        if self.estimated_error <= error {
            return Some(0);
        }
        if self.rate >= 1.0 || self.rounding_error >= error {
            return None;
        }
        let left = (error - self.rounding_error) / (self.estimated_error - self.rounding_error);
        Some((left.ln() / self.rate.ln()).ceil() as u64)
    }

    /// The residual of a gathering solver that is within `error`, dimensionless.
    fn residual_at(&self, error: f64) -> f64 {
        (error / (1.0 - error) * (1.0 - self.rate) - ROUNDING) / self.rate
    }

    /// What a user should know whose gathering solver stopped at a residual of `tolerance`, if anything.
    pub fn warning(&self, tolerance: f64) -> Option<String> {
        let most = ERROR_TOLERANCE.max(tolerance);
        if self.estimated_error <= most {
            return None;
        }
        let mut parts = vec![format!(
            "not converged: radiosities hardly change any more, but are an estimated {:.1} percent from the \
             solution, since an iteration takes only {:.1e} percent of that away",
            100.0 * self.estimated_error,
            100.0 * (1.0 - self.rate)
        )];
        // Where rounding keeps the most away, twice of it can be had.
        let least = most.max(2.0 * self.rounding_error);
        if let Some(more @ 1..) = self.iterations_to(least) {
            parts.push(format!(
                "about {more} more, with --tolerance {:.1e}, come within {:.1} percent",
                self.residual_at(least),
                100.0 * least
            ));
        }
        if least > most {
            parts.push(format!(
                "rounding alone may keep {:.1} percent: lower the highest reflectances",
                100.0 * self.rounding_error
            ));
        }
        Some(parts.join("; "))
    }
}

/// What a share of the solution found is of the solution it goes to.
fn share(of_found: f64) -> f64 {
    if of_found.is_finite() {
        of_found / (1.0 + of_found)
    } else {
        1.0
    }
}

/// The factor by which changes fall in an iteration, 0 to 1; `before` is the norm before an iteration of
/// that residual, as a share of the norm after it.
fn rate(residuals: &[f64], before: impl Fn(f64) -> f64) -> Option<f64> {
    // What has fallen to the rounding stays there and tells nothing.
    let end = residuals.iter().position(|&r| r <= ROUNDING);
    let told = &residuals[..end.map_or(residuals.len(), |end| end + 1)];
    // A change of more than all there is may have been a start from somewhere else.
    let start = told.iter().rposition(|&r| before(r) <= 0.0);
    let told = &told[start.map_or(0, |start| start + 1)..];
    let (&last, earlier) = told.split_last()?;
    if earlier.is_empty() {
        return None;
    }
    let last = last.max(ROUNDING);
    let noise = 2.0 * ROUNDING / last;
    let (mut norms, mut summed, mut lag) = (1.0, 0, 1);
    loop {
        let lag_now = lag.min(earlier.len());
        let first = told.len() - 1 - lag_now;
        norms *= told[first + 1..told.len() - summed]
            .iter()
            .map(|&r| before(r))
            .product::<f64>();
        summed = lag_now;
        let fallen = (last / (told[first] * norms)).min(1.0);
        if 1.0 - fallen >= CLEARLY * noise || lag_now == earlier.len() {
            return Some(fallen.powf(1.0 / lag_now as f64));
        }
        lag *= 2;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Jacobi's residuals in a furnace, r_k = q^k / (1 + q + ... + q^k).
    fn furnace(q: f64, iterations: i32) -> Vec<f64> {
        (1..=iterations)
            .map(|k| q.powi(k) * (1.0 - q) / (1.0 - q.powi(k + 1)))
            .collect()
    }

    /// The formulas above are exact there, but for the rounding that is allowed for and f64.
    #[test]
    fn furnace_residuals_tell_rate_and_error() {
        for (q, iterations) in [(0.5, 10), (0.9, 50), (0.999, 3000), (0.99999, 100_000)] {
            let found = Convergence::new(SolverChoice::Jacobi, &furnace(q, iterations)).unwrap();
            assert!((found.rate - q).abs() < 1e-9, "{found:?}");
            let error = q.powi(iterations + 1);
            let rounding = ROUNDING / (1.0 - q);
            let difference = (found.estimated_error - error).abs();
            assert!(difference <= 1.01 * rounding + 1e-9, "{error} {found:?}");
        }
    }

    #[test]
    fn iterations_to_an_error_reach_it() {
        let q = 0.999;
        let found = Convergence::new(SolverChoice::Jacobi, &furnace(q, 1000)).unwrap();
        let more = found.iterations_to(0.01).unwrap();
        // The error is q^(k+1); rounding, 3e-4 here, is allowed for.
        let exact = 0.01_f64.ln() / q.ln() - 1001.0;
        assert!((more as f64 / exact - 1.0).abs() < 0.02, "{more} {exact}");
        assert_eq!(found.iterations_to(1e-4), None);
        assert_eq!(found.iterations_to(1.0), Some(0));
    }

    #[test]
    fn residuals_that_do_not_fall_promise_nothing() {
        for residuals in [&[0.5; 20][..], &[0.1, 0.2, 0.4]] {
            let found = Convergence::new(SolverChoice::Shooting, residuals).unwrap();
            assert!(found.rate >= 1.0, "{found:?}");
            assert_eq!(found.iterations_to(1e-3), None);
        }
        let found = Convergence::new(SolverChoice::Jacobi, &[0.1, 0.2, 0.4]).unwrap();
        assert!(found.estimated_error >= 1.0, "{found:?}");
        assert!(found.warning(1e-5).is_some());
    }

    #[test]
    fn too_few_residuals_tell_nothing() {
        for residuals in [&[][..], &[0.5], &[0.0], &[3.0, 0.5]] {
            assert_eq!(Convergence::new(SolverChoice::Jacobi, residuals), None);
        }
    }

    /// Black walls: the second iteration changes nothing.
    #[test]
    fn what_does_not_change_has_converged() {
        let found = Convergence::new(SolverChoice::Jacobi, &[0.4, 0.0, 0.0]).unwrap();
        assert!(found.estimated_error < 1e-6, "{found:?}");
        assert_eq!(found.warning(1e-5), None);
    }
}
