//! Parts of a triangle, cut off where it is on a grid. A mean has many of them: they need no memory of their own.

use glam::DVec2;

use crate::planar::turn;

/// A triangle that is cut by the four sides of a cell has seven corners at most.
const MOST_CORNERS: usize = 7;

/// A point of a triangle.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Point {
    /// Its barycentric coordinates with respect to the second and the third corner.
    barycentric: DVec2,
    /// Where it is on the grid.
    pub at: DVec2,
}

/// A convex part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    points: [Point; MOST_CORNERS],
    count: usize,
}

impl Part {
    /// The whole triangle, whose corners are there on the grid.
    pub(super) fn whole(corners: [DVec2; 3]) -> Self {
        let mut whole = Self {
            points: [Point::default(); MOST_CORNERS],
            count: 0,
        };
        for (barycentric, at) in [DVec2::ZERO, DVec2::X, DVec2::Y].into_iter().zip(corners) {
            whole.push(Point { barycentric, at });
        }
        whole
    }

    /// Its corners, counter-clockwise or clockwise as the triangle's.
    pub(super) fn points(&self) -> &[Point] {
        self.points.get(..self.count).unwrap_or(&[])
    }

    /// The part along an axis of the grid, 0 or 1, within bounds, which may be infinite.
    pub(super) fn between(&self, axis: usize, [low, high]: [f64; 2]) -> Self {
        self.cut(|at| at[axis] - low).cut(|at| high - at[axis])
    }

    /// Its area, as a share of that of the triangle, on the surface.
    pub(super) fn share(&self) -> f64 {
        let points = self.points();
        let Some((first, rest)) = points.split_first() else {
            return 0.0;
        };
        let sides = rest.iter().zip(rest.iter().skip(1));
        let twice = sides.map(|(p, q)| turn(first.barycentric, p.barycentric, q.barycentric));
        // Twice the area of the triangle is 1 there.
        twice.sum::<f64>().max(0.0)
    }

    /// The part on which a linear function of the place on the grid is not negative
    /// (Sutherland and Hodgman, "Reentrant polygon clipping", 1974, one plane).
    fn cut(&self, side: impl Fn(DVec2) -> f64) -> Self {
        let mut kept = Self { count: 0, ..*self };
        let points = self.points();
        for (p, q) in points.iter().zip(points.iter().cycle().skip(1)) {
            let (at_p, at_q) = (side(p.at), side(q.at));
            if at_p >= 0.0 {
                kept.push(*p);
            }
            if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
                let share = at_p / (at_p - at_q);
                kept.push(Point {
                    barycentric: p.barycentric.lerp(q.barycentric, share),
                    at: p.at.lerp(q.at, share),
                });
            }
        }
        kept
    }

    /// Each cut adds one corner at most, so that there is room.
    fn push(&mut self, point: Point) {
        if let Some(free) = self.points.get_mut(self.count) {
            *free = point;
            self.count += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_a_triangle_are_all_of_it() {
        let corners = [[-1.25, 0.5], [2.5, -0.75], [1.0, 3.25]].map(DVec2::from);
        let mut sum = 0.0;
        for row in -1..4 {
            let strip = Part::whole(corners).between(1, [f64::from(row), f64::from(row + 1)]);
            for column in -2..3 {
                sum += strip
                    .between(0, [f64::from(column), f64::from(column + 1)])
                    .share();
            }
        }
        assert!((sum - 1.0).abs() < 1e-14, "{sum}");
    }

    #[test]
    fn a_cell_inside_of_a_triangle_has_its_share_of_the_area() {
        let corners = [[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]].map(DVec2::from);
        let part = Part::whole(corners)
            .between(1, [1.0, 2.0])
            .between(0, [2.0, 3.0]);
        assert!(
            (part.share() - 1.0 / 32.0).abs() < 1e-15,
            "{}",
            part.share()
        );
        assert_eq!(
            Part::whole(corners)
                .between(0, [f64::NEG_INFINITY, f64::INFINITY])
                .points()
                .len(),
            3
        );
    }

    /// All three corners are cut off, and each side of the cell cuts the triangle.
    #[test]
    fn seven_corners_are_the_most() {
        let corners = [[-3.0, -1.0], [4.0, -1.5], [0.5, 5.0]].map(DVec2::from);
        let part = Part::whole(corners)
            .between(1, [-1.2, 3.0])
            .between(0, [-2.0, 3.0]);
        assert_eq!(part.points().len(), MOST_CORNERS);
    }
}
