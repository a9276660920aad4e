//! The gpu sees what the cpu sees.

use std::sync::Arc;

use compute::backend::agreement::{MAX_DIFFERENT_SHARE, moved};
use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::receivers::ReceiverId;
use compute::rows::RowSource;
use scene::{PatchId, Scene};
use visibility::Drawable;
use visibility::item_buffer::{BACK_FACE, HemicubeDrawer, NOTHING};

use crate::model::{frame, room, room_far_from_a_box, ruin};
use crate::{open, settings};

/// Of the pixels that differ, those whose neighbours all see the same on the cpu: something thinner than a pixel meets a
/// pixel's centre in one picture only. Tuned: none of 720,000 pixels was measured.
const MAX_DIFFERENT_OFF_EDGE_SHARE: f64 = 5e-6;

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
fn compare(on_cpu: &Scene, on_gpu: &Scene, resolution: u32, count: u32) -> Comparison {
    let mut gpu = open(on_gpu, settings(resolution));
    let mut cpu = HemicubeDrawer::new(&Arc::new(Drawable::new(on_cpu)), resolution);
    let mut comparison = Comparison::default();
    for patch in sample(on_cpu, count) {
        let frame = frame(on_cpu, patch);
        let expected = cpu.item_buffer(on_cpu.mesh().surface_of(patch), &frame);
        let ids = gpu.item_buffer(ReceiverId(patch.0), &frame).unwrap();
        comparison.add(&expected, &ids, resolution);
    }
    comparison
}

pub fn twins_see_the_same_but_for_pixels_on_edges() {
    for (name, model) in [("room", room()), ("ruin", ruin())] {
        for max_area in [f64::INFINITY, 0.1, 0.005] {
            for resolution in [2, 100, 128] {
                let scene = model.scene(max_area);
                let comparison = compare(&scene, &scene, resolution, 24);
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

/// What is near is seen as well in a scene with things far away; the cpu's twin test is
/// `geometry_far_outside_a_closed_room_changes_no_bit_inside`.
pub fn regression_twins_see_the_same_in_a_room_far_from_something() {
    // No depth changes where the far box comes last.
    let scene = room_far_from_a_box().scene(f64::INFINITY);
    let alone = room().scene(f64::INFINITY);
    let comparison = compare(&alone, &scene, 100, alone.patch_count());
    println!("{comparison:?}");
    assert!(comparison.agrees(), "{comparison:?}");
}

pub fn a_moved_surface_makes_the_twins_disagree() {
    let scene = room().scene(0.1);
    let mut moved = room();
    // A corner of a box's top, by a tenth of the box.
    let triangle = moved.triangles.len() - 10;
    moved.triangles[triangle][0].x += 0.07;
    let comparison = compare(&scene, &moved.scene(0.1), 100, 24);
    assert!(!comparison.agrees(), "{comparison:?}");
}

pub fn backs_and_openings_are_seen_where_the_cpu_sees_them() {
    let scene = ruin().scene(0.1);
    let mut gpu = open(&scene, settings(100));
    let mut counts = [0; 2];
    for patch in sample(&scene, 24) {
        let ids = gpu
            .item_buffer(ReceiverId(patch.0), &frame(&scene, patch))
            .unwrap();
        for (count, code) in counts.iter_mut().zip([NOTHING, BACK_FACE]) {
            *count += ids.iter().filter(|&&id| id == code).count();
        }
    }
    // That they are the right ones is what the comparison of the twins shows.
    assert!(counts.iter().all(|&count| count > 1000), "{counts:?}");
}

/// The twins' rows differ by what the pixels on edges are worth.
pub fn twins_form_factors_agree() {
    let scene = ruin().scene(0.1);
    let mut gpu = open(&scene, settings(100));
    let mut cpu = CpuRows::new(&Arc::new(Hemicubes::new(&scene, settings(100))));
    let count = scene.patch_count().min(100);
    let (on_gpu, on_cpu) = (
        gpu.draw_rows(0..count).unwrap(),
        cpu.draw_rows(0..count).unwrap(),
    );
    let moved = moved(&on_cpu, &on_gpu);
    let mean = moved.iter().sum::<f64>() / moved.len() as f64;
    println!("mean share that moved: {mean:.2e}");
    assert!(mean < MAX_DIFFERENT_SHARE, "{mean}");
}
