//! Laws of row files: what is read is what was written, whatever happened to the file.

mod rows;

use std::io::{Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process::Command;

use compute::row_file::{BLOCK, Identity, RowFile, RowFileError, RowState, RowWriter};
use proptest::collection::vec;
use proptest::prelude::*;
use serde_json::json;
use tempfile::TempDir;

use rows::*;

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
    assert_eq!(refused(), [true; 3]);
    let names: Vec<_> = std::fs::read_dir(folder.path()).unwrap().collect();
    assert_eq!(names.len(), 1);
}

#[test]
fn a_file_is_gone_when_its_writer_removes_it() {
    let (folder, path) = folder();
    let writer = RowWriter::create(&path, &IDENTITY, u64::MAX).unwrap();
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
