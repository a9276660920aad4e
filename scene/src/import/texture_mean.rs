//! The mean colour of a texture over a triangle: until textures are shown, a surface reflects the mean of its part.
//!
//! # Theory
//! mean = sum_k A_k c_k / sum_k A_k, where c_k is the linear colour of texel k and A_k the area of that part of the triangle
//! which has texel k. Texture coordinates are linear on the triangle, so that such a part is a convex polygon, and A_k is
//! exact. Areas are measured in barycentric coordinates, in which they are those of the surface but for a factor: triangles
//! whose texture coordinates lie on a line or in a point have means like all others.
//!
//! # Differences
//! Where a triangle covers more than `MOST_CELLS` texels, a coarser picture takes the place of the texture (`texels.rs`). Cells
//! inside of the triangle count exactly all the same, those on its sides by their means, so that no texel is lost: of triangles
//! that share a cell each has its share, and together they have all of it. So the time for a triangle is bounded, at some
//! milliseconds.

use glam::{DVec2, DVec3};

use super::part::Part;
use super::texels::{Grid, Texels};
use super::wrap::{Axis, Wrap};
use crate::Rgb;
use crate::planar::turn;

/// The most cells that are looked at for one triangle.
const MOST_CELLS: f64 = 65536.0;

/// Bits behind the leading one that means keep, so that surfaces that look alike are one material: a mean is right to one
/// part in 8192, however small it is.
const KEPT_BITS: u32 = 12;

/// The mean over the triangle between three texture coordinates, (0, 0) at the lower left of the picture; rounded.
pub(super) fn mean(texels: &Texels, corners: [DVec2; 3], wrap: [Wrap; 2]) -> Rgb {
    let from_top = corners.map(|corner| DVec2::new(corner.x, 1.0 - corner.y));
    let mut mean = Rgb::ZERO;
    for grid in &texels.grids {
        let triangle = Triangle::new(grid, from_top, wrap);
        if grid.size == [1, 1] {
            mean = grid.get(0, 0).as_vec3();
        } else if triangle.cells() <= MOST_CELLS
            && let Some(exact) = triangle.mean()
        {
            mean = exact.as_vec3();
            break;
        }
    }
    rounded(mean)
}

/// Colours to some bits each, so that what is nearly the same is the same.
pub(super) fn rounded(colour: Rgb) -> Rgb {
    let dropped = f32::MANTISSA_DIGITS - 1 - KEPT_BITS;
    let half = 1 << (dropped - 1);
    Rgb::from(
        colour.to_array().map(|value| {
            f32::from_bits((value.to_bits().saturating_add(half) >> dropped) << dropped)
        }),
    )
}

/// A triangle on a grid.
struct Triangle<'a> {
    grid: &'a Grid,
    /// In cells from the upper left.
    corners: [DVec2; 3],
    /// Columns and rows.
    axes: [Axis; 2],
}

impl<'a> Triangle<'a> {
    /// `from_top` are texture coordinates, (0, 0) at the upper left.
    fn new(grid: &'a Grid, from_top: [DVec2; 3], [along_u, along_v]: [Wrap; 2]) -> Self {
        let [columns, rows] = grid.size;
        let axis = |wrap, size| Axis { wrap, size };
        let axes = [axis(along_u, columns), axis(along_v, rows)];
        let size = DVec2::new(columns.into(), rows.into());
        let mut corners = from_top.map(|corner| corner * size);
        for (k, axis) in axes.iter().enumerate() {
            // Far away from the picture numbers would be too large to count by.
            if let Some(period) = axis.period() {
                let [low, _] = range(corners.map(|corner| corner[k]));
                let shift = (low / period).floor() * period;
                for corner in &mut corners {
                    corner[k] -= shift;
                }
            }
        }
        Self {
            grid,
            corners,
            axes,
        }
    }

    /// At most how many cells it touches: a convex polygon's sides cross no more than twice the cells along both axes.
    fn cells(&self) -> f64 {
        let [columns, rows] = [0, 1].map(|k| {
            let [low, high] = range(self.corners.map(|corner| corner[k]));
            let cells = self.axes[k].cells(low, high);
            cells.end.saturating_sub(cells.start) as f64
        });
        let most = self.area() + 2.0 * (columns + rows) + 4.0;
        most.min(columns * rows)
    }

    /// Cells.
    fn area(&self) -> f64 {
        let [a, b, c] = self.corners;
        0.5 * turn(a, b, c).abs()
    }

    /// The mean; `None` where rounding leaves nothing of the triangle.
    fn mean(&self) -> Option<DVec3> {
        let [columns, rows] = self.axes;
        let whole = Part::whole(self.corners);
        let [low, high] = range(self.corners.map(|corner| corner.y));
        let of_inner = 1.0 / self.area();
        let (mut sum, mut total) = (DVec3::ZERO, 0.0);
        for row in rows.cells(low, high) {
            let strip = whole.between(1, rows.bounds(row));
            let [low, high] = range(strip.points().iter().map(|point| point.at.x));
            if low > high {
                continue;
            }
            let [first_inner, end_inner] = self.inner(rows.bounds(row));
            for column in columns.cells(low, high) {
                let [left, right] = columns.bounds(column);
                let is_inner = first_inner <= left && right <= end_inner;
                let share = if is_inner && (right - left).is_finite() {
                    of_inner
                } else {
                    strip.between(0, [left, right]).share()
                };
                let [column, row] = [columns.texel(column), rows.texel(row)];
                sum += share * self.grid.get(column, row);
                total += share;
            }
        }
        (total > 0.0).then(|| sum / total)
    }

    /// Between which places a row, from its upper to its lower bound, is inside of the triangle over its whole height.
    fn inner(&self, bounds: [f64; 2]) -> [f64; 2] {
        let [above, below] = bounds.map(|y| self.slice(y));
        [above[0].max(below[0]), above[1].min(below[1])]
    }

    /// Between which places a horizontal line is inside; the first is beyond the second where it is not.
    fn slice(&self, y: f64) -> [f64; 2] {
        let [a, b, c] = self.corners;
        let crossings = [[a, b], [b, c], [c, a]].into_iter().filter_map(|[p, q]| {
            let share = (y - p.y) / (q.y - p.y);
            let place = p.x + share * (q.x - p.x);
            (0.0..=1.0).contains(&share).then_some(place)
        });
        range(crossings)
    }
}

/// The least and the largest of some numbers.
fn range(values: impl IntoIterator<Item = f64>) -> [f64; 2] {
    let nothing = [f64::INFINITY, f64::NEG_INFINITY];
    let values = values.into_iter();
    values.fold(nothing, |[low, high], value| {
        [low.min(value), high.max(value)]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rounding_keeps_powers_of_two_and_is_relative() {
        for value in [0.0, 1.0, 0.5, 2e-9, 0.123_456_79, 0.999_999_9, 3.05e-5] {
            let found = rounded(Rgb::splat(value)).x;
            assert!((found - value).abs() <= value / 8192.0, "{value} {found}");
        }
        assert_eq!(rounded(Rgb::new(0.0, 1.0, 0.25)), Rgb::new(0.0, 1.0, 0.25));
        assert_eq!(rounded(Rgb::splat(0.5)), rounded(Rgb::splat(0.500_01)));
    }

    /// Coordinates that no file of sense has.
    #[test]
    fn coordinates_far_away_or_without_number_have_a_mean() {
        let texels = Texels::new([64, 64], vec![255; 3 * 64 * 64]);
        for far in [1e18, 1e300, f64::MAX, f64::INFINITY, f64::NAN] {
            for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
                for corners in [
                    [DVec2::ZERO, DVec2::new(far, 0.0), DVec2::ONE],
                    [DVec2::splat(far); 3],
                ] {
                    assert_eq!(
                        mean(&texels, corners, [wrap; 2]),
                        Rgb::ONE,
                        "{far} {wrap:?}"
                    );
                }
            }
        }
    }
}
