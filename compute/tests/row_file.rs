//! Laws of row files: what is read is what was written, whatever happened to the file.

use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::LazyLock;

use compute::compact_rows::{CompactRows, Exact};
use compute::row_file::{BLOCK, Identity, RowFile, RowFileError, RowState, RowWriter};
use compute::rows::{Entry, Row, RowBatch, Unseen};
use glam::{DVec3, Vec3};
use proptest::collection::vec;
use proptest::prelude::*;
use scene::file::{FileFault, OutputLock};
use scene::{Material, MaterialId, ObjectId, Rgb, Scene, Surface};
use serde_json::json;
use tempfile::TempDir;

/// Not a whole number of blocks: 2^7 + 2^3.
const RECEIVERS: u32 = 136;
const BLOCKS: u32 = RECEIVERS.div_ceil(BLOCK);

/// More than a block's header can skip: 2^13 + 2^3.
const SOURCES: u32 = 8200;

/// Two surfaces with so many bisections.
fn scene(depths: [u32; 2]) -> Scene {
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
fn scenes() -> [Scene; 2] {
    let scenes = [scene([7, 3]), scene([13, 3])];
    assert_eq!(
        scenes.each_ref().map(Scene::patch_count),
        [RECEIVERS, SOURCES]
    );
    scenes
}

static IDENTITY: LazyLock<Identity> = LazyLock::new(|| {
    let [receivers, sources] = scenes();
    Identity::new(&receivers, &sources, &json!({"resolution": 64}), "cpu")
});

static EXACT: LazyLock<Exact> = LazyLock::new(|| Exact::new(&scenes()[1].patch_emissions()));

/// Rows of all receivers, and what there is of each.
#[derive(Clone, Debug)]
struct Rows {
    /// One per receiver.
    rows: Vec<Row>,
    /// One per receiver.
    states: Vec<RowState>,
}

impl Rows {
    /// The rows of some receivers, as they are kept: empty where they are not drawn.
    fn batch(&self, receivers: std::ops::Range<u32>) -> (CompactRows, &[RowState]) {
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

    fn add(&self, writer: &mut RowWriter, receivers: std::ops::Range<u32>) {
        let (rows, states) = self.batch(receivers);
        writer.add(&rows, states).unwrap();
    }

    /// A file with all of them.
    fn write(&self, path: &Path) {
        let mut writer = RowWriter::create(path, &IDENTITY, u64::MAX).unwrap();
        self.add(&mut writer, 0..RECEIVERS);
        writer.flush().unwrap();
    }

    /// Every row that the file has is this one, bit for bit. Gives the number of rows that are drawn, and panics where
    /// anything is not missing that should be.
    fn check(&self, file: &mut RowFile) -> u32 {
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

    fn drawn(&self) -> u32 {
        let states = self.states.iter();
        states
            .filter(|state| matches!(state, RowState::Drawn(_)))
            .count() as u32
    }
}

/// Empty rows, narrow and wide blocks, gaps of all lengths; some rows are unlit or missing.
fn any_rows() -> impl Strategy<Value = Rows> {
    let gap = prop_oneof![6 => 1..3_u32, 2 => 1..40_u32, 1 => 1..7000_u32];
    let units = prop_oneof![4 => 1.0..1e5_f32, 1 => 1e6..1e9_f32, 1 => 1e-20..1e-3_f32];
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
fn small_rows() -> Rows {
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

fn folder() -> (TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.rad.rows");
    (folder, path)
}

fn open(path: &Path) -> RowFile {
    RowFile::open(path, &IDENTITY).unwrap().unwrap()
}

/// The log of a file, and where it starts, bytes: after 24 of a header, of which the second 4 of 8 are the length of the
/// identity.
fn log(bytes: &[u8]) -> (usize, &[u8]) {
    let start = 24 + u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    (start, &bytes[start..])
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn blocks_do_not_depend_on_the_batches_rows_come_in(
        rows in any_rows(),
        sizes in vec(1..100_u32, 1..20),
    ) {
        let (_folder, path) = folder();
        rows.write(&path);
        let at_once = std::fs::read(&path).unwrap();
        prop_assert_eq!(rows.check(&mut open(&path)), rows.drawn());

        let mut writer = RowWriter::create(&path, &IDENTITY, u64::MAX).unwrap();
        let (mut next, mut sizes) = (0, sizes.iter().cycle());
        while next < RECEIVERS {
            let end = RECEIVERS.min(next + sizes.next().unwrap());
            rows.add(&mut writer, next..end);
            next = end;
        }
        writer.flush().unwrap();
        prop_assert_eq!(rows.check(writer.file()), rows.drawn());
        prop_assert_eq!(std::fs::read(&path).unwrap(), at_once);
    }

    #[test]
    fn rows_of_a_block_may_come_in_any_order_and_more_than_once(
        rows in any_rows(),
        parts in vec((0..RECEIVERS, 1..40_u32, 0..8_u32), 0..40),
    ) {
        let (_folder, path) = folder();
        let mut writer = RowWriter::create(&path, &IDENTITY, u64::MAX).unwrap();
        let mut added = Rows { states: vec![RowState::Missing; RECEIVERS as usize], ..rows.clone() };
        for (first, count, then) in parts {
            let end = RECEIVERS.min(first + count);
            rows.add(&mut writer, first..end);
            let range = first as usize..end as usize;
            added.states[range.clone()].copy_from_slice(&rows.states[range]);
            if then == 0 {
                writer.flush().unwrap();
            } else if then == 1 {
                // As a later run does.
                writer.flush().unwrap();
                drop(writer);
                writer = RowWriter::open(&path, &IDENTITY, u64::MAX).unwrap().unwrap();
            }
        }
        writer.flush().unwrap();
        prop_assert_eq!(added.check(writer.file()), added.drawn());
        drop(writer);
        prop_assert_eq!(open(&path).row_count(), added.drawn());
        prop_assert_eq!(added.check(&mut open(&path)), added.drawn());
    }

    #[test]
    fn logs_one_after_the_other_are_a_merge(rows in any_rows(), middle in 1..RECEIVERS) {
        let (_folder, path) = folder();
        let part = |receivers| {
            let mut writer = RowWriter::create(&path, &IDENTITY, u64::MAX).unwrap();
            rows.add(&mut writer, receivers);
            writer.flush().unwrap();
            drop(writer);
            std::fs::read(&path).unwrap()
        };
        // With some rows in both, and the last ones first.
        let mut merged = part(middle / 2..RECEIVERS);
        merged.extend_from_slice(log(&part(0..middle)).1);
        std::fs::write(&path, merged).unwrap();
        prop_assert_eq!(rows.check(&mut open(&path)), rows.drawn());
    }
}

#[test]
fn rows_that_are_there_are_not_added_again() {
    let (_folder, path) = folder();
    let rows = small_rows();
    rows.write(&path);
    let before = std::fs::read(&path).unwrap();
    let mut writer = RowWriter::open(&path, &IDENTITY, u64::MAX)
        .unwrap()
        .unwrap();
    rows.add(&mut writer, 5..70);
    writer.flush().unwrap();
    assert_eq!(writer.file().bytes(), before.len() as u64);
    drop(writer);
    assert_eq!(std::fs::read(&path).unwrap(), before);
}

#[test]
fn unlit_rows_can_be_drawn_later_and_drawn_ones_stay() {
    let (_folder, path) = folder();
    let drawn = small_rows();
    let unlit = Rows {
        states: vec![RowState::Unlit; RECEIVERS as usize],
        ..drawn.clone()
    };
    unlit.write(&path);
    assert_eq!(unlit.check(&mut open(&path)), 0);
    let mut writer = RowWriter::open(&path, &IDENTITY, u64::MAX)
        .unwrap()
        .unwrap();
    assert_eq!(
        writer.file().read_block(1).unwrap().states,
        [RowState::Unlit; 64]
    );
    drawn.add(&mut writer, 0..RECEIVERS);
    unlit.add(&mut writer, 0..RECEIVERS);
    writer.flush().unwrap();
    assert_eq!(drawn.check(writer.file()), RECEIVERS);
    drop(writer);
    assert_eq!(drawn.check(&mut open(&path)), RECEIVERS);
}

#[test]
fn of_a_file_cut_off_anywhere_whole_records_are_used_and_the_rest_is_replaced() {
    let (_folder, path) = folder();
    let rows = small_rows();
    rows.write(&path);
    let whole = std::fs::read(&path).unwrap();
    let start = log(&whole).0;
    let mut counts = Vec::new();
    for length in 0..=whole.len() {
        std::fs::write(&path, &whole[..length]).unwrap();
        if length < start {
            let error = RowFile::open(&path, &IDENTITY).unwrap_err();
            assert!(matches!(error, RowFileError::Damaged { .. }), "{error}");
            continue;
        }
        counts.push(rows.check(&mut open(&path)));
        let mut writer = RowWriter::open(&path, &IDENTITY, u64::MAX)
            .unwrap()
            .unwrap();
        rows.add(&mut writer, 0..RECEIVERS);
        drop(writer);
        assert_eq!(std::fs::read(&path).unwrap(), whole);
    }
    assert!(counts.is_sorted());
    counts.dedup();
    assert_eq!(counts, [0, BLOCK, 2 * BLOCK, RECEIVERS]);
}

#[test]
fn with_any_bit_changed_no_row_is_another_one() {
    let (_folder, path) = folder();
    let rows = small_rows();
    rows.write(&path);
    let whole = std::fs::read(&path).unwrap();
    let start = log(&whole).0;
    let mut changed = std::fs::File::options().write(true).open(&path).unwrap();
    let mut change = |at: usize, bits: u8| {
        changed.seek(SeekFrom::Start(at as u64)).unwrap();
        changed.write_all(&[whole[at] ^ bits]).unwrap();
    };
    for at in 0..whole.len() {
        for bit in 0..8 {
            change(at, 1 << bit);
            match RowFile::open(&path, &IDENTITY) {
                Ok(file) => {
                    assert!(at >= start);
                    // What was changed is missing, and in its body no more than that.
                    let mut file = file.unwrap();
                    let found = rows.check(&mut file);
                    assert!(found < RECEIVERS);
                    let lost = RECEIVERS - found;
                    assert_eq!(
                        file.damaged_records() == 1,
                        lost <= BLOCK && file.bytes() == whole.len() as u64
                    );
                    assert_eq!(file.row_count(), found);
                }
                Err(RowFileError::Foreign { .. }) => assert!(at < 8),
                Err(RowFileError::Version { .. }) => assert!((8..12).contains(&at)),
                Err(RowFileError::Damaged { .. }) => assert!((12..start).contains(&at)),
                Err(error) => panic!("byte {at}, bit {bit}: {error}"),
            }
        }
        change(at, 0);
    }
}

#[test]
fn rows_that_vanish_while_a_file_is_open_are_missing() {
    let (_folder, path) = folder();
    let rows = small_rows();
    rows.write(&path);
    let mut file = open(&path);
    let shorter = std::fs::metadata(&path).unwrap().len() - 1;
    let other = std::fs::File::options().write(true).open(&path).unwrap();
    other.set_len(shorter).unwrap();
    assert!(file.contains(RECEIVERS - 1));
    assert_eq!(rows.check(&mut file), 2 * BLOCK);
    assert!(!file.contains(RECEIVERS - 1));
    assert_eq!(file.damaged_records(), 1);
}

#[test]
fn rows_of_another_identity_are_refused_by_what_differs() {
    let (_folder, path) = folder();
    small_rows().write(&path);
    let [receivers, sources] = scenes();
    let other = Identity::new(&receivers, &receivers, &json!({"resolution": 100}), "gpu");
    let errors = [
        RowFile::open(&path, &other).unwrap_err(),
        RowWriter::open(&path, &other, u64::MAX).unwrap_err(),
    ];
    for error in errors {
        assert!(matches!(error, RowFileError::Other { .. }));
        assert_eq!(
            error.to_string(),
            format!(
                "{}: its rows are of another run: this one has back end gpu instead of cpu, \
                 resolution 100 instead of 64, other sources (136 instead of 8200)",
                path.display()
            )
        );
    }
    assert_eq!(open(&path).row_count(), RECEIVERS);
    // Who wants other rows there starts anew.
    let other = Identity::new(&sources, &sources, &(), "cpu");
    let mut writer = RowWriter::create(&path, &other, u64::MAX).unwrap();
    assert_eq!(writer.file().row_count(), 0);
    assert_eq!(writer.file().receivers(), SOURCES);
    drop(writer);
    assert!(RowFile::open(&path, &IDENTITY).is_err());
    assert!(RowFile::open(&path, &other).unwrap().is_some());
}

#[test]
fn no_file_is_longer_than_its_limit() {
    let (_folder, path) = folder();
    let rows = small_rows();
    rows.write(&path);
    let whole = std::fs::read(&path).unwrap();
    let mut lengths = Vec::new();
    for limit in log(&whole).0..=whole.len() {
        let mut writer = RowWriter::create(&path, &IDENTITY, limit as u64).unwrap();
        assert!(!writer.is_full());
        rows.add(&mut writer, 0..RECEIVERS);
        writer.flush().unwrap();
        assert_eq!(writer.is_full(), limit < whole.len());
        rows.check(writer.file());
        drop(writer);
        let written = std::fs::read(&path).unwrap();
        assert!(written.len() <= limit && whole.starts_with(&written));
        lengths.push(written.len());
    }
    lengths.dedup();
    assert_eq!(lengths.len(), BLOCKS as usize + 1);
}

#[test]
fn what_is_no_row_file_is_neither_read_nor_replaced() {
    let (folder, path) = folder();
    assert!(RowFile::open(&path, &IDENTITY).unwrap().is_none());
    assert!(
        RowWriter::open(&path, &IDENTITY, u64::MAX)
            .unwrap()
            .is_none()
    );
    std::fs::write(&path, "my list of rows").unwrap();
    let refused = || {
        let results = [
            RowFile::open(&path, &IDENTITY).map(drop),
            RowWriter::open(&path, &IDENTITY, u64::MAX).map(drop),
            RowWriter::create(&path, &IDENTITY, u64::MAX).map(drop),
        ];
        results.map(|result| {
            let error = result.unwrap_err();
            assert!(error.to_string().starts_with(&path.display().to_string()));
            matches!(error, RowFileError::Foreign { .. })
        })
    };
    assert_eq!(refused(), [true; 3]);
    assert_eq!(std::fs::read(&path).unwrap(), b"my list of rows");
    std::fs::remove_file(&path).unwrap();
    #[cfg(unix)]
    {
        // By a link: a failure must not destroy the machine's device. A pipe would wait for ever.
        std::os::unix::fs::symlink("/dev/full", &path).unwrap();
        assert_eq!(refused(), [true; 3]);
        std::fs::remove_file(&path).unwrap();
        let made = Command::new("mkfifo").arg(&path).status();
        if made.is_ok_and(|status| status.success()) {
            assert_eq!(refused(), [true; 3]);
            std::fs::remove_file(&path).unwrap();
        }
    }
    std::fs::create_dir(&path).unwrap();
    // A writer does not come further than the lock.
    assert_eq!(refused(), [true, false, false]);
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(names.len(), 1);
}

#[test]
fn a_file_has_one_writer_and_is_gone_when_that_removes_it() {
    let (folder, path) = folder();
    let writer = RowWriter::create(&path, &IDENTITY, u64::MAX).unwrap();
    let others = [
        RowWriter::create(&path, &IDENTITY, u64::MAX).map(drop),
        RowWriter::open(&path, &IDENTITY, u64::MAX).map(drop),
        OutputLock::acquire(&path).map(drop).map_err(Into::into),
    ];
    for other in others {
        assert!(
            matches!(&other, Err(RowFileError::File(error)) if matches!(error.fault, FileFault::Locked { .. })),
            "{other:?}"
        );
    }
    writer.remove().unwrap();
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_missing_folder_is_an_error() {
    let (folder, _) = folder();
    let path = folder.path().join("none/a.rad.rows");
    let error = RowWriter::create(&path, &IDENTITY, u64::MAX).unwrap_err();
    assert!(error.to_string().contains("cannot write"), "{error}");
}

/// A file system of 64 KiB for one test, unmounted at its end.
struct SmallDisk {
    folder: TempDir,
}

impl SmallDisk {
    /// `None`, reported as a skip, where mounting is not allowed.
    fn mount() -> Option<Self> {
        let folder = tempfile::tempdir().unwrap();
        let status = Command::new("mount")
            .args(["-t", "tmpfs", "-o", "size=64k", "tmpfs"])
            .arg(folder.path())
            .output();
        if status.is_ok_and(|output| output.status.success()) {
            Some(Self { folder })
        } else {
            eprintln!("skipped: mounting a file system needs more rights");
            None
        }
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        Command::new("umount").arg(self.folder.path()).status().ok();
    }
}

#[test]
fn a_full_disk_is_one_error_and_leaves_what_was_there() {
    let Some(disk) = SmallDisk::mount() else {
        return;
    };
    let path = disk.folder.path().join("a.rad.rows");
    let mut rows = small_rows();
    // The second block does not fit: 64 rows of 1000 numbers.
    for row in &mut rows.rows[BLOCK as usize..] {
        let entry = |source| Entry { source, units: 9.0 };
        row.entries = (0..1000).map(entry).collect();
    }
    let mut writer = RowWriter::create(&path, &IDENTITY, u64::MAX).unwrap();
    rows.add(&mut writer, 0..BLOCK);
    let before = std::fs::read(&path).unwrap();
    let (all, states) = rows.batch(0..RECEIVERS);
    let error = writer.add(&all, states).unwrap_err();
    assert!(
        matches!(&error, RowFileError::File(error)
            if matches!(&error.fault, FileFault::Io { source, .. } if source.kind() == std::io::ErrorKind::StorageFull)),
        "{error}"
    );
    writer.add(&all, states).unwrap();
    writer.flush().unwrap();
    assert!(!writer.is_full());
    assert_eq!(rows.check(writer.file()), BLOCK);
    drop(writer);
    assert_eq!(std::fs::read(&path).unwrap(), before);
    assert_eq!(rows.check(&mut open(&path)), BLOCK);
}
