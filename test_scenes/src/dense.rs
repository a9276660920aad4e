//! Scenes of many small triangles.

use glam::{DVec3, Quat, Vec3};
use scene::{Material, MaterialId, ObjectId, Rgb, Scene, Surface};

/// Corners, metres.
pub type Triangle = [Vec3; 3];

/// A scene of stone; the last two triangles shine.
pub fn stone(surfaces: &[Triangle], max_area: f64) -> Scene {
    let material = |emission: f32| Material {
        name: "stone".into(),
        reflectance: Rgb::splat(0.5),
        emission: Rgb::splat(emission),
    };
    let surface = |(k, &corners): (usize, &Triangle)| Surface {
        corners,
        material: MaterialId(u32::from(k + 2 >= surfaces.len())),
        object: ObjectId(0),
    };
    let surfaces = surfaces.iter().enumerate().map(surface).collect();
    let materials = vec![material(0.0), material(9.0)];
    let objects = vec!["all".into()];
    Scene::with_max_area(materials, objects, surfaces, max_area, DVec3::ZERO).unwrap()
}

/// A sphere of radius about 1 m with bumps, turned inwards: a cube whose faces have `cells` x `cells`
/// squares of two triangles, blown up.
pub fn bumpy_sphere(cells: u32) -> Vec<Triangle> {
    let at = |face: u32, i: u32, j: u32| -> Vec3 {
        let across = |k: u32| 2.0 * k as f32 / cells as f32 - 1.0;
        let (x, y) = (across(i), across(j));
        let on_cube = match face {
            0 => Vec3::new(x, y, 1.0),
            1 => Vec3::new(y, x, -1.0),
            2 => Vec3::new(1.0, x, y),
            3 => Vec3::new(-1.0, y, x),
            4 => Vec3::new(y, 1.0, x),
            _ => Vec3::new(x, -1.0, y),
        };
        let out = on_cube.normalize();
        let bumps = (9.0 * out.x).sin() * (8.0 * out.y).cos() * (7.0 * out.z).sin();
        (1.0 + 0.05 * bumps) * out
    };
    let mut surfaces = Vec::new();
    for k in 0..6 * cells * cells {
        let (face, i, j) = (k / (cells * cells), k / cells % cells, k % cells);
        let [a, b] = [at(face, i, j), at(face, i + 1, j)];
        let [c, d] = [at(face, i, j + 1), at(face, i + 1, j + 1)];
        surfaces.extend([[a, c, b], [b, c, d]]);
    }
    surfaces
}

/// A ball in the sphere, seen from outside, and a square that floats in it, of which both sides are seen.
pub fn furnished_sphere() -> Vec<Triangle> {
    let mut surfaces = bumpy_sphere(20);
    let place = |p: Vec3| 0.3 * p + Vec3::new(0.2, 0.1, 0.3);
    surfaces.extend(
        bumpy_sphere(12)
            .into_iter()
            .map(|[a, b, c]| [a, c, b].map(place)),
    );
    let turn = Quat::from_rotation_x(0.4) * Quat::from_rotation_y(0.3);
    let corner = |x: f32, y: f32| turn * Vec3::new(0.6 * x, 0.6 * y, 0.0) - 0.4;
    let [a, b, c, d] = [
        corner(0.0, 0.0),
        corner(1.0, 0.0),
        corner(1.0, 1.0),
        corner(0.0, 1.0),
    ];
    surfaces.extend([[a, b, c], [a, c, d]]);
    surfaces
}
