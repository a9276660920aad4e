//! Shapes made of triangles, and scenes made of shapes.
//!
//! Curved shapes become polyhedra of the same area. For a disk the error in its outline then cancels
//! to first order. For a convex solid the mean area of its shadows, over all directions, is right,
//! being a quarter of its surface (Cauchy); between two nested spheres the form factors, which are
//! ratios of areas, are exact.

use std::f64::consts::PI;

use glam::DVec3;
use scene::import::ImportedModel;
use scene::planar::box_sides;
use scene::{Material, MaterialId, ObjectId, Rgb, Scene, SceneError, Surface};

/// Three corners, metres, counter-clockwise from the front.
pub type Triangle = [DVec3; 3];

/// What tessellating a disk or a sphere changes a form factor by, relative: a bound that a test
/// holds against exact integrals over the polyhedra.
pub const TESSELLATION: f64 = 5e-4;

/// Sides of the polygon that stands for a disk.
const DISK_SIDES: usize = 48;

/// Side of the triangle that stands for a point, metres: what its corners see differs from what the
/// point sees by 1e-4 of the distance, which cancels over the three to second order.
const POINT_SIDE: f64 = 1e-4;

/// A planar convex polygon as a fan.
pub fn polygon(corners: &[DVec3]) -> Vec<Triangle> {
    corners
        .windows(2)
        .skip(1)
        .map(|pair| [corners[0], pair[0], pair[1]])
        .collect()
}

/// The same triangles from both sides.
pub fn two_sided(triangles: Vec<Triangle>) -> Vec<Triangle> {
    let backs: Vec<Triangle> = triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    [triangles, backs].concat()
}

/// A rectangle in a plane of constant z, its front upwards, or downwards if not `up`.
pub fn horizontal(x: [f64; 2], y: [f64; 2], z: f64, up: bool) -> Vec<Triangle> {
    let mut corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| DVec3::new(x[i], y[j], z));
    if !up {
        corners.reverse();
    }
    polygon(&corners)
}

/// A tiny triangle around a point.
pub fn point(position: DVec3, normal: DVec3) -> Vec<Triangle> {
    let [u, v] = tangents(normal);
    let corner = |k: i32| {
        let (sin, cos) = (2.0 * PI / 3.0 * f64::from(k)).sin_cos();
        position + POINT_SIDE / 3.0_f64.sqrt() * (cos * u + sin * v)
    };
    vec![[corner(0), corner(1), corner(2)]]
}

/// A disk as a regular polygon of the same area, a fan around its centre.
pub fn disk(centre: DVec3, radius: f64, normal: DVec3) -> Vec<Triangle> {
    let [u, v] = tangents(normal);
    let step = 2.0 * PI / DISK_SIDES as f64;
    let radius = radius * (step / step.sin()).sqrt();
    let rim = |k: usize| {
        let (sin, cos) = (step * (k % DISK_SIDES) as f64).sin_cos();
        centre + radius * (cos * u + sin * v)
    };
    (0..DISK_SIDES)
        .map(|k| [centre, rim(k), rim(k + 1)])
        .collect()
}

/// Two unit vectors u and v with u x v the unit normal.
fn tangents(normal: DVec3) -> [DVec3; 2] {
    let (u, v) = normal.normalize().any_orthonormal_pair();
    [u, v]
}

/// A sphere as an icosahedron whose faces are quartered `level` times, pushed out to a sphere of
/// such a radius that the area is right; seen from outside, or from inside if `inward`.
pub fn sphere(centre: DVec3, radius: f64, level: u32, inward: bool) -> Vec<Triangle> {
    let mut triangles = icosahedron();
    for _ in 0..level {
        triangles = triangles
            .into_iter()
            .flat_map(|[a, b, c]| {
                let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| (p + q).normalize());
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    let scale = radius * (4.0 * PI / area(&triangles)).sqrt();
    triangles
        .into_iter()
        .map(|[a, b, c]| if inward { [a, c, b] } else { [a, b, c] })
        .map(|corners| corners.map(|p| centre + scale * p))
        .collect()
}

/// Corners on the unit sphere, fronts outside.
fn icosahedron() -> Vec<Triangle> {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut corners = Vec::new();
    for s in [-1.0, 1.0] {
        for t in [-golden, golden] {
            corners.extend([
                DVec3::new(0.0, s, t),
                DVec3::new(s, t, 0.0),
                DVec3::new(t, 0.0, s),
            ]);
        }
    }
    // The edges of this one are 2 long; any other two corners are farther apart.
    let near = |p: DVec3, q: DVec3| p.distance(q) < 2.5;
    let mut triangles = Vec::new();
    for (i, &a) in corners.iter().enumerate() {
        for (j, &b) in corners.iter().enumerate().skip(i + 1) {
            for &c in &corners[j + 1..] {
                if near(a, b) && near(b, c) && near(c, a) {
                    let outward = (b - a).cross(c - a).dot(a) > 0.0;
                    let corners = if outward { [a, b, c] } else { [a, c, b] };
                    triangles.push(corners.map(DVec3::normalize));
                }
            }
        }
    }
    triangles
}

/// The six faces of a box: floor, ceiling, then the walls at low y, high y, low x, high x. Seen
/// from inside, or from outside if `solid`.
pub fn faces(low: DVec3, high: DVec3, solid: bool) -> [Vec<Triangle>; 6] {
    box_sides(low, high).map(|mut face| {
        if solid {
            face.reverse();
        }
        polygon(&face)
    })
}

/// Total area, m^2.
pub fn area(triangles: &[Triangle]) -> f64 {
    triangles
        .iter()
        .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
        .sum()
}

/// A scene being put together, object by object.
#[derive(Clone, Debug, Default)]
pub struct SceneBuilder {
    materials: Vec<Material>,
    objects: Vec<String>,
    surfaces: Vec<Surface>,
    /// Largest patch area, m^2, one per surface.
    max_areas: Vec<f64>,
    origin: DVec3,
}

/// A model whose patches are its triangles.
impl From<ImportedModel> for SceneBuilder {
    fn from(model: ImportedModel) -> Self {
        Self {
            max_areas: vec![f64::INFINITY; model.surfaces.len()],
            materials: model.materials,
            objects: model.objects,
            surfaces: model.surfaces,
            origin: model.origin,
        }
    }
}

impl SceneBuilder {
    /// Adds an object that neither reflects nor emits, cut into at least `patches` patches.
    #[must_use]
    pub fn dark(self, name: &str, patches: u32, triangles: &[Triangle]) -> Self {
        self.object(name, 0.0, 0.0, patches, triangles)
    }

    /// Adds an object that reflects and emits the same in all channels, cut into at least `patches`
    /// patches.
    #[must_use]
    pub fn object(
        self,
        name: &str,
        reflectance: f32,
        emission: f32,
        patches: u32,
        triangles: &[Triangle],
    ) -> Self {
        let material = Material {
            name: name.into(),
            reflectance: Rgb::splat(reflectance),
            emission: Rgb::splat(emission),
        };
        self.with_material(material, patches, triangles)
    }

    /// Adds an object of its own material, whose name is the object's.
    #[must_use]
    pub fn with_material(
        mut self,
        material: Material,
        patches: u32,
        triangles: &[Triangle],
    ) -> Self {
        let index = self.objects.len() as u32;
        self.objects.push(material.name.clone());
        self.materials.push(material);
        // A hair more, so that rounding does not cut twice.
        let max_area = area(triangles) / f64::from(patches) * (1.0 + 1e-5);
        for corners in triangles {
            self.surfaces.push(Surface {
                corners: corners.map(DVec3::as_vec3),
                material: MaterialId(index),
                object: ObjectId(index),
            });
            self.max_areas.push(max_area);
        }
        self
    }

    /// The scene.
    pub fn build(&self) -> Result<Scene, SceneError> {
        let depths: Vec<u32> = self
            .surfaces
            .iter()
            .zip(&self.max_areas)
            .map(|(surface, &most)| {
                scene::bisection::bisections_for(surface.area(), most).unwrap_or(0)
            })
            .collect();
        Scene::new(
            self.materials.clone(),
            self.objects.clone(),
            self.surfaces.clone(),
            &depths,
            self.origin,
        )
    }
}
