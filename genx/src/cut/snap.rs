//! Snap rounding: segments that cross anywhere become paths between points of a grid that meet there alone.
//!
//! Pixels of the grid in which a segment ends or two cross are *hot*. Each segment becomes the path through the centres of the
//! hot pixels that it passes, in order. Paths then meet in grid points only, and none is off its segment by more than half
//! a pixel along an axis (Hobby, "Practical segment intersection with finite precision output", 1999; Guibas and Marimont,
//! "Rounding arrangements dynamically", 1998). All decisions are exact: coordinates are integers. What may be near is looked
//! up in trees, with a pixel to spare.

use std::collections::BTreeSet;

use rstar::primitives::{GeomWithData, Line};
use rstar::{AABB, RTree, RTreeObject, SelectionFunction};

/// The most pixels in which segments may cross.
pub(super) const MOST_CROSSINGS: usize = 1 << 20;

/// A point of the grid, in pixels: below 2^31 in magnitude, so that products of three differences fit an i128.
pub(super) type Point = [i64; 2];

/// Selects what may be less than a pixel off a segment.
struct Beside([[f64; 2]; 2]);

impl<T: RTreeObject<Envelope = AABB<[f64; 2]>>> SelectionFunction<T> for Beside {
    fn should_unpack_parent(&self, envelope: &AABB<[f64; 2]>) -> bool {
        let [from, to] = self.0;
        let (low, high) = (envelope.lower(), envelope.upper());
        let is_apart =
            (0..2).any(|k| from[k].max(to[k]) < low[k] - 1.0 || from[k].min(to[k]) > high[k] + 1.0);
        // The line's distance from the box's middle, and the box's reach in that direction, times the segment's length.
        let across = [from[1] - to[1], to[0] - from[0]];
        let distance: f64 = (0..2)
            .map(|k| across[k] * (0.5 * (low[k] + high[k]) - from[k]))
            .sum();
        let reach: f64 = (0..2)
            .map(|k| across[k].abs() * (0.5 * (high[k] - low[k]) + 1.0))
            .sum();
        !is_apart && distance.abs() <= reach
    }

    fn should_unpack_leaf(&self, leaf: &T) -> bool {
        SelectionFunction::<T>::should_unpack_parent(self, &leaf.envelope())
    }
}

/// The paths of segments; `None` where more than [`MOST_CROSSINGS`] cross.
pub(super) fn paths(segments: &[[Point; 2]]) -> Option<Vec<Vec<Point>>> {
    let flat = |p: Point| p.map(|x| x as f64);
    let beside = |&[from, to]: &[Point; 2]| Beside([flat(from), flat(to)]);
    let lines = segments
        .iter()
        .enumerate()
        .map(|(n, &[from, to])| GeomWithData::new(Line::new(flat(from), flat(to)), n));
    let lines = RTree::bulk_load(lines.collect());
    let mut hot: BTreeSet<Point> = segments.iter().flatten().copied().collect();
    let most = hot.len() + MOST_CROSSINGS;
    for (n, one) in segments.iter().enumerate() {
        let near = lines.locate_with_selection_function(beside(one));
        let later = near.map(|other| other.data).filter(|&other| other > n);
        hot.extend(later.filter_map(|other| crossing(*one, segments[other])));
        if hot.len() > most {
            return None;
        }
    }
    let hot = RTree::bulk_load(
        hot.into_iter()
            .map(|p| GeomWithData::new(flat(p), p))
            .collect(),
    );
    let path = |segment: &[Point; 2]| {
        let [from, to] = *segment;
        let near = hot.locate_with_selection_function(beside(segment));
        let mut path: Vec<Point> = near
            .map(|pixel| pixel.data)
            .filter(|&pixel| passes(*segment, pixel))
            .collect();
        let along = |p: &Point| {
            let dot = (0..2).map(|k| i128::from(p[k] - from[k]) * i128::from(to[k] - from[k]));
            (dot.sum::<i128>(), *p)
        };
        path.sort_by_key(along);
        path
    };
    Some(segments.iter().map(path).collect())
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

/// Whether a segment passes a pixel, which has its lower and left borders and not the others: whether it meets the closed square
/// that is smaller at those by however little. Terms of that little decide where all else is equal.
fn passes([a, b]: [Point; 2], pixel: Point) -> bool {
    if pixel == a || pixel == b {
        return true;
    }
    // In half pixels.
    let twice = |p: Point| p.map(|x| 2 * i128::from(x));
    let (a, b, pixel) = (twice(a), twice(b), twice(pixel));
    let is_beside = |k: usize| a[k].max(b[k]) < pixel[k] - 1 || a[k].min(b[k]) > pixel[k];
    if is_beside(0) || is_beside(1) {
        return false;
    }
    let [dx, dy] = [b[0] - a[0], b[1] - a[1]];
    let sides = [(-1, -1), (1, -1), (1, 1), (-1, 1)].map(|(x, y): (i128, i128)| {
        let side = dx * (pixel[1] + y - a[1]) - dy * (pixel[0] + x - a[0]);
        let little = i128::from(x > 0) * dy - i128::from(y > 0) * dx;
        side.cmp(&0).then(little.cmp(&0))
    });
    !sides.iter().all(|side| side.is_gt()) && !sides.iter().all(|side| side.is_lt())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    /// Some are long and nearly along an axis, so that they pass many pixels near a border.
    fn segment() -> impl Strategy<Value = [Point; 2]> {
        let point = || [-40..40_i64, -40..40_i64];
        let near = (point(), point()).prop_map(|(a, b)| [a, b]);
        let far = (
            -40..40_i64,
            -2..=2_i64,
            -100_000..100_000_i64,
            any::<bool>(),
        )
            .prop_map(|(from, rise, at, is_upright)| {
                let ends = [[at - 1_000_000, from], [at + 1_000_000, from + rise]];
                if is_upright {
                    ends.map(|[x, y]| [y, x])
                } else {
                    ends
                }
            });
        prop_oneof![3 => near, 1 => far]
    }

    proptest! {
        /// Straight parts of paths cross nowhere, and lie on no grid point of a path but their ends.
        #[test]
        fn paths_meet_at_grid_points_alone(segments in prop::collection::vec(segment(), 1..12)) {
            let paths = paths(&segments).unwrap();
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
