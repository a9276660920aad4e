//! Collecting the surfaces of a model.
//!
//! Corners are f64 and become f32 one by one, so the same corner has the same bits in every surface
//! that ends there; nothing here computes a corner twice in two ways.

use glam::DVec3;
use scene::{Material, MaterialId, ObjectId, Rgb, Scene, SceneError, Surface};

use crate::changes::Parts;

/// What a surface is made of and what it is part of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Look {
    pub material: MaterialId,
    pub object: ObjectId,
}

/// A plane across one axis, with a front.
///
/// Its coordinates u and v run along the next two axes in the cyclic order x, y, z: for y they are
/// z and x. Seen from the positive side, u, v is counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// 0, 1, 2 for x, y, z.
    pub axis: usize,
    /// Where it cuts its axis, metres.
    pub at: f64,
    /// Whether the front looks along the axis or against it.
    pub positive: bool,
}

impl Plane {
    fn point(self, [u, v]: [f64; 2]) -> DVec3 {
        let mut point = [0.0; 3];
        point[self.axis] = self.at;
        point[(self.axis + 1) % 3] = u;
        point[(self.axis + 2) % 3] = v;
        point.into()
    }
}

/// A model on its way to a scene.
#[derive(Default)]
pub struct Builder {
    materials: Vec<Material>,
    objects: Vec<String>,
    surfaces: Vec<Surface>,
}

impl Builder {
    pub fn material(&mut self, name: &str, reflectance: Rgb, emission: Rgb) -> MaterialId {
        self.materials.push(Material {
            name: name.to_owned(),
            reflectance,
            emission,
        });
        MaterialId(self.materials.len() as u32 - 1)
    }

    pub fn object(&mut self, name: &str) -> ObjectId {
        self.objects.push(name.to_owned());
        ObjectId(self.objects.len() as u32 - 1)
    }

    /// A material and an object of the same name.
    pub fn look(&mut self, name: &str, reflectance: Rgb, emission: Rgb) -> Look {
        Look {
            material: self.material(name, reflectance, emission),
            object: self.object(name),
        }
    }

    /// All materials so far, to be changed.
    pub fn materials_mut(&mut self) -> &mut [Material] {
        &mut self.materials
    }

    /// A triangle, counter-clockwise from its front.
    pub fn triangle(&mut self, corners: [DVec3; 3], look: Look) {
        self.surfaces.push(Surface {
            corners: corners.map(DVec3::as_vec3),
            material: look.material,
            object: look.object,
        });
    }

    /// A quadrilateral, counter-clockwise from its front, cut from its first corner to its third.
    pub fn quad(&mut self, [a, b, c, d]: [DVec3; 4], look: Look) {
        self.triangle([a, b, c], look);
        self.triangle([c, d, a], look);
    }

    /// A triangle in a plane, counter-clockwise in u, v.
    fn triangle_in(&mut self, plane: Plane, corners: [[f64; 2]; 3], look: Look) {
        let [a, b, c] = corners.map(|corner| plane.point(corner));
        self.triangle(if plane.positive { [a, b, c] } else { [a, c, b] }, look);
    }

    /// A rectangle in a plane.
    pub fn rectangle(&mut self, plane: Plane, u: [f64; 2], v: [f64; 2], look: Look) {
        let [a, b, c, d] =
            [[u[0], v[0]], [u[1], v[0]], [u[1], v[1]], [u[0], v[1]]].map(|p| plane.point(p));
        self.quad(
            if plane.positive {
                [a, b, c, d]
            } else {
                [a, d, c, b]
            },
            look,
        );
    }

    /// A rectangle with a rectangular hole, whose sides have a corner in their middles.
    ///
    /// Each side takes three triangles: with a hole of width w and margins of m they keep the longest
    /// side under twice the shortest for m from 0.4 w to 1.9 w, which two triangles a side would not.
    pub fn frame(
        &mut self,
        plane: Plane,
        u: [f64; 3],
        v: [f64; 3],
        hole_u: [f64; 2],
        hole_v: [f64; 2],
        look: Look,
    ) {
        let outer = [
            [u[0], v[0]],
            [u[1], v[0]],
            [u[2], v[0]],
            [u[2], v[1]],
            [u[2], v[2]],
            [u[1], v[2]],
            [u[0], v[2]],
            [u[0], v[1]],
        ];
        let inner = [
            [hole_u[0], hole_v[0]],
            [hole_u[1], hole_v[0]],
            [hole_u[1], hole_v[1]],
            [hole_u[0], hole_v[1]],
        ];
        for side in 0..4 {
            let [start, middle, end] = [0, 1, 2].map(|k| outer[(2 * side + k) % 8]);
            let [near, far] = [inner[side], inner[(side + 1) % 4]];
            self.triangle_in(plane, [start, middle, near], look);
            self.triangle_in(plane, [middle, far, near], look);
            self.triangle_in(plane, [middle, end, far], look);
        }
    }

    /// The four sides of an upright column, seen from outside, in one storey between each two heights.
    pub fn column(&mut self, x: [f64; 2], z: [f64; 2], heights: &[f64], look: Look) {
        for y in heights.windows(2) {
            let y = [y[0], y[1]];
            for (side, positive) in [(0, false), (1, true)] {
                let across = |axis, at| Plane { axis, at, positive };
                self.rectangle(across(0, x[side]), y, z, look);
                self.rectangle(across(2, z[side]), x, y, look);
            }
        }
    }

    /// What may still change.
    pub fn parts(&mut self) -> Parts<'_> {
        Parts {
            materials: &mut self.materials,
            objects: &self.objects,
            surfaces: &mut self.surfaces,
            faces: None,
        }
    }

    /// The scene, meshed.
    pub fn finish(self, max_area: f64) -> Result<Scene, SceneError> {
        Scene::with_max_area(
            self.materials,
            self.objects,
            self.surfaces,
            max_area,
            DVec3::ZERO,
        )
    }
}
