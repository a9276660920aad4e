//! A smooth curve through points that are reached at given times.
//!
//! Between the points P_i and P_(i+1) the curve is the cubic
//!
//! P(s) = (1 - w) P_i + w P_(i+1) + h s (1 - s)^2 m_i - h s^2 (1 - s) m_(i+1), w = s^2 (3 - 2 s),
//!
//! s from 0 to 1, of a Catmull-Rom spline with *centripetal* knots: h_i = |P_(i+1) - P_i|^(1/2), and
//! m_i = (h_i d_(i-1) + h_(i-1) d_i) / (h_(i-1) + h_i) with d_i = (P_(i+1) - P_i) / h_i; at the ends, and beside
//! a point that is repeated, m is the d that there is. (Barry, Goldman 1988, "A recursive evaluation algorithm
//! for a class of Catmull-Rom splines"; Yuksel, Schaefer, Keyser 2011, "Parameterization and applications of
//! Catmull-Rom curves", which shows that with these knots no piece has a cusp or crosses itself.)
//!
//! Times do not enter the shape. With knots at the times a short way before a long one would throw the curve far
//! out. Here |d_i| = h_i, so that h_i |m| < 2 h_i^2, and the last two terms are less than
//! 2 s (1 - s) |P_(i+1) - P_i|: **a piece is nowhere further from its chord than half of the chord's length.**
//!
//! How far s has come at a time is a monotone cubic, of the same form, with the slopes of Fritsch and Butland (1984,
//! "A method for constructing local monotone piecewise cubic interpolants"): the harmonic mean of the speeds
//! v_i = h_i / (t_(i+1) - t_i) before and after a point, weighted by the times. So the speed has no jump, s never
//! runs backwards, and where a point is repeated the curve stops gently and waits.

use glam::DVec3;

/// Where in a list of times a time is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// The piece: from time number `piece` to the next one.
    pub piece: usize,
    /// Share of the piece's time that has passed, dimensionless, 0 to 1.
    pub share: f64,
}

impl Moment {
    /// Of `time` among two or more ascending times; before the first and after the last it is their moment.
    pub fn new(times: &[f64], time: f64) -> Self {
        let last_piece = times.len().saturating_sub(2);
        let passed = times.partition_point(|&t| t <= time);
        let piece = passed.saturating_sub(1).min(last_piece);
        let share = match times.get(piece..piece + 2) {
            Some(&[from, to]) => ((time - from) / (to - from)).clamp(0.0, 1.0),
            _ => 0.0,
        };
        // A time that is no number is as good as the first.
        let share = if share.is_nan() { 0.0 } else { share };
        Self { piece, share }
    }
}

/// A number that goes through given values without leaving the two that it is between.
#[derive(Clone, Debug, PartialEq)]
pub struct Monotone {
    /// One per time.
    values: Vec<f64>,
    /// Change from a value to the next; one per piece.
    changes: Vec<f64>,
    /// Slopes at a piece's two ends, over its share of time; one per piece.
    slopes: Vec<[f64; 2]>,
}

impl Monotone {
    /// Through one value per time; times ascend.
    pub fn new(times: &[f64], values: Vec<f64>) -> Self {
        let changes: Vec<f64> = values.windows(2).map(|v| v[1] - v[0]).collect();
        let slopes = monotone_slopes(times, &changes);
        Self {
            values,
            changes,
            slopes,
        }
    }

    /// The value at a moment of the same times.
    pub fn at(&self, moment: Moment) -> f64 {
        let Moment { piece, share } = moment;
        let Some(&change) = self.changes.get(piece) else {
            return self.values.first().copied().unwrap_or(0.0);
        };
        if share >= 1.0 {
            return self.values[piece + 1];
        }
        self.values[piece] + hermite(share, change, self.slopes[piece])
    }
}

/// A curve through points.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// One per time.
    points: Vec<DVec3>,
    /// h_i, metres^(1/2); one per piece.
    steps: Vec<f64>,
    /// m_i, metres^(1/2); one per point.
    tangents: Vec<DVec3>,
    /// Slopes of h_i s at a piece's two ends, over its share of time; one per piece.
    slopes: Vec<[f64; 2]>,
}

impl Curve {
    /// Through one point per time; times ascend.
    pub fn new(times: &[f64], points: Vec<DVec3>) -> Self {
        let steps: Vec<f64> = points
            .windows(2)
            .map(|p| p[0].distance(p[1]).sqrt())
            .collect();
        let direction = |piece: usize| {
            let step = steps.get(piece).copied().filter(|&step| step > 0.0)?;
            Some(((points[piece + 1] - points[piece]) / step, step))
        };
        let tangents = (0..points.len())
            .map(|i| {
                let before = i.checked_sub(1).and_then(direction);
                match (before, direction(i)) {
                    (Some((d0, h0)), Some((d1, h1))) => (h1 * d0 + h0 * d1) / (h0 + h1),
                    (Some((d, _)), None) | (None, Some((d, _))) => d,
                    (None, None) => DVec3::ZERO,
                }
            })
            .collect();
        let slopes = monotone_slopes(times, &steps);
        Self {
            points,
            steps,
            tangents,
            slopes,
        }
    }

    /// The point at a moment of the same times.
    pub fn at(&self, moment: Moment) -> DVec3 {
        let Moment { piece, share } = moment;
        let Some(&step) = self.steps.get(piece) else {
            return self.points.first().copied().unwrap_or(DVec3::ZERO);
        };
        let [from, to] = [self.points[piece], self.points[piece + 1]];
        if step == 0.0 || share == 0.0 {
            return from;
        }
        if share >= 1.0 {
            return to;
        }
        let s = hermite(share, step, self.slopes[piece]) / step;
        let w = s * s * (3.0 - 2.0 * s);
        let [m0, m1] = [self.tangents[piece], self.tangents[piece + 1]].map(|m| step * m);
        from + w * (to - from) + s * (1.0 - s) * ((1.0 - s) * m0 - s * m1)
    }
}

/// A cubic from 0 to `change` with these slopes at 0 and 1.
fn hermite(x: f64, change: f64, [from, to]: [f64; 2]) -> f64 {
    x * x * (3.0 - 2.0 * x) * change + x * (1.0 - x) * ((1.0 - x) * from - x * to)
}

/// Slopes at the ends of each piece, over its share of time, of a monotone cubic that changes by `changes`.
fn monotone_slopes(times: &[f64], changes: &[f64]) -> Vec<[f64; 2]> {
    let spans: Vec<f64> = times.windows(2).map(|t| t[1] - t[0]).collect();
    // Over time, at time number i.
    let slope = |i: usize| {
        let piece = |i: usize| Some((*changes.get(i)? / spans.get(i)?, *spans.get(i)?));
        match (i.checked_sub(1).and_then(piece), piece(i)) {
            (Some((v0, t0)), Some((v1, t1))) if v0 * v1 > 0.0 => {
                3.0 * (t0 + t1) / ((t0 + 2.0 * t1) / v0 + (2.0 * t0 + t1) / v1)
            }
            // It turns round or waits.
            (Some(_), Some(_)) | (None, None) => 0.0,
            (Some((v, _)), None) | (None, Some((v, _))) => v,
        }
    };
    (0..changes.len())
        .map(|i| [slope(i), slope(i + 1)].map(|slope| slope * spans[i]))
        .collect()
}
