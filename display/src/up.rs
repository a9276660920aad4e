//! Which axis points up in a scene.
//!
//! In this order:
//! 1. What the scene says.
//! 2. Rooms are lower than they are wide: the axis of the smallest extent, if that is at most
//!    three quarters of the next one.
//! 3. Lamps hang from ceilings: the axis along which the emitted power leaves the lamps (the sum
//!    of power times normal), if that is at least 0.9 of all power.
//! 4. Y, as in most OBJ files.

use glam::{DVec3, Vec3};
use scene::{Axis, Scene};

/// Smallest extent over the next one, from which on no extent is called the smallest.
const CLEARLY_LOWER: f64 = 0.75;
/// Share of the emitted power along one axis, from which on lamps are said to shine along it.
const CLEARLY_ALONG: f64 = 0.9;

/// The axis that points up.
pub fn guess(scene: &Scene) -> Axis {
    let [low, high] = scene.bounds().map(Vec3::as_dvec3);
    let known = scene.axes().up;
    known
        .or_else(|| lowest(high - low))
        .or_else(|| lamps(scene))
        .unwrap_or(Axis::Y)
}

fn lowest(extent: DVec3) -> Option<Axis> {
    let mut axes = Axis::ALL.map(|axis| (extent.dot(axis.direction()), axis));
    axes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let [(smallest, axis), (next, _), _] = axes;
    // A single plane has no height, and lies on the ground.
    (smallest <= CLEARLY_LOWER * next).then_some(axis)
}

fn lamps(scene: &Scene) -> Option<Axis> {
    let (mut along, mut total) = (DVec3::ZERO, 0.0);
    for surface in scene.surfaces() {
        let emission = scene.material(surface.material).emission.as_dvec3();
        let power = surface.area() * emission.element_sum();
        along += power * surface.normal();
        total += power;
    }
    let is_along = |axis: &Axis| along.dot(axis.direction()).abs() >= CLEARLY_ALONG * total;
    if total > 0.0 {
        Axis::ALL.into_iter().find(is_along)
    } else {
        None
    }
}
