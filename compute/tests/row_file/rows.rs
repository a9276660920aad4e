//! Rows to be written and read, of two surfaces.

use std::path::Path;
use std::sync::LazyLock;

use compute::compact_rows::{CompactRows, Exact};
use compute::row_file::{BLOCK, Identity, RowFile, RowState, RowWriter};
use compute::rows::{Entry, Row, RowBatch, Unseen};
use glam::{DVec3, Vec3};
use proptest::collection::vec;
use proptest::prelude::*;
use scene::{Material, MaterialId, ObjectId, Rgb, Scene, Surface};
use serde_json::json;

/// Not a whole number of blocks: 2^7 + 2^3.
pub const RECEIVERS: u32 = 136;
pub const BLOCKS: u32 = RECEIVERS.div_ceil(BLOCK);

/// More than a block's header can skip: 2^13 + 2^3.
pub const SOURCES: u32 = 8200;

/// Two surfaces with so many bisections.
pub fn scene(depths: [u32; 2]) -> Scene {
    let material = |emission| Material {
        name: String::new(),
        reflectance: Rgb::splat(0.5),
        emission,
    };
    let surface = |k: u32| {
        let z = k as f32;
        Surface {
            corners: [
                Vec3::new(1.0, 0.0, z),
                Vec3::new(0.0, 1.0, z),
                Vec3::new(0.0, 0.0, z),
            ],
            material: MaterialId(k),
            object: ObjectId(0),
        }
    };
    Scene::new(
        vec![material(Rgb::ZERO), material(Rgb::ONE)],
        vec![String::new()],
        vec![surface(0), surface(1)],
        &depths,
        DVec3::ZERO,
    )
    .unwrap()
}

/// The scenes of receivers and of sources.
pub fn scenes() -> [Scene; 2] {
    let scenes = [scene([7, 3]), scene([13, 3])];
    assert_eq!(
        scenes.each_ref().map(Scene::patch_count),
        [RECEIVERS, SOURCES]
    );
    scenes
}

pub static IDENTITY: LazyLock<Identity> = LazyLock::new(|| {
    let [receivers, sources] = scenes();
    Identity::new(&receivers, &sources, &json!({"resolution": 64}), "cpu")
});

pub static EXACT: LazyLock<Exact> = LazyLock::new(|| Exact::new(&scenes()[1].patch_emissions()));

/// Rows of all receivers, and what there is of each.
#[derive(Clone, Debug)]
pub struct Rows {
    /// One per receiver.
    pub rows: Vec<Row>,
    /// One per receiver.
    pub states: Vec<RowState>,
}

impl Rows {
    /// The rows of some receivers, as they are kept: empty where they are not drawn.
    pub fn batch(&self, receivers: std::ops::Range<u32>) -> (CompactRows, &[RowState]) {
        let range = receivers.start as usize..receivers.end as usize;
        let rows = self.rows[range.clone()]
            .iter()
            .zip(&self.states[range.clone()]);
        let rows = rows.map(|(row, state)| match state {
            RowState::Drawn(_) => row.clone(),
            _ => Row::default(),
        });
        let batch = RowBatch::of(receivers.start, rows.collect());
        (CompactRows::encode(&batch, &EXACT), &self.states[range])
    }

    pub fn add(&self, writer: &mut RowWriter, receivers: std::ops::Range<u32>) {
        let (rows, states) = self.batch(receivers);
        writer.add(&rows, states).unwrap();
    }

    /// A file with all of them.
    pub fn write(&self, path: &Path) {
        let mut writer = RowWriter::create(path, &IDENTITY, u64::MAX).unwrap();
        self.add(&mut writer, 0..RECEIVERS);
        writer.flush().unwrap();
    }

    /// Every row that the file has is this one, bit for bit. Gives the number of rows that are drawn, and panics where
    /// anything is not missing that should be.
    pub fn check(&self, file: &mut RowFile) -> u32 {
        let mut drawn = 0;
        for block in 0..BLOCKS {
            let receivers = block * BLOCK..RECEIVERS.min((block + 1) * BLOCK);
            let Some(found) = file.read_block(block) else {
                assert!(receivers.clone().all(|receiver| !file.contains(receiver)));
                continue;
            };
            let (expected, states) = self.batch(receivers.clone());
            assert_eq!(found.rows.receivers(), receivers);
            assert_eq!(found.states.len(), states.len());
            for (k, receiver) in receivers.enumerate() {
                let is_drawn = matches!(found.states[k], RowState::Drawn(_));
                assert_eq!(file.contains(receiver), is_drawn);
                if found.states[k] != RowState::Missing {
                    assert_eq!(found.states[k], states[k]);
                }
                if is_drawn {
                    assert_eq!(found.rows.stored(k), expected.stored(k));
                    drawn += 1;
                } else {
                    assert_eq!(found.rows.row(k).into_iter().next(), None);
                }
            }
        }
        drawn
    }

    pub fn drawn(&self) -> u32 {
        let states = self.states.iter();
        states
            .filter(|state| matches!(state, RowState::Drawn(_)))
            .count() as u32
    }
}

/// Empty rows, narrow and wide blocks, gaps of all lengths; some rows are unlit or missing. No row has more than a file may
/// have of it, two hemispheres of 2^32 units.
pub fn any_rows() -> impl Strategy<Value = Rows> {
    let gap = prop_oneof![6 => 1..3_u32, 2 => 1..40_u32, 1 => 1..7000_u32];
    let units = prop_oneof![4 => 1.0..1e5_f32, 1 => 1e6..2e8_f32, 1 => 1e-20..1e-3_f32];
    let row = vec((gap, units), 0..30).prop_map(|steps| {
        let mut patch = 0;
        let entries = steps.into_iter().map(|(gap, units)| {
            patch += gap;
            Entry {
                source: patch - 1,
                units,
            }
        });
        Row {
            entries: entries.take_while(|e| e.source < SOURCES).collect(),
            ..Row::default()
        }
    });
    let state = prop_oneof![
        8 => (0..1_u32 << 31, 0..1_u32 << 31).prop_map(|(open, back_face)| RowState::Drawn(Unseen { open, back_face })),
        1 => Just(RowState::Unlit),
        1 => Just(RowState::Missing),
    ];
    let count = RECEIVERS as usize;
    (vec(row, count), vec(state, count)).prop_map(|(rows, states)| Rows { rows, states })
}

/// Rows that are all drawn, of a few entries.
pub fn small_rows() -> Rows {
    let row = |i: u32| Row {
        entries: (0..i % 3)
            .map(|k| Entry {
                source: i + 2000 * k,
                units: (i * 1000 + k + 1) as f32,
            })
            .collect(),
        ..Row::default()
    };
    let state = |i: u32| {
        RowState::Drawn(Unseen {
            open: i,
            back_face: 2 * i,
        })
    };
    Rows {
        rows: (0..RECEIVERS).map(row).collect(),
        states: (0..RECEIVERS).map(state).collect(),
    }
}
