//! How many hemicubes a patch needs: few where the surroundings are far, more where they are near.
//!
//! # Theory
//! What a point sees of a surface at distance d varies over a patch of radius r by second differences of
//! the order (r/d)^2: the midpoint rule's error, which has the same sign for all patches of a wall. Measured
//! between unit squares at distance 1 it is 0.16 percent at d = 11 r, so 0.07 percent at 16 r. Nearer than that
//! takes the three-point rule, whose error falls with a higher power. How many bisections it takes beside
//! a surface that touches or nearly does is asked of Lambert's formula
//! ([`crate::polygon_form_factor`]), which knows the unhidden form factor of a point: bisections go on
//! until their means over the patch settle.
//!
//! # Practice
//! A surface counts that rises above the patch's plane, shows its front, and takes at least
//! `LEAST_FORM_FACTOR` of the view of the centroid or of one of the three points: the next facet of a smooth
//! concave shape does not. What emits counts in any case.
//! Distances are from the centroid, radii to the farthest corner. One point where nothing that counts is
//! within `FAR` radii; else three in each of 2^k triangles, with the smallest k up to `MOST_BISECTIONS`
//! for which
//!
//! - the triangles' radii are at most `GAPS` times the distance of what faces the patch (normals more
//!   than 120 degrees apart): across a narrow gap the view changes along its rim within a gap's width;
//! - the form factors of what counts within `NEAR` radii change by at most a share `SETTLED` in sum with
//!   either of the next two bisections.
//!
//! Most patches before a gap lie away from its rim and see the same from everywhere. So where a gap asks for more points,
//! the fewest are taken, one included, whose form factors are the same but for a share `SAME`.

use std::f64::consts::PI;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scene::{PatchId, Scene, Surface, SurfaceId};
use visibility::{COORDINATE_ULPS, Drawable, Frame, is_in_plane, plane_tolerance, reach};

use super::rule::Rule;
use crate::polygon_form_factor::point_to_triangle;
use crate::sphere::{Sphere, Spheres};
use crate::triangle;

/// Distance in patch radii from which on one point does.
const FAR: f64 = 16.0;

/// Distance in patch radii within which form factors have to settle.
const NEAR: f64 = 2.0;

/// The least unhidden form factor of a surface that counts.
const LEAST_FORM_FACTOR: f64 = 2e-3;

/// Sum of the form factors' changes, relative to their sum, that is small enough.
const SETTLED: f64 = 2e-2;

/// Difference of a form factor, relative to it, by which rules are as good as each other; below `LEAST_FORM_FACTOR`, relative
/// to that.
const SAME: f64 = 5e-5;

/// Radius of a triangle in distances of what faces it, at most.
const GAPS: f64 = 4.0;

/// The most bisections: 96 points.
const MOST_BISECTIONS: u32 = 5;

/// The rule of a patch that is alone.
pub(super) const FEWEST: Rule = Rule::Centroids { bisections: 0 };

/// The rule that has so many points.
pub(super) fn rule(count: u32) -> Rule {
    if count == FEWEST.count() {
        FEWEST
    } else {
        Rule::ThreePoint {
            bisections: (count / 3).trailing_zeros(),
        }
    }
}

/// The number of each patch's first hemicube, then the number of all.
pub(super) fn firsts(scene: &Scene, drawable: &Drawable) -> Vec<u32> {
    let surroundings = Surroundings::new(scene, drawable);
    let counts: Vec<u32> = (0..scene.patch_count())
        .into_par_iter()
        .map(|patch| surroundings.rule(PatchId(patch)).count())
        .collect();
    let mut firsts = Vec::with_capacity(counts.len() + 1);
    let mut sum = 0;
    firsts.push(sum);
    // At most 2^24 patches with 96 each: below 2^31.
    firsts.extend(counts.iter().map(|count| {
        sum += count;
        sum
    }));
    firsts
}

/// What patches have around them.
struct Surroundings<'a> {
    scene: &'a Scene,
    /// Of the same surfaces.
    drawable: &'a Drawable<'a>,
    spheres: Spheres,
    /// One per surface.
    facts: Vec<Facts>,
    plane_tolerance: f64,
}

/// What is asked of every surface that is near.
#[derive(Clone, Copy, Debug)]
struct Facts {
    /// Unit vector.
    normal: DVec3,
    /// Product of the normal with the points of its plane, metres.
    offset: f64,
    /// m^2.
    area: f64,
    emits: bool,
}

impl Facts {
    fn new(scene: &Scene, surface: &Surface) -> Self {
        let normal = surface.normal();
        Self {
            normal,
            offset: normal.dot(surface.corners[0].as_dvec3()),
            area: surface.area(),
            emits: scene.material(surface.material).is_emitter(),
        }
    }

    /// False only where no point within `radius` of the eye, metres, can have a form factor of [`LEAST_FORM_FACTOR`]
    /// to the surface, in its sphere: with both cosines as large as they can be and the distance as small, F is at
    /// most A cos cos' / (pi d^2).
    fn may_count(&self, sphere: &Sphere, frame: &Frame, radius: f64) -> bool {
        let away = sphere.centre - frame.position;
        let nearest = away.length() - sphere.radius - radius;
        if self.emits || nearest <= 0.0 {
            return true;
        }
        // Largest heights over each other's plane, no larger than what a cosine of 1 has.
        let above = (frame.normal.dot(away) + sphere.radius).clamp(0.0, nearest);
        let in_front = (self.normal.dot(frame.position) - self.offset + radius).clamp(0.0, nearest);
        let squared = nearest * nearest;
        self.area * above * in_front >= LEAST_FORM_FACTOR * PI * squared * squared
    }
}

impl<'a> Surroundings<'a> {
    fn new(scene: &'a Scene, drawable: &'a Drawable<'a>) -> Self {
        Self {
            scene,
            drawable,
            spheres: Spheres::new(scene.surfaces()),
            facts: scene
                .surfaces()
                .iter()
                .map(|s| Facts::new(scene, s))
                .collect(),
            plane_tolerance: plane_tolerance(scene),
        }
    }

    /// The rule that a patch needs.
    fn rule(&self, patch: PatchId) -> Rule {
        let geometry = self.scene.patch(patch);
        let normal = self.drawable.normal_of(geometry.surface);
        let corners = geometry.corners.map(Vec3::as_dvec3);
        let centroid = geometry.centroid();
        let radius = corners
            .iter()
            .map(|p| p.distance(centroid))
            .fold(0.0, f64::max);
        let frame = Frame::on_patch(&geometry, normal, centroid, 0.0);
        let corners = corners.map(|p| frame.to_local(p));
        let points = Rule::ThreePoint { bisections: 0 }.points(corners);
        let mut rule = FEWEST;
        let mut near: Vec<Neighbour> = Vec::new();
        let mut gap = f64::INFINITY;
        let far = FAR * radius;
        self.spheres
            .for_each_within(far, centroid, |index, sphere| {
                let id = SurfaceId(index as u32);
                let facts = &self.facts[index];
                if id != geometry.surface
                    && facts.may_count(sphere, &frame, radius)
                    && let Some(neighbour) = self.neighbour(&frame, &points, id)
                {
                    let distance = triangle::distance(DVec3::ZERO, neighbour.corners);
                    if distance < far {
                        rule = Rule::ThreePoint { bisections: 0 };
                    }
                    if distance < NEAR * radius {
                        if neighbour.normal.z < -0.5 {
                            gap = gap.min(distance);
                        }
                        near.push(neighbour);
                    }
                }
                // Once something is known to be within reach, only what is near matters.
                if rule == FEWEST { far } else { NEAR * radius }
            });
        if near.is_empty() {
            return rule;
        }
        // Areas are halved, so radii fall by sqrt(2).
        let least = (2.0 * (radius / (GAPS * gap)).log2()).ceil().max(0.0) as u32;
        let least = least.min(MOST_BISECTIONS);
        let means_of = |bisections| means(Rule::ThreePoint { bisections }, corners, &near);
        let mut finer = [means_of(least), means_of(least + 1)];
        let mut bisections = least;
        while bisections < MOST_BISECTIONS {
            let [here, next] = &finer;
            let after_next = means_of(bisections + 2);
            if differ(here, next) <= SETTLED && differ(here, &after_next) <= SETTLED {
                break;
            }
            let [_, next] = finer;
            finer = [next, after_next];
            bisections += 1;
        }
        let rule = Rule::ThreePoint { bisections };
        if least == 0 {
            return rule;
        }
        let fewer = (0..bisections).map(|bisections| Rule::ThreePoint { bisections });
        std::iter::once(FEWEST)
            .chain(fewer)
            .find(|&fewer| are_same(&means(fewer, corners, &near), &finer[0]))
            .unwrap_or(rule)
    }

    /// A surface in a patch's frame, which stands at its centroid; `None` where it does not count, there and
    /// at some other points.
    fn neighbour(&self, frame: &Frame, points: &[DVec3], surface: SurfaceId) -> Option<Neighbour> {
        let corners = self
            .scene
            .surface(surface)
            .corners
            .map(|p| frame.to_local(p.as_dvec3()));
        let reach = reach(self.scene.surface(surface)).max(frame.position.abs());
        let height = corners.iter().fold(0.0, |most, q| q.z.max(most));
        if height == 0.0 || is_in_plane(height, self.plane_tolerance, frame.normal, reach) {
            return None;
        }
        let Facts { normal, emits, .. } = self.facts[surface.index()];
        let neighbour = Neighbour {
            corners,
            plane_tolerance: self
                .plane_tolerance
                .min(COORDINATE_ULPS * normal.abs().dot(reach)),
            normal: (corners[1] - corners[0])
                .cross(corners[2] - corners[0])
                .normalize_or_zero(),
        };
        let counts = |point| neighbour.form_factor(point) >= LEAST_FORM_FACTOR;
        (emits || counts(DVec3::ZERO) || points.iter().copied().any(counts)).then_some(neighbour)
    }
}

/// Mean unhidden form factors over a patch, one per neighbour.
fn means(rule: Rule, corners: [DVec3; 3], near: &[Neighbour]) -> Vec<f64> {
    let points = rule.points(corners);
    near.iter()
        .map(|neighbour| {
            let sum: f64 = points
                .iter()
                .map(|&point| neighbour.form_factor(point))
                .sum();
            sum / points.len() as f64
        })
        .collect()
}

/// How far form factors are from those of a finer rule, relative to these, all in sum.
fn differ(means: &[f64], finer: &[f64]) -> f64 {
    let changes = means.iter().zip(finer).map(|(a, b)| (a - b).abs());
    changes.sum::<f64>() / finer.iter().sum::<f64>().max(f64::MIN_POSITIVE)
}

/// Whether each form factor is that of a finer rule.
fn are_same(means: &[f64], finer: &[f64]) -> bool {
    let mut pairs = means.iter().zip(finer);
    pairs.all(|(a, b)| (a - b).abs() <= SAME * b.max(LEAST_FORM_FACTOR))
}

/// A surface in a patch's frame.
struct Neighbour {
    corners: [DVec3; 3],
    normal: DVec3,
    /// Distance from its plane that may be rounding alone, metres.
    plane_tolerance: f64,
}

impl Neighbour {
    /// What a point of the patch sees of it if nothing hides it, dimensionless.
    fn form_factor(&self, point: DVec3) -> f64 {
        if (point - self.corners[0]).dot(self.normal) <= self.plane_tolerance {
            return 0.0;
        }
        point_to_triangle(self.corners.map(|corner| corner - point))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rules_come_back_from_their_counts() {
        for bisections in 0..=MOST_BISECTIONS {
            let three = Rule::ThreePoint { bisections };
            assert_eq!(rule(three.count()), three);
        }
        assert_eq!(rule(1), FEWEST);
    }
}
