//! Scenes that the tests share.
#![allow(dead_code)] // each test binary uses its part

use glam::{DVec3, Vec3};
use scene::planar::box_sides;
use scene::{Material, MaterialId, ObjectId, PatchId, Rgb, Scene, Solution, Surface};

/// A scene on its way.
#[derive(Default)]
pub struct Builder {
    pub materials: Vec<Material>,
    pub surfaces: Vec<Surface>,
    /// Bisections, one per surface.
    pub depths: Vec<u32>,
}

impl Builder {
    pub fn material(&mut self, reflectance: f32, emission: f32) -> MaterialId {
        self.materials.push(Material {
            name: format!("material {}", self.materials.len()),
            reflectance: Rgb::splat(reflectance),
            emission: Rgb::splat(emission),
        });
        MaterialId(self.materials.len() as u32 - 1)
    }

    /// A quad with counter-clockwise corners, as two surfaces.
    pub fn quad(&mut self, [a, b, c, d]: [[f32; 3]; 4], material: MaterialId, depth: u32) {
        for corners in [[a, b, c], [c, d, a]] {
            self.surfaces.push(Surface {
                corners: corners.map(Vec3::from_array),
                material,
                object: ObjectId(0),
            });
            self.depths.push(depth);
        }
    }

    /// A box between two corners, its fronts inside, without the sides listed: -x, +x, -y, +y, -z,
    /// +z.
    pub fn room(
        &mut self,
        low: Vec3,
        high: Vec3,
        without: &[usize],
        material: MaterialId,
        depth: u32,
    ) {
        for side in (0..6).filter(|side| !without.contains(side)) {
            self.quad(box_side(low, high, side), material, depth);
        }
    }

    /// A box between two corners, its fronts outside.
    pub fn block(&mut self, low: Vec3, high: Vec3, material: MaterialId, depth: u32) {
        for side in 0..6 {
            let mut corners = box_side(low, high, side);
            corners.reverse();
            self.quad(corners, material, depth);
        }
    }

    pub fn scene(self) -> Scene {
        self.scene_at(DVec3::ZERO)
    }

    pub fn scene_at(self, origin: DVec3) -> Scene {
        Scene::new(
            self.materials,
            vec!["all".into()],
            self.surfaces,
            &self.depths,
            origin,
        )
        .unwrap()
    }
}

/// Corners of a box's side, counter-clockwise from inside: -x, +x, -y, +y, -z, +z.
fn box_side(low: Vec3, high: Vec3, side: usize) -> [[f32; 3]; 4] {
    let sides = box_sides(low.as_dvec3(), high.as_dvec3());
    sides[[4, 5, 2, 3, 0, 1][side]].map(|corner| corner.as_vec3().to_array())
}

/// A closed cube with edges of 2 m about the origin, fronts inside.
pub fn closed_cube(depth: u32) -> Scene {
    let mut builder = Builder::default();
    let material = builder.material(0.5, 0.0);
    builder.room(Vec3::NEG_ONE, Vec3::ONE, &[], material, depth);
    builder.scene()
}

/// A solution with these irradiances, W/m^2, by patch.
pub fn solution(scene: &Scene, irradiance: impl Fn(PatchId) -> Rgb) -> Solution {
    let irradiance = (0..scene.patch_count())
        .map(|p| irradiance(PatchId(p)))
        .collect();
    Solution {
        irradiance,
        ..Solution::dark(scene)
    }
}

/// A room of 4 x 3 x 5 m, open towards +z, with a block and a ceiling lamp, and irradiances as of a
/// point source at the lamp, of 100 W in all directions, with 0.2 W/m^2 around.
pub fn lit_room() -> (Scene, Solution) {
    let mut builder = Builder::default();
    let wall = builder.material(0.7, 0.0);
    let block = builder.material(0.4, 0.0);
    let lamp = builder.material(0.0, 200.0);
    builder.room(
        Vec3::new(-2.0, 0.0, -5.0),
        Vec3::new(2.0, 3.0, 0.0),
        &[5],
        wall,
        8,
    );
    builder.block(
        Vec3::new(-1.2, 0.0, -3.5),
        Vec3::new(-0.2, 1.2, -2.5),
        block,
        5,
    );
    let ceiling = 2.99;
    let (left, right, back, front) = (-0.4, 0.4, -2.8, -2.0);
    let lamp_corners = [[left, back], [right, back], [right, front], [left, front]];
    builder.quad(lamp_corners.map(|[x, z]| [x, ceiling, z]), lamp, 0);
    let scene = builder.scene();
    let source = DVec3::new(0.0, ceiling.into(), -2.4);
    let solution = solution(&scene, |patch| {
        let patch = scene.patch(patch);
        let to_source = source - patch.centroid();
        let cosine = scene
            .surface(patch.surface)
            .normal()
            .dot(to_source.normalize_or_zero());
        let direct = 100.0 / (4.0 * std::f64::consts::PI) * cosine.max(0.0)
            / to_source.length_squared().max(0.05);
        Rgb::new(1.0, 0.9, 0.7) * (0.2 + direct) as f32
    });
    (scene, solution)
}
