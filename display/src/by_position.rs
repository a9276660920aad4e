//! How far a solution is from another one whose patches, surfaces or origin differ, place by place.
//!
//! Points stand on the patches of the first scene. Each has the values of both solutions: those of the first where it stands, and
//! those of the second at the same place of the model's own coordinates ([`crate::places`]). Both errors are those of
//! [`compute::compare`], of the reflected radiosity rho H as a picture shows it, over the area that light reaches in either.
//!
//! A patch has three points of equal weight, x_k = 1/3 + cos(a + 2 pi k / 3) / 3 and their rotations as barycentric coordinates.
//! With any angle a that is right for what is quadratic: the sum of their squares is 1/2 (Hammer and Stroud, "Numerical
//! integration over simplexes and cones", Mathematical Tables and Other Aids to Computation 10, 1956, has a = 0). Here a is 15 degrees,
//! so that no point lies on a line of bisection, where two patches of a finer mesh would meet. Large patches are bisected first.

use std::f64::consts::PI;

use compute::compare::{Compared, POINTS, are_same_surfaces, errors_over, irradiance_at};
use compute::function::Errors;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scene::bisection::{bisections_for, leaf_corners};
use scene::{PatchId, Rgb, Scene, Solution};

use crate::compare::{describe_difference, describe_errors};
use crate::luminance::luminance;
use crate::places::{Place, Places, point_at};

/// Points of a part of a patch.
const POINTS_A_PART: usize = 3;

/// By which angle these are turned, degrees.
const TURNED: f64 = 15.0;

/// A scene and what was solved of it.
type Solved<'s> = (&'s Scene, &'s Solution);

/// Two solutions at the same places.
#[derive(Clone, Debug)]
pub struct ByPosition {
    /// Those that both scenes have, patch by patch of the first one.
    points: Vec<Point>,
    /// See [`Self::irradiance`].
    irradiance: Vec<Option<Rgb>>,
    /// What share of the first scene's area that may be seen they stand for.
    share: f64,
}

/// A place that both scenes have.
#[derive(Clone, Copy, Debug)]
struct Point {
    /// Where it is in the first scene.
    patch: PatchId,
    /// What it stands for, m^2.
    area: f64,
    /// Reflected radiosity in the first scene and in the second, W/m^2.
    reflected: [Rgb; 2],
    /// Irradiance in the second, W/m^2.
    irradiance: Rgb,
}

/// What differs between two solutions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AreaComparison {
    /// Both errors, over the area that is compared and that light reaches in either; infinite where what is right is black and the
    /// other is not.
    pub errors: Errors,
    /// Share of the area that is compared, 0 to 1: where the other scene has a surface, too. What lies inside of solids does not count.
    pub compared_share: f64,
    /// The patch whose reflected radiosity has the luminance that differs most on the mean, and by how much, W/m^2, above 0
    /// where it is too bright; `None` where nothing is compared.
    pub most: Option<(PatchId, f64)>,
}

impl ByPosition {
    /// Looks up the places of one scene in another one, which is taken to be right.
    pub fn new(shown: Solved, right: Solved) -> Self {
        let scene = shown.0;
        let look_up = LookUp::new(scene, right.0);
        let is_inside = scene.is_inside();
        let patches = (0..scene.patch_count()).into_par_iter().map(PatchId);
        let seen = patches.map(|patch| {
            if is_inside[patch.index()] {
                (Vec::new(), 0.0)
            } else {
                points_of(patch, shown, right, &look_up)
            }
        });
        let of_patches: Vec<(Vec<Point>, f64)> = seen.collect();
        let area: f64 = of_patches.iter().map(|(_, area)| area).sum();
        let irradiance = of_patches.iter().map(|(points, _)| {
            let sum: DVec3 = points.iter().map(|p| p.irradiance.as_dvec3()).sum();
            (!points.is_empty()).then(|| (sum / points.len() as f64).as_vec3())
        });
        let irradiance = irradiance.collect();
        let points: Vec<Point> = of_patches.into_iter().flat_map(|(of, _)| of).collect();
        let compared: f64 = points.iter().map(|point| point.area).sum();
        Self {
            points,
            irradiance,
            share: if area > 0.0 {
                (compared / area).min(1.0)
            } else {
                0.0
            },
        }
    }

    /// Mean irradiance that the right solution has in the place of each patch of the other one, W/m^2, one per patch; `None` where it
    /// has no surface, and inside of solids.
    pub fn irradiance(&self) -> &[Option<Rgb>] {
        &self.irradiance
    }

    /// What differs, by area.
    pub fn errors_by_area(&self) -> AreaComparison {
        let compared = self.points.iter().map(Point::compared);
        let of_patches = self.points.chunk_by(|a, b| a.patch == b.patch);
        let differences = of_patches.map(|points| {
            let difference = |p: &Point| {
                let [shown, right] = p.reflected.map(|value| f64::from(luminance(value)));
                shown - right
            };
            let sum: f64 = points.iter().map(difference).sum();
            (points[0].patch, sum / points.len() as f64)
        });
        AreaComparison {
            errors: errors_over(&compared.filter(Compared::is_lit)),
            compared_share: self.share,
            most: differences.reduce(|a, b| if b.1.abs() > a.1.abs() { b } else { a }),
        }
    }
}

impl Point {
    fn compared(&self) -> Compared {
        let [shown, right] = self.reflected.map(Vec3::as_dvec3);
        Compared {
            area: self.area,
            shown,
            right,
        }
    }
}

impl AreaComparison {
    /// A line for people about a comparison of this scene with another one.
    pub fn describe(&self, scene: &Scene) -> String {
        let Some((patch, difference)) = self.most else {
            return "0 % of the area is compared: the other scene has no surfaces in these places; \
                    compare solutions of one model, in one unit"
                .to_owned();
        };
        let errors = describe_errors(self.errors);
        let percent = 100.0 * self.compared_share;
        let most = if difference == 0.0 {
            "of one luminance in each patch".to_owned()
        } else {
            let object = scene.surface(scene.mesh().surface_of(patch)).object;
            let (number, name) = (patch.0, scene.object(object));
            let difference = describe_difference(difference);
            format!("most {difference} on patch {number} of \"{name}\"")
        };
        format!("{errors}, over {percent:.0} % of the area; {most}")
    }
}

/// How a place of one scene is found in another one.
struct LookUp<'s> {
    scene: &'s Scene,
    right: &'s Scene,
    /// `None` where both have the same surfaces in the same places.
    places: Option<Places<'s>>,
    /// Whether each patch of the right scene lies inside of a solid.
    is_inside: Vec<bool>,
}

impl<'s> LookUp<'s> {
    fn new(scene: &'s Scene, right: &'s Scene) -> Self {
        let is_moved = scene.origin() != right.origin()
            || scene.axes().unit.to_bits() != right.axes().unit.to_bits();
        let is_other = is_moved || !are_same_surfaces(scene, right);
        Self {
            scene,
            right,
            places: is_other.then(|| Places::new(right)),
            is_inside: right.is_inside(),
        }
    }

    fn place(&self, here: Place) -> Option<Place> {
        let Some(places) = &self.places else {
            return Some(here);
        };
        let surface = self.scene.surface(here.surface);
        let within = Vec3::from_array(here.within).as_dvec3();
        let point = point_at(surface.corners.map(Vec3::as_dvec3), within);
        let there = self.right.to_scene(self.scene.to_model(point));
        places.of(there, surface.normal())
    }
}

/// The points of a patch that both scenes have, and the area that all of its points stand for, m^2.
fn points_of(patch: PatchId, shown: Solved, right: Solved, look_up: &LookUp) -> (Vec<Point>, f64) {
    let scene = shown.0;
    let surface = scene.mesh().surface_of(patch);
    let tree = scene.mesh().tree(surface);
    let area = scene.surface(surface).area() / f64::from(1_u32 << tree.depth);
    let largest = scene.area() * POINTS_A_PART as f64 / POINTS;
    let bisections = bisections_for(area, largest).unwrap_or(0);
    let code = (patch.0 - tree.first_patch.0) << bisections;
    let parts = (0..1_u32 << bisections).map(|k| leaf_corners(tree.depth + bisections, code + k));
    let area = area / (POINTS_A_PART << bisections) as f64;
    let (mut points, mut seen) = (Vec::new(), 0.0);
    for within in parts.flat_map(points_in) {
        let here = Place {
            surface,
            within: within.as_vec3().to_array(),
        };
        let there = look_up.place(here);
        let hidden = there.filter(|there| {
            let (patch, _) = right.0.mesh().locate(there.surface, there.within);
            look_up.is_inside[patch.index()]
        });
        if hidden.is_some() {
            continue;
        }
        seen += area;
        if let Some(there) = there {
            let irradiance = received(right, there);
            points.push(Point {
                patch,
                area,
                reflected: [
                    reflectance(scene, here) * received(shown, here),
                    reflectance(right.0, there) * irradiance,
                ],
                irradiance,
            });
        }
    }
    (points, seen)
}

/// Three points of a triangle.
fn points_in(corners: [DVec3; 3]) -> [DVec3; 3] {
    let weight = |k: usize| {
        let angle = TURNED.to_radians() + 2.0 * PI * (k % 3) as f64 / 3.0;
        (1.0 + angle.cos()) / 3.0
    };
    [0, 1, 2].map(|k| point_at(corners, DVec3::new(weight(k), weight(k + 1), weight(k + 2))))
}

/// What a place receives, W/m^2. Beyond a border by a rounding, a function may be below 0 by as little.
fn received(solved: Solved, place: Place) -> Rgb {
    let irradiance = irradiance_at(solved, place.surface, place.within);
    irradiance.as_vec3().max(Rgb::ZERO)
}

fn reflectance(scene: &Scene, place: Place) -> Rgb {
    scene
        .material(scene.surface(place.surface).material)
        .reflectance
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_points_are_right_for_what_is_quadratic() {
        let points = points_in([DVec3::X, DVec3::Y, DVec3::Z]);
        let mean = |f: &dyn Fn(DVec3) -> f64| points.iter().map(|&p| f(p)).sum::<f64>() / 3.0;
        // The means over a triangle of x, x^2 and x y in barycentric coordinates.
        for (found, exact) in [
            (mean(&|p| p.y), 1.0 / 3.0),
            (mean(&|p| p.y * p.y), 1.0 / 6.0),
            (mean(&|p| p.x * p.z), 1.0 / 12.0),
        ] {
            assert!((found - exact).abs() < 1e-15, "{found} {exact}");
        }
        assert!(points.iter().all(|p| p.min_element() > 0.09));
    }
}
