//! Laws of form factor rows drawn on the CPU.

mod common;

use std::sync::Arc;

use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::rows::{RowBatch, RowSource, UNITS_PER_ONE, Unseen};
use compute::settings::{FormFactorSettings, Points};
use glam::{DVec3, Vec3};
use scene::{PatchId, Scene, SurfaceId};
use visibility::item_buffer::{BACK_FACE, HemicubeDrawer, NOTHING};
use visibility::{Drawable, Frame, hemicube};

fn settings(resolution: u32, points: Points) -> FormFactorSettings {
    FormFactorSettings {
        points,
        ..FormFactorSettings::new(resolution)
    }
}

fn all_rows(scene: &Scene, settings: FormFactorSettings, threads: usize) -> RowBatch {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()
        .unwrap();
    pool.install(|| {
        CpuRows::new(&Arc::new(Hemicubes::new(scene, settings)))
            .draw_rows(0..scene.patch_count())
            .unwrap()
    })
}

#[test]
fn closed_room_form_factors_sum_to_one() {
    let points = [
        Points::CENTROID,
        Points::Vertices,
        Points::Bisected { bisections: 3 },
        Points::ThreePoint { bisections: 1 },
        Points::Auto,
    ];
    for points in points {
        for resolution in [2, 30, 100] {
            for scene in [common::furnace(0.5, 1.0, 0.05), common::furnished_room(0.2)] {
                let settings = settings(resolution, points);
                let rows = all_rows(&scene, settings, 2);
                for k in 0..scene.patch_count() as usize {
                    let sum: f64 = rows.row(k).iter().map(|e| f64::from(e.units)).sum();
                    assert_eq!(
                        rows.unseen(k),
                        Unseen::default(),
                        "{points} {resolution} patch {k}"
                    );
                    let error = sum / f64::from(UNITS_PER_ONE) - 1.0;
                    assert!(
                        error.abs() < common::methods::ROUNDING,
                        "{points} patch {k}: {error}"
                    );
                }
            }
        }
    }
}

#[test]
fn rows_are_in_patch_order_and_never_hold_their_own_surface() {
    let scene = common::furnished_room(0.1);
    let rows = all_rows(&scene, settings(50, Points::CENTROID), 2);
    for k in 0..scene.patch_count() {
        let own = scene.mesh().surface_of(PatchId(k));
        let row = rows.row(k as usize);
        assert!(row.is_sorted_by(|a, b| a.patch < b.patch));
        assert!(
            row.iter()
                .all(|e| e.units > 0.0 && scene.mesh().surface_of(PatchId(e.patch)) != own)
        );
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = common::furnished_room(0.1);
    let one = all_rows(&scene, settings(64, Points::CENTROID), 1);
    for threads in [2, 3, 16] {
        assert_eq!(
            all_rows(&scene, settings(64, Points::CENTROID), threads),
            one
        );
    }
}

/// The hemicube's pixel centres are where rays go, so an exact ray caster finds the same patches.
/// It works in f64 on the same f32 corners; only pixels whose ray passes an edge within
/// rounding may differ, and rays meet no edge of these walls that closely.
#[test]
fn item_buffer_agrees_with_ray_casting() {
    let surfaces = common::shaken(common::furnished_room_surfaces());
    let materials = vec![common::material(0.5, 0.0), common::material(0.3, 2.0)];
    let scene = common::scene(materials, surfaces, 0.07);
    let resolution = 24;
    let mut drawer = HemicubeDrawer::new(&Arc::new(Drawable::new(&scene)), resolution);
    let (mut pixels, mut differing) = (0, 0);
    for patch in (0..scene.patch_count()).step_by(37).map(PatchId) {
        let frame = Hemicubes::new(&scene, settings(2, Points::CENTROID)).frames(patch)[0];
        let own = scene.mesh().surface_of(patch);
        let ids = drawer.item_buffer(own, &frame);
        let mut index = 0;
        for window in hemicube::windows(resolution) {
            for j in 0..window.height {
                for i in 0..window.width {
                    let local = window.forward
                        + (window.left + (i as f64 + 0.5) * window.pixel) * window.right
                        + (window.bottom + (j as f64 + 0.5) * window.pixel) * window.up;
                    let expected = cast(&scene, own, &frame, local);
                    differing += usize::from(expected != ids[index]);
                    pixels += 1;
                    index += 1;
                }
            }
        }
        assert_eq!(index, ids.len());
    }
    // Patch borders are crossed by rounding of the f32 look-up: each of some 200 borders a picture
    // of 24 pixels moves by 1e-6 of a pixel. One in a thousand would already be a defect.
    assert!(
        differing * 1000 <= pixels,
        "{differing} of {pixels} pixels differ"
    );
}

/// The patch seen along a direction given in the frame, by testing every surface.
fn cast(scene: &Scene, own: SurfaceId, frame: &Frame, local: DVec3) -> u32 {
    let direction = local.x * frame.tangent + local.y * frame.bitangent + local.z * frame.normal;
    let mut nearest = f64::INFINITY;
    let mut seen = NOTHING;
    for (index, surface) in scene.surfaces().iter().enumerate() {
        let [p0, p1, p2] = surface.corners.map(Vec3::as_dvec3);
        let normal = (p1 - p0).cross(p2 - p0);
        let towards = direction.dot(normal);
        let distance = (p0 - frame.position).dot(normal) / towards;
        if own == SurfaceId(index as u32)
            || !distance.is_finite()
            || distance <= 1e-9
            || distance >= nearest
        {
            continue;
        }
        let hit = frame.position + distance * direction;
        let share =
            |p: DVec3, q: DVec3| (q - p).cross(hit - p).dot(normal) / normal.length_squared();
        let (a, b, c) = (share(p1, p2), share(p2, p0), share(p0, p1));
        if a < 0.0 || b < 0.0 || c < 0.0 {
            continue;
        }
        nearest = distance;
        seen = if towards > 0.0 {
            BACK_FACE
        } else {
            let weights = [a as f32, b as f32, c as f32];
            scene.mesh().locate(SurfaceId(index as u32), weights).0.0
        };
    }
    seen
}

/// Identical parallel directly opposed unit squares, distance 1: F = 0.199824895698 (Howell,
/// catalogue of radiation configuration factors, C-11). Mean over the centroids of 512 right
/// triangles with legs h = 1/16: a triangle's second moment is h^2/18 in each direction, so the
/// midpoint rule errs by h^2/36 times the mean Laplacian of the point form factor, which is under 5
/// of its own value: 0.05 percent. Pixels of a 128 px face err as much again at the most.
#[test]
fn opposite_walls_of_a_cube_see_a_fifth_of_each_other() {
    let scene = common::furnace(0.5, 1.0, 1.0 / 512.0);
    let settings = settings(128, Points::CENTROID);
    let rows = all_rows(&scene, settings, 2);
    let per_wall = scene.patch_count() / 6;
    let mut opposite = 0.0;
    for k in 0..per_wall {
        opposite += rows
            .row(k as usize)
            .iter()
            .filter(|e| e.patch / per_wall == 1)
            .map(|e| f64::from(e.units) / f64::from(UNITS_PER_ONE))
            .sum::<f64>();
    }
    let form_factor = opposite / f64::from(per_wall);
    assert!(
        (form_factor / 0.199_824_895_698 - 1.0).abs() < 1e-3,
        "{form_factor}"
    );
}
