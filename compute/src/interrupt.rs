//! Ctrl-C and requests to end: noted, and answered between two pieces of work.

use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Exit code of an interrupted program: 128 + SIGINT, as shells have it.
pub const EXIT_CODE: u8 = 130;

/// Starts to listen. A second request ends the process at once; the last checkpoint is whole.
pub fn listen() {
    // An error means that something else in the process listens already; then it decides.
    ctrlc::set_handler(|| {
        if REQUESTED.swap(true, Ordering::SeqCst) {
            std::process::exit(i32::from(EXIT_CODE));
        }
    })
    .ok();
}

/// True once the user has asked to stop.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}
