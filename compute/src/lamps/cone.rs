//! Which surfaces can be in a lamp's view at all.

use glam::DVec3;

use crate::hemicube::{Frame, Window};
use crate::sphere::Sphere;

/// The part of a cone that a view looks through, up to the lamp.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cone {
    apex: DVec3,
    /// Unit vector.
    axis: DVec3,
    /// Of half its opening angle.
    sin: f64,
    cos: f64,
    /// From the apex, metres.
    reach: f64,
}

impl Cone {
    /// The cone around all rays of a window.
    pub fn around(frame: &Frame, window: &Window, reach: f64) -> Self {
        let axis = window.forward;
        let far =
            |low: f64, pixels: usize| low.abs().max((low + pixels as f64 * window.pixel).abs());
        let tan = far(window.left, window.width).hypot(far(window.bottom, window.height));
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        Self {
            apex: frame.position,
            axis: frame.to_scene(axis),
            sin: tan * cos,
            cos,
            reach,
        }
    }

    /// False only where no point of the sphere is in the cone.
    pub fn meets(&self, sphere: &Sphere) -> bool {
        let offset = sphere.centre - self.apex;
        let along = offset.dot(self.axis);
        let across = (offset.length_squared() - along * along).max(0.0).sqrt();
        // Distance of the centre from the cone's side, at least; and from the planes at its ends.
        across * self.cos - along * self.sin <= sphere.radius
            && along >= -sphere.radius
            && along <= self.reach + sphere.radius
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_has_a_point_in_the_window_meets_the_cone(
            x in -1.0..1.0, y in -1.0..1.0, distance in 0.1..9.9,
            dx in -1.0..1.0, dy in -1.0..1.0, dz in -1.0..1.0,
        ) {
            let frame = Frame {
                position: DVec3::new(1.0, 2.0, 3.0),
                tangent: DVec3::Y,
                bitangent: DVec3::Z,
                normal: DVec3::X,
            };
            let window = Window {
                right: DVec3::X,
                up: DVec3::Y,
                forward: DVec3::Z,
                left: -0.5,
                bottom: -0.25,
                pixel: 0.1,
                width: 10,
                height: 5,
            };
            // A point in the window, and a sphere that holds it.
            let direction = DVec3::new(0.5 * x, 0.25 * y, 1.0).normalize();
            let local: DVec3 = distance * direction;
            let point = frame.position + local.x * DVec3::Y + local.y * DVec3::Z + local.z * DVec3::X;
            let offset = DVec3::new(dx, dy, dz);
            let sphere = Sphere { centre: point + offset, radius: offset.length() * (1.0 + 1e-12) };
            prop_assert!(Cone::around(&frame, &window, 10.0).meets(&sphere));
        }
    }

    #[test]
    fn what_is_beside_behind_or_beyond_does_not() {
        let frame = Frame {
            position: DVec3::ZERO,
            tangent: DVec3::X,
            bitangent: DVec3::Y,
            normal: DVec3::Z,
        };
        let window = Window {
            right: DVec3::X,
            up: DVec3::Y,
            forward: DVec3::Z,
            left: -0.5,
            bottom: -0.5,
            pixel: 0.1,
            width: 10,
            height: 10,
        };
        let cone = Cone::around(&frame, &window, 5.0);
        for centre in [
            DVec3::new(3.0, 0.0, 2.0),
            DVec3::new(0.0, 0.0, -1.0),
            DVec3::new(0.0, 0.0, 6.0),
        ] {
            assert!(
                !cone.meets(&Sphere {
                    centre,
                    radius: 0.5
                }),
                "{centre}"
            );
        }
    }
}
