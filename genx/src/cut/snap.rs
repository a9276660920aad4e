//! Snap rounding: segments that cross anywhere become paths between points of a grid that meet there alone.
//!
//! Pixels of the grid in which a segment ends or two cross are *hot*. Each segment becomes the path through the centres of the
//! hot pixels that it passes, in order. Paths then meet in grid points only, and none is off its segment by more than half
//! a pixel along an axis (Hobby, "Practical segment intersection with finite precision output", 1999; Guibas and Marimont,
//! "Rounding arrangements dynamically", 1998). All arithmetic is exact: coordinates are integers.

use std::collections::BTreeSet;

/// A point of the grid, in pixels: below 2^31 in magnitude, so that products of three differences fit an i128.
pub(super) type Point = [i64; 2];

/// Parts of a pixel. A pixel has its lower and left borders, not the others.
const PARTS: i128 = 1 << 10;

/// The paths of segments.
pub(super) fn paths(segments: &[[Point; 2]]) -> Vec<Vec<Point>> {
    let mut hot: BTreeSet<Point> = segments.iter().flatten().copied().collect();
    for (n, &one) in segments.iter().enumerate() {
        for &other in &segments[n + 1..] {
            hot.extend(crossing(one, other));
        }
    }
    let path = |&[from, to]: &[Point; 2]| {
        let (low, high) = (from[0].min(to[0]), from[0].max(to[0]));
        let near = hot.range([low, i64::MIN]..=[high, i64::MAX]);
        let mut path: Vec<Point> = near
            .copied()
            .filter(|&pixel| passes([from, to], pixel))
            .collect();
        let along = |p: &Point| {
            (0..2)
                .map(|k| i128::from(p[k] - from[k]) * i128::from(to[k] - from[k]))
                .sum::<i128>()
        };
        path.sort_by_key(along);
        path
    };
    segments.iter().map(path).collect()
}

/// Twice the area of a triangle, above 0 if counter-clockwise.
fn turn(a: Point, b: Point, c: Point) -> i128 {
    let difference = |p: Point, k: usize| i128::from(p[k] - a[k]);
    difference(b, 0) * difference(c, 1) - difference(b, 1) * difference(c, 0)
}

/// The pixel in which two segments cross inside of both.
fn crossing([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<Point> {
    let apart = |k: usize| a[k].max(b[k]) < c[k].min(d[k]) || c[k].max(d[k]) < a[k].min(b[k]);
    if apart(0) || apart(1) {
        return None;
    }
    let (at_c, at_d) = (turn(a, b, c), turn(a, b, d));
    let (at_a, at_b) = (turn(c, d, a), turn(c, d, b));
    let is_crossed = |one: i128, other: i128| (one > 0 && other < 0) || (one < 0 && other > 0);
    if !is_crossed(at_c, at_d) || !is_crossed(at_a, at_b) {
        return None;
    }
    // a + (b - a) at_a / (at_a - at_b), rounded to the nearest.
    let whole = at_a - at_b;
    let rounded = |k: usize| {
        let (above, below) = (2 * at_a * i128::from(b[k] - a[k]) + whole, 2 * whole);
        let (above, below) = if below < 0 {
            (-above, -below)
        } else {
            (above, below)
        };
        a[k] + above.div_euclid(below) as i64
    };
    Some([rounded(0), rounded(1)])
}

/// Whether a segment passes a pixel.
fn passes([a, b]: [Point; 2], pixel: Point) -> bool {
    if pixel == a || pixel == b {
        return true;
    }
    let scaled = |p: Point| p.map(|x| i128::from(x) * PARTS);
    let ([ax, ay], [bx, by], [px, py]) = (scaled(a), scaled(b), scaled(pixel));
    let (low, high) = (PARTS / 2, PARTS / 2 - 1);
    let is_beside = |a: i128, b: i128, p: i128| a.max(b) < p - low || a.min(b) > p + high;
    if is_beside(ax, bx, px) || is_beside(ay, by, py) {
        return false;
    }
    let corners = [
        [px - low, py - low],
        [px + high, py - low],
        [px + high, py + high],
        [px - low, py + high],
    ];
    let sides = corners.map(|[x, y]| (bx - ax) * (y - ay) - (by - ay) * (x - ax));
    !sides.iter().all(|&side| side > 0) && !sides.iter().all(|&side| side < 0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn segment() -> impl Strategy<Value = [Point; 2]> {
        let point = || [-40..40_i64, -40..40_i64];
        (point(), point()).prop_map(|(a, b)| [a, b])
    }

    proptest! {
        /// Straight parts of paths cross nowhere, and lie on no grid point of a path but their ends.
        #[test]
        fn paths_meet_at_grid_points_alone(segments in prop::collection::vec(segment(), 1..12)) {
            let paths = paths(&segments);
            for (path, [from, to]) in paths.iter().zip(&segments) {
                prop_assert_eq!(path.first(), Some(from));
                prop_assert_eq!(path.last(), Some(to));
            }
            let parts: BTreeSet<[Point; 2]> = paths
                .iter()
                .flat_map(|path| path.windows(2).map(|pair| [pair[0].min(pair[1]), pair[0].max(pair[1])]))
                .collect();
            let parts: Vec<[Point; 2]> = parts.into_iter().collect();
            for (n, &one) in parts.iter().enumerate() {
                for &other in &parts[n + 1..] {
                    prop_assert_eq!(crossing(one, other), None, "{:?} {:?}", one, other);
                }
            }
        }
    }
}
