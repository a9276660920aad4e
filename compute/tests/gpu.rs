//! Laws of the gpu back end, and its agreement with its twin on the cpu.
//!
//! Without an adapter every test here prints that it is skipped; with `REQUIRE_GPU=1` it fails.

use compute::cpu::CpuRows;
use compute::cpu::item_buffer::{BACK_FACE, HemicubeDrawer, NOTHING};
use compute::delta_form_factors::DeltaFormFactors;
use compute::gpu::{AdapterChoice, GpuRows};
use compute::hemicube::{self, Frame};
use compute::rows::{BackendError, Entry, RowBatch, RowSource, Unseen};
use compute::settings::{FormFactorSettings, Maps, Points};
use glam::{DQuat, DVec3, EulerRot};
use scene::{Material, MaterialId, ObjectId, PatchId, Scene, Surface};

/// Pixels that may differ between the twins, of all pixels: corners are f32 here and f64 there, and
/// GPUs snap them to 1/256 of a pixel, so a pixel differs only where an edge of a surface or a patch
/// passes its centre that closely. Tuned: the most measured is 0.2 % (llvmpipe, 788 patches at 100
/// pixels, where by symmetry many edges pass pixels' centres exactly); others may snap otherwise.
const MAX_DIFFERENT_SHARE: f64 = 0.005;
/// Of these, pixels whose neighbours all see the same on the cpu: something thinner than a pixel meets a
/// pixel's centre in one picture only. Tuned: 1 pixel of 720,000 was measured.
const MAX_DIFFERENT_OFF_EDGE_SHARE: f64 = 2e-5;
/// Share of a hemisphere in which a closed body may show its inside at 100 pixels: two pixels of at
/// most 4 / (pi R^2). It takes a front seen at a grazing angle, whose depth changes by much within the
/// 1/256 of a pixel to which its corners are snapped, or an edge through a pixel's very centre. Measured:
/// one pixel, in a row of a thousand or fewer.
const MAX_SNAPPED_BACK_FACE_SHARE: f64 = 2.0 * 4.0 / (std::f64::consts::PI * 100.0 * 100.0);

fn settings(resolution: u32) -> FormFactorSettings {
    FormFactorSettings {
        resolution,
        maps: Maps::Exact,
        points: Points::CENTROID,
    }
}

/// A back end, or `None` where there is no adapter and none is required.
fn open(scene: &Scene, settings: FormFactorSettings) -> Option<GpuRows<'_>> {
    match GpuRows::new(scene, settings, AdapterChoice::Any) {
        Ok(rows) => Some(rows),
        Err(BackendError::NoAdapter)
            if std::env::var_os("REQUIRE_GPU").is_none_or(|v| v != "1") =>
        {
            eprintln!("skipped: there is no GPU adapter");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

/// Triangles of quads, turned in space so that nothing lies along an axis.
#[derive(Default)]
struct Model {
    triangles: Vec<[DVec3; 3]>,
}

impl Model {
    /// Corners counter-clockwise as seen from the front.
    fn quad(&mut self, [a, b, c, d]: [DVec3; 4]) {
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// The sides of a box, seen from outside, or from inside if it is a room.
    fn cuboid(&mut self, low: DVec3, high: DVec3, is_room: bool) {
        let corner = |k: usize| {
            DVec3::new(
                if k & 1 == 0 { low.x } else { high.x },
                if k & 2 == 0 { low.y } else { high.y },
                if k & 4 == 0 { low.z } else { high.z },
            )
        };
        for side in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            let mut corners = side.map(corner);
            if is_room {
                corners.reverse();
            }
            self.quad(corners);
        }
    }

    fn surfaces(&self) -> Vec<Surface> {
        let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, 0.5, 0.7);
        self.triangles
            .iter()
            .map(|corners| Surface {
                corners: corners.map(|p| (turn * p).as_vec3()),
                material: MaterialId(0),
                object: ObjectId(0),
            })
            .collect()
    }

    fn scene(&self, max_area: f64) -> Scene {
        let material = Material {
            name: "grey".into(),
            reflectance: glam::Vec3::splat(0.5),
            emission: glam::Vec3::ZERO,
        };
        let objects = vec!["model".into()];
        Scene::with_max_area(
            vec![material],
            objects,
            self.surfaces(),
            max_area,
            DVec3::ZERO,
        )
        .unwrap()
    }
}

/// A closed room with two boxes that hover this high over its floor.
fn room_with_boxes_at(height: f64) -> Model {
    let low = height - 1.0;
    let mut model = Model::default();
    model.cuboid(
        DVec3::new(-2.0, -1.5, -1.0),
        DVec3::new(2.0, 1.5, 1.0),
        true,
    );
    model.cuboid(
        DVec3::new(-1.2, -0.9, low),
        DVec3::new(-0.3, 0.1, 0.5),
        false,
    );
    model.cuboid(DVec3::new(0.4, 0.0, low), DVec3::new(1.1, 1.0, -0.2), false);
    model
}

/// A closed room with two boxes on its floor, into which the patches below them look from inside.
fn room() -> Model {
    room_with_boxes_at(0.0)
}

/// Walls with gaps between them, and a sheet whose back is in view.
fn ruin() -> Model {
    let mut model = room();
    model
        .triangles
        .retain(|corners| corners.iter().any(|p| p.z < 0.9));
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.7);
    model.quad([at(-1.0, -1.0), at(-1.0, 0.5), at(1.0, 0.5), at(1.0, -1.0)]);
    model.quad([at(1.2, -1.0), at(1.8, -1.0), at(1.8, 1.0), at(1.2, 1.0)]);
    model
}

fn frame(scene: &Scene, patch: PatchId) -> Frame {
    hemicube::frames(scene, patch, Points::CENTROID)[0]
}

/// Patches all over the scene.
fn sample(scene: &Scene, count: u32) -> impl Iterator<Item = PatchId> {
    let patches = scene.patch_count();
    (0..count).map(move |k| PatchId((u64::from(k) * u64::from(patches) / u64::from(count)) as u32))
}

/// Whether some neighbour in its face sees something else, pixel by pixel.
fn edge_pixels(ids: &[u32], resolution: usize) -> Vec<bool> {
    let face = |j: usize| {
        if j < resolution {
            0
        } else {
            1 + (j - resolution) / (resolution / 2)
        }
    };
    let id = |i: usize, j: usize| ids[j * resolution + i];
    let is_edge = |i: usize, j: usize| {
        let same_face = |other: usize| other < 3 * resolution && face(other) == face(j);
        let columns = [i.wrapping_sub(1), i + 1]
            .into_iter()
            .filter(|&c| c < resolution);
        let rows = [j.wrapping_sub(1), j + 1]
            .into_iter()
            .filter(|&r| same_face(r));
        columns
            .map(|c| id(c, j))
            .chain(rows.map(|r| id(i, r)))
            .any(|other| other != id(i, j))
    };
    (0..ids.len())
        .map(|k| is_edge(k % resolution, k / resolution))
        .collect()
}

/// How two item buffers of one hemicube compare, in pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Comparison {
    pixels: usize,
    edge: usize,
    different: usize,
    different_off_edge: usize,
}

impl Comparison {
    fn add(&mut self, on_cpu: &[u32], on_gpu: &[u32], resolution: u32) {
        assert_eq!(on_cpu.len(), on_gpu.len());
        let edges = edge_pixels(on_cpu, resolution as usize);
        for ((a, b), is_edge) in on_cpu.iter().zip(on_gpu).zip(edges) {
            self.pixels += 1;
            self.edge += usize::from(is_edge);
            self.different += usize::from(a != b);
            self.different_off_edge += usize::from(a != b && !is_edge);
        }
    }

    fn agrees(&self) -> bool {
        let share = |count: usize| count as f64 / self.pixels as f64;
        // Pictures of 12 pixels are little but edges: their share says nothing.
        let is_small = self.pixels < 1000;
        self.different <= self.edge
            && share(self.different_off_edge) < MAX_DIFFERENT_OFF_EDGE_SHARE
            && (is_small || share(self.different) < MAX_DIFFERENT_SHARE)
    }
}

/// Compares the twins on `count` patches, the cpu drawing `on_cpu` and the gpu `on_gpu`.
fn compare(on_cpu: &Scene, on_gpu: &Scene, resolution: u32, count: u32) -> Option<Comparison> {
    let mut gpu = open(on_gpu, settings(resolution))?;
    let mut cpu = HemicubeDrawer::new(on_cpu, resolution);
    let mut comparison = Comparison::default();
    for patch in sample(on_cpu, count) {
        let frame = frame(on_cpu, patch);
        let expected = cpu.item_buffer(patch, &frame);
        let ids = gpu.item_buffer(patch, &frame).unwrap();
        comparison.add(&expected, &ids, resolution);
    }
    Some(comparison)
}

#[test]
fn twins_see_the_same_but_for_pixels_on_edges() {
    for (name, model) in [("room", room()), ("ruin", ruin())] {
        for max_area in [f64::INFINITY, 0.1, 0.005] {
            for resolution in [2, 100, 128] {
                let scene = model.scene(max_area);
                let Some(comparison) = compare(&scene, &scene, resolution, 24) else {
                    return;
                };
                let patches = scene.patch_count();
                println!("{name}, {patches} patches, {resolution}: {comparison:?}");
                assert!(
                    comparison.agrees(),
                    "{name} {max_area} {resolution}: {comparison:?}"
                );
            }
        }
    }
}

#[test]
fn a_moved_surface_makes_the_twins_disagree() {
    let scene = room().scene(0.1);
    let mut moved = room();
    // A corner of a box's top, by a tenth of the box.
    let triangle = moved.triangles.len() - 10;
    moved.triangles[triangle][0].x += 0.07;
    let Some(comparison) = compare(&scene, &moved.scene(0.1), 100, 24) else {
        return;
    };
    assert!(!comparison.agrees(), "{comparison:?}");
}

#[test]
fn backs_and_openings_are_seen_where_the_cpu_sees_them() {
    let scene = ruin().scene(0.1);
    let Some(mut gpu) = open(&scene, settings(100)) else {
        return;
    };
    let mut counts = [0; 2];
    for patch in sample(&scene, 24) {
        let ids = gpu.item_buffer(patch, &frame(&scene, patch)).unwrap();
        for (count, code) in counts.iter_mut().zip([NOTHING, BACK_FACE]) {
            *count += ids.iter().filter(|&&id| id == code).count();
        }
    }
    // That they are the right ones is what the comparison of the twins shows.
    assert!(counts.iter().all(|&count| count > 1000), "{counts:?}");
}

/// The row that item buffers and delta form factors make, summed here.
fn row_on_host(
    scene: &Scene,
    settings: FormFactorSettings,
    item_buffers: &[Vec<u32>],
) -> (Vec<Entry>, Unseen) {
    let factors = DeltaFormFactors::new(
        settings.maps,
        settings.resolution,
        settings.units_per_hemicube(),
    );
    let table: Vec<u32> = (0..5)
        .flat_map(|face| factors.face(face))
        .copied()
        .collect();
    let mut units = vec![0; scene.patch_count() as usize];
    let mut unseen = Unseen::default();
    for ids in item_buffers {
        for (&id, factor) in ids.iter().zip(&table) {
            match id {
                NOTHING => unseen.open += factor,
                BACK_FACE => unseen.back_face += factor,
                patch => units[patch as usize] += factor,
            }
        }
    }
    let entries = (0..)
        .zip(units)
        .filter(|&(_, units)| units != 0)
        .map(|(patch, units)| Entry { patch, units })
        .collect();
    (entries, unseen)
}

/// Draws rows and sums them again from the gpu's own item buffers.
fn assert_rows_are_their_item_buffers_sums(
    scene: &Scene,
    settings: FormFactorSettings,
    patches: std::ops::Range<u32>,
) {
    let Some(mut gpu) = open(scene, settings) else {
        return;
    };
    let rows = gpu.draw_rows(patches.clone()).unwrap();
    assert_eq!(rows.patches(), patches);
    for (k, patch) in patches.enumerate() {
        let item_buffers: Vec<_> = hemicube::frames(scene, PatchId(patch), settings.points)
            .iter()
            .map(|frame| gpu.item_buffer(PatchId(patch), frame).unwrap())
            .collect();
        let (entries, unseen) = row_on_host(scene, settings, &item_buffers);
        let different = rows.row(k).iter().zip(&entries).find(|(a, b)| a != b);
        assert_eq!(different, None, "patch {patch}");
        assert_eq!(rows.row(k).len(), entries.len(), "patch {patch}");
        assert_eq!(rows.unseen(k), unseen, "patch {patch}");
    }
}

#[test]
fn rows_are_the_sums_of_their_item_buffers_to_the_bit() {
    let scene = ruin().scene(0.05);
    for (resolution, points, maps) in [
        (2, Points::CENTROID, Maps::Exact),
        (100, Points::CENTROID, Maps::Exact),
        (128, Points::Vertices, Maps::Exact),
        (50, Points::Bisected { bisections: 4 }, Maps::Thesis),
    ] {
        let settings = FormFactorSettings {
            resolution,
            points,
            maps,
        };
        let first = scene.patch_count() / 2;
        assert_rows_are_their_item_buffers_sums(&scene, settings, first..first + 6);
    }
}

/// A tile of it is more than the budget of an atlas, and its picture is taller than any texture.
#[test]
fn a_hemicube_larger_than_a_texture_is_drawn_in_parts() {
    let scene = ruin().scene(0.5);
    assert_rows_are_their_item_buffers_sums(&scene, settings(3000), 3..4);
}

/// Rows over several blocks and workgroups, with gaps between their entries.
#[test]
fn rows_of_half_a_million_patches_are_complete() {
    let scene = ruin().scene(1.2e-4);
    assert!(
        (300_000..1_000_000).contains(&scene.patch_count()),
        "{}",
        scene.patch_count()
    );
    let first = scene.patch_count() - 3;
    assert_rows_are_their_item_buffers_sums(&scene, settings(100), first..first + 3);
}

#[test]
fn closed_room_sees_itself_completely() {
    let mut empty = room();
    empty.triangles.truncate(12);
    for (model, back_face_share) in [
        (empty, 0.0),
        (room_with_boxes_at(0.01), MAX_SNAPPED_BACK_FACE_SHARE),
    ] {
        let scene = model.scene(0.1);
        for points in [Points::CENTROID, Points::Vertices] {
            let settings = FormFactorSettings {
                points,
                ..settings(100)
            };
            let Some(mut gpu) = open(&scene, settings) else {
                return;
            };
            let rows = gpu.draw_rows(0..scene.patch_count()).unwrap();
            let one = settings.units_per_one();
            for k in 0..rows.patches().len() {
                let unseen = rows.unseen(k);
                assert_eq!(unseen.open, 0, "{points}, patch {k}");
                let share = f64::from(unseen.back_face) / f64::from(one);
                assert!(share <= back_face_share, "{points}, patch {k}: {share}");
                let sum: u32 = rows.row(k).iter().map(|entry| entry.units).sum();
                assert_eq!(sum, one - unseen.back_face, "{points}, patch {k}");
                assert!(
                    rows.row(k).is_sorted_by(|a, b| a.patch < b.patch),
                    "{points}, patch {k}"
                );
            }
        }
    }
}

#[test]
fn rows_depend_on_no_batch_size_and_on_no_run() {
    let scene = ruin().scene(0.05);
    let Some(mut gpu) = open(&scene, settings(100)) else {
        return;
    };
    let all = gpu.draw_rows(0..40).unwrap();
    for size in [1, 7, 40] {
        let mut again = RowBatch::new(0);
        for start in (0..40).step_by(size) {
            let end = (start + size as u32).min(40);
            again.append(&gpu.draw_rows(start..end).unwrap());
        }
        assert!(again == all, "in batches of {size}");
    }
    let Some(mut other) = open(&scene, settings(100)) else {
        return;
    };
    assert!(other.draw_rows(0..40).unwrap() == all, "in another run");
    assert!(other.preferred_batch() >= 1);
    assert!(
        other.describe().starts_with("gpu, "),
        "{}",
        other.describe()
    );
}

#[test]
fn no_rows_are_asked_for_and_none_come() {
    let scene = room().scene(f64::INFINITY);
    let Some(mut gpu) = open(&scene, settings(2)) else {
        return;
    };
    assert_eq!(gpu.draw_rows(5..5).unwrap(), RowBatch::new(5));
}

/// The twins' rows differ by what the pixels on edges are worth.
#[test]
fn twins_form_factors_agree() {
    let scene = ruin().scene(0.1);
    let Some(mut gpu) = open(&scene, settings(100)) else {
        return;
    };
    let mut cpu = CpuRows::new(&scene, settings(100));
    let count = scene.patch_count().min(100);
    let (on_gpu, on_cpu) = (
        gpu.draw_rows(0..count).unwrap(),
        cpu.draw_rows(0..count).unwrap(),
    );
    let dense = |rows: &RowBatch, k: usize| {
        let mut units = vec![0_i64; scene.patch_count() as usize];
        for entry in rows.row(k) {
            units[entry.patch as usize] = entry.units.into();
        }
        units
    };
    let one = f64::from(settings(100).units_per_one());
    let mut moved = 0.0;
    for k in 0..count as usize {
        let (a, b) = (dense(&on_gpu, k), dense(&on_cpu, k));
        let units: i64 = a.iter().zip(&b).map(|(a, b)| (a - b).abs()).sum();
        moved += units as f64 / one;
    }
    // Each pixel that differs moves its share from one patch to another.
    let mean = moved / f64::from(count);
    println!("mean share that moved: {mean:.2e}");
    assert!(mean < 2.0 * MAX_DIFFERENT_SHARE, "{mean}");
}
