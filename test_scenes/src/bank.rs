//! The bank of scenes that every strategy and every back end is held against the reference on.

use glam::{DQuat, DVec3, EulerRot, Vec3};
use scene::{Material, Scene, Surface};

use crate::dense::{furnished_sphere, stone};
use crate::objects::grid;
use crate::rooms::{
    block, colourful_room, furnished_room, furnished_room_surfaces, material, scene, shaken,
};

/// Scenes with their names. Nothing in them overlaps, so that what a ray sees is not a matter of rounding.
pub fn bank() -> Vec<(&'static str, Scene)> {
    vec![
        ("a closed room with blocks in the air", furnished_room(0.3)),
        ("the same, turned and shaken", shaken_room()),
        ("coloured walls in fine patches", colourful_room(0.01)),
        ("walls of many rectangles", room_of_rectangles()),
        ("a ruin of open and turned walls", ruin()),
        ("a small room far from a box", far_from_a_box()),
        (
            "small triangles, each a patch",
            stone(&furnished_sphere(), f64::INFINITY),
        ),
        (
            "small triangles in fine patches",
            stone(&furnished_sphere(), 0.002),
        ),
    ]
}

/// The first scene of the bank, and the same with a corner that is a hundredth of a metre off: what is held against the
/// reference must tell them apart.
pub fn moved_corner() -> (Scene, Scene) {
    let (_, scene) = bank().swap_remove(0);
    let mut surfaces = scene.surfaces().to_vec();
    let last = surfaces.len() - 1;
    surfaces[last].corners[0].z += 0.01;
    let moved = crate::rooms::scene(scene.materials().to_vec(), surfaces, 0.3);
    (scene, moved)
}

fn stones() -> Vec<Material> {
    vec![material(0.5, 0.0), material(0.3, 2.0)]
}

fn turned(surfaces: Vec<Surface>) -> Vec<Surface> {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.4, 1.1, -0.7);
    let place = |p: Vec3| (turn * p.as_dvec3() + DVec3::new(0.3, -2.0, 1.0)).as_vec3();
    let surfaces = surfaces.into_iter();
    surfaces
        .map(|surface| Surface {
            corners: surface.corners.map(place),
            ..surface
        })
        .collect()
}

fn shaken_room() -> Scene {
    scene(stones(), turned(shaken(furnished_room_surfaces())), 0.3)
}

/// A box whose walls are 7 x 7 rectangles of two surfaces each.
fn room_of_rectangles() -> Scene {
    let walls = block(Vec3::ZERO, Vec3::new(3.0, 4.0, 2.5), false, 0);
    let walls = walls.chunks_exact(2).flat_map(|wall| {
        let [a, b, c] = wall[0].corners;
        grid(a, b - a, c - b, 7)
    });
    scene(stones(), turned(walls.collect()), 0.05)
}

/// Every fifth wall's triangle is gone, and every seventh shows its back.
fn ruin() -> Scene {
    let mut surfaces = turned(furnished_room_surfaces());
    for surface in surfaces.iter_mut().step_by(7) {
        surface.corners.swap(1, 2);
    }
    let kept = surfaces.into_iter().enumerate().filter(|(k, _)| k % 5 != 3);
    scene(stones(), kept.map(|(_, surface)| surface).collect(), 0.1)
}

/// What is near is seen as well as if nothing were far away.
fn far_from_a_box() -> Scene {
    let mut surfaces = furnished_room_surfaces();
    surfaces.extend(block(Vec3::splat(2e4), Vec3::splat(2.1e4), true, 1));
    scene(stones(), surfaces, f64::INFINITY)
}
