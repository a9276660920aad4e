//! Laws of form factor rows drawn on the CPU.

mod common;

use std::sync::Arc;

use compute::cpu::CpuRows;
use compute::hemicubes::Hemicubes;
use compute::rows::{Entry, Row, RowBatch, RowSource, UNITS_PER_ONE, Unseen};
use compute::settings::{FormFactorSettings, Points};
use glam::DVec3;
use scene::{PatchId, Scene, SurfaceId};

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
        assert!(row.is_sorted_by(|a, b| a.source < b.source));
        assert!(
            row.iter()
                .all(|e| e.units > 0.0 && scene.mesh().surface_of(PatchId(e.source)) != own)
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
/// Rows as surfaces in the order of `names` see them: patches that surface k of the scene has are `names[k]`'s.
fn renamed(scene: &Scene, other: &Scene, names: &[usize], rows: &RowBatch) -> RowBatch {
    let patch_of = |patch: u32| {
        let surface = other.mesh().surface_of(PatchId(patch));
        let first = other.mesh().tree(surface).first_patch.0;
        let named = SurfaceId(names[surface.index()] as u32);
        scene.mesh().tree(named).first_patch.0 + patch - first
    };
    let mut sorted = vec![Row::default(); rows.receivers().len()];
    for k in 0..sorted.len() {
        let mut entries: Vec<Entry> = rows.row(k).to_vec();
        for entry in &mut entries {
            entry.source = patch_of(entry.source);
        }
        entries.sort_unstable_by_key(|entry| entry.source);
        sorted[patch_of(k as u32) as usize] = Row {
            entries,
            unseen: rows.unseen(k),
        };
    }
    RowBatch::of(0, sorted)
}

/// Where a ray passes an edge within the margins of both its surfaces, some 4 2^-24 of their distance, it sees the one
/// that comes first. That is 4e-6 of a pixel of 2/30, and of the 2.2 million pixels one in ten has an edge in it: one such
/// ray is expected, more than eight by chance once in a million times.
#[test]
fn the_order_of_surfaces_changes_nothing_but_on_edges() {
    let surfaces = common::shaken(common::furnished_room_surfaces());
    let materials = || vec![common::material(0.5, 0.0), common::material(0.3, 2.0)];
    let scene = common::scene(materials(), surfaces.clone(), 0.2);
    let expected = all_rows(&scene, settings(30, Points::Auto), 2);
    // 7 has no factor in common with the number of surfaces.
    let names: Vec<usize> = (0..surfaces.len())
        .map(|k| 7 * k % surfaces.len())
        .collect();
    let shuffled = names.iter().map(|&k| surfaces[k]).collect();
    let other = common::scene(materials(), shuffled, 0.2);
    let rows = all_rows(&other, settings(30, Points::Auto), 2);
    assert!(rows != expected);
    let rows = renamed(&scene, &other, &names, &rows);
    let count = scene.patch_count() as usize;
    let differing = (0..count)
        .filter(|&k| rows.row(k) != expected.row(k) || rows.unseen(k) != expected.unseen(k));
    let differing = differing.count();
    assert!(count > 200 && differing <= 8, "{differing} of {count}");
}

/// What is behind a pixel does not depend on how finely other surfaces are cut.
#[test]
fn refining_some_surfaces_changes_nothing_that_others_see() {
    let room = common::furnished_room(0.2);
    let depths: Vec<u32> = room.mesh().trees().iter().map(|tree| tree.depth).collect();
    let refined = |extra: u32| {
        let depths = depths.iter().enumerate();
        let depths: Vec<u32> = depths
            .map(|(k, depth)| depth + extra * (k as u32 % 2))
            .collect();
        let (materials, objects) = (room.materials().to_vec(), room.objects().to_vec());
        Scene::new(
            materials,
            objects,
            room.surfaces().to_vec(),
            &depths,
            DVec3::ZERO,
        )
        .unwrap()
    };
    let [coarse, fine] = [refined(0), refined(2)];
    let sums = |scene: &Scene| -> Vec<Vec<Vec<f64>>> {
        let rows = all_rows(scene, settings(30, Points::CENTROID), 2);
        let trees = scene.mesh().trees();
        let even = trees.iter().step_by(2);
        even.map(|tree| {
            let patches = tree.patches();
            patches
                .map(|patch| {
                    let mut sums = vec![0.0; trees.len()];
                    for entry in rows.row(patch as usize) {
                        let surface = scene.mesh().surface_of(PatchId(entry.source));
                        sums[surface.index()] += f64::from(entry.units);
                    }
                    sums
                })
                .collect()
        })
        .collect()
    };
    // Each entry is rounded to 24 bits, so sums of some hundreds of them differ by some 2^-24 of themselves.
    let (coarse, fine) = (sums(&coarse), sums(&fine));
    for (a, b) in coarse.iter().flatten().zip(fine.iter().flatten()) {
        for (a, b) in a.iter().zip(b) {
            assert!((a - b).abs() <= 1e-6 * a, "{a} {b}");
        }
    }
}

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
            .filter(|e| e.source / per_wall == 1)
            .map(|e| f64::from(e.units) / f64::from(UNITS_PER_ONE))
            .sum::<f64>();
    }
    let form_factor = opposite / f64::from(per_wall);
    assert!(
        (form_factor / 0.199_824_895_698 - 1.0).abs() < 1e-3,
        "{form_factor}"
    );
}
