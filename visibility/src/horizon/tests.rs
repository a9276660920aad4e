//! What is behind a horizon is left out, and nothing else.

use genx::{Model, Settings};
use glam::{DVec3, EulerRot, Quat, Vec3};
use scene::{Material, MaterialId, ObjectId, PatchId, Rgb, Scene, Surface, SurfaceId};

use crate::Frame;
use crate::eye::{Eye, Standpoint};
use crate::geometry::Geometry;
use crate::spans::Projection;

/// A house on a wide ground, turned and moved so that no plane's coordinates are round. Its roof is a millimetre lower
/// in the middle; the last two surfaces are its foot, which lies on the ground.
fn house() -> Scene {
    let turn = Quat::from_euler(EulerRot::XYZ, 0.3, 0.7, 1.1);
    let p = |x: f32, y: f32, z: f32| turn * Vec3::new(x, y, z) + Vec3::new(7.0, -3.0, 5.0);
    let square = |low: f32, high: f32, z: f32| {
        [[low, low], [high, low], [high, high], [low, high]].map(|[x, y]| p(x, y, z))
    };
    let (foot, eaves, middle) = (
        square(1.0, 3.0, 0.0),
        square(1.0, 3.0, 2.0),
        p(2.0, 2.0, 1.999),
    );
    let mut triangles = Vec::new();
    let mut quad = |[a, b, c, d]: [Vec3; 4]| triangles.extend([[a, b, c], [a, c, d]]);
    quad(square(-2.0, 6.0, 0.0));
    let sides = [(0, 1), (1, 2), (2, 3), (3, 0)];
    for (from, to) in sides {
        quad([foot[from], foot[to], eaves[to], eaves[from]]);
    }
    triangles.extend(sides.map(|(from, to)| [eaves[from], eaves[to], middle]));
    let [a, b, c, d] = foot;
    triangles.extend([[a, c, b], [a, d, c]]);
    let surface = |corners| Surface {
        corners,
        material: MaterialId(0),
        object: ObjectId(0),
    };
    let stone = Material {
        name: "stone".into(),
        reflectance: Rgb::splat(0.5),
        emission: Rgb::splat(1.0),
    };
    let surfaces = triangles.into_iter().map(surface).collect();
    let (materials, objects) = (vec![stone], vec!["house".into()]);
    Scene::with_max_area(materials, objects, surfaces, 0.2, DVec3::ZERO).unwrap()
}

fn hall() -> Scene {
    let settings = Settings {
        max_area: Some(100.0),
        ..Settings::new(Model::Hall)
    };
    genx::make(&settings).unwrap().scene
}

/// Two for each patch, one of them near its border.
fn frames(scene: &Scene) -> impl Iterator<Item = (SurfaceId, Frame)> {
    let points = [[1.0 / 3.0; 3], [0.98, 0.01, 0.01]];
    let patches = (0..scene.patch_count()).map(PatchId);
    patches.flat_map(move |id| {
        let patch = scene.patch(id);
        let normal = scene.surface(patch.surface).normal();
        points.map(|weights| {
            let weighted = patch.corners.iter().zip(weights);
            let point = weighted
                .map(|(corner, weight)| weight * corner.as_dvec3())
                .sum();
            let turn = 0.7 * f64::from(id.0);
            let frame = Frame::on_patch(&patch, normal, point, turn);
            (patch.surface, frame)
        })
    })
}

#[test]
fn what_is_seen_does_not_change() {
    for scene in [house(), hall()] {
        let geometry = Geometry::new(&scene);
        let count = geometry.facts.len() as u32;
        let mut projection = Projection::new(&geometry);
        let mut of_all = Projection::new(&geometry);
        let mut left_out = 0;
        for (own, frame) in frames(&scene) {
            let at = Standpoint::new(&geometry, &Eye::with_horizon(&frame, own));
            projection.set(&at);
            left_out += count - projection.horizon.regions().len() as u32;
            of_all.set_some(&at, 0..count);
            assert_eq!(projection.pieces, of_all.pieces, "{own:?} {frame:?}");
            assert_eq!(projection.corners, of_all.corners);
        }
        assert!(left_out > 0);
    }
}

/// The foot of the house is at the ground's horizon, and behind all others.
#[test]
fn surfaces_behind_every_horizon_cost_nothing() {
    let scene = house();
    let geometry = Geometry::new(&scene);
    let mut projection = Projection::new(&geometry);
    let mut hemicubes_that_try = vec![0; geometry.facts.len()];
    for (own, frame) in frames(&scene) {
        let at = Standpoint::new(&geometry, &Eye::with_horizon(&frame, own));
        projection.set(&at);
        let own = geometry.regions.region_of(own);
        for &region in projection.horizon.regions().iter().filter(|r| **r != own) {
            hemicubes_that_try[region as usize] += 1;
        }
    }
    let foot = geometry
        .regions
        .region_of(SurfaceId(scene.surfaces().len() as u32 - 1));
    for (region, &tries) in (0..).zip(&hemicubes_that_try) {
        assert_eq!(tries == 0, region == foot, "region {region}: {tries}");
    }
}
