//! Surfaces that lie in each other, bodies that cut each other, and patches inside bodies.

use std::sync::Arc;

use compute::certificate::{Known, certify};
use compute::rows::{RowBatch, UNITS_PER_ONE};
use glam::{DVec3, Vec3};
use scene::{MaterialId, ObjectId, Scene, Surface, SurfaceId};
use visibility::item_buffer::{BACK_FACE, HemicubeDrawer};
use visibility::{Drawable, Frame};

use super::{all_rows, cache};
use crate::common::{self, block, compute, folder, material, quad, save, stderr};

fn room() -> Vec<Surface> {
    block(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0), false, 0)
}

fn of_object(object: u32, surfaces: impl IntoIterator<Item = Surface>) -> Vec<Surface> {
    let surfaces = surfaces.into_iter();
    surfaces
        .map(|s| Surface {
            object: ObjectId(object),
            material: MaterialId(object.min(1)),
            ..s
        })
        .collect()
}

/// A room, "room", and two things in it, "first" and "second".
fn scene(first: Vec<Surface>, second: Vec<Surface>, max_area: f64) -> Scene {
    let surfaces = [room(), of_object(1, first), of_object(2, second)].concat();
    let materials = vec![material(0.5, 0.0), material(0.3, 2.0)];
    let objects = ["room", "first", "second"].map(String::from).to_vec();
    Scene::with_max_area(materials, objects, surfaces, max_area, DVec3::ZERO).unwrap()
}

/// A poster on the ceiling, facing down, of these places in x and y.
fn poster(low: f32, high: f32) -> Vec<Surface> {
    let at = |x: f32, y: f32| Vec3::new(x, y, 2.0);
    let corners = [at(low, low), at(low, high), at(high, high), at(high, low)];
    quad(corners, 1).to_vec()
}

fn posters() -> Scene {
    scene(poster(0.5, 1.5), poster(1.0, 2.0), 0.25)
}

/// Two boxes that share a corner's region, whose border lies on no patches' border.
fn crossing_boxes() -> Scene {
    scene(
        block(Vec3::splat(0.5), Vec3::splat(1.3), true, 1),
        block(Vec3::splat(0.93), Vec3::splat(1.73), true, 1),
        0.02,
    )
}

fn rows_on(scene: &Scene, threads: usize) -> RowBatch {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.unwrap().install(|| all_rows(scene, 48))
}

/// Which of two surfaces in one plane a pixel sees is a matter of rounding, and of nothing else.
#[test]
fn overlapping_surfaces_give_the_same_bits_on_any_threads() {
    for scene in [posters(), crossing_boxes()] {
        let one = rows_on(&scene, 1);
        for threads in [2, 3, 7, 16] {
            assert!(rows_on(&scene, threads) == one, "{threads}");
        }
    }
}

/// Rows stay closed: of surfaces in one plane every pixel sees one.
#[test]
fn posters_on_a_ceiling_open_no_gap() {
    super::assert_closed(&posters(), 48, "posters");
}

/// Posters and the ceiling behind them look out alike, but share what looks in: reciprocity is missed by
/// the whole of some patches, which are a percent of the area or more, so by ten percent root mean
/// square or more. And what overlaps absorbs twice what arrives.
#[test]
fn overlapping_surfaces_fail_the_certificate() {
    let folder = folder();
    save(folder.path(), "in.rad", &posters());
    let output = compute(folder.path(), &["in.rad", "out.rad", "48", "--strict"]);
    assert_eq!(output.status.code(), Some(1), "{output:?}");
    let said = stderr(&output);
    assert!(said.contains("miss reciprocity"), "{said}");
}

/// A patch of one box whose middle is inside the other sees nothing but backs. Those that are cut are seen
/// by others all the same, so the certificate tells of the backs, and whose they are; those that are
/// wholly inside are seen by nobody.
#[test]
fn bodies_that_cut_each_other_are_reported() {
    let scene = crossing_boxes();
    let mut rows = cache(&scene, 48);
    rows.draw_missing().unwrap();
    let one = UNITS_PER_ONE;
    let mut inside = 0;
    for (patch, unseen) in (0..).map(scene::PatchId).zip(rows.unseen()) {
        let surface = scene.mesh().surface_of(patch);
        let object = scene.surface(surface).object.0;
        let centroid = scene.patch(patch).centroid();
        let other = match object {
            1 => 0.93..1.73,
            2 => 0.5..1.3,
            _ => continue,
        };
        if centroid.to_array().iter().all(|x| other.contains(x)) {
            inside += 1;
            assert_eq!(unseen.unwrap().back_face, one, "{patch:?}");
        }
    }
    assert!(inside > 20, "{inside}");
    let certificate = certify(&rows, Known::default());
    let backs = certificate.back_faces.as_ref().unwrap();
    assert!(
        ["first", "second"].contains(&backs.culprit.as_deref().unwrap()),
        "{backs:?}"
    );
    assert!(!certificate.warnings().is_empty());
    let hidden = certificate.hidden_patches.unwrap();
    assert!(hidden > 0 && hidden < inside, "{hidden} of {inside}");
}

/// A sheet inside a solid is seen by nobody, sees nothing but the solid's backs, and changes not a bit of
/// what the others see.
#[test]
fn a_patch_inside_a_solid_has_no_part_in_the_exchange() {
    let solid = || block(Vec3::ONE, Vec3::splat(1.8), true, 1);
    let at = |x: f32, y: f32| Vec3::new(x, y, 1.4);
    let sheet = quad([at(1.2, 1.2), at(1.6, 1.2), at(1.6, 1.6), at(1.2, 1.6)], 1);
    let with = scene(solid(), sheet.to_vec(), 0.1);
    let without = scene(solid(), Vec::new(), 0.1);
    let (rows, expected) = (all_rows(&with, 48), all_rows(&without, 48));
    let count = without.patch_count() as usize;
    for k in 0..count {
        assert_eq!(rows.row(k), expected.row(k), "{k}");
        assert_eq!(rows.unseen(k), expected.unseen(k), "{k}");
    }
    let one = UNITS_PER_ONE;
    for k in count..with.patch_count() as usize {
        assert!(rows.row(k).is_empty(), "{k}");
        assert_eq!(rows.unseen(k).back_face, one, "{k}");
    }
    let mut cache = cache(&with, 48);
    cache.draw_missing().unwrap();
    let certificate = certify(&cache, Known::default());
    assert_eq!(
        certificate.hidden_patches,
        Some(with.patch_count() - count as u32)
    );
    assert_eq!(certificate.back_faces.map(|finding| finding.share), None);
}

/// Rays exactly through the edges of a solid, where its fronts and its backs meet at equal depths, see a
/// front: the hemicube stands at the origin along the axes, and the box's sides are cut by the pixels'
/// centres, (k + 1/2) / 32, at the height of its bottom, or of its top.
#[test]
fn rays_along_the_silhouette_of_a_solid_never_see_its_inside() {
    let resolution = 64;
    let frame = Frame {
        position: DVec3::ZERO,
        tangent: DVec3::X,
        bitangent: DVec3::Y,
        normal: DVec3::Z,
    };
    let hall = block(Vec3::new(-9.0, -9.0, 0.0), Vec3::splat(9.0), false, 0);
    // The patch below the hemicube.
    let own = hall
        .iter()
        .position(|s| s.corners.iter().all(|p| p.z == 0.0))
        .unwrap();
    let centre = |k: i32| (k as f32 + 0.5) / 32.0;
    for (height, left) in (-28..28).map(|k| (0.7 + 0.05 * (k + 28) as f32, centre(k))) {
        for far in [height, height + 0.3] {
            let low = Vec3::new(left * far, centre(-5) * height, height);
            let high = Vec3::new(low.x + 0.4 * height, centre(9) * far, height + 0.3);
            let mut surfaces = hall.clone();
            surfaces.extend(block(low, high, true, 0));
            let scene = common::scene(vec![material(0.5, 1.0)], surfaces, f64::INFINITY);
            let ids = HemicubeDrawer::new(&Arc::new(Drawable::new(&scene)), resolution)
                .item_buffer(SurfaceId(own as u32), &frame);
            let backs = ids.iter().filter(|&&id| id == BACK_FACE).count();
            assert_eq!(backs, 0, "{low} {high}");
        }
    }
}
