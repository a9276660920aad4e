//! Reading rows, trusting nothing in the file.

use std::fs::File;
use std::io::{self, ErrorKind, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::layout::{
    Header, MAGIC, MAX_IDENTITY_BYTES, RecordHeader, RowRecord, VERSION, checksum,
};
use super::{BLOCK, Identity, RowFileError, RowState, StoredBlock, bits_of, ones, place, rows_in};
use crate::compact_rows::{CompactRows, Stored};
use crate::rows::Unseen;

/// The rows that a file has.
#[derive(Debug)]
pub struct RowFile {
    pub(super) path: PathBuf,
    pub(super) file: File,
    receivers: u32,
    sources: u32,
    /// One per block of receivers.
    blocks: Vec<Block>,
    /// Where the log ends, bytes.
    pub(super) end: u64,
    damaged_records: u64,
}

/// What a file has of a block.
#[derive(Clone, Debug, Default)]
struct Block {
    drawn: u64,
    unlit: u64,
    records: Vec<Record>,
}

/// A record of the log.
#[derive(Clone, Copy, Debug)]
struct Record {
    /// Where its body starts in the file, bytes.
    body: u64,
    header: RecordHeader,
}

impl RowFile {
    /// Opens a file to read rows of this identity; `None` where there is no file.
    ///
    /// # Errors
    /// What [`RowFileError`] has, [`RowFileError::Other`] where the rows are others.
    pub fn open(path: &Path, identity: &Identity) -> Result<Option<Self>, RowFileError> {
        match open_if_any(path, false)? {
            Some(file) => Self::read(path, file, identity).map(Some),
            None => Ok(None),
        }
    }

    /// A file that has been opened, of which nothing is known.
    pub(super) fn read(path: &Path, file: File, identity: &Identity) -> Result<Self, RowFileError> {
        let start = check_header(path, &file, identity)?;
        let mut rows = Self::empty(path, file, identity, start);
        rows.scan()
            .map_err(|source| RowFileError::io(path, "read", source))?;
        Ok(rows)
    }

    /// A file whose log begins at byte `start` and has nothing in it.
    pub(super) fn empty(path: &Path, file: File, identity: &Identity, start: u64) -> Self {
        let blocks = identity.receivers().div_ceil(BLOCK);
        Self {
            path: path.to_owned(),
            file,
            receivers: identity.receivers(),
            sources: identity.sources(),
            blocks: vec![Block::default(); blocks as usize],
            end: start,
            damaged_records: 0,
        }
    }

    /// Goes through the log by its records' headers, up to its end.
    fn scan(&mut self) -> io::Result<()> {
        let file_bytes = self.file.metadata()?.len();
        let mut bytes = [0; size_of::<RecordHeader>()];
        let mut body = self.end + bytes.len() as u64;
        while body <= file_bytes {
            self.read_at(self.end, &mut bytes)?;
            let header: RecordHeader = bytemuck::pod_read_unaligned(&bytes);
            let is_whole = header.is_whole()
                && self.is_possible(&header)
                && header.body_bytes <= file_bytes - body;
            if !is_whole {
                break;
            }
            self.note(header);
            body = self.end + bytes.len() as u64;
        }
        Ok(())
    }

    /// True where a record may be of these receivers.
    fn is_possible(&self, header: &RecordHeader) -> bool {
        let rows = if (header.block as usize) < self.blocks.len() {
            rows_in(header.block, self.receivers)
        } else {
            0
        };
        let fits = (header.drawn | header.unlit) & !bits_of(rows) == 0;
        let least = u64::from(header.drawn.count_ones()) * size_of::<RowRecord>() as u64;
        fits && header.drawn & header.unlit == 0 && header.body_bytes >= least
    }

    /// Takes up the record that is, whole, at the end of the log.
    pub(super) fn note(&mut self, header: RecordHeader) {
        let body = self.end + size_of::<RecordHeader>() as u64;
        self.end = body + header.body_bytes;
        self.blocks[header.block as usize].add(Record { body, header });
    }

    /// How many receivers have rows, drawn or not.
    pub fn receivers(&self) -> u32 {
        self.receivers
    }

    /// How long the log and what comes before it are, bytes.
    pub fn bytes(&self) -> u64 {
        self.end
    }

    /// True where the file has the row of this receiver, as far as is known before it is read.
    pub fn contains(&self, receiver: u32) -> bool {
        let (block, k) = place(receiver);
        self.drawn(block) & 1 << k != 0
    }

    /// How many rows the file has, as far as is known before they are read.
    pub fn row_count(&self) -> u32 {
        let rows = self.blocks.iter().map(|block| block.drawn.count_ones());
        rows.sum()
    }

    /// How many records were damaged, of those that were read.
    pub fn damaged_records(&self) -> u64 {
        self.damaged_records
    }

    /// A bit for each row of a block that is drawn.
    pub(super) fn drawn(&self, block: u32) -> u64 {
        let block = self.blocks.get(block as usize);
        block.map_or(0, |block| block.drawn)
    }

    /// A bit for each row of a block that is drawn or unlit.
    pub(super) fn known(&self, block: u32) -> u64 {
        let block = self.blocks.get(block as usize);
        block.map_or(0, |block| block.drawn | block.unlit)
    }

    /// What the file has of a block; `None` where it has nothing. What is damaged or cannot be read is missing, and
    /// not contained any more.
    pub fn read_block(&mut self, block: u32) -> Option<StoredBlock> {
        let records = std::mem::take(&mut self.blocks.get_mut(block as usize)?.records);
        let mut bodies = Vec::with_capacity(records.len());
        let mut found = Block::default();
        for record in records {
            if let Some(body) = self.body(&record) {
                found.add(record);
                bodies.push(body);
            } else {
                self.damaged_records += 1;
            }
        }
        let count = rows_in(block, self.receivers) as usize;
        let mut rows = vec![Stored::default(); count];
        let mut states = vec![RowState::Missing; count];
        for k in ones(found.unlit) {
            states[k as usize] = RowState::Unlit;
        }
        for (record, body) in found.records.iter().zip(&bodies) {
            for (n, k) in ones(record.header.drawn).enumerate() {
                rows[k as usize] = body.rows.stored(n);
                states[k as usize] = RowState::Drawn(body.unseen[n]);
            }
        }
        let is_there = !found.records.is_empty();
        self.blocks[block as usize] = found;
        is_there.then(|| StoredBlock {
            rows: CompactRows::of_stored(block * BLOCK, &rows),
            states,
        })
    }

    /// The body of a record; `None` where it is damaged.
    fn body(&self, record: &Record) -> Option<Body> {
        // At most the file's size, which a file with holes may have without having the bytes.
        let length = usize::try_from(record.header.body_bytes).ok()?;
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(length).ok()?;
        bytes.resize(length, 0);
        self.read_at(record.body, &mut bytes).ok()?;
        if checksum(&[&bytes]) != record.header.body_checksum {
            return None;
        }
        Body::parse(&bytes, record.header.drawn.count_ones(), self.sources)
    }

    fn read_at(&self, offset: u64, bytes: &mut [u8]) -> io::Result<()> {
        let mut file = &self.file;
        file.seek(SeekFrom::Start(offset))?;
        file.read_exact(bytes)
    }
}

impl Block {
    fn add(&mut self, record: Record) {
        self.drawn |= record.header.drawn;
        self.unlit = (self.unlit | record.header.unlit) & !self.drawn;
        self.records.push(record);
    }
}

/// The rows of a record.
struct Body {
    rows: CompactRows,
    /// One per row.
    unseen: Vec<Unseen>,
}

impl Body {
    /// The body that these bytes are; `None` where they are not `rows` rows with entries of `sources` patches.
    fn parse(bytes: &[u8], rows: u32, sources: u32) -> Option<Self> {
        let (records, rest) = bytes.split_at_checked(rows as usize * size_of::<RowRecord>())?;
        let records: Vec<RowRecord> = bytemuck::pod_collect_to_vec(records);
        let headers: u64 = records.iter().map(|row| u64::from(row.headers)).sum();
        let header_bytes = usize::try_from(headers * size_of::<u32>() as u64).ok()?;
        let (headers, numbers) = rest.split_at_checked(header_bytes)?;
        if !numbers.len().is_multiple_of(size_of::<u16>()) {
            return None;
        }
        let headers: Vec<u32> = bytemuck::pod_collect_to_vec(headers);
        let numbers: Vec<u16> = bytemuck::pod_collect_to_vec(numbers);
        let (mut headers, mut numbers) = (&headers[..], &numbers[..]);
        let mut rows = Vec::with_capacity(records.len());
        for row in &records {
            let (row_headers, row_numbers);
            (row_headers, headers) = headers.split_at_checked(row.headers as usize)?;
            (row_numbers, numbers) = numbers.split_at_checked(row.numbers as usize)?;
            rows.push(Stored::checked(row_headers, row_numbers, sources)?);
            // Shares of one hemisphere, each rounded.
            row.open.checked_add(row.back_face)?;
        }
        let unseen = |row: &RowRecord| Unseen {
            open: row.open,
            back_face: row.back_face,
        };
        numbers.is_empty().then(|| Self {
            rows: CompactRows::of_stored(0, &rows),
            unseen: records.iter().map(unseen).collect(),
        })
    }
}

/// Opens a file that is there, for writing too or not. What is no ordinary file is refused without being opened: a pipe
/// would wait.
pub(super) fn open_if_any(path: &Path, is_written: bool) -> Result<Option<File>, RowFileError> {
    let action = if is_written { "write" } else { "read" };
    let fail = |source| RowFileError::io(path, action, source);
    match path.metadata() {
        Ok(metadata) if metadata.is_file() => {}
        Ok(_) => {
            let path = path.to_owned();
            return Err(RowFileError::Foreign { path });
        }
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(fail(error)),
    }
    let mut options = File::options();
    let file = options.read(true).write(is_written).open(path);
    file.map(Some).map_err(fail)
}

/// True where a file begins as a row file does, or would if it were longer.
pub(super) fn begins_as_rows(file: &File) -> io::Result<bool> {
    let magic = first_bytes(file, MAGIC.len() as u64)?;
    Ok(MAGIC.starts_with(&magic))
}

/// The first bytes of a file, fewer where it ends before.
fn first_bytes(mut file: &File, count: u64) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    file.seek(SeekFrom::Start(0))?;
    file.take(count).read_to_end(&mut bytes)?;
    Ok(bytes)
}

/// Checks that a file has rows of this identity, and says where its log begins, bytes.
fn check_header(path: &Path, file: &File, identity: &Identity) -> Result<u64, RowFileError> {
    const HEADER_BYTES: usize = size_of::<Header>();
    let fail = |source| RowFileError::io(path, "read", source);
    let damaged = |what: String| RowFileError::Damaged {
        path: path.to_owned(),
        what,
    };
    if !begins_as_rows(file).map_err(fail)? {
        let path = path.to_owned();
        return Err(RowFileError::Foreign { path });
    }
    let most = HEADER_BYTES as u64 + u64::from(MAX_IDENTITY_BYTES);
    let bytes = first_bytes(file, most).map_err(fail)?;
    let truncated = || damaged("the file ends within its header".to_owned());
    let (header, rest) = bytes.split_at_checked(HEADER_BYTES).ok_or_else(truncated)?;
    let header: Header = bytemuck::pod_read_unaligned(header);
    if header.version != VERSION {
        return Err(RowFileError::Version {
            path: path.to_owned(),
            found: header.version,
        });
    }
    if header.identity_bytes > MAX_IDENTITY_BYTES {
        return Err(damaged(format!(
            "an identity of {} bytes, more than {MAX_IDENTITY_BYTES}",
            header.identity_bytes
        )));
    }
    let json = rest
        .get(..header.identity_bytes as usize)
        .ok_or_else(truncated)?;
    let expected = Header::new(json).checksum;
    if header.checksum != expected {
        return Err(damaged(format!(
            "checksum {:016x} of its header, expected {expected:016x}",
            header.checksum
        )));
    }
    let found: Identity =
        serde_json::from_slice(json).map_err(|error| damaged(format!("its identity: {error}")))?;
    let differences = found.differences(identity);
    if differences.is_empty() {
        Ok(HEADER_BYTES as u64 + u64::from(header.identity_bytes))
    } else {
        let path = path.to_owned();
        Err(RowFileError::Other { path, differences })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::row_file::identity::tests::of_one_surface;

    /// A file of 2^5 receivers with these records, whose checksums are right, and then a good one: how many rows it
    /// has, and how many of its records are damaged.
    fn read(records: &[(RecordHeader, Vec<u8>)]) -> (u32, u64) {
        let identity = of_one_surface(5);
        let json = identity.to_bytes();
        let mut bytes = [bytemuck::bytes_of(&Header::new(&json)), &json].concat();
        let good = body(RowRecord::default(), &[], &[]);
        let good = (RecordHeader::new(0, 1 << 31, 0, &good), good);
        for (header, body) in records.iter().chain([&good]) {
            bytes.extend_from_slice(bytemuck::bytes_of(header));
            bytes.extend_from_slice(body);
        }
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.rows");
        std::fs::write(&path, bytes).unwrap();
        let mut file = RowFile::open(&path, &identity).unwrap().unwrap();
        file.read_block(0);
        assert!(file.read_block(1).is_none());
        (file.row_count(), file.damaged_records())
    }

    /// A body of one row.
    fn body(row: RowRecord, headers: &[u32], numbers: &[u16]) -> Vec<u8> {
        [
            bytemuck::bytes_of(&row),
            bytemuck::cast_slice(headers),
            bytemuck::cast_slice(numbers),
        ]
        .concat()
    }

    #[test]
    fn wrong_values_with_right_checksums_are_missing() {
        const HEADERS: [u32; 1] = [64 << 24 | 0b11];
        const NUMBERS: [u16; 2] = [5, 6];
        let row = RowRecord {
            headers: 1,
            numbers: 2,
            ..RowRecord::default()
        };
        let of_body = |body: Vec<u8>| read(&[(RecordHeader::new(0, 1, 0, &body), body)]);
        assert_eq!(of_body(body(row, &HEADERS, &NUMBERS)), (2, 0));
        let unseen = RowRecord {
            open: u32::MAX,
            back_face: 1,
            ..row
        };
        let too_many = RowRecord {
            headers: u32::MAX,
            numbers: u32::MAX,
            ..row
        };
        for bad in [
            body(unseen, &HEADERS, &NUMBERS),
            body(too_many, &HEADERS, &NUMBERS),
            body(row, &HEADERS, &NUMBERS[1..]),
            body(row, &HEADERS, &[5, 6, 7]),
            // No such patch, of 32.
            body(row, &[64 << 24 | 2 << 16 | 0b11], &NUMBERS),
            [&body(row, &HEADERS, &NUMBERS)[..], &[0]].concat(),
        ] {
            assert_eq!(of_body(bad), (1, 1));
        }
        // A header that is none ends the log.
        let body = body(row, &HEADERS, &NUMBERS);
        for (block, drawn, unlit) in [
            (1, 1, 0),
            (u32::MAX, 1, 0),
            (0, 1 << 32, 0),
            (0, 1, 1 << 32),
            (0, 1, 1),
            // Rows that the body has no room for.
            (0, 0b11, 0),
        ] {
            let header = RecordHeader::new(block, drawn, unlit, &body);
            assert_eq!(read(&[(header, body.clone())]), (0, 0));
        }
    }

    #[test]
    fn a_length_that_the_file_does_not_have_ends_the_log() {
        for body_bytes in [1 << 20, u64::MAX] {
            let header = RecordHeader {
                body_bytes,
                ..RecordHeader::new(0, 1, 0, &[])
            };
            let header = RecordHeader {
                checksum: header.expected_checksum(),
                ..header
            };
            assert!(header.is_whole());
            assert_eq!(read(&[(header, Vec::new())]), (0, 0));
        }
    }
}
