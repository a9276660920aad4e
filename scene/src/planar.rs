//! Geometry in a plane.

use std::ops::{Add, Mul};

use glam::{DVec2, DVec3};

/// Indices of the two axes of the coordinate plane that a normal faces most, in such an order that what is
/// counter-clockwise from the front is so in the plane. Coordinates keep all their bits there.
pub fn facing_axes(normal: DVec3) -> [usize; 2] {
    let axis = normal.abs().max_position();
    let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
    if normal[axis] < 0.0 { [v, u] } else { [u, v] }
}

/// Twice the area of a triangle, above 0 if counter-clockwise.
pub fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// The part of a convex polygon where a linear function of its points is not negative, at most one corner more
/// (Sutherland and Hodgman, "Reentrant polygon clipping", 1974, one plane).
pub fn clip<P>(polygon: &[P], side: impl Fn(P) -> f64) -> Vec<P>
where
    P: Copy + Add<Output = P> + Mul<f64, Output = P>,
{
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    for (k, &p) in polygon.iter().enumerate() {
        let q = polygon[(k + 1) % polygon.len()];
        let (at_p, at_q) = (side(p), side(q));
        if at_p >= 0.0 {
            kept.push(p);
        }
        if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
            let share = at_p / (at_p - at_q);
            kept.push(p * (1.0 - share) + q * share);
        }
    }
    kept
}

/// The sides of a box: bottom, top, then those at low y, high y, low x and high x, counter-clockwise as seen from
/// inside.
pub fn box_sides(low: DVec3, high: DVec3) -> [[DVec3; 4]; 6] {
    let corner = |k: usize| {
        DVec3::new(
            if k & 1 == 0 { low.x } else { high.x },
            if k & 2 == 0 { low.y } else { high.y },
            if k & 4 == 0 { low.z } else { high.z },
        )
    };
    [
        [0, 1, 3, 2],
        [4, 6, 7, 5],
        [0, 4, 5, 1],
        [2, 3, 7, 6],
        [0, 2, 6, 4],
        [1, 5, 7, 3],
    ]
    .map(|side| side.map(corner))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_cut_off_leaves_the_rest() {
        let square = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]].map(DVec2::from);
        let area = |p: &[DVec2]| {
            (2..p.len())
                .map(|k| turn(p[0], p[k - 1], p[k]))
                .sum::<f64>()
        };
        for (line, left) in [(0.5, 6.0), (0.0, 8.0), (2.0, 0.0), (3.0, 0.0)] {
            let kept = clip(&square, |p| p.x - line);
            assert!((area(&kept) - left).abs() < 1e-15, "{line}: {kept:?}");
        }
        let corner = clip(&square, |p| p.x + p.y - 3.0);
        assert_eq!(corner.len(), 3);
        assert!((area(&corner) - 1.0).abs() < 1e-15);
    }

    /// The vector areas of a closed surface sum to 0, and its volume is a third of the sum of p . area.
    #[test]
    fn sides_of_a_box_close_it_and_face_inwards() {
        let [low, high] = [DVec3::new(-1.0, 0.0, 2.0), DVec3::new(1.0, 3.0, 2.5)];
        let sides = box_sides(low, high);
        let area = |[a, _, c, d]: [DVec3; 4], b: DVec3| 0.5 * (c - a).cross(d - b);
        let areas = sides.map(|side| area(side, side[1]));
        assert_eq!(areas.iter().sum::<DVec3>(), DVec3::ZERO);
        let volume: f64 = sides
            .iter()
            .zip(areas)
            .map(|(s, a)| s[0].dot(a) / 3.0)
            .sum();
        assert!((volume + 3.0).abs() < 1e-15, "{volume}");
    }

    #[test]
    fn axes_keep_the_orientation() {
        for normal in [
            DVec3::X,
            DVec3::NEG_X,
            DVec3::Y,
            DVec3::NEG_Y,
            DVec3::Z,
            DVec3::NEG_Z,
        ] {
            let (u, v) = normal.any_orthonormal_pair();
            let [i, j] = facing_axes(normal);
            let flat = |p: DVec3| DVec2::new(p[i], p[j]);
            assert!(turn(DVec2::ZERO, flat(u), flat(v)) > 0.0, "{normal}");
        }
    }
}
