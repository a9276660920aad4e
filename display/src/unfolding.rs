//! The unfolded hemicube: its five faces laid out in a plane, as a cross.
//!
//! # Theory
//! The top face lies in the middle of a square of side 4, in units of half the hemicube's edge. The half faces are
//! turned about the edges that they share with it until they lie beside it; the corners of the square stay empty.
//! With u to the right and v down, both from -2 to 2 about the middle, the point (u, v) looks along
//!
//! top:             (u, v, 1)        where |u| <= 1 and |v| <= 1
//! right and left:  (±1, v, 2 - |u|) where |u| > 1
//! bottom and top:  (u, ±1, 2 - |v|) where |v| > 1
//!
//! in the frame (tangent, bitangent, normal). That is continuous over all four folds, and the outer border is the horizon.
//! Tangent to the right and bitangent *down* are what an eye sees that looks along the normal: with bitangent up it would be
//! the mirror image.
//!
//! The square may be turned by quarter turns besides, to put the scene's top up.
//!
//! # Practice
//! At resolution R the square has 2R x 2R pixels. The windows of [`visibility::hemicube`] have their i along
//! normal x forward, so that two of the side faces run against u or v.

use glam::DVec3;
use visibility::hemicube::MAX_RESOLUTION;

/// A resolution of no hemicube.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("resolution {value} must be an even number from 2 to {MAX_RESOLUTION}")]
pub struct ResolutionError {
    /// What was asked for, pixels along a face.
    pub value: u32,
}

/// Where the pixels of a hemicube lie in the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unfolding {
    resolution: u32,
    /// Clockwise.
    quarter_turns: u32,
}

impl Unfolding {
    /// The hemicube of a resolution: pixels along a face, even, 2 to [`MAX_RESOLUTION`].
    pub fn new(resolution: u32) -> Result<Self, ResolutionError> {
        let is_one = resolution.is_multiple_of(2) && (2..=MAX_RESOLUTION).contains(&resolution);
        if is_one {
            Ok(Self {
                resolution,
                quarter_turns: 0,
            })
        } else {
            Err(ResolutionError { value: resolution })
        }
    }

    /// The square turned clockwise by so many quarter turns from where tangent is right and bitangent down.
    #[must_use]
    pub fn turned(self, quarter_turns: u32) -> Self {
        Self {
            quarter_turns: quarter_turns % 4,
            ..self
        }
    }

    /// The direction that points up in the middle of the square, in the frame (tangent, bitangent, normal).
    pub fn up(self) -> DVec3 {
        [DVec3::NEG_Y, DVec3::NEG_X, DVec3::Y, DVec3::X][self.quarter_turns as usize % 4]
    }

    /// Pixels along a face, R.
    pub fn resolution(self) -> u32 {
        self.resolution
    }

    /// Pixels along the square, 2R.
    pub fn side(self) -> usize {
        2 * self.resolution as usize
    }

    /// Pixels of the square, 4 R^2, of which 3 R^2 are the hemicube's.
    pub fn pixel_count(self) -> usize {
        self.side() * self.side()
    }

    /// Index in the square, row by row from the top, of a face's pixel (i, j), in the order of
    /// [`visibility::hemicube::windows`].
    #[inline]
    pub fn index(self, face: usize, i: usize, j: usize) -> usize {
        let size = self.resolution as usize;
        let half = size / 2;
        let (column, row) = match face {
            0 => (half + i, half + j),
            1 => (2 * size - 1 - j, half + i),
            2 => (half + size - 1 - i, 2 * size - 1 - j),
            3 => (j, half + size - 1 - i),
            _ => (half + i, j),
        };
        let last = self.side() - 1;
        let (column, row) = match self.quarter_turns {
            0 => (column, row),
            1 => (last - row, column),
            2 => (last - column, last - row),
            _ => (row, last - column),
        };
        row * self.side() + column
    }

    /// Lays out a value for each pixel, given face by face, each row by row; `outside` is that of the empty corners.
    pub fn lay_out<'f, T: Copy + 'f>(
        self,
        outside: T,
        faces: impl IntoIterator<Item = &'f [T]>,
    ) -> Vec<T> {
        let mut square = vec![outside; self.pixel_count()];
        for (face, values) in faces.into_iter().enumerate() {
            for (j, row) in values.chunks_exact(self.resolution as usize).enumerate() {
                for (i, &value) in row.iter().enumerate() {
                    square[self.index(face, i, j)] = value;
                }
            }
        }
        square
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use visibility::hemicube::windows;

    use super::*;

    /// Unit directions in the frame of a hemicube, one per pixel of the square.
    fn directions(resolution: u32) -> Vec<Option<DVec3>> {
        directions_in(Unfolding::new(resolution).unwrap())
    }

    fn directions_in(unfolding: Unfolding) -> Vec<Option<DVec3>> {
        let resolution = unfolding.resolution();
        let faces = windows(resolution).map(|window| -> Vec<Option<DVec3>> {
            let pixel = |k| window.direction(k % window.width, k / window.width);
            (0..window.pixel_count())
                .map(|k| Some(pixel(k).normalize()))
                .collect()
        });
        unfolding.lay_out(None, faces.iter().map(Vec::as_slice))
    }

    #[test]
    fn every_pixel_of_a_hemicube_has_a_place_of_its_own_and_the_corners_are_empty() {
        for resolution in [2, 4, 6, 50] {
            let directions = directions(resolution);
            let side = 2 * resolution as usize;
            let is_beside = |k: usize| k < side / 4 || k >= 3 * side / 4;
            for (k, direction) in directions.iter().enumerate() {
                let is_corner = is_beside(k % side) && is_beside(k / side);
                assert_eq!(direction.is_none(), is_corner, "pixel {k} at {resolution}");
            }
        }
    }

    /// A pixel is 2/R wide at a distance of 1 or more. Pixels beside a fold are half of that away from it on either side,
    /// which is nearer; f64 rounds by less than 1e-15.
    #[test]
    fn neighbours_look_along_directions_within_a_pixels_angle_of_each_other() {
        for resolution in [2, 4, 10, 64] {
            let directions = directions(resolution);
            let side = 2 * resolution as usize;
            let angle = 2.0 / f64::from(resolution);
            let mut pairs = 0;
            for k in 0..directions.len() {
                let right = (k % side + 1 < side).then_some(k + 1);
                for neighbour in [right, Some(k + side)].into_iter().flatten() {
                    let neighbour = directions.get(neighbour).copied().flatten();
                    if let (Some(a), Some(b)) = (directions[k], neighbour) {
                        pairs += 1;
                        assert!(a.angle_between(b) <= angle + 1e-15, "{k} at {resolution}");
                    }
                }
            }
            // Of a cross: 2 R^2 less one along each row, R rows of 2R, and R half as long; the same along columns.
            let size = resolution as usize;
            let along_rows = size * (2 * size - 1) + size * (size - 1);
            assert_eq!(pairs, 2 * along_rows);
        }
    }

    /// Right x up of an eye's picture points back at the eye. Turned pictures have the same pairs of neighbours.
    #[test]
    fn picture_is_not_mirrored_and_its_up_is_up_however_it_is_turned() {
        for quarter_turns in 0..5 {
            let unfolding = Unfolding::new(64).unwrap().turned(quarter_turns);
            let directions = directions_in(unfolding);
            let at = |column: usize, row: usize| directions[row * 128 + column].unwrap();
            let right = (at(65, 64) - at(64, 64)).normalize();
            let up = (at(64, 63) - at(64, 64)).normalize();
            // The middle's four pixels are within 1/64 of the normal.
            assert!(right.cross(up).dot(DVec3::Z) < -0.99);
            assert!(up.dot(unfolding.up()) > 0.99);
            // A quarter turn on, what was left is up.
            let left_in_plain = unfolding.turned(quarter_turns + 1).up();
            assert!(right.dot(left_in_plain) < -0.99);
        }
    }

    #[test]
    fn border_is_the_horizon() {
        let resolution = 64_u32;
        let directions = directions(resolution);
        let side = 2 * resolution as usize;
        let lowest = 1.0 / f64::from(resolution);
        let mut seen = 0;
        for k in 0..side {
            for border in [k, (side - 1) * side + k, k * side, k * side + side - 1] {
                if let Some(direction) = directions[border] {
                    let along_side = direction / direction.truncate().abs().max_element();
                    assert!((along_side.z - lowest).abs() < 1e-15);
                    seen += 1;
                }
            }
        }
        assert_eq!(seen, 4 * resolution);
    }

    #[test]
    fn resolutions_are_those_of_compute() {
        for value in [0, 1, 3, 127, MAX_RESOLUTION + 2, u32::MAX] {
            let error = Unfolding::new(value).unwrap_err();
            assert!(error.to_string().contains(&value.to_string()));
        }
        assert!(Unfolding::new(2).is_ok() && Unfolding::new(MAX_RESOLUTION).is_ok());
    }
}
