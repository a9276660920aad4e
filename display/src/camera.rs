//! A pinhole camera.
//!
//! A point q relative to the eye is seen at x = q.right / q.forward, y = q.up / q.forward; the
//! picture is the part of that plane with |y| < tan(fov / 2) and |x| < aspect tan(fov / 2), fov
//! the vertical angle of view.

use glam::DVec3;
use visibility::{Frame, Window};

use crate::settings::Size;

/// A camera in the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position, metres, relative to the scene's origin.
    pub eye: DVec3,
    /// Unit vector into the picture.
    pub forward: DVec3,
    /// Unit vector to the picture's right.
    pub right: DVec3,
    /// Unit vector to the picture's top.
    pub up: DVec3,
    /// Vertical angle of view, degrees, between 0 and 180.
    pub fov_degrees: f64,
}

impl Camera {
    /// A camera at `eye` whose picture has `forward` in its middle and `up` upright.
    ///
    /// Along a zero direction it looks along an axis; where `up` is the line of sight, an axis
    /// across it takes its place.
    pub fn new(eye: DVec3, forward: DVec3, up: DVec3, fov_degrees: f64) -> Self {
        let forward = forward.try_normalize().unwrap_or(DVec3::NEG_Z);
        let across = |up: DVec3| {
            let right = forward.cross(up);
            // A line of sight within a millionth of `up` has no stable horizon.
            (right.length() > 1e-6 * up.length()).then(|| right.normalize())
        };
        // Of all axes, the one most across the line of sight has a component of at most 0.58.
        let right = across(up)
            .or_else(|| across(DVec3::NEG_Z))
            .or_else(|| across(DVec3::Y))
            .unwrap_or_else(|| forward.any_orthonormal_vector());
        Self {
            eye,
            forward,
            right,
            up: right.cross(forward),
            fov_degrees,
        }
    }

    /// A frame at the eye with the axes of the world, which [`Camera::window`] refers to.
    pub fn frame(&self) -> Frame {
        frame_at(self.eye)
    }

    /// Half the picture's height on the plane at distance 1, dimensionless.
    pub fn half_height(&self) -> f64 {
        (0.5 * self.fov_degrees.to_radians()).tan()
    }

    /// The picture as a window with `samples` x `samples` rays a pixel.
    pub fn window(&self, size: Size, samples: u32) -> Window {
        let (width, height) = (size.width * samples, size.height * samples);
        let half_height = self.half_height();
        let pixel = 2.0 * half_height / f64::from(height);
        Window {
            right: self.right,
            up: self.up,
            forward: self.forward,
            left: -0.5 * pixel * f64::from(width),
            bottom: -half_height,
            pixel,
            width: width as usize,
            height: height as usize,
        }
    }

    /// Where a point (metres, relative to the scene's origin) is in the picture: column and row, in
    /// pixels from the top left corner, with a pixel's centre at one half. `None` behind the eye.
    pub fn project(&self, point: DVec3, size: Size) -> Option<[f64; 2]> {
        let q = point - self.eye;
        let depth = q.dot(self.forward);
        let pixel = 2.0 * self.half_height() / f64::from(size.height);
        (depth > 0.0).then(|| {
            [
                0.5 * f64::from(size.width) + q.dot(self.right) / depth / pixel,
                0.5 * f64::from(size.height) - q.dot(self.up) / depth / pixel,
            ]
        })
    }
}

/// A frame with the axes of the world.
pub fn frame_at(position: DVec3) -> Frame {
    Frame {
        position,
        tangent: DVec3::X,
        bitangent: DVec3::Y,
        normal: DVec3::Z,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camera_axes_are_orthonormal_and_right_handed_even_where_up_is_the_line_of_sight() {
        for forward in [
            DVec3::Y,
            DVec3::NEG_Y,
            DVec3::Z,
            DVec3::new(1.0, 2.0, -3.0),
            DVec3::ZERO,
        ] {
            for up in [DVec3::X, DVec3::Y, DVec3::Z] {
                let camera = Camera::new(DVec3::ZERO, forward, up, 60.0);
                // f64 rounding of a few products of unit vectors.
                assert!(camera.right.cross(camera.up).distance(-camera.forward) < 1e-14);
                assert!(camera.up.dot(up) >= -1e-14, "{up} points down");
            }
        }
    }

    #[test]
    fn window_spans_the_angle_of_view() {
        let camera = Camera::new(DVec3::ZERO, DVec3::NEG_Z, DVec3::Y, 90.0);
        let window = camera.window(
            Size {
                width: 200,
                height: 100,
            },
            3,
        );
        assert_eq!((window.width, window.height), (600, 300));
        assert!((window.bottom + 1.0).abs() < 1e-15 && (window.left + 2.0).abs() < 1e-14);
        assert!((window.pixel * 300.0 - 2.0).abs() < 1e-14);
    }
}
