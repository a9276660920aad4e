//! Keeping two programs from writing the same file.

use std::fs::{File, TryLockError};
use std::path::{Path, PathBuf};

use super::write::{folder_of, is_device_or_pipe, is_read_only};
use super::{FileError, FileFault};

/// The right to write one output file, held for as long as this value lives.
///
/// A lock file `.NAME.lock` beside the output carries an advisory lock of the operating system,
/// which ends with the process however it ends; a lock file that a killed process left behind
/// locks nothing. A device or a pipe takes what several programs write, and is not locked.
#[derive(Debug)]
pub struct OutputLock {
    held: Option<Held>,
}

/// A lock file and its name.
#[derive(Debug)]
struct Held {
    path: PathBuf,
    /// Kept open: closing it gives the lock back.
    _file: File,
}

impl OutputLock {
    /// Locks `output` for writing, and so finds out at once if its folder is missing or read-only.
    ///
    /// # Errors
    /// [`FileFault::Locked`] when another program holds it, [`FileFault::ReadOnly`] when it must not be replaced, [`FileFault::Io`] when the folder is
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
        if is_device_or_pipe(output) {
            return Ok(Self { held: None });
        }
        if is_read_only(output) {
            return Err(FileError::new(output, FileFault::ReadOnly));
        }
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
            if is_at(&file, &path) {
                let held = Some(Held { path, _file: file });
                return Ok(Self { held });
            }
        }
    }
}

impl Drop for OutputLock {
    fn drop(&mut self) {
        if let Some(held) = &self.held {
            // A lock file that stays behind does no harm.
            std::fs::remove_file(&held.path).ok();
        }
    }
}

/// Whether an open file still has its name.
#[cfg(unix)]
fn is_at(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (file.metadata(), std::fs::metadata(path)) {
        (Ok(a), Ok(b)) => (a.dev(), a.ino()) == (b.dev(), b.ino()),
        _ => false,
    }
}

/// Elsewhere an open file cannot be removed.
#[cfg(not(unix))]
fn is_at(_: &File, _: &Path) -> bool {
    true
}
