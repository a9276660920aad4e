//! Small pictures, to find out what there is to see from a point.

use std::sync::Arc;

use glam::DVec3;
use visibility::{Canvas, Cull, Drawable, Eye, Sample, View, Viewer, Window};

use crate::camera::frame_at;

/// The memory of eyes that look about; one a thread.
#[derive(Debug)]
pub struct Probe<'a> {
    viewer: Viewer<'a>,
    canvas: Canvas,
}

/// An eye that can look about.
#[derive(Debug)]
pub struct Lookout<'p> {
    view: View<'p>,
    canvas: &'p mut Canvas,
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
            viewer: Viewer::new(drawable),
            canvas: Canvas::default(),
        }
    }

    /// An eye at a point, metres, relative to the scene's origin, that will look through about so many pixels.
    pub fn at(&mut self, eye: DVec3, cull: Cull, pixels: usize) -> Lookout<'_> {
        let eye = Eye::free(&frame_at(eye), cull);
        Lookout {
            view: self.viewer.view(&eye, pixels),
            canvas: &mut self.canvas,
        }
    }
}

impl Lookout<'_> {
    /// Looks through a window, whose directions are the world's.
    pub fn look(&mut self, window: &Window, mut take: impl FnMut(Ray)) {
        let picture = self.canvas.draw(&self.view, window);
        for j in 0..window.height {
            picture.for_each_sample(j, 0..window.width, |i, sample| {
                let direction = window.direction(i, j);
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
