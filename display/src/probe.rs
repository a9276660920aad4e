//! Small item buffers, to find out what there is to see from a point.

use std::sync::Arc;

use compute::cpu::{Cull, Drawable, Projection, Raster, Sample};
use compute::hemicube::Window;
use glam::DVec3;

use crate::camera::frame_at;

/// An eye that can look about; one a thread.
#[derive(Debug)]
pub struct Probe<'a> {
    projection: Projection<'a>,
    raster: Raster,
}

/// One ray of a probe.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Direction in the world, with a component of 1 along the window's forward direction.
    pub direction: DVec3,
    /// What it meets.
    pub sample: Sample,
    /// Solid angle of its pixel, sr.
    pub solid_angle: f64,
}

impl<'a> Probe<'a> {
    /// A probe in a scene.
    pub fn new(drawable: &Arc<Drawable<'a>>) -> Self {
        Self {
            projection: Projection::new(drawable),
            raster: Raster::default(),
        }
    }

    /// Moves the eye, metres, relative to the scene's origin.
    pub fn set_eye(&mut self, eye: DVec3, cull: Cull) {
        let frame = frame_at(eye);
        self.projection.set(&frame, None, false, cull);
    }

    /// Looks through a window, whose directions are the world's.
    pub fn look(&mut self, window: &Window, mut take: impl FnMut(Ray)) {
        self.raster.draw(&self.projection, window);
        for j in 0..window.height {
            let (raster, projection) = (&self.raster, &self.projection);
            raster.for_each_sample(projection, j, 0..window.width, |i, sample| {
                let x = window.left + (i as f64 + 0.5) * window.pixel;
                let y = window.bottom + (j as f64 + 0.5) * window.pixel;
                let direction = window.forward + x * window.right + y * window.up;
                take(Ray {
                    direction,
                    sample,
                    solid_angle: window.pixel.powi(2) / direction.length().powi(3),
                });
            });
        }
    }

    /// Looks in all directions, through the faces of a cube of `size` x `size` pixels each.
    pub fn look_around(&mut self, size: usize, mut take: impl FnMut(Ray)) {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for forward in [axis, -axis] {
                let (right, up) = forward.any_orthonormal_pair();
                let pixel = 2.0 / size as f64;
                let (width, height) = (size, size);
                let (left, bottom) = (-1.0, -1.0);
                let window = Window {
                    right,
                    up,
                    forward,
                    left,
                    bottom,
                    pixel,
                    width,
                    height,
                };
                self.look(&window, &mut take);
            }
        }
    }
}
