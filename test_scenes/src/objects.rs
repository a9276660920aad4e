//! Scenes of named objects.

use glam::{DVec3, Vec3};
use scene::{MaterialId, ObjectId, Scene, Surface};

use crate::rooms::{block, material, quad};

/// A scene of named objects whose materials reflect half and emit 1 W/m^2.
pub fn named(objects: &[(&str, Vec<Surface>)], max_area: f64) -> Scene {
    let names = objects.iter().map(|(name, _)| (*name).to_owned()).collect();
    let mut surfaces = Vec::new();
    for (object, (_, of_object)) in objects.iter().enumerate() {
        surfaces.extend(of_object.iter().map(|&surface| Surface {
            object: ObjectId(object as u32),
            material: MaterialId(0),
            ..surface
        }));
    }
    let materials = vec![material(0.5, 1.0)];
    Scene::with_max_area(materials, names, surfaces, max_area, DVec3::ZERO).unwrap()
}

/// The names of [`walls`].
pub const WALLS: [&str; 6] = ["floor", "ceiling", "south", "north", "west", "east"];

/// A box's walls, one object each, seen from inside.
pub fn walls(size: Vec3) -> Vec<(&'static str, Vec<Surface>)> {
    let surfaces = block(Vec3::ZERO, size, false, 0);
    let pairs = surfaces.chunks(2).map(<[Surface]>::to_vec);
    WALLS.into_iter().zip(pairs).collect()
}

/// A wall of n x n quadrilaterals from one corner along two edges, seen from along x across.
pub fn grid(corner: Vec3, along: Vec3, across: Vec3, n: usize) -> Vec<Surface> {
    let at =
        |i: usize, j: usize| corner + i as f32 / n as f32 * along + j as f32 / n as f32 * across;
    (0..n * n)
        .flat_map(|k| {
            let (i, j) = (k % n, k / n);
            quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)], 0)
        })
        .collect()
}
