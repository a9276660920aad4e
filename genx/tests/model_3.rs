//! Model 3: a region that no direct light reaches.

mod common;

use common::{Random, START_OFFSET, cast, in_rectangle, size};
use genx::{Model, Settings, make};
use glam::{DVec2, DVec3, Vec3, Vec3Swizzles};
use scene::{Patch, PatchId, Scene, Surface};

fn bend() -> Scene {
    make(&Settings::new(Model::Bend)).unwrap().scene
}

fn patches(scene: &Scene) -> impl Iterator<Item = Patch> + '_ {
    (0..scene.patch_count()).map(|patch| scene.patch(PatchId(patch)))
}

fn lamps(scene: &Scene) -> Vec<&Surface> {
    scene
        .surfaces()
        .iter()
        .filter(|s| scene.material(s.material).is_emitter())
        .collect()
}

/// The side of the obstacle that looks along x: one rectangle, as its plane, and its corners in z, y.
fn far_side(scene: &Scene) -> (f64, DVec2, DVec2) {
    let triangles: Vec<&Surface> = scene
        .surfaces()
        .iter()
        .filter(|s| scene.object(s.object) == "obstacle" && s.normal().x > 0.9)
        .collect();
    let corners = || triangles.iter().flat_map(|s| s.corners);
    let x = corners().next().unwrap().x;
    assert!(corners().all(|p| p.x.to_bits() == x.to_bits()));
    let low = corners()
        .map(Vec3::zy)
        .reduce(glam::Vec2::min)
        .unwrap()
        .as_dvec2();
    let high = corners()
        .map(Vec3::zy)
        .reduce(glam::Vec2::max)
        .unwrap()
        .as_dvec2();
    let area: f64 = triangles.iter().map(|s| s.area()).sum();
    // The triangles fill the rectangle between their extremes. Products of f32 numbers are exact.
    assert!((area - (high - low).element_product()).abs() < 1e-12 * area);
    (f64::from(x), low, high)
}

/// Whether the whole lamp is hidden from a point, exactly: projected from the point onto the plane
/// of the obstacle's far side, the lamp's triangles are the convex hulls of their projected corners,
/// so if each corner falls into the rectangle, all of the lamp does. Points of the far side itself
/// have the lamp behind them.
fn is_shaded(scene: &Scene, point: DVec3) -> bool {
    let (x, low, high) = far_side(scene);
    point.x >= x
        && lamps(scene).iter().flat_map(|s| s.corners).all(|corner| {
            let corner = corner.as_dvec3();
            assert!(corner.x < x);
            let share = (point.x - x) / (point.x - corner.x);
            let crossing = point + share * (corner - point);
            in_rectangle(DVec2::new(crossing.z, crossing.y), low, high)
        })
}

#[test]
fn a_third_of_the_area_sees_no_lamp_at_all() {
    let scene = bend();
    let shaded: f64 = patches(&scene)
        .filter(|patch| {
            patch
                .corners
                .iter()
                .all(|p| is_shaded(&scene, p.as_dvec3()))
        })
        .map(|patch| patch.area)
        .sum();
    let share = shaded / scene.area();
    assert!((1.0 / 3.0..0.5).contains(&share), "{share}");
}

#[test]
fn no_ray_joins_the_lamp_and_the_region_without_direct_light() {
    let scene = bend();
    let lamps = lamps(&scene);
    let mut random = Random(3);
    let (mut shaded, mut lit) = (0, 0);
    for patch in patches(&scene).step_by(7) {
        let normal = scene.surface(patch.surface).normal();
        let from = patch.centroid() + START_OFFSET * size(&scene) * normal;
        let sees_lamp = (0..16).any(|ray| {
            let to = random.point_on(lamps[ray % lamps.len()]);
            cast(&scene, from, to - from).is_some_and(|hit| {
                let material = scene.surface(hit.surface).material;
                hit.is_front && scene.material(material).is_emitter()
            })
        });
        if is_shaded(&scene, from) {
            assert!(!sees_lamp, "from {from}");
            shaded += 1;
        } else if sees_lamp {
            lit += 1;
        }
    }
    assert!(shaded > 100 && lit > 100, "{shaded} shaded, {lit} lit");
}

#[test]
fn reflected_light_can_reach_the_region_without_direct_light() {
    let scene = bend();
    let lamps = lamps(&scene);
    let mut random = Random(4);
    // A wall patch that sees both the lamp and a shaded patch carries light round the bend.
    let shaded: Vec<Patch> = patches(&scene)
        .filter(|patch| is_shaded(&scene, patch.centroid()))
        .collect();
    let sees = |from: DVec3, to: DVec3| {
        cast(&scene, from, to - from).is_some_and(|hit| (hit.distance - 1.0).abs() < 1e-6)
    };
    let carries = patches(&scene).step_by(11).any(|patch| {
        let from =
            patch.centroid() + START_OFFSET * size(&scene) * scene.surface(patch.surface).normal();
        let lamp = random.point_on(lamps[0]);
        let target = shaded[(random.unit() * shaded.len() as f64) as usize].centroid();
        sees(from, lamp) && sees(from, target)
    });
    assert!(carries);
}
