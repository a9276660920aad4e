//! Bodies of lights that are close together, kept apart: they are opaque, and what one of them sends into another is lost.
//!
//! Lights within `REACH` radii of a place where one stands already are a cluster, and stand there:
//! - Points are one sphere, of the sum of their intensities.
//! - Spots whose axes agree within 27 degrees are one disc along the first one's axis.
//! - A disc that has its place to itself stands there. Others are a quarter as wide, with the same intensity, and stand ahead of
//!   the place, each touching the sphere of `AHEAD` radii round it. There each sees nothing of the others and hides 1.3
//!   percent of the sphere's light: F = (1/64) (1/AHEAD)^2, by the reciprocity of the form factors of a sphere and a small
//!   disc that faces it.
//!
//! So no body of a cluster reaches into another one, nor into those of other clusters, whose places are `REACH` radii away.

use std::collections::HashMap;

use glam::{DVec3, I64Vec3};

use super::names::told_of;
use super::shapes::{disc, sphere};

/// How close a light is to a place to belong to it, radii: more than twice a disc's reach, 2 x 1.13, and than those of a disc
/// and a sphere, 1.13 + 1.05, whose corners are a little outside of it.
const REACH: f64 = 2.3;

/// How far ahead of its place a disc stands among others, radii: beyond the corners of the sphere.
const AHEAD: f64 = 1.1;

/// The radius of such a disc, radii.
const NARROW: f64 = 0.25;

/// The cosine of the angle between axes up to which discs are one. Seen from their place narrow discs that stand ahead of it
/// have a radius of 13.1 degrees, so that at more than twice this they do not meet.
const ALIGNED: f64 = 0.89;

/// A light that something stands in for.
#[derive(Clone, Debug)]
pub(super) struct Emitter {
    pub name: String,
    /// Metres.
    pub place: DVec3,
    pub shape: Shape,
    /// Of the channels red, green and blue, on the axis, W/sr.
    pub intensity: DVec3,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Shape {
    Sphere,
    Disc { axis: DVec3 },
}

/// What stands in for one or more lights.
pub(super) struct Body {
    pub name: String,
    pub intensity: DVec3,
    /// Metres.
    pub radius: f64,
    pub triangles: Vec<[DVec3; 3]>,
}

/// Lights at one place.
struct Cluster {
    place: DVec3,
    /// Each with its number, and no two of which are one body.
    emitters: Vec<(usize, Emitter)>,
}

/// The bodies of lights, in the order of these.
pub(super) fn apart(emitters: Vec<Emitter>, radius: f64, warnings: &mut Vec<String>) -> Vec<Body> {
    let mut clusters = Clusters {
        reach: REACH * radius,
        all: Vec::new(),
        by_cell: HashMap::new(),
    };
    let (mut joined, mut ahead) = (vec![], vec![]);
    let (spheres, discs): (Vec<_>, Vec<_>) = (0..)
        .zip(emitters)
        .partition(|(_, emitter)| emitter.shape == Shape::Sphere);
    // Spheres first, since they stay where they are.
    for (number, emitter) in spheres.into_iter().chain(discs) {
        let cluster = clusters.at(emitter.place);
        let mut others = cluster.emitters.iter_mut();
        match others.find(|(_, other)| is_one(other.shape, emitter.shape)) {
            Some((_, other)) => {
                other.intensity += emitter.intensity;
                joined.push(format!("\"{}\" with \"{}\"", emitter.name, other.name));
            }
            None => cluster.emitters.push((number, emitter)),
        }
    }
    let mut bodies = Vec::new();
    for Cluster { place, emitters } in clusters.all {
        let is_alone = emitters.len() == 1;
        for (number, emitter) in emitters {
            let (radius, triangles) = match emitter.shape {
                Shape::Sphere => (radius, sphere(place, radius)),
                Shape::Disc { axis } if is_alone => (radius, disc(place, axis, radius)),
                Shape::Disc { axis } => {
                    ahead.push(format!("\"{}\"", emitter.name));
                    let narrow = NARROW * radius;
                    (narrow, disc(place + AHEAD * radius * axis, axis, narrow))
                }
            };
            let body = Body {
                name: emitter.name,
                intensity: emitter.intensity,
                radius,
                triangles,
            };
            bodies.push((number, body));
        }
    }
    bodies.sort_by_key(|&(number, _)| number);
    warnings.extend(told_of(&joined, |them| {
        format!(
            "lights of one kind that are closer together than {REACH} radii of their bodies have one body: {them}; \
             a smaller --light-radius keeps them apart"
        )
    }));
    warnings.extend(told_of(&ahead, |them| {
        format!(
            "spot lights that are as close to other lights are narrower discs, {AHEAD} radii ahead of these: {them}"
        )
    }));
    bodies.into_iter().map(|(_, body)| body).collect()
}

/// Whether one body can stand in for both.
fn is_one(first: Shape, second: Shape) -> bool {
    match (first, second) {
        (Shape::Sphere, Shape::Sphere) => true,
        (Shape::Disc { axis: first }, Shape::Disc { axis: second }) => first.dot(second) >= ALIGNED,
        _ => false,
    }
}

/// Clusters, which are found by cells of a grid as wide as the reach.
struct Clusters {
    /// Metres.
    reach: f64,
    all: Vec<Cluster>,
    by_cell: HashMap<I64Vec3, Vec<usize>>,
}

impl Clusters {
    /// The first cluster in whose reach a place is, else a new one.
    fn at(&mut self, place: DVec3) -> &mut Cluster {
        let cell = (place / self.reach).floor().as_i64vec3();
        let neighbours = (0..27).map(|k| I64Vec3::new(k % 3, k / 3 % 3, k / 9) - I64Vec3::ONE);
        let known = neighbours.filter_map(|step| self.by_cell.get(&cell.saturating_add(step)));
        let is_near = |&k: &usize| {
            let cluster = self.all.get(k);
            cluster.is_some_and(|cluster| cluster.place.distance(place) < self.reach)
        };
        let first = known.flatten().copied().filter(is_near).min();
        let index = first.unwrap_or_else(|| {
            self.all.push(Cluster {
                place,
                emitters: Vec::new(),
            });
            self.all.len() - 1
        });
        if first.is_none() {
            self.by_cell.entry(cell).or_default().push(index);
        }
        &mut self.all[index]
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn centre(body: &Body) -> DVec3 {
        let corners = body.triangles.as_flattened();
        corners.iter().sum::<DVec3>() / corners.len() as f64
    }

    /// How far its corners are from some point, at least and at most.
    fn distances(body: &Body, point: DVec3) -> [f64; 2] {
        let corners = body.triangles.iter().flatten();
        corners.fold([f64::INFINITY, 0.0], |[low, high], corner| {
            let distance = corner.distance(point);
            [low.min(distance), high.max(distance)]
        })
    }

    fn normal(body: &Body) -> DVec3 {
        let area = |[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a);
        body.triangles.iter().map(area).sum::<DVec3>().normalize()
    }

    /// Whether a disc is wholly behind another body's plane, or away from its ball.
    fn is_clear(disc: &Body, other: &Body) -> bool {
        let middle = centre(other);
        let [_, reach] = distances(other, middle);
        let is_away = distances(disc, middle)[0].min(centre(disc).distance(middle)) > reach;
        let front = normal(disc);
        let corners = other.triangles.iter().flatten();
        let mut heights = corners.map(|&corner| (corner - centre(disc)).dot(front));
        is_away || heights.all(|height| height < 0.0)
    }

    fn emitter() -> impl Strategy<Value = Emitter> {
        let place = prop::array::uniform3(-3.0..3.0f64).prop_map(DVec3::from);
        let axis = prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from);
        (place, prop::option::of(axis)).prop_map(|(place, axis)| Emitter {
            name: String::new(),
            place,
            shape: match axis.and_then(DVec3::try_normalize) {
                Some(axis) => Shape::Disc { axis },
                None => Shape::Sphere,
            },
            intensity: DVec3::ONE,
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

        /// Bodies keep all intensity, spheres do not touch, and discs are outside of all others or see nothing of them.
        #[test]
        fn bodies_are_apart(emitters in prop::collection::vec(emitter(), 1..12)) {
            let count = emitters.len() as f64;
            let bodies = apart(emitters, 1.0, &mut Vec::new());
            let total: f64 = bodies.iter().map(|body| body.intensity.x).sum();
            prop_assert!((total - count).abs() < 1e-9, "{total} {count}");
            let is_sphere = |body: &Body| body.triangles.len() == 80;
            for (k, body) in bodies.iter().enumerate() {
                for other in &bodies[k + 1..] {
                    let is_apart = match [is_sphere(body), is_sphere(other)] {
                        [true, true] => centre(body).distance(centre(other)) > 2.0 * 1.05,
                        [true, false] => is_clear(other, body),
                        [false, true] => is_clear(body, other),
                        [false, false] => is_clear(body, other) && is_clear(other, body),
                    };
                    prop_assert!(is_apart, "{:?} {:?}", centre(body), centre(other));
                }
            }
        }
    }
}
