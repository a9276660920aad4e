//! Where emitters are so near that light changes within a triangle, and by how much if nothing is in the way.
//!
//! A lamp a hand's breadth before a wall lights a spot of that size. Neither a large triangle's corners nor points by chance in it
//! know of the spot, but the closed form does: what a point receives from an emitter that nothing hides is Lambert's
//! ([`polygon_form_factor`](crate::polygon_form_factor)). It is no part of the function, only tells where to look.

use glam::{DVec3, Vec3};
use scene::{Scene, SurfaceId};

use super::INSET;
use crate::polygon_form_factor::point_to_triangle;
use crate::triangle::distance;

/// Emitters that are asked at most, those of most power.
const MOST_EMITTERS: usize = 1 << 10;

/// An emitter is near where it is not so many times as far as a triangle is large: beyond, light is as good as linear in it, or its
/// corners tell.
const NEAR: f64 = 4.0;

/// Of those that are near so many are asked how far they are.
const MOST_NEAR: usize = 24;

/// A triangle is parted, the largest part over its distance to emitters first, until none is larger than this, or there are this
/// many.
const PART: f64 = 0.5;
const MOST_PARTS: usize = 256;

/// Emitters so many times as far as they are large are points.
const FAR: f64 = 4.0;

/// A distance from a plane that may be none, as a share of a triangle's size.
const ROUNDED: f64 = 1e-6;

/// The emitters of a scene.
#[derive(Clone, Debug)]
pub(super) struct Emitters(Vec<Emitter>);

#[derive(Clone, Copy, Debug)]
struct Emitter {
    corners: [DVec3; 3],
    /// Unit length.
    normal: DVec3,
    middle: DVec3,
    /// Of the sphere around the middle that encloses it, m.
    radius: f64,
    /// m^2.
    area: f64,
    /// W/m^2.
    emission: DVec3,
}

/// A part of a triangle that is small for its distance to emitters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// As barycentric coordinates in the triangle.
    pub in_triangle: [DVec3; 3],
    /// Share of the triangle.
    pub share: f64,
    /// What its middle receives straight from near emitters that nothing hides, less what is linear between the triangle's corners,
    /// W/m^2.
    pub surplus: DVec3,
}

/// A triangle that light falls on from near emitters.
#[derive(Clone, Debug)]
pub(super) struct Spots {
    pub parts: Vec<Part>,
    /// What its corners receive from these emitters if nothing hides them, W/m^2.
    pub at_corners: [DVec3; 3],
}

impl Emitters {
    /// Those of most power.
    pub fn new(scene: &Scene) -> Self {
        let emitter = |surface: &scene::Surface| {
            let emission = scene.material(surface.material).emission.as_dvec3();
            let corners = surface.corners.map(Vec3::as_dvec3);
            let middle = corners.iter().sum::<DVec3>() / 3.0;
            let radius = corners.map(|corner| corner.distance(middle));
            (emission != DVec3::ZERO).then(|| Emitter {
                corners,
                normal: surface.normal(),
                middle,
                radius: radius.into_iter().fold(0.0, f64::max),
                area: surface.area(),
                emission,
            })
        };
        let mut emitters: Vec<Emitter> = scene.surfaces().iter().filter_map(emitter).collect();
        let power = |emitter: &Emitter| emitter.area * emitter.emission.element_sum();
        emitters.sort_by(|a, b| power(b).total_cmp(&power(a)));
        emitters.truncate(MOST_EMITTERS);
        Self(emitters)
    }

    /// The spots on a triangle of a surface, whose corners these are as barycentric coordinates in it; `None` where no emitter is
    /// near.
    pub fn spots(&self, scene: &Scene, surface: SurfaceId, corners: [DVec3; 3]) -> Option<Spots> {
        let surface = scene.surface(surface);
        let normal = surface.normal();
        let at = |within: DVec3| -> DVec3 {
            let corners = surface.corners.map(Vec3::as_dvec3);
            (0..3).map(|k| within[k] * corners[k]).sum()
        };
        let triangle = corners.map(at);
        let middle = triangle.iter().sum::<DVec3>() / 3.0;
        let (size, _) = longest_side(triangle);
        let is_near = |emitter: &&Emitter| {
            let gap = middle.distance(emitter.middle) - emitter.radius - size;
            // Each has a part of the other before it, by more than what is rounded of a lamp in its ceiling.
            let least = ROUNDED * size;
            let above = emitter
                .corners
                .iter()
                .any(|&corner| (corner - middle).dot(normal) > least);
            let before = triangle
                .iter()
                .any(|&corner| (corner - emitter.middle).dot(emitter.normal) > least);
            gap < NEAR * size && above && before
        };
        let near: Vec<&Emitter> = self.0.iter().filter(is_near).collect();
        if near.is_empty() {
            return None;
        }
        let receive = |position: DVec3| {
            let each = near.iter();
            each.map(|emitter| emitter.irradiance(position, normal))
                .sum::<DVec3>()
        };
        // Some of the many facets of a round lamp tell how far it is.
        let facets = near.len().div_ceil(MOST_NEAR);
        let some: Vec<&Emitter> = near.iter().copied().step_by(facets).collect();
        // As vertices do on a wall's side, which holds the plane of the next one.
        let at_corners = triangle.map(|corner| receive(corner.lerp(middle, INSET)));
        let whole = Piece::new([DVec3::X, DVec3::Y, DVec3::Z], 1.0, triangle, &some);
        let mut pieces = vec![whole];
        while pieces.len() < MOST_PARTS {
            let sizes = pieces.iter().enumerate();
            let largest = sizes.max_by(|(_, a), (_, b)| a.size.total_cmp(&b.size));
            let Some((k, _)) = largest.filter(|(_, piece)| piece.size > PART) else {
                break;
            };
            let [first, second] = pieces[k].halves(triangle, &some);
            pieces[k] = first;
            pieces.push(second);
        }
        let part = |piece: Piece| {
            let middle = piece.corners.iter().sum::<DVec3>() / 3.0;
            let linear: DVec3 = (0..3).map(|k| middle[k] * at_corners[k]).sum();
            let position: DVec3 = (0..3).map(|k| middle[k] * triangle[k]).sum();
            Part {
                in_triangle: piece.corners,
                share: piece.share,
                surplus: receive(position) - linear,
            }
        };
        let parts = pieces.into_iter().map(part).collect();
        Some(Spots { parts, at_corners })
    }
}

/// A part on its way.
#[derive(Clone, Copy, Debug)]
struct Piece {
    /// As barycentric coordinates in the triangle.
    corners: [DVec3; 3],
    /// Of the triangle.
    share: f64,
    /// Its longest side over its middle's distance from emitters.
    size: f64,
    /// The corner at which that side begins.
    longest: usize,
}

impl Piece {
    fn new(corners: [DVec3; 3], share: f64, triangle: [DVec3; 3], near: &[&Emitter]) -> Self {
        let on_wall = corners.map(|w| (0..3).map(|k| w[k] * triangle[k]).sum::<DVec3>());
        let middle = on_wall.iter().sum::<DVec3>() / 3.0;
        let distances = near.iter().map(|emitter| distance(middle, emitter.corners));
        let nearest = distances.fold(f64::INFINITY, f64::min);
        let (side, longest) = longest_side(on_wall);
        Self {
            corners,
            share,
            size: side / nearest,
            longest,
        }
    }

    fn halves(&self, triangle: [DVec3; 3], near: &[&Emitter]) -> [Self; 2] {
        let [a, b, c] = [0, 1, 2].map(|k| self.corners[(self.longest + k) % 3]);
        let m = 0.5 * (a + b);
        [[a, m, c], [m, b, c]].map(|half| Self::new(half, 0.5 * self.share, triangle, near))
    }
}

impl Emitter {
    /// What a point receives from it if nothing hides it, W/m^2.
    fn irradiance(&self, position: DVec3, normal: DVec3) -> DVec3 {
        let way = self.middle - position;
        if -(way.dot(self.normal)) <= 0.0 {
            return DVec3::ZERO;
        }
        let squared = way.length_squared();
        let form_factor = if squared > (FAR * self.radius).powi(2) {
            let cosines = way.dot(normal).max(0.0) * -way.dot(self.normal);
            cosines * self.area / (std::f64::consts::PI * squared * squared)
        } else {
            let (right, up) = normal.any_orthonormal_pair();
            let local = |corner: DVec3| {
                let way = corner - position;
                DVec3::new(way.dot(right), way.dot(up), way.dot(normal))
            };
            point_to_triangle(self.corners.map(local))
        };
        form_factor * self.emission
    }
}

/// The length of a triangle's longest side, metres, and the corner that it begins at.
fn longest_side(corners: [DVec3; 3]) -> (f64, usize) {
    let sides = (0..3).map(|k| (corners[k].distance(corners[(k + 1) % 3]), k));
    sides.fold(
        (0.0, 0),
        |most, side| if side.0 > most.0 { side } else { most },
    )
}

#[cfg(test)]
mod tests {
    use scene::{Material, MaterialId, ObjectId, Rgb, Surface};

    use super::*;

    /// A lamp of 10 x 10 cm, so high over a floor of some metres, and the floor's spots.
    fn spots(height: f32) -> Option<Spots> {
        let surface = |corners: [[f32; 3]; 3], material: u32| Surface {
            corners: corners.map(Vec3::from),
            material: MaterialId(material),
            object: ObjectId(0),
        };
        let material = |emission: f32| Material {
            name: "m".into(),
            reflectance: Rgb::splat(0.5),
            emission: Rgb::splat(emission),
        };
        let (l, h) = (0.05, height);
        let surfaces = vec![
            surface([[-9.0, -5.0, 0.0], [9.0, -5.0, 0.0], [0.0, 9.0, 0.0]], 0),
            surface([[-l, -l, h], [l, l, h], [l, -l, h]], 1),
            surface([[-l, -l, h], [-l, l, h], [l, l, h]], 1),
        ];
        let materials = vec![material(0.0), material(3.0)];
        let objects = vec!["o".into()];
        let max_area = f64::INFINITY;
        let scene = Scene::with_max_area(materials, objects, surfaces, max_area, DVec3::ZERO);
        let corners = [DVec3::X, DVec3::Y, DVec3::Z];
        let scene = scene.unwrap();
        Emitters::new(&scene).spots(&scene, SurfaceId(0), corners)
    }

    /// Nearly all of what the lamp emits falls on the floor, on a spot that is a ten-thousandth of it; parts are smaller than half
    /// their distance to it, over which light changes by a tenth of what a middle says.
    #[test]
    fn parts_find_all_of_a_small_spot() {
        for height in [0.01, 0.05, 0.3] {
            let Spots { parts, at_corners } = spots(height).unwrap();
            assert!(parts.len() <= MOST_PARTS);
            let shares: f64 = parts.iter().map(|part| part.share).sum();
            assert!((shares - 1.0).abs() < 1e-12);
            let floor = 0.5 * 18.0 * 14.0;
            let received = parts.iter().map(|part| {
                let middle = part.in_triangle.iter().sum::<DVec3>() / 3.0;
                let linear: DVec3 = (0..3).map(|k| middle[k] * at_corners[k]).sum();
                floor * part.share * (part.surplus + linear).x
            });
            let received: f64 = received.sum();
            let emitted = 3.0 * 0.1 * 0.1;
            assert!(
                (received / emitted - 1.0).abs() < 0.1,
                "{received} of {emitted}"
            );
        }
    }

    /// A lamp that looks away from a wall, or lies in it, makes no spots there.
    #[test]
    fn what_does_not_face_makes_no_spots() {
        assert!(spots(-0.1).is_none() && spots(0.0).is_none());
    }
}
