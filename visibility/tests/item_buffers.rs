//! What pixels see of walls that are made of many surfaces, asked one by one.

use std::sync::Arc;

use genx::{Model, Settings};
use glam::{DVec3, EulerRot, Quat, Vec3};
use scene::{PatchId, Scene, Surface};
use test_scenes::grid;
use visibility::hemicube::{FACES, pixel_count};
use visibility::item_buffer::{BACK_FACE, HemicubeDrawer, NOTHING};
use visibility::{Canvas, Drawable, Eye, Frame, Viewer, Window};

/// How far from a patch, in pixels, a ray may meet its wall that is said to see it: walks may stay on a surface
/// for 1/1024 of a pixel too long, and what is linear over a window of 400 pixels is right to some 1e-4.
const BESIDE: f64 = 1.5 / 1024.0;

/// Coordinates on walls are f32, relative to the wall: this share of the scene's size.
const ROUNDING: f64 = 8.0 / (1 << 24) as f64;

/// A box whose walls are n x n rectangles of two surfaces each.
fn walls_of_rectangles(n: usize) -> Vec<Surface> {
    let walls = test_scenes::block(Vec3::ZERO, Vec3::new(3.0, 4.0, 2.5), false, 0);
    walls
        .chunks_exact(2)
        .flat_map(|wall| {
            let [a, b, c] = wall[0].corners;
            grid(a, b - a, c - b, n)
        })
        .collect()
}

fn made(model: Model, max_area: f64) -> Scene {
    let settings = Settings {
        max_area: Some(max_area),
        ..Settings::new(model)
    };
    genx::make(&settings).unwrap().scene
}

fn scenes() -> Vec<Scene> {
    let rectangles = |area| {
        let surfaces = walls_of_rectangles(12);
        test_scenes::scene(vec![test_scenes::material(0.5, 1.0)], surfaces, area)
    };
    vec![
        rectangles(f64::INFINITY),
        rectangles(0.01),
        made(Model::Hall, 5.0),
        made(Model::Cornell, 4e-4),
    ]
}

/// Distance of a point from a triangle, metres.
fn distance(p: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize();
    let sides = [(a, b), (b, c), (c, a)];
    let is_over = |&(from, to): &(DVec3, DVec3)| normal.cross(to - from).dot(p - from) >= 0.0;
    if sides.iter().all(is_over) {
        return normal.dot(p - a).abs();
    }
    sides
        .iter()
        .map(|&(from, to)| {
            let along = (p - from).dot(to - from) / from.distance_squared(to);
            p.distance(from.lerp(to, along.clamp(0.0, 1.0)))
        })
        .fold(f64::INFINITY, f64::min)
}

/// Where the ray through a place in a window, in pixels, meets the plane of a patch.
fn hit(scene: &Scene, frame: &Frame, window: &Window, patch: PatchId, [i, j]: [f64; 2]) -> DVec3 {
    let local = window.forward
        + (window.left + i * window.pixel) * window.right
        + (window.bottom + j * window.pixel) * window.up;
    let direction = frame.to_scene(local);
    let geometry = scene.patch(patch);
    let normal = scene.surface(geometry.surface).normal();
    let point = geometry.corners[0].as_dvec3();
    frame.position + direction * ((point - frame.position).dot(normal) / direction.dot(normal))
}

/// Where surfaces are wide, as in the larger pictures, rows of pixels are walked from surface to surface, else pixels
/// are looked up together; still each pixel's ray meets the patch it is said to see.
#[test]
fn pixels_see_the_patches_that_their_rays_meet() {
    for scene in scenes() {
        let drawable = Arc::new(Drawable::new(&scene));
        assert!(drawable.regions().regions().len() * 3 < scene.surfaces().len());
        let [low, high] = scene.bounds();
        let rounding = ROUNDING * f64::from((high - low).max_element());
        let mut viewer = Viewer::new(&drawable);
        let mut canvas = Canvas::default();
        let mut seen = 0_u32;
        for k in 0..24 {
            let patch = PatchId((u64::from(scene.patch_count()) * k / 24) as u32);
            let geometry = scene.patch(patch);
            let own = geometry.surface;
            // Some look along the walls' sides, or nearly so.
            let turn = match k % 8 {
                0 => 1e-4 + std::f64::consts::FRAC_PI_4 * (k / 8) as f64,
                _ => 0.7 * k as f64,
            };
            let normal = scene.surface(own).normal();
            let frame = Frame::on_patch(&geometry, normal, geometry.centroid(), turn);
            let resolution = if k % 8 == 0 { 400 } else { 100 };
            let hemicube = viewer.hemicube(resolution, &frame, own);
            for (face, window) in hemicube.windows().iter().enumerate() {
                let mut picture = canvas.draw_face(&hemicube, face);
                picture.for_each_row(u32::MAX, u32::MAX, |j, ids| {
                    for (i, &id) in ids.iter().enumerate().filter(|(_, id)| **id != u32::MAX) {
                        let at = |di: f64, dj: f64| {
                            let place = [i as f64 + 0.5 + di, j as f64 + 0.5 + dj];
                            hit(&scene, &frame, window, PatchId(id), place)
                        };
                        let point = at(0.0, 0.0);
                        let corners = scene.patch(PatchId(id)).corners.map(Vec3::as_dvec3);
                        let beside = distance(point, corners);
                        // Towards the horizon of a wall a step is longer on one side than on the other.
                        let reach = [at(BESIDE, 0.0), at(-BESIDE, 0.0), at(0.0, BESIDE)]
                            .map(|p| p.distance(point));
                        let allowed = rounding + reach.iter().sum::<f64>();
                        assert!(
                            beside <= allowed,
                            "{patch:?}, face {face}, pixel {i} {j}: {id} is {beside:e} > {allowed:e} away"
                        );
                        seen += 1;
                    }
                });
            }
        }
        assert!(seen > 21 * 20_000 + 3 * 320_000, "{seen}");
    }
}

/// Faces leave out what has a bit of theirs; without, all is drawn, and the picture is the same.
#[test]
fn a_face_is_what_its_window_sees_of_everything() {
    for scene in scenes() {
        let drawable = Arc::new(Drawable::new(&scene));
        let mut of_hemicube = Viewer::new(&drawable);
        let mut of_all = Viewer::new(&drawable);
        let (mut face_canvas, mut canvas) = (Canvas::default(), Canvas::default());
        for k in 0..24 {
            let patch = PatchId((u64::from(scene.patch_count()) * k / 24) as u32);
            let geometry = scene.patch(patch);
            let normal = scene.surface(geometry.surface).normal();
            let frame = Frame::on_patch(&geometry, normal, geometry.centroid(), 0.7 * k as f64);
            let hemicube = of_hemicube.hemicube(32, &frame, geometry.surface);
            let eye = Eye::with_horizon(&frame, geometry.surface);
            let all = of_all.view(&eye, pixel_count(32));
            for (face, window) in hemicube.windows().iter().enumerate() {
                let of_face = face_canvas.draw_face(&hemicube, face);
                let picture = canvas.draw(&all, window);
                for (i, j) in (0..window.height).flat_map(|j| (0..32).map(move |i| (i, j))) {
                    assert_eq!(of_face.sample(i, j), picture.sample(i, j));
                }
            }
        }
    }
}

/// What one piece hides no pixel sees; and in a hall with columns one piece hides much.
#[test]
fn no_pixel_sees_what_is_hidden() {
    let scene = made(Model::Hall, 5.0);
    let drawable = Arc::new(Drawable::new(&scene));
    let mut of_hemicube = Viewer::new(&drawable);
    let mut of_all = Viewer::new(&drawable);
    let mut canvas = Canvas::default();
    let (mut hidden, mut visible) = (0, 0);
    for k in 0..12 {
        let patch = PatchId(scene.patch_count() * k / 12);
        let geometry = scene.patch(patch);
        let normal = scene.surface(geometry.surface).normal();
        let frame = Frame::on_patch(&geometry, normal, geometry.centroid(), 0.7);
        let hemicube = of_hemicube.hemicube(200, &frame, geometry.surface);
        let all = of_all.view(
            &Eye::with_horizon(&frame, geometry.surface),
            pixel_count(200),
        );
        let mut is_seen = vec![false; scene.surfaces().len()];
        for face in 0..FACES {
            let mut picture = canvas.draw_face(&hemicube, face);
            picture.for_each_row(u32::MAX, u32::MAX, |_, ids| {
                for &id in ids.iter().filter(|id| **id != u32::MAX) {
                    is_seen[scene.mesh().surface_of(PatchId(id)).index()] = true;
                }
            });
        }
        for (surface, is_seen) in scene.surfaces().iter().zip(is_seen) {
            let corners = surface.corners.map(|p| frame.to_local(p.as_dvec3()));
            let is_hidden = all.hides(&[corners.to_vec()]);
            assert!(!(is_hidden && is_seen), "{patch:?}: {corners:?}");
            hidden += u32::from(is_hidden);
            visible += u32::from(is_seen);
        }
    }
    assert!(hidden > 12 * 100 && visible > 12 * 50, "{hidden} {visible}");
}

/// Walls that are fans of slivers, some no wider than a few roundings of their corners, whose own normals are not their
/// wall's: hemicubes stand on the wall all the same.
#[test]
fn closed_rooms_leak_nothing_to_hemicubes_on_slivers() {
    const SLIVERS: usize = 60;
    let turn = Quat::from_euler(EulerRot::XYZ, 0.4, 1.1, -0.7);
    let mut surfaces: Vec<Surface> = Vec::new();
    for wall in test_scenes::block(Vec3::ZERO, Vec3::new(3.0, 4.0, 2.5), false, 0).chunks_exact(2) {
        let [a, b, c] = wall[0].corners;
        let ring = [a, b, c, a + c - b];
        let middle = a + 0.3 * (b - a) + 0.6 * (c - b);
        let along = |side: usize, k: usize| {
            let share = (k as f32 / SLIVERS as f32).powi(4);
            turn * ring[side].lerp(ring[(side + 1) % 4], share)
        };
        surfaces.extend(
            (0..4 * SLIVERS)
                .map(|k| (k / SLIVERS, k % SLIVERS))
                .map(|(side, k)| Surface {
                    corners: [turn * middle, along(side, k), along(side, k + 1)],
                    ..wall[0]
                })
                .filter(|surface| !surface.is_degenerate()),
        );
    }
    let scene = test_scenes::scene(
        vec![test_scenes::material(0.5, 1.0)],
        surfaces,
        f64::INFINITY,
    );
    let drawable = Arc::new(Drawable::new(&scene));
    let mut drawer = HemicubeDrawer::new(&drawable, 32);
    let leaks = |patch: &PatchId| {
        let geometry = scene.patch(*patch);
        let normal = drawable.normal_of(geometry.surface);
        let turn = 0.7 * f64::from(patch.0);
        let frame = Frame::on_patch(&geometry, normal, geometry.centroid(), turn);
        let ids = drawer.item_buffer(geometry.surface, &frame);
        ids.contains(&NOTHING) || ids.contains(&BACK_FACE)
    };
    let patches = (0..scene.patch_count()).map(PatchId);
    let leaking: Vec<PatchId> = patches.filter(leaks).collect();
    assert!(leaking.is_empty(), "{leaking:?} of {}", scene.patch_count());
}
