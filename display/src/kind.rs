//! Whether a scene is a room, a stage or an object.
//!
//! From a grid of points inside the bounding box a small picture is taken in all directions.
//! Points that see backs of surfaces lie in something solid, or outside a room, and are dropped.
//! Of the rest, the median share of directions in which there is nothing says what the scene is:
//! - no points, or more than `MAX_ROOM_OPENING`: an *object*;
//! - at least `MIN_FRONT_OPENING`, most of it through one side of the bounding box: a *stage*;
//! - else a *room*.

use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scene::Scene;
use visibility::{Cull, Drawable, Sample};

use crate::probe::Probe;

/// Share of directions that are open, above which a scene is no room.
const MAX_ROOM_OPENING: f64 = 0.3;
/// The same, above which an opening may be the missing wall of a stage.
const MIN_FRONT_OPENING: f64 = 0.04;
/// Share of the openings that is on one side of a stage.
const ONE_SIDED: f64 = 0.7;
/// Share of directions with backs of surfaces, above which a point is not in free space: imported
/// models have small leaks.
pub const MAX_BACK_FACES: f64 = 0.002;

/// Side of a probe's faces, pixels.
const PROBE_SIZE: usize = 16;

/// Points along each side of the bounding box.
fn points_of(scene: &Scene) -> usize {
    // A point costs some 200 ns a surface.
    match scene.surfaces().len() {
        0..=20_000 => 5,
        20_001..=100_000 => 4,
        _ => 2,
    }
}

/// What kind of scene it is, as seen from inside its bounding box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// Closed, or with windows.
    Room,
    /// A room that is open on the side with this outward normal.
    Stage(DVec3),
    /// Nothing to be inside of.
    Object,
}

/// The scene's bounding box: its middle and half its extent, metres.
pub fn bounding_box(scene: &Scene) -> [DVec3; 2] {
    let [low, high] = scene.bounds().map(Vec3::as_dvec3);
    [0.5 * (low + high), 0.5 * (high - low)]
}

/// The kind of a scene.
pub fn of(scene: &Scene) -> Kind {
    let [middle, half] = bounding_box(scene);
    let n = points_of(scene);
    let points: Vec<DVec3> = (0..n * n * n)
        .map(|k| {
            let at = DVec3::new((k % n) as f64, (k / n % n) as f64, (k / n / n) as f64);
            middle + half * ((2.0 * at + 1.0) / n as f64 - 1.0)
        })
        .collect();
    let drawable = Arc::new(Drawable::new(scene));
    let openings: Vec<[f64; 6]> = points
        .into_par_iter()
        .map_init(
            || Probe::new(&drawable),
            |probe, point| openings(probe, point, middle, half),
        )
        .flatten()
        .collect();
    let mut shares: Vec<f64> = openings.iter().map(|sides| sides.iter().sum()).collect();
    shares.sort_by(f64::total_cmp);
    let Some(&median) = shares.get(shares.len() / 2) else {
        return Kind::Object;
    };
    let total: f64 = shares.iter().sum();
    if median >= MIN_FRONT_OPENING {
        for side in 0..6 {
            let through_side: f64 = openings.iter().map(|sides| sides[side]).sum();
            if through_side >= ONE_SIDED * total {
                return Kind::Stage(side_normal(side));
            }
        }
    }
    if median <= MAX_ROOM_OPENING {
        Kind::Room
    } else {
        Kind::Object
    }
}

fn side_normal(side: usize) -> DVec3 {
    let axis = DVec3::AXES[side / 2];
    if side.is_multiple_of(2) { axis } else { -axis }
}

/// The shares of all directions in which a point sees nothing, by the side of the bounding box they
/// leave through; `None` for a point that is not in free space.
fn openings(probe: &mut Probe, point: DVec3, middle: DVec3, half: DVec3) -> Option<[f64; 6]> {
    let (mut sides, mut backs, mut total) = ([0.0; 6], 0.0, 0.0);
    let pixels = 6 * PROBE_SIZE * PROBE_SIZE;
    let mut probe = probe.at(point, Cull::Nothing, pixels);
    probe.look_around(PROBE_SIZE, |ray| {
        total += ray.solid_angle;
        match ray.sample {
            Sample::Front { .. } => {}
            Sample::BackFace(_) => backs += ray.solid_angle,
            Sample::Nothing => {
                // The ray meets the plane of each side at its own distance; it leaves by the
                // nearest.
                let to_side = |axis: DVec3| {
                    let along = ray.direction.dot(axis);
                    let distance =
                        (half.dot(axis) * along.signum() - (point - middle).dot(axis)) / along;
                    (distance, along < 0.0)
                };
                let distances = DVec3::AXES.map(to_side);
                let mut axis = 0;
                for k in 1..3 {
                    if distances[k].0 < distances[axis].0 {
                        axis = k;
                    }
                }
                sides[2 * axis + usize::from(distances[axis].1)] += ray.solid_angle;
            }
        }
    });
    (backs <= MAX_BACK_FACES * total).then(|| sides.map(|share| share / total))
}
