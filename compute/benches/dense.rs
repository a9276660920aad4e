//! Item buffers of scenes whose triangles are many and small, on one core: where rays are cast instead of
//! drawing all of them. `cargo bench -p compute --bench dense`.
//!
//! In the box full of tetrahedra triangles lie behind triangles, but among gaps: blocks of pixels that are wholly covered, by
//! which the hierarchical depth buffer leaves out what lies behind, are few. Of the bumpy sphere, seen from inside,
//! hardly any triangle is hidden.

#[path = "performance/scenes.rs"]
#[allow(dead_code)] // the other benchmark uses all of it
mod scenes;

use std::hint::black_box;
use std::sync::Arc;

use compute::hemicubes::Hemicubes;
use compute::receivers::ReceiverId;
use compute::settings::{FormFactorSettings, Points};
use criterion::{BenchmarkId, Criterion, criterion_group, criterion_main};
use scene::{PatchId, Scene};
use visibility::item_buffer::{BACK_FACE, HemicubeDrawer, NOTHING};

const RESOLUTION: u32 = 128;

/// Hemicubes a measurement, spread over the scene.
const HEMICUBES: u32 = 16;

const TRIANGLES: [u32; 5] = [30_000, 65_000, 100_000, 200_000, 1_000_000];

fn benches(c: &mut Criterion) {
    of(c, "tetrahedra", scenes::tetrahedra);
    of(c, "bumpy_sphere", scenes::bumpy_sphere);
}

fn of(c: &mut Criterion, name: &str, make: fn(u32) -> anyhow::Result<Scene>) {
    let mut group = c.benchmark_group(format!("item_buffer_{HEMICUBES}x/{name}"));
    group.sample_size(10);
    for triangles in TRIANGLES {
        let scene = make(triangles).expect("it has no faults");
        let settings = FormFactorSettings {
            points: Points::CENTROID,
            ..FormFactorSettings::new(RESOLUTION)
        };
        let hemicubes = Arc::new(Hemicubes::new(&scene, settings));
        let mut drawer = HemicubeDrawer::new(hemicubes.drawable(), RESOLUTION);
        let count = u64::from(scene.patch_count());
        let patch = |k: u32| PatchId((count * u64::from(k) / u64::from(HEMICUBES)) as u32);
        let patches: Vec<PatchId> = (0..HEMICUBES).map(patch).collect();
        group.bench_function(BenchmarkId::from_parameter(triangles), |b| {
            b.iter(|| {
                for &patch in &patches {
                    let frame = hemicubes.receivers().frames(ReceiverId(patch.0))[0];
                    let own = hemicubes.receivers().surface(ReceiverId(patch.0));
                    drawer.draw(own, &frame, NOTHING, BACK_FACE, |_, _, ids| {
                        black_box(ids);
                    });
                }
            });
        });
    }
}

criterion_group!(dense, benches);
criterion_main!(dense);
