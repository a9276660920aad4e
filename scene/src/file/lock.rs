//! Keeping two programs from writing the same file.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use super::write::folder_of;
use super::{FileError, FileFault};

/// The right to write one output file, held for as long as this value lives.
///
/// A lock file `.NAME.lock` beside the output carries an advisory lock of the operating system,
/// which ends with the process however it ends; a lock file that a killed process left behind
/// locks nothing.
#[derive(Debug)]
pub struct OutputLock {
    path: PathBuf,
    /// Kept open: closing it gives the lock back.
    _file: File,
}

impl OutputLock {
    /// Locks `output` for writing, and so finds out at once if its folder is missing or read-only.
    ///
    /// # Errors
    /// [`FileFault::Locked`] when another program holds it, [`FileFault::Io`] when the folder is
    /// missing or cannot be written or when `output` is a folder. All name `output`.
    pub fn acquire(output: &Path) -> Result<Self, FileError> {
        let fail = |source| {
            FileError::new(
                output,
                FileFault::Io {
                    action: "write",
                    source,
                },
            )
        };
        let Some(name) = output.file_name().filter(|_| !output.is_dir()) else {
            return Err(fail(std::io::ErrorKind::IsADirectory.into()));
        };
        let path = folder_of(output).join(format!(".{}.lock", name.to_string_lossy()));
        loop {
            let file = File::create(&path).map_err(fail)?;
            match file.try_lock() {
                Ok(()) => {}
                Err(TryLockError::WouldBlock) => {
                    return Err(FileError::new(output, FileFault::Locked { lock: path }));
                }
                Err(TryLockError::Error(source)) => return Err(fail(source)),
            }
            // The last holder may have removed the file between our opening and our locking it;
            // then the name stands for nothing, or for another program's new file.
            if is_same_file(&file, &path) {
                return Ok(Self { path, _file: file });
            }
        }
    }
}

impl Drop for OutputLock {
    fn drop(&mut self) {
        // A lock file that stays behind does no harm.
        std::fs::remove_file(&self.path).ok();
    }
}

#[cfg(unix)]
fn is_same_file(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// Elsewhere an open file cannot be removed.
#[cfg(not(unix))]
fn is_same_file(_: &File, _: &Path) -> bool {
    true
}
