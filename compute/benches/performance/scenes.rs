//! Scenes to measure with.

use std::path::Path;

use genx::{Format, Model, Settings};
use glam::{DVec3, Quat, Vec3};
use scene::{Material, MaterialId, ObjectId, Rgb, Scene, Surface};

/// A built-in model with patches of at most this area, m^2.
pub fn model(model: Model, max_area: f64) -> anyhow::Result<Scene> {
    let settings = Settings {
        max_area: Some(max_area),
        ..Settings::new(model)
    };
    Ok(genx::make(&settings)?.scene)
}

/// A file's triangles, each one patch.
pub fn obj(path: &Path) -> anyhow::Result<Scene> {
    let format = Format::Obj;
    let path = path.to_owned();
    model(Model::File { format, path }, f64::INFINITY)
}

/// Width of the box of [`tetrahedra`], metres.
const WIDTH: f32 = 10.0;

/// Area of all its tetrahedra together, m^2: half of the walls'. A straight line in it goes 13 m, the
/// volume over a quarter of the area, until it meets one: most of the box is in sight from anywhere.
const AREA: f32 = 300.0;

/// Corners of a regular tetrahedron with faces of area 2 root(3), and its faces, seen from outside.
const CORNERS: [Vec3; 4] = [
    Vec3::new(1.0, 1.0, 1.0),
    Vec3::new(1.0, -1.0, -1.0),
    Vec3::new(-1.0, 1.0, -1.0),
    Vec3::new(-1.0, -1.0, 1.0),
];
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]];

/// A closed box of about this many triangles, each one patch: its walls, and tetrahedra that float in it,
/// turned at random. Whatever their number their area is the same, so that a view into the box is
/// covered alike by more and smaller triangles.
pub fn tetrahedra(triangles: u32) -> anyhow::Result<Scene> {
    let count = (triangles.saturating_sub(12) / 4).max(1);
    let scale = (AREA / (count as f32 * 8.0 * 3_f32.sqrt())).sqrt();
    let mut random = Random(1);
    let mut surfaces = walls();
    for _ in 0..count {
        let turn = random.rotation();
        // All inside: a corner is root(3) scale from the middle.
        let room = WIDTH - 4.0 * scale;
        let middle = Vec3::splat(2.0 * scale) + room * random.point();
        let corners = CORNERS.map(|corner| middle + scale * (turn * corner));
        surfaces.extend(FACES.map(|face| surface(face.map(|k| corners[k]))));
    }
    one_patch_each(surfaces)
}

/// A sphere of radius about 1 m with bumps, turned inwards, of about this many triangles: a
/// cube whose faces are squares of two triangles each, blown up.
pub fn bumpy_sphere(triangles: u32) -> anyhow::Result<Scene> {
    let cells = (triangles as f32 / 12.0).sqrt().round().max(1.0) as u32;
    let triangles = test_scenes::bumpy_sphere(cells).into_iter();
    one_patch_each(triangles.map(surface).collect())
}

/// A scene whose triangles are its patches.
fn one_patch_each(surfaces: Vec<Surface>) -> anyhow::Result<Scene> {
    let grey = Material {
        name: "grey".to_owned(),
        reflectance: Rgb::splat(0.5),
        emission: Rgb::ZERO,
    };
    Ok(Scene::with_max_area(
        vec![grey],
        vec!["all".to_owned()],
        surfaces,
        f64::INFINITY,
        DVec3::ZERO,
    )?)
}

fn surface(corners: [Vec3; 3]) -> Surface {
    Surface {
        corners,
        material: MaterialId(0),
        object: ObjectId(0),
    }
}

/// The box, seen from inside: two triangles a wall.
fn walls() -> Vec<Surface> {
    let axes = [Vec3::X, Vec3::Y, Vec3::Z].map(|axis| WIDTH * axis);
    let mut surfaces = Vec::new();
    for k in 0..3 {
        let [u, v, w] = [axes[k], axes[(k + 1) % 3], axes[(k + 2) % 3]];
        // u x v looks along w: inwards at the origin, outwards on the other side.
        for [o, u, v] in [[Vec3::ZERO, u, v], [w, v, u]] {
            surfaces.push(surface([o, o + u, o + u + v]));
            surfaces.push(surface([o, o + u + v, o + v]));
        }
    }
    surfaces
}

/// Numbers that are the same in every run: `SplitMix64` (Steele, Lea and Flood, "Fast splittable
/// pseudorandom number generators", OOPSLA 2014).
struct Random(u64);

impl Random {
    /// In [0, 1).
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.unit(), self.unit(), self.unit())
    }

    /// Not quite uniform, which matters to nobody here.
    fn rotation(&mut self) -> Quat {
        let axis = (self.point() - 0.5).try_normalize().unwrap_or(Vec3::X);
        Quat::from_axis_angle(axis, std::f32::consts::TAU * self.unit())
    }
}
