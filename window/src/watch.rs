//! A file that may change while it is shown.
//!
//! Once a second its modification time and size are compared with those before its last reading. It is read beside the window, and
//! what was shown stays until the new content is whole: whoever writes the file may take its time.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::mpsc::{Receiver, TryRecvError, channel};
use std::time::{Duration, Instant, SystemTime};

use crate::loaded::Loaded;

/// Time between two looks at the file.
pub const PERIOD: Duration = Duration::from_secs(1);

/// What tells one state of a file from another: its modification time and bytes; `None` where there is no file.
type Stamp = Option<(SystemTime, u64)>;

/// What a reading came to.
pub type Outcome = Result<Box<Loaded>, String>;

/// A file that is looked after.
pub struct Watch {
    path: PathBuf,
    /// Before the last reading began.
    stamp: Stamp,
    last_look: Instant,
    reading: Option<Receiver<Outcome>>,
    /// Called when a reading has ended.
    wake: Arc<dyn Fn() + Send + Sync>,
}

impl Watch {
    /// Begins to read a file; `wake` is called, from another thread, whenever a reading has ended.
    pub fn new(path: PathBuf, wake: impl Fn() + Send + Sync + 'static) -> Self {
        let mut watch = Self {
            path,
            stamp: None,
            last_look: Instant::now(),
            reading: None,
            wake: Arc::new(wake),
        };
        watch.read_again();
        watch
    }

    /// The file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The file's name without its folders.
    pub fn name(&self) -> String {
        let name = self.path.file_name().unwrap_or(self.path.as_os_str());
        name.to_string_lossy().into_owned()
    }

    /// Whether the file is being read.
    pub fn is_reading(&self) -> bool {
        self.reading.is_some()
    }

    /// Reads the file whether it has changed or not, unless it is being read.
    pub fn read_again(&mut self) {
        if self.is_reading() {
            return;
        }
        // Taken before: what is written from now on makes another stamp.
        self.stamp = stamp(&self.path);
        let (sender, receiver) = channel();
        let path = self.path.clone();
        let wake = Arc::clone(&self.wake);
        std::thread::spawn(move || {
            let outcome = Loaded::read(&path)
                .map(Box::new)
                .map_err(|error| error.to_string());
            // A window that has been closed asks for it no more.
            let _ = sender.send(outcome);
            wake();
        });
        self.reading = Some(receiver);
    }

    /// What a reading came to that has ended since the last call. Looks at the file if it is time to.
    pub fn poll(&mut self, now: Instant) -> Option<Outcome> {
        if let Some(reading) = &self.reading {
            let outcome = match reading.try_recv() {
                Err(TryRecvError::Empty) => return None,
                Ok(outcome) => outcome,
                Err(TryRecvError::Disconnected) => {
                    Err(format!("{}: reading it broke off", self.path.display()))
                }
            };
            self.reading = None;
            return Some(outcome);
        }
        if now.saturating_duration_since(self.last_look) >= PERIOD {
            self.last_look = now;
            // A file that is gone for a moment is being replaced.
            let stamp = stamp(&self.path);
            if stamp.is_some() && stamp != self.stamp {
                self.read_again();
            }
        }
        None
    }
}

fn stamp(path: &Path) -> Stamp {
    let metadata = std::fs::metadata(path).ok()?;
    Some((metadata.modified().ok()?, metadata.len()))
}
