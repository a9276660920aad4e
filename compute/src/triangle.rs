//! How far a point is from a triangle.

use glam::DVec3;

/// Distance of a point from a triangle, in the unit of both.
pub(crate) fn distance(point: DVec3, corners: [DVec3; 3]) -> f64 {
    let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
    let beyond = |k: usize| {
        let (p, q) = (corners[k], corners[(k + 1) % 3]);
        (q - p).cross(point - p).dot(normal) < 0.0
    };
    if let Some(height) = normal.try_normalize()
        && !(0..3).any(beyond)
    {
        return (point - corners[0]).dot(height).abs();
    }
    (0..3)
        .map(|k| {
            let (p, q) = (corners[k], corners[(k + 1) % 3]);
            let edge = q - p;
            // An edge without length divides by something all the same.
            let along = (point - p).dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE);
            point.distance(p + along.clamp(0.0, 1.0) * edge)
        })
        .fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0, -1.0..1.0, -1.0..1.0).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    proptest! {
        /// No sampled point of the triangle is nearer, and one is within a grid step (a side of at most
        /// 2 sqrt 3, cut into 32) of the distance.
        #[test]
        fn distance_is_that_of_the_nearest_point(
            p in point(), a in point(), b in point(), c in point()
        ) {
            let distance = distance(p, [a, b, c]);
            let grid = (0..=32).flat_map(|i| (0..=32 - i).map(move |j| (i, j)));
            let nearest = grid
                .map(|(i, j)| {
                    let (u, v) = (f64::from(i) / 32.0, f64::from(j) / 32.0);
                    p.distance(a + u * (b - a) + v * (c - a))
                })
                .fold(f64::INFINITY, f64::min);
            prop_assert!(nearest >= distance - 1e-12);
            prop_assert!(nearest <= distance + 2.0 * 3.0_f64.sqrt() / 32.0);
        }
    }
}
