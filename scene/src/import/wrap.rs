//! What is beyond the sides of a picture, along one axis. A cell is an interval of one texel's width, numbered from the
//! picture's side on, below 0 and beyond its size too.

use std::ops::Range;

/// What is beyond the sides of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Wrap {
    /// The same picture.
    #[default]
    Repeat,
    /// The same picture, every other time mirrored.
    Mirror,
    /// Its outermost texels.
    Clamp,
}

/// An axis of a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Axis {
    pub wrap: Wrap,
    /// In texels, at least 1.
    pub size: u32,
}

impl Axis {
    /// After how many texels the picture comes again, if it does.
    pub(super) fn period(self) -> Option<f64> {
        match self.wrap {
            Wrap::Repeat => Some(f64::from(self.size)),
            Wrap::Mirror => Some(2.0 * f64::from(self.size)),
            Wrap::Clamp => None,
        }
    }

    /// The cells between two places, one at least.
    pub(super) fn cells(self, low: f64, high: f64) -> Range<i64> {
        let low = low.floor() as i64;
        let cells = low..(high.ceil() as i64).max(low.saturating_add(1));
        match self.wrap {
            Wrap::Repeat | Wrap::Mirror => cells,
            Wrap::Clamp => {
                let last = i64::from(self.size) - 1;
                cells.start.clamp(0, last)..cells.end.clamp(1, last + 1)
            }
        }
    }

    /// Where a cell starts and ends; all that is beyond the sides of a clamped picture is in its outermost cells.
    pub(super) fn bounds(self, cell: i64) -> [f64; 2] {
        let is_clamped = self.wrap == Wrap::Clamp;
        let is_last = cell + 1 == i64::from(self.size);
        [
            if is_clamped && cell == 0 {
                f64::NEG_INFINITY
            } else {
                cell as f64
            },
            if is_clamped && is_last {
                f64::INFINITY
            } else {
                (cell + 1) as f64
            },
        ]
    }

    /// The texel that is in a cell.
    pub(super) fn texel(self, cell: i64) -> u32 {
        let size = i64::from(self.size);
        let texel = match self.wrap {
            Wrap::Repeat => cell.rem_euclid(size),
            Wrap::Mirror => {
                let at = cell.rem_euclid(2 * size);
                at.min(2 * size - 1 - at)
            }
            Wrap::Clamp => cell.clamp(0, size - 1),
        };
        texel as u32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_repeat_are_mirrored_or_stay() {
        let texels =
            |wrap| [-4, -3, -1, 0, 2, 3, 5, 6].map(|cell| Axis { wrap, size: 3 }.texel(cell));
        assert_eq!(texels(Wrap::Repeat), [2, 0, 2, 0, 2, 0, 2, 0]);
        assert_eq!(texels(Wrap::Mirror), [2, 2, 0, 0, 2, 2, 0, 0]);
        assert_eq!(texels(Wrap::Clamp), [0, 0, 0, 0, 2, 2, 2, 2]);
    }

    #[test]
    fn cells_between_two_places_hold_them() {
        let cells = |wrap, low, high| Axis { wrap, size: 3 }.cells(low, high);
        for wrap in [Wrap::Repeat, Wrap::Mirror] {
            assert_eq!(cells(wrap, -1.5, 2.0), -2..2);
            assert_eq!(cells(wrap, 2.0, 2.0), 2..3);
        }
        assert_eq!(cells(Wrap::Clamp, -9.5, -8.0), 0..1);
        assert_eq!(cells(Wrap::Clamp, -9.5, 9.0), 0..3);
        assert_eq!(cells(Wrap::Clamp, 3.0, 9.0), 2..3);
    }
}
