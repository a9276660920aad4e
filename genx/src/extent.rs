//! How large a model is, and what makes it too large.
//!
//! Corners are f32 relative to the middle of the model: at a distance of L they are right to 2^-24 L. Where something lies
//! so far from the rest that this is much of a patch, nothing is where it should be.

use glam::{DVec3, Vec3};
use scene::{Scene, Surface};

/// How much of a patch's side the step of its coordinates may be.
const MOST_STEP: f64 = 0.01;

/// Patches that are smaller than all others have this share of the area at most: slivers decide nothing.
const NEGLIGIBLE: f64 = 0.01;

/// The units that a model may be in, and the least of its three extents from which on that is likely, if they are no metres.
const UNITS: [(&str, f64); 2] = [("mm", 1000.0), ("cm", 150.0)];

/// An object that is too far away from the rest.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "object \"{object}\" lies {distance:.0} m from the middle of the rest, where coordinates have steps of {step} m, and patches have \
     sides of {side:.2e} m: remove it from the model, or raise the area threshold"
)]
pub struct FarAway {
    /// Its name.
    pub object: String,
    /// From the middle of the surfaces, metres.
    pub distance: f64,
    /// Between neighbouring numbers, metres.
    pub step: f64,
    /// Of nearly the smallest patch, metres.
    pub side: f64,
}

/// Finds what is too far away.
///
/// # Errors
/// The object that is farthest from the middle, where that spoils the patches.
pub fn check(scene: &Scene) -> Result<(), FarAway> {
    let [low, high] = scene.bounds();
    let reach = low.abs().max(high.abs()).max_element();
    let step = f64::from(reach.next_up()) - f64::from(reach);
    let mut areas = scene.patch_areas();
    areas.sort_unstable_by(f64::total_cmp);
    let mut negligible = NEGLIGIBLE * areas.iter().sum::<f64>();
    let smallest = areas.into_iter().find(|area| {
        negligible -= area;
        negligible < 0.0
    });
    let side = smallest.unwrap_or(0.0).sqrt();
    if step <= MOST_STEP * side {
        return Ok(());
    }
    let middle = middle(scene.surfaces());
    let distance = |surface: &Surface| {
        let corners = surface.corners.iter();
        let distances = corners.map(|corner| corner.as_dvec3().distance(middle));
        distances.fold(0.0, f64::max)
    };
    let farthest = scene
        .surfaces()
        .iter()
        .max_by(|a, b| distance(a).total_cmp(&distance(b)));
    farthest.map_or(Ok(()), |surface| {
        Err(FarAway {
            object: scene.object(surface.object).to_owned(),
            distance: distance(surface),
            step,
            side,
        })
    })
}

/// Where half of the surfaces lie to each side, along each axis.
fn middle(surfaces: &[Surface]) -> DVec3 {
    let median = |axis: usize| {
        let mut values: Vec<f32> = surfaces.iter().map(|s| s.corners[0][axis]).collect();
        values.sort_unstable_by(f32::total_cmp);
        values.get(values.len() / 2).copied().unwrap_or_default()
    };
    Vec3::new(median(0), median(1), median(2)).as_dvec3()
}

/// Width, depth and height of a scene, metres.
pub fn of(scene: &Scene) -> DVec3 {
    let [low, high] = scene.bounds().map(Vec3::as_dvec3);
    high - low
}

/// The unit that a model of such an extent is likely to be in, if it was taken to be in metres.
pub fn likely_unit(extent: DVec3) -> Option<&'static str> {
    let least = extent.min_element();
    UNITS
        .into_iter()
        .find(|(_, from)| least >= *from)
        .map(|(unit, _)| unit)
}
