//! The rows of a run in files: those that were drawn before are found, those that are drawn now are kept.

use std::fmt::{Display, Formatter};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use scene::file::is_same_file;

use super::read::{begins_as_rows, open_if_any};
use super::{
    Identity, RowFile, RowFileError, RowState, RowWriter, StoredBlock, path_beside, place,
};
use crate::compact_rows::CompactRows;
use crate::quantity::show_size;

/// Where a run looks for rows, and where it keeps its own.
#[derive(Clone, Debug)]
pub struct RowFiles {
    /// Beside the output: read, and written.
    path: PathBuf,
    /// Beside the input, where that is another file: read.
    also: Option<PathBuf>,
    limit_bytes: u64,
    start: Instant,
    after: Duration,
}

/// Rows of one identity in files. Whatever goes wrong there costs a remark and no more.
#[derive(Debug)]
pub struct StoredRows {
    files: RowFiles,
    identity: Identity,
    own: Option<Own>,
    also: Option<RowFile>,
    /// Whether the output's file is still to be opened for writing.
    is_to_be_written: bool,
    is_full_told: bool,
    is_damage_told: bool,
    remarks: Vec<RowFileRemark>,
    duration: Duration,
}

/// The output's file.
#[derive(Debug)]
enum Own {
    Read(RowFile),
    Written(RowWriter),
}

/// What a user should know of files of rows, as a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum RowFileRemark {
    /// Why rows that are there are drawn all the same.
    NotUsed(String),
    /// Why rows that are drawn are not kept.
    NotKept(String),
}

impl RowFiles {
    /// Those beside the input and the output of a run that starts now. The output's is written, up to so many bytes, once
    /// the run has lasted so long: what takes less is drawn again sooner than it is worth a file. `None` where the output
    /// is a device or a pipe.
    pub fn beside(input: &Path, output: &Path, limit_bytes: u64, after: Duration) -> Option<Self> {
        let also = path_beside(input).filter(|_| !is_same_file(input, output));
        Some(Self {
            path: path_beside(output)?,
            also,
            limit_bytes,
            start: Instant::now(),
            after,
        })
    }

    /// The output's file.
    pub fn path(&self) -> &Path {
        &self.path
    }
}

impl StoredRows {
    /// Looks for rows of this identity.
    pub fn find(files: &RowFiles, identity: Identity) -> Self {
        let mut stored = Self {
            files: files.clone(),
            own: None,
            also: None,
            is_to_be_written: files.limit_bytes > 0,
            is_full_told: false,
            is_damage_told: false,
            remarks: Vec::new(),
            duration: Duration::ZERO,
            identity,
        };
        stored.own = stored.look(&files.path).map(Own::Read);
        stored.also = files.also.as_ref().and_then(|path| stored.look(path));
        stored
    }

    fn look(&mut self, path: &Path) -> Option<RowFile> {
        let error = match RowFile::open(path, &self.identity) {
            Ok(found) => return found,
            Err(error) => error,
        };
        let is_own = path == self.files.path;
        self.remarks
            .push(if is_own && matches!(error, RowFileError::Foreign { .. }) {
                self.is_to_be_written = false;
                RowFileRemark::NotKept(error.to_string())
            } else {
                RowFileRemark::NotUsed(error.to_string())
            });
        None
    }

    /// True where a file has the row of this receiver, as far as is known before it is read.
    pub fn contains(&self, receiver: u32) -> bool {
        let own = match &self.own {
            Some(Own::Read(file)) => file.contains(receiver),
            Some(Own::Written(writer)) => writer.contains(receiver),
            None => false,
        };
        own || self
            .also
            .as_ref()
            .is_some_and(|file| file.contains(receiver))
    }

    /// The block with the row of this receiver; `None` where it cannot be read.
    pub fn read(&mut self, receiver: u32) -> Option<StoredBlock> {
        let start = Instant::now();
        let own = self.own.as_mut().map(|own| match own {
            Own::Read(file) => file,
            Own::Written(writer) => writer.file(),
        });
        let mut found = None;
        for file in own.into_iter().chain(&mut self.also) {
            if found.is_some() || !file.contains(receiver) {
                continue;
            }
            let block = file.read_block(place(receiver).0);
            found = block.filter(|_| file.contains(receiver));
            if file.damaged_records() > 0 && !std::mem::replace(&mut self.is_damage_told, true) {
                let damage = format!("{}: damaged in part", file.path.display());
                self.remarks.push(RowFileRemark::NotUsed(damage));
            }
        }
        self.duration += start.elapsed();
        found
    }

    /// True once the run has lasted so long that its rows are to be kept, and as long as [`Self::begin`] has not been
    /// called.
    pub fn is_due(&self) -> bool {
        self.is_to_be_written && self.files.start.elapsed() >= self.files.after
    }

    /// Goes on with the output's file, or makes one.
    pub fn begin(&mut self) {
        self.is_to_be_written = false;
        match self.writer() {
            Ok(Some(writer)) => self.own = Some(Own::Written(writer)),
            Ok(None) => self.tell_full(),
            Err(error) => self.tell_fault(&error),
        }
    }

    /// `None` where the limit is too small for any row.
    fn writer(&self) -> Result<Option<RowWriter>, RowFileError> {
        let (path, limit_bytes) = (&self.files.path, self.files.limit_bytes);
        if self.own.is_some()
            && let Some(writer) = RowWriter::open(path, &self.identity, limit_bytes)?
        {
            return Ok(Some(writer));
        }
        let mut writer = RowWriter::create(path, &self.identity, limit_bytes)?;
        if writer.file().bytes() <= limit_bytes {
            return Ok(Some(writer));
        }
        writer.remove()?;
        Ok(None)
    }

    /// Keeps the rows of a batch, once [`Self::begin`] has been called; `states` has one element per row.
    pub fn add(&mut self, rows: &CompactRows, states: &[RowState]) {
        self.write(|writer| writer.add(rows, states));
    }

    /// Writes what waits for other rows of its blocks.
    pub fn flush(&mut self) {
        self.write(RowWriter::flush);
    }

    fn write(&mut self, write: impl FnOnce(&mut RowWriter) -> Result<(), RowFileError>) {
        let Some(Own::Written(writer)) = &mut self.own else {
            return;
        };
        let start = Instant::now();
        let result = write(writer);
        let is_full = writer.is_full();
        self.duration += start.elapsed();
        match result {
            Err(error) => self.tell_fault(&error),
            Ok(()) if is_full => self.tell_full(),
            Ok(()) => {}
        }
    }

    fn tell_full(&mut self) {
        if !std::mem::replace(&mut self.is_full_told, true) {
            self.remarks.push(RowFileRemark::NotKept(format!(
                "{} has reached its limit of {}",
                self.files.path.display(),
                show_size(self.files.limit_bytes)
            )));
        }
    }

    fn tell_fault(&mut self, error: &RowFileError) {
        self.remarks.push(RowFileRemark::NotKept(error.to_string()));
    }

    /// Removes the output's file, so that its disk has room for something else, and keeps no rows any more; false where
    /// there is none.
    pub fn remove(&mut self) -> bool {
        self.is_to_be_written = false;
        let path = self.files.path.clone();
        let result = match self.own.take() {
            Some(Own::Written(writer)) => writer.remove().map(|()| true),
            // Not every system removes what is open.
            Some(Own::Read(file)) => {
                drop(file);
                remove(&path)
            }
            None => remove(&path),
        };
        match result {
            Ok(true) => self.remarks.push(RowFileRemark::removed(&path)),
            Ok(false) => {}
            Err(ref error) => self.tell_fault(error),
        }
        result.unwrap_or(false)
    }

    /// What a user should know and has not been told.
    pub fn take_remarks(&mut self) -> Vec<RowFileRemark> {
        std::mem::take(&mut self.remarks)
    }

    /// What reading and writing has taken.
    pub fn duration(&self) -> Duration {
        self.duration
    }
}

impl RowFileRemark {
    /// That a file had to go.
    pub fn removed(path: &Path) -> Self {
        Self::NotKept(format!(
            "{} is removed, since there is no room for the result beside it",
            path.display()
        ))
    }
}

impl Display for RowFileRemark {
    fn fmt(&self, f: &mut Formatter) -> std::fmt::Result {
        match self {
            Self::NotUsed(reason) => write!(f, "{reason}; rows are drawn again"),
            Self::NotKept(reason) => {
                write!(f, "{reason}; no more rows are kept for a run that goes on")
            }
        }
    }
}

/// Removes a file of rows, whosever they are; false where there is none.
///
/// # Errors
/// [`RowFileError::Foreign`] where the file is not one of rows, and [`RowFileError::File`].
pub fn remove(path: &Path) -> Result<bool, RowFileError> {
    let fail = |source| RowFileError::io(path, "remove", source);
    let Some(file) = open_if_any(path, false)? else {
        return Ok(false);
    };
    if !begins_as_rows(&file).map_err(fail)? {
        let path = path.to_owned();
        return Err(RowFileError::Foreign { path });
    }
    drop(file);
    std::fs::remove_file(path).map_err(fail)?;
    Ok(true)
}
