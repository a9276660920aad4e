//! Hemicubes on one core: item buffer with patch look-up, the look-up alone, and the whole row. `cargo bench -p compute
//! --bench hemicubes`.
//!
//! The same scene at several numbers of patches shows that a hemicube costs by its pixels and
//! surfaces, not by its patches.

use std::hint::black_box;
use std::sync::Arc;

use compute::cpu::RowDrawer;
use compute::hemicubes::Hemicubes;
use compute::receivers::ReceiverId;
use compute::settings::{FormFactorSettings, Points};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use genx::{Model, Settings};
use scene::{PatchId, Scene};
use visibility::hemicube::FACES;
use visibility::item_buffer::{BACK_FACE, HemicubeDrawer, NOTHING};
use visibility::{Canvas, Viewer};

const RESOLUTION: u32 = 100;

/// Hemicubes a measurement, spread over the scene.
const HEMICUBES: u32 = 64;

fn scene(model: Model, max_area: f64) -> Scene {
    let settings = Settings {
        max_area: Some(max_area),
        ..Settings::new(model)
    };
    genx::make(&settings)
        .expect("the built-in models are valid")
        .scene
}

fn patches(scene: &Scene) -> Vec<PatchId> {
    let count = u64::from(scene.patch_count());
    (0..HEMICUBES)
        .map(|k| PatchId((count * u64::from(k) / u64::from(HEMICUBES)) as u32))
        .collect()
}

fn one_a_patch(scene: &Scene) -> Arc<Hemicubes<'_>> {
    let settings = FormFactorSettings {
        points: Points::CENTROID,
        ..FormFactorSettings::new(RESOLUTION)
    };
    Arc::new(Hemicubes::new(scene, settings))
}

fn item_buffers(c: &mut Criterion, name: &str, scenes: &[Scene]) {
    let mut group = c.benchmark_group(format!("item_buffer_{HEMICUBES}x/{name}"));
    for scene in scenes {
        let hemicubes = one_a_patch(scene);
        let mut drawer = HemicubeDrawer::new(hemicubes.drawable(), RESOLUTION);
        let patches = patches(scene);
        group.bench_function(BenchmarkId::from_parameter(scene.patch_count()), |b| {
            b.iter(|| {
                for &patch in &patches {
                    let frame = hemicubes.receivers().frames(ReceiverId(patch.0))[0];
                    drawer.draw(
                        hemicubes.receivers().surface(ReceiverId(patch.0)),
                        &frame,
                        NOTHING,
                        BACK_FACE,
                        |_, _, ids| {
                            black_box(ids);
                        },
                    );
                }
            });
        });
    }
}

/// Of hemicubes that are drawn already.
fn look_ups(c: &mut Criterion, name: &str, scenes: &[Scene]) {
    let mut group = c.benchmark_group(format!("look_up_{HEMICUBES}x/{name}"));
    for scene in scenes {
        let hemicubes = one_a_patch(scene);
        let mut drawn: Vec<(Viewer, [Canvas; FACES])> = patches(scene)
            .into_iter()
            .map(|_| (Viewer::new(hemicubes.drawable()), Default::default()))
            .collect();
        let mut pictures = Vec::new();
        for ((viewer, canvases), patch) in drawn.iter_mut().zip(patches(scene)) {
            let (own, frame) = (
                hemicubes.receivers().surface(ReceiverId(patch.0)),
                hemicubes.receivers().frames(ReceiverId(patch.0))[0],
            );
            let hemicube = viewer.hemicube(RESOLUTION, &frame, own);
            let faces = canvases.iter_mut().enumerate();
            pictures.extend(faces.map(|(face, canvas)| canvas.draw_face(&hemicube, face)));
        }
        group.bench_function(BenchmarkId::from_parameter(scene.patch_count()), |b| {
            b.iter(|| {
                for picture in &mut pictures {
                    picture.for_each_row(NOTHING, BACK_FACE, |_, ids| {
                        black_box(ids);
                    });
                }
            });
        });
    }
}

fn rows(c: &mut Criterion, name: &str, scenes: &[Scene]) {
    let mut group = c.benchmark_group(format!("row_{HEMICUBES}x/{name}"));
    for scene in scenes {
        let hemicubes = one_a_patch(scene);
        let mut drawer = RowDrawer::new(&hemicubes);
        let patches = patches(scene);
        group.bench_function(BenchmarkId::from_parameter(scene.patch_count()), |b| {
            b.iter(|| {
                for &patch in &patches {
                    black_box(drawer.row(ReceiverId(patch.0)));
                }
            });
        });
    }
}

fn benches(c: &mut Criterion) {
    // 2,600, 40,000 and 560,000 patches on the same surfaces.
    let cornell = [1e-3, 6e-5, 4e-6].map(|area| scene(Model::Cornell, area));
    let hall = [5.0, 0.25].map(|area| scene(Model::Hall, area));
    item_buffers(c, "cornell", &cornell);
    item_buffers(c, "hall", &hall);
    look_ups(c, "cornell", &cornell);
    look_ups(c, "hall", &hall);
    rows(c, "cornell", &cornell);
    rows(c, "hall", &hall);
}

criterion_group!(hemicubes, benches);
criterion_main!(hemicubes);
