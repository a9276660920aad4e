//! A camera that is moved by hand.
//!
//! It looks along a unit vector f at a target t, which lies before it at the distance d: the eye is e = t - d f.
//!
//! - orbit: f is turned about the vertical, and about the horizontal axis across f; t and d stay.
//! - look: f is turned the same way; e and d stay.
//! - pan: t and with it e move in the picture's plane, so that what is at the distance d follows the pointer; f and d stay.
//! - zoom: d is multiplied by a factor above 0, so that the eye never passes t; t and f stay.
//! - fly: t and e move along the picture's axes; f and d stay.

use display::Camera;
use glam::{DQuat, DVec3};

/// The steepest line of sight that a turn leads to, degrees above or below the horizon: nothing tips over.
const STEEPEST: f64 = 89.0;

/// The least distance of the target, as a share of the scene's size.
const NEAREST: f64 = 1e-4;
/// The greatest.
const FARTHEST: f64 = 100.0;

/// Which way to fly, each -1 to 1: to the right, up, and ahead.
pub type Course = [f64; 3];

/// A camera, its target, and where it started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraControl {
    pose: Pose,
    home: Pose,
    /// Unit vector.
    up: DVec3,
    /// Diagonal of the scene's bounding box, metres.
    scene_size: f64,
    fov_degrees: f64,
}

/// Where a camera is and which way it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The point in the middle of the picture that an orbit is about, metres, relative to the scene's origin.
    pub target: DVec3,
    /// Unit vector into the picture.
    pub forward: DVec3,
    /// From the eye to the target, metres.
    pub distance: f64,
}

impl Pose {
    /// The eye, metres, relative to the scene's origin.
    pub fn eye(&self) -> DVec3 {
        self.target - self.distance * self.forward
    }
}

impl CameraControl {
    /// Starts at a camera, in a scene with these smallest and largest coordinates, metres.
    pub fn new(camera: &Camera, up: DVec3, [low, high]: [DVec3; 2]) -> Self {
        let scene_size = (high - low).length().max(f64::MIN_POSITIVE);
        // As far ahead as the scene's middle is, or what is near in a scene whose middle is behind.
        let ahead = (0.5 * (low + high) - camera.eye).dot(camera.forward);
        let distance = ahead.max(0.1 * scene_size);
        let pose = Pose {
            target: camera.eye + distance * camera.forward,
            forward: camera.forward,
            distance,
        };
        Self {
            pose,
            home: pose,
            up,
            scene_size,
            fov_degrees: camera.fov_degrees,
        }
    }

    /// The camera.
    pub fn camera(&self) -> Camera {
        Camera::new(
            self.pose.eye(),
            self.pose.forward,
            self.up,
            self.fov_degrees,
        )
    }

    /// Where it is.
    pub fn pose(&self) -> Pose {
        self.pose
    }

    /// Diagonal of the scene's bounding box, metres.
    pub fn scene_size(&self) -> f64 {
        self.scene_size
    }

    /// Goes where it was before.
    pub fn go_to(&mut self, pose: Pose) {
        self.pose = pose;
    }

    /// Goes back to the start.
    pub fn reset(&mut self) {
        self.pose = self.home;
    }

    /// Turns about the target, by angles in radians: to the left, and upwards in the picture.
    pub fn orbit(&mut self, left: f64, upwards: f64) {
        self.pose.forward = self.turned(left, upwards);
    }

    /// Turns about the eye, by angles in radians: to the left and upwards.
    pub fn look(&mut self, left: f64, upwards: f64) {
        let eye = self.pose.eye();
        self.pose.forward = self.turned(left, upwards);
        self.pose.target = eye + self.pose.distance * self.pose.forward;
    }

    /// Moves in the picture's plane, by shares of the picture's height, so that what is at the target's distance moves as far to the
    /// right and upwards.
    pub fn pan(&mut self, right: f64, upwards: f64) {
        let camera = self.camera();
        let height = 2.0 * camera.half_height() * self.pose.distance;
        self.pose.target -= height * (right * camera.right + upwards * camera.up);
    }

    /// Multiplies the target's distance by a factor above 0, within the limits of the scene's size.
    pub fn zoom(&mut self, factor: f64) {
        let limits = [NEAREST, FARTHEST].map(|share| share * self.scene_size);
        let distance = self.pose.distance * factor;
        if distance.is_finite() {
            self.pose.distance = distance.clamp(limits[0], limits[1]);
        }
    }

    /// Moves so many metres along a course.
    pub fn fly(&mut self, [right, up, ahead]: Course, metres: f64) {
        let camera = self.camera();
        let way = right * camera.right + up * self.up + ahead * camera.forward;
        self.pose.target += metres * way;
    }

    fn turned(&self, left: f64, upwards: f64) -> DVec3 {
        let Camera { forward, right, .. } = self.camera();
        let elevation = forward.dot(self.up).clamp(-1.0, 1.0).asin();
        let steepest = STEEPEST.to_radians();
        // A start that is steeper, as a plan seen from above, may stay so.
        let limit = steepest.max(elevation.abs());
        let upwards = (elevation + upwards).clamp(-limit, limit) - elevation;
        let turn = DQuat::from_axis_angle(self.up, left) * DQuat::from_axis_angle(right, upwards);
        (turn * forward).normalize()
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use proptest::prelude::*;

    use super::*;

    /// f64 rounding of some hundred operations on numbers up to a thousand.
    const ROUNDING: f64 = 1e-10;

    fn any_control() -> impl Strategy<Value = CameraControl> {
        let place = prop::array::uniform3(-10.0_f64..10.0).prop_map(DVec3::from_array);
        let level = (-1.4_f64..1.4, 0.0_f64..TAU);
        (place, level).prop_map(|(eye, (elevation, azimuth))| {
            let forward = DVec3::new(
                elevation.cos() * azimuth.cos(),
                elevation.cos() * azimuth.sin(),
                elevation.sin(),
            );
            let camera = Camera::new(eye, forward, DVec3::Z, 60.0);
            CameraControl::new(&camera, DVec3::Z, [DVec3::splat(-9.0), DVec3::splat(9.0)])
        })
    }

    proptest! {
        #[test]
        fn the_first_picture_is_that_of_the_camera_it_starts_at(control in any_control()) {
            let again = CameraControl::new(&control.camera(), DVec3::Z, [DVec3::splat(-9.0), DVec3::splat(9.0)]);
            prop_assert!(again.camera().eye.distance(control.camera().eye) < ROUNDING);
            prop_assert!(again.camera().forward.distance(control.camera().forward) < ROUNDING);
        }

        #[test]
        fn an_orbit_keeps_the_target_and_its_distance(
            mut control in any_control(), left in -9.0_f64..9.0, upwards in -9.0_f64..9.0
        ) {
            let before = control.pose();
            control.orbit(left, upwards);
            let after = control.pose();
            prop_assert_eq!(after.target, before.target);
            prop_assert!((after.eye().distance(after.target) - before.distance).abs() < ROUNDING);
        }

        #[test]
        fn a_full_circle_returns(mut control in any_control(), parts in 1_u32..50) {
            let before = control.pose();
            for _ in 0..parts {
                control.orbit(TAU / f64::from(parts), 0.0);
            }
            prop_assert!(control.pose().eye().distance(before.eye()) < ROUNDING);
        }

        #[test]
        fn a_look_keeps_the_eye(
            mut control in any_control(), left in -9.0_f64..9.0, upwards in -9.0_f64..9.0
        ) {
            let before = control.pose();
            control.look(left, upwards);
            prop_assert!(control.pose().eye().distance(before.eye()) < ROUNDING);
            prop_assert!((control.pose().distance - before.distance).abs() < ROUNDING);
        }

        #[test]
        fn no_turn_tips_the_camera_over(
            mut control in any_control(), turns in prop::collection::vec((-2.0_f64..2.0, -2.0_f64..2.0), 1..20)
        ) {
            for (left, upwards) in turns {
                control.orbit(left, upwards);
                prop_assert!(control.camera().up.z > 0.0);
            }
        }

        #[test]
        fn a_pan_keeps_all_directions_and_is_undone_by_its_opposite(
            mut control in any_control(), right in -3.0_f64..3.0, upwards in -3.0_f64..3.0
        ) {
            let before = (control.pose(), control.camera());
            control.pan(right, upwards);
            let camera = control.camera();
            prop_assert_eq!(
                (camera.forward, camera.right, camera.up),
                (before.1.forward, before.1.right, before.1.up)
            );
            control.pan(-right, -upwards);
            prop_assert!(control.pose().target.distance(before.0.target) < ROUNDING);
        }

        /// What was at the target is seen as far from the picture's middle as the pointer has gone.
        #[test]
        fn a_pan_takes_what_is_at_the_target_along(
            mut control in any_control(), right in -0.4_f64..0.4, upwards in -0.4_f64..0.4
        ) {
            let target = control.pose().target;
            control.pan(right, upwards);
            let size = display::Size { width: 100, height: 100 };
            let [x, y] = control.camera().project(target, size).unwrap();
            prop_assert!((x - 50.0 - 100.0 * right).abs() < 1e-6);
            prop_assert!((y - 50.0 + 100.0 * upwards).abs() < 1e-6);
        }

        #[test]
        fn a_zoom_never_passes_the_target(
            mut control in any_control(), factors in prop::collection::vec(0.0_f64..3.0, 1..40)
        ) {
            let before = control.pose();
            for factor in factors {
                control.zoom(factor);
                let pose = control.pose();
                prop_assert!(pose.distance > 0.0);
                prop_assert!((pose.target - pose.eye()).dot(before.forward) > 0.0);
            }
            prop_assert_eq!(control.pose().target, before.target);
        }

        #[test]
        fn a_flight_goes_as_far_as_it_is_told_and_looks_ahead(
            mut control in any_control(), metres in 0.0_f64..5.0, axis in 0_usize..3
        ) {
            let before = control.pose();
            let mut course = [0.0; 3];
            course[axis] = 1.0;
            control.fly(course, metres);
            let way = control.pose().eye().distance(before.eye());
            prop_assert!((way - metres).abs() < ROUNDING);
            prop_assert_eq!(control.pose().forward, before.forward);
        }
    }

    #[test]
    fn a_reset_leads_back_to_the_start() {
        let camera = Camera::new(DVec3::ONE, DVec3::X, DVec3::Z, 50.0);
        let mut control = CameraControl::new(&camera, DVec3::Z, [DVec3::ZERO, DVec3::splat(3.0)]);
        let start = control;
        control.orbit(1.0, 0.5);
        control.zoom(0.3);
        control.fly([1.0, 0.0, 0.5], 2.0);
        assert_ne!(control, start);
        control.reset();
        assert_eq!(control, start);
    }

    /// A picture of what has no extent, and no finite factor.
    #[test]
    fn a_scene_of_one_point_and_a_wheel_gone_mad_leave_a_camera() {
        let camera = Camera::new(DVec3::ZERO, DVec3::X, DVec3::Z, 50.0);
        let mut control = CameraControl::new(&camera, DVec3::Z, [DVec3::ZERO; 2]);
        for factor in [f64::INFINITY, f64::NAN, 0.0, -1.0] {
            control.zoom(factor);
            assert!(control.camera().eye.is_finite());
            assert!(control.pose().distance > 0.0);
        }
    }
}
