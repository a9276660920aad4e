//! The pixels that an eye looks through.

use glam::DVec3;

/// A rectangle of square pixels in the frame of an eye: a face of a hemicube, a camera's picture, a view of a lamp.
///
/// Pixel (i, j) looks along `forward + x right + y up` with x = left + (i + 1/2) pixel and
/// y = bottom + (j + 1/2) pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Window {
    /// Unit vector, direction of growing i.
    pub right: DVec3,
    /// Unit vector, direction of growing j.
    pub up: DVec3,
    /// Unit vector into the picture.
    pub forward: DVec3,
    /// Edge of the first column on the plane at distance 1, dimensionless.
    pub left: f64,
    /// Edge of the first row on the plane at distance 1, dimensionless.
    pub bottom: f64,
    /// Side of a pixel on the plane at distance 1, dimensionless.
    pub pixel: f64,
    /// Pixels in a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
}

impl Window {
    /// Pixels in all.
    pub fn pixel_count(&self) -> usize {
        self.width * self.height
    }

    /// The ray through the centre of pixel (i, j); its component along the window's forward vector is 1.
    #[inline]
    pub fn direction(&self, i: usize, j: usize) -> DVec3 {
        self.forward
            + (self.left + (i as f64 + 0.5) * self.pixel) * self.right
            + (self.bottom + (j as f64 + 0.5) * self.pixel) * self.up
    }
}
