//! Rows are the sums of what is seen, whatever they are drawn together with.

use compute::delta_form_factors::DeltaFormFactors;
use compute::hemicubes::Hemicubes;
use compute::receivers::ReceiverId;
use compute::rows::{Entry, RowBatch, RowSource, UNITS_PER_ONE, Unseen};
use compute::settings::{FormFactorSettings, Maps, Points};
use scene::Scene;
use visibility::item_buffer::{BACK_FACE, NOTHING};

use crate::model::{room, room_with_boxes_at, ruin};
use crate::{open, settings};

/// The row that item buffers and delta form factors make, summed here.
fn row_on_host(
    scene: &Scene,
    settings: FormFactorSettings,
    item_buffers: &[Vec<u32>],
) -> (Vec<Entry>, Unseen) {
    let factors = DeltaFormFactors::new(
        settings.maps,
        settings.resolution,
        UNITS_PER_ONE / item_buffers.len() as u32,
    );
    let table: Vec<u32> = (0..5)
        .flat_map(|face| factors.face(face))
        .copied()
        .collect();
    let mut units = vec![0_u32; scene.patch_count() as usize];
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
        .map(|(patch, units)| Entry {
            source: patch,
            units: units as f32,
        })
        .collect();
    (entries, unseen)
}

/// Draws rows and sums them again from the gpu's own item buffers.
fn assert_rows_are_their_item_buffers_sums(
    scene: &Scene,
    settings: FormFactorSettings,
    patches: std::ops::Range<u32>,
) {
    let mut gpu = open(scene, settings);
    let rows = gpu.draw_rows(patches.clone()).unwrap();
    assert_eq!(rows.receivers(), patches);
    for (k, patch) in patches.enumerate() {
        let item_buffers: Vec<_> = Hemicubes::new(scene, settings)
            .receivers()
            .frames(ReceiverId(patch))
            .iter()
            .map(|frame| gpu.item_buffer(ReceiverId(patch), frame).unwrap())
            .collect();
        let (entries, unseen) = row_on_host(scene, settings, &item_buffers);
        let different = rows.row(k).iter().zip(&entries).find(|(a, b)| a != b);
        assert_eq!(different, None, "patch {patch}");
        assert_eq!(rows.row(k).len(), entries.len(), "patch {patch}");
        assert_eq!(rows.unseen(k), unseen, "patch {patch}");
    }
}

pub fn rows_are_the_sums_of_their_item_buffers_to_the_bit() {
    let scene = ruin().scene(0.05);
    for (resolution, points, maps) in [
        (2, Points::CENTROID, Maps::Exact),
        (100, Points::CENTROID, Maps::Exact),
        (128, Points::Vertices, Maps::Exact),
        (50, Points::Bisected { bisections: 4 }, Maps::Thesis),
        (64, Points::Auto, Maps::Exact),
    ] {
        let settings = FormFactorSettings {
            points,
            maps,
            ..FormFactorSettings::new(resolution)
        };
        let first = scene.patch_count() / 2;
        assert_rows_are_their_item_buffers_sums(&scene, settings, first..first + 6);
    }
}

/// A tile of it is more than the budget of an atlas, and its picture is taller than any texture.
pub fn a_hemicube_larger_than_a_texture_is_drawn_in_parts() {
    let scene = ruin().scene(0.5);
    assert_rows_are_their_item_buffers_sums(&scene, settings(3000), 3..4);
}

/// Rows over several blocks and workgroups, with gaps between their entries.
pub fn rows_of_half_a_million_patches_are_complete() {
    let scene = ruin().scene(1.2e-4);
    assert!(
        (300_000..1_000_000).contains(&scene.patch_count()),
        "{}",
        scene.patch_count()
    );
    let first = scene.patch_count() - 3;
    assert_rows_are_their_item_buffers_sums(&scene, settings(100), first..first + 3);
}

pub fn closed_room_sees_itself_completely() {
    let mut empty = room();
    empty.triangles.truncate(12);
    for model in [empty, room_with_boxes_at(0.01)] {
        let scene = model.scene(0.1);
        for points in [Points::CENTROID, Points::Vertices] {
            let settings = FormFactorSettings {
                points,
                ..settings(100)
            };
            let mut gpu = open(&scene, settings);
            let rows = gpu.draw_rows(0..scene.patch_count()).unwrap();
            for k in 0..rows.receivers().len() {
                assert_eq!(rows.unseen(k), Unseen::default(), "{points}, patch {k}");
                let sum: f64 = rows.row(k).iter().map(|e| f64::from(e.units)).sum();
                // Each entry is rounded to half of 2^-24 of itself.
                let error = sum / f64::from(UNITS_PER_ONE) - 1.0;
                assert!(error.abs() < 6e-8, "{points}, patch {k}: {error}");
                assert!(
                    rows.row(k).is_sorted_by(|a, b| a.source < b.source),
                    "{points}, patch {k}"
                );
            }
        }
    }
}

pub fn rows_depend_on_no_batch_size_and_on_no_run() {
    let scene = ruin().scene(0.05);
    let mut gpu = open(&scene, settings(100));
    let all = gpu.draw_rows(0..40).unwrap();
    for size in [1, 7, 40] {
        let mut again = RowBatch::new(0);
        for start in (0..40).step_by(size) {
            let end = (start + size as u32).min(40);
            again.append(gpu.draw_rows(start..end).unwrap());
        }
        assert!(again == all, "in batches of {size}");
    }
    let mut other = open(&scene, settings(100));
    assert!(other.draw_rows(0..40).unwrap() == all, "in another run");
    assert!(other.preferred_batch() >= 1);
    assert!(
        other.describe().starts_with("gpu, "),
        "{}",
        other.describe()
    );
}

pub fn no_rows_are_asked_for_and_none_come() {
    let scene = room().scene(f64::INFINITY);
    let mut gpu = open(&scene, settings(2));
    assert_eq!(gpu.draw_rows(5..5).unwrap(), RowBatch::new(5));
}
