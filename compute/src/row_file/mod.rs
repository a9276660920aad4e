//! A file of form factor rows beside a solution, so that a run that goes on need not draw them again.
//!
//! Rows are what a run costs, and a checkpoint has none of them. `solved.rad` has its rows in `solved.rad.rows`, see
//! [`path_beside`]: a header that says what the rows are of, then a log of records. Each record has rows of one
//! *block*, [`BLOCK`] consecutive receivers, in the form in which they are kept ([`crate::compact_rows`]).
//!
//! # Layout
//! Everything is little-endian. `layout.rs` has the records field by field.
//!
//! | part | bytes | what it is |
//! |---|---|---|
//! | header | 24 | magic, version, length of the identity, checksum of both |
//! | identity | given | JSON of [`Identity`]: everything that decides the rows |
//! | records | to the end | the log |
//!
//! A record stands for itself: it says neither where in the file it is nor whose it is.
//!
//! | part of a record | bytes | what it is |
//! |---|---|---|
//! | header | 48 | magic, block, a bit for each row that is drawn and for each that is unlit, length and checksum of the body, checksum of the header |
//! | rows | 16 each | of each drawn row: its [`Unseen`], how many block headers and numbers it has |
//! | block headers | 4 each | of all drawn rows |
//! | numbers | 2 each | of all drawn rows |
//!
//! # Laws
//! - *Records add up.* A row is [drawn](RowState::Drawn) if any record of its block has it, else unlit if any
//!   says so, else missing. A drawn row is the same in all records, since the header names what decides it, so
//!   their order is of no importance, and a block may come in parts: what is added later is what is new.
//! - *Rows are stored row by row*: a record depends on its rows alone, not on the batches they were drawn
//!   in, nor on threads.
//! - *The log ends at the first record that is not whole*, where a program was killed while it wrote, or whose header
//!   is damaged. What comes before it is used; who writes next takes the rest away.
//! - *A record whose body is damaged* is as if it were not there. That is told when it is read: to open a file
//!   reads the headers alone.
//! - *Unlit* says that a run did not need the row, not that the row is empty: a reader for whom the patch
//!   is not unlit must draw it.
//!
//! # Merging
//! Since records stand for themselves and add up, the logs of several files with equal identities, one after the other
//! behind one header, are a file with all their rows. Parts of a scene that several machines have drawn need nothing
//! else; those whose bounds are multiples of [`BLOCK`] share no block.
//!
//! # Safety of what is on disk
//! Nothing in a file is trusted: sizes are checked before anything is allocated, values before they are used. A file is
//! not synced, since a checksum covers every byte: what a power cut takes is drawn again. A file that cannot be
//! written costs an error, which is a warning to a run, and nothing is written any more; what is there stays.
//! What does not begin as a row file is never replaced.
//!
//! # In a run
//! [`StoredRows`] is what [`crate::row_cache`] asks: it finds the rows beside the input and beside the output, and keeps
//! those that are drawn beside the output. Files are of the rows that iterations need again and again; those by which
//! patches gather once from coarser sources are in none.

mod identity;
mod layout;
mod pending;
mod read;
mod store;
mod write;

use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};

use scene::file::{FileError, FileFault};

pub use identity::Identity;
pub use read::RowFile;
pub use store::{RowFileRemark, RowFiles, StoredRows, remove};
pub use write::RowWriter;

use crate::compact_rows::CompactRows;
use crate::rows::Unseen;

/// Receivers in a block: their bits make one number. A block of a large scene has some megabytes.
pub const BLOCK: u32 = u64::BITS;

/// What a file has of a row.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RowState {
    /// Nothing.
    #[default]
    Missing,
    /// That it was left out, since no light could reach the receiver, see [`crate::unlit`].
    Unlit,
    /// The row, and what the receiver does not see as patches.
    Drawn(Unseen),
}

/// A block as a file has it.
#[derive(Clone, Debug)]
pub struct StoredBlock {
    /// Of all receivers of the block; empty where they are not drawn.
    pub rows: CompactRows,
    /// One per row.
    pub states: Vec<RowState>,
}

/// The name of the file with the rows of `output`; `None` where that is a device or a pipe, which has nothing beside it.
pub fn path_beside(output: &Path) -> Option<PathBuf> {
    if output.metadata().is_ok_and(|metadata| !metadata.is_file()) {
        return None;
    }
    let mut name = OsString::from(output.file_name()?);
    name.push(".rows");
    Some(output.with_file_name(name))
}

/// Why a row file is not used, or not written any more.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum RowFileError {
    #[error(transparent)]
    File(#[from] FileError),
    #[error(
        "{}: not a file of form factor rows (it does not start with {:?}), so it is neither read nor replaced; move it away or choose another output",
        path.display(),
        layout::MAGIC_TEXT
    )]
    Foreign { path: PathBuf },
    #[error(
        "{}: version {found} of row files is not supported, this program reads {}",
        path.display(),
        layout::VERSION
    )]
    Version { path: PathBuf, found: u32 },
    #[error("{}: damaged: {what}", path.display())]
    Damaged { path: PathBuf, what: String },
    #[error(
        "{}: its rows are of another run: this one has {}",
        path.display(),
        differences.join(", ")
    )]
    Other {
        path: PathBuf,
        differences: Vec<String>,
    },
}

impl RowFileError {
    fn io(path: &Path, action: &'static str, source: io::Error) -> Self {
        let (path, fault) = (path.to_owned(), FileFault::Io { action, source });
        Self::File(FileError { path, fault })
    }
}

/// The block that a receiver is in, and its place there.
fn place(receiver: u32) -> (u32, u32) {
    (receiver / BLOCK, receiver % BLOCK)
}

/// How many receivers a block has, of `receivers`.
fn rows_in(block: u32, receivers: u32) -> u32 {
    receivers.saturating_sub(block * BLOCK).min(BLOCK)
}

/// The bits of so many rows, [`BLOCK`] at most.
fn bits_of(rows: u32) -> u64 {
    u64::MAX.checked_shr(BLOCK - rows).unwrap_or(0)
}

/// The numbers of the bits that are set, ascending.
fn ones(mut bits: u64) -> impl Iterator<Item = u32> {
    std::iter::from_fn(move || {
        let first = bits.trailing_zeros();
        (bits != 0).then(|| {
            bits &= bits - 1;
            first
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_are_those_of_the_blocks_rows() {
        assert_eq!([bits_of(0), bits_of(3), bits_of(64)], [0, 7, u64::MAX]);
        assert_eq!([0, 1, 2].map(|block| rows_in(block, 130)), [64, 64, 2]);
        assert_eq!(
            ones(1 << 63 | 0b1010).collect::<Vec<_>>(),
            [1, 3, BLOCK - 1]
        );
        assert_eq!(place(130), (2, 2));
    }

    #[test]
    fn rows_lie_beside_a_file_and_nowhere_else() {
        let folder = tempfile::tempdir().unwrap();
        let output = folder.path().join("a.b.rad");
        let beside = folder.path().join("a.b.rad.rows");
        assert_eq!(path_beside(&output), Some(beside.clone()));
        std::fs::write(&output, "").unwrap();
        assert_eq!(path_beside(&output), Some(beside));
        assert_eq!(path_beside(folder.path()), None);
        assert_eq!(path_beside(Path::new("a")), Some("a.rows".into()));
        #[cfg(unix)]
        assert_eq!(path_beside(Path::new("/dev/null")), None);
    }
}
