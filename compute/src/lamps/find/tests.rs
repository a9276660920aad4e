//! What lamps are found.

use glam::{EulerRot, Quat};
use scene::{Material, MaterialId, ObjectId, Rgb, Surface};

use super::*;

/// Three squares that shine into the corner that they meet in, each of two triangles that share corners with the next
/// square.
fn corner_squares() -> [[[Vec3; 3]; 2]; 3] {
    let [x, y, z] = [Vec3::X, Vec3::Y, Vec3::Z];
    [(x, y), (y, z), (z, x)].map(|(a, b)| [[Vec3::ZERO, a, b], [a, a + b, b]])
}

fn scene(corners: impl Iterator<Item = [Vec3; 3]>) -> Scene {
    let shining = Material {
        name: "shining".into(),
        reflectance: Rgb::splat(0.5),
        emission: Rgb::splat(1.0),
    };
    let surface = |corners| Surface {
        corners,
        material: MaterialId(0),
        object: ObjectId(0),
    };
    let surfaces = corners.map(surface).collect();
    Scene::with_max_area(
        vec![shining],
        vec!["squares".into()],
        surfaces,
        9.0,
        DVec3::ZERO,
    )
    .unwrap()
}

#[test]
fn lamps_do_not_depend_on_the_order_of_surfaces() {
    let squares = corner_squares();
    let by_square = squares.iter().flatten().copied();
    let by_half = [0, 1]
        .into_iter()
        .flat_map(|half| squares.map(|square| square[half]));
    for scene in [scene(by_square), scene(by_half)] {
        let lamps = lamps(&Drawable::new(&scene));
        assert_eq!(lamps.len(), 3, "{lamps:?}");
        for lamp in &lamps {
            let [a, b] = lamp.surfaces[..] else {
                panic!("{lamp:?} is no square");
            };
            assert_eq!(scene.surface(a).normal(), scene.surface(b).normal());
        }
    }
}

/// The normal of the sliver alone is far off, since its corners are rounded.
#[test]
fn a_sliver_is_part_of_its_lamp_in_any_order() {
    for k in 0..20 {
        let angle = |step: f32| step * k as f32;
        let turn = Quat::from_euler(EulerRot::XYZ, angle(0.7), angle(1.9), angle(0.3));
        let at = |x: f32, y: f32| turn * Vec3::new(x, y, 0.0) + Vec3::new(3.0, 5.0, 8.0);
        let wide = [at(0.0, 0.0), at(1.0, 0.0), at(0.0, 1.0)];
        let sliver = [at(0.0, 0.0), at(0.4, -1e-3), at(1.0, 0.0)];
        for corners in [[wide, sliver], [sliver, wide]] {
            let scene = scene(corners.into_iter());
            let lamps = lamps(&Drawable::new(&scene));
            assert_eq!(lamps.len(), 1, "{k}: {lamps:?}");
            assert_eq!(lamps[0].surfaces.len(), 2, "{k}: {lamps:?}");
        }
    }
}
