//! Adding rows to a file.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;

use super::layout::Header;
use super::pending::Pending;
use super::read::{begins_as_rows, open_if_any};
use super::{Identity, RowFile, RowFileError, RowState, bits_of, place, rows_in};
use crate::compact_rows::CompactRows;

/// Rows that wait for the others of their blocks take at most about this, bytes: shooting asks for rows here and there,
/// and parts of blocks are then written as they are. Not tuned: small beside what a run takes otherwise.
const MOST_PENDING_BYTES: u64 = 64 << 20;

/// A file that rows are added to, by who holds the lock of the output that it is beside ([`scene::file::OutputLock`]).
///
/// A row is written when all of its block are there, or with [`Self::flush`], or when many wait; what waits when this is
/// dropped is lost. After an error nothing is written any more, and what was written stays.
#[derive(Debug)]
pub struct RowWriter {
    file: RowFile,
    limit_bytes: u64,
    pending: Pending,
    room: Room,
}

/// Whether rows can be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Room {
    Some,
    /// No: a record would have made the file longer than it may be.
    None,
    /// No: the file could not be written.
    Failed,
}

impl RowWriter {
    /// Makes a file without rows, of at most so many bytes once it has any. Another row file of the name is replaced.
    ///
    /// # Errors
    /// [`RowFileError::File`] and [`RowFileError::Foreign`].
    pub fn create(
        path: &Path,
        identity: &Identity,
        limit_bytes: u64,
    ) -> Result<Self, RowFileError> {
        let fail = |source| RowFileError::io(path, "write", source);
        let file = match open_if_any(path, true)? {
            Some(file) if begins_as_rows(&file).map_err(fail)? => file,
            Some(_) => {
                let path = path.to_owned();
                return Err(RowFileError::Foreign { path });
            }
            None => File::options()
                .read(true)
                .write(true)
                .create_new(true)
                .open(path)
                .map_err(fail)?,
        };
        let json = identity.to_bytes();
        let header = [bytemuck::bytes_of(&Header::new(&json)), &json].concat();
        file.set_len(0)
            .and_then(|()| write_at(&file, 0, &header))
            .map_err(|source| {
                // Nobody can use it.
                std::fs::remove_file(path).ok();
                fail(source)
            })?;
        let file = RowFile::empty(path, file, identity, header.len() as u64);
        Ok(Self::new(file, limit_bytes))
    }

    /// Opens a file to add rows of the same identity, and takes away what a killed program has left of a record;
    /// `None` where there is no file.
    ///
    /// # Errors
    /// As [`RowFile::open`].
    pub fn open(
        path: &Path,
        identity: &Identity,
        limit_bytes: u64,
    ) -> Result<Option<Self>, RowFileError> {
        let Some(file) = open_if_any(path, true)? else {
            return Ok(None);
        };
        let rows = RowFile::read(path, file, identity)?;
        rows.file
            .set_len(rows.end)
            .map_err(|source| RowFileError::io(path, "write", source))?;
        Ok(Some(Self::new(rows, limit_bytes)))
    }

    fn new(file: RowFile, limit_bytes: u64) -> Self {
        Self {
            file,
            limit_bytes,
            pending: Pending::default(),
            room: Room::Some,
        }
    }

    /// The rows that have been written, to be read.
    pub fn file(&mut self) -> &mut RowFile {
        &mut self.file
    }

    /// True where the row of this receiver has been written.
    pub fn contains(&self, receiver: u32) -> bool {
        self.file.contains(receiver)
    }

    /// True once a row was left out because of the limit.
    pub fn is_full(&self) -> bool {
        self.room == Room::None
    }

    /// Adds the rows of a batch that are not there yet; `states` has one element per row.
    ///
    /// # Errors
    /// Where the file cannot be written, once; after that nothing is done.
    ///
    /// # Panics
    /// Where there are not as many states as rows, or a receiver is none of the file's.
    pub fn add(&mut self, rows: &CompactRows, states: &[RowState]) -> Result<(), RowFileError> {
        let receivers = rows.receivers();
        assert_eq!(states.len(), receivers.len());
        assert!(receivers.end <= self.file.receivers());
        if self.room != Room::Some || receivers.is_empty() {
            return Ok(());
        }
        for (k, (receiver, &state)) in receivers.clone().zip(states).enumerate() {
            let (block, place) = place(receiver);
            let there = match state {
                RowState::Missing => u64::MAX,
                RowState::Unlit => self.file.known(block),
                RowState::Drawn(_) => self.file.drawn(block),
            };
            if there & 1 << place == 0 {
                self.pending.add(receiver, rows.stored(k), state);
            }
        }
        for block in place(receivers.start).0..=place(receivers.end - 1).0 {
            let waiting = self.pending.bits(block);
            let all = bits_of(rows_in(block, self.file.receivers()));
            if waiting != 0 && waiting | self.file.known(block) == all {
                self.write(block)?;
            }
        }
        if self.pending.bytes() > MOST_PENDING_BYTES {
            self.flush()?;
        }
        Ok(())
    }

    /// Writes what waits for other rows.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub fn flush(&mut self) -> Result<(), RowFileError> {
        while let Some(block) = self.pending.first() {
            self.write(block)?;
        }
        Ok(())
    }

    /// Removes the file.
    ///
    /// # Errors
    /// Where that cannot be.
    pub fn remove(self) -> Result<(), RowFileError> {
        let Self { file, .. } = self;
        let path = file.path.clone();
        // Not every system removes what is open.
        drop(file);
        std::fs::remove_file(&path).map_err(|source| RowFileError::io(&path, "remove", source))
    }

    /// Writes what waits of a block.
    fn write(&mut self, block: u32) -> Result<(), RowFileError> {
        let (header, record) = self.pending.take(block).record(block);
        if record.len() as u64 > self.limit_bytes.saturating_sub(self.file.end) {
            self.give_up(Room::None);
            return Ok(());
        }
        if let Err(source) = write_at(&self.file.file, self.file.end, &record) {
            self.give_up(Room::Failed);
            // Who reads it would find the end of the log all the same.
            self.file.file.set_len(self.file.end).ok();
            return Err(RowFileError::io(&self.file.path, "write", source));
        }
        self.file.note(header);
        Ok(())
    }

    fn give_up(&mut self, room: Room) {
        self.room = room;
        self.pending = Pending::default();
    }
}

fn write_at(mut file: &File, offset: u64, bytes: &[u8]) -> io::Result<()> {
    file.seek(SeekFrom::Start(offset))?;
    file.write_all(bytes)
}

#[cfg(test)]
mod tests {
    use scene::Rgb;

    use super::*;
    use crate::compact_rows::Exact;
    use crate::row_file::identity::tests::of_one_surface;
    use crate::rows::{Entry, Row, RowBatch, Unseen};

    /// The rows of a block of 2^8 patches, and their states.
    fn block(block: u32) -> (CompactRows, Vec<RowState>) {
        let row = |k| Row {
            entries: vec![Entry {
                source: k,
                units: 5.0,
            }],
            ..Row::default()
        };
        let batch = RowBatch::of(block * 64, (0..64).map(row).collect());
        let rows = CompactRows::encode(&batch, &Exact::new(&[Rgb::ZERO; 256]));
        (rows, vec![RowState::Drawn(Unseen::default()); 64])
    }

    #[test]
    fn what_cannot_be_written_is_one_error_and_leaves_what_was_there() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.rad.rows");
        let mut writer = RowWriter::create(&path, &of_one_surface(8), u64::MAX).unwrap();
        let (rows, states) = block(1);
        writer.add(&rows, &states).unwrap();
        let before = std::fs::read(&path).unwrap();
        // Nothing can be written by way of a file that was opened to be read.
        writer.file.file = File::open(&path).unwrap();
        let (rows, states) = block(0);
        let error = writer.add(&rows, &states).unwrap_err().to_string();
        assert!(
            error.starts_with(&format!("{}: cannot write: ", path.display())),
            "{error}"
        );
        writer.add(&rows, &states).unwrap();
        writer.flush().unwrap();
        assert!(!writer.is_full());
        assert!(writer.file().read_block(0).is_none());
        assert!(writer.file().read_block(1).is_some());
        drop(writer);
        assert_eq!(std::fs::read(&path).unwrap(), before);
    }

    #[test]
    fn rows_do_not_wait_without_end() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.rad.rows");
        let mut writer = RowWriter::create(&path, &of_one_surface(8), u64::MAX).unwrap();
        let (rows, mut states) = block(2);
        states[9] = RowState::Missing;
        writer.add(&rows, &states).unwrap();
        assert_eq!(writer.file().row_count(), 0);
        // 16 bytes, one block's header and one number.
        assert_eq!(writer.pending.bytes(), 63 * 22);
        writer.flush().unwrap();
        assert_eq!(writer.file().row_count(), 63);
        assert_eq!(writer.pending.bytes(), 0);
    }
}
