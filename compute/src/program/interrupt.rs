//! Ctrl-C and requests to end: noted, and answered between two pieces of work.

use crate::cancel::CancelToken;

/// Exit code of an interrupted program: 128 + SIGINT, as shells have it.
pub const EXIT_CODE: u8 = 130;

/// Starts to listen, and passes the user's wish on. A second request ends the process at once; the last checkpoint is
/// whole.
pub fn listen(cancel: &CancelToken) {
    let cancel = cancel.clone();
    // An error means that something else in the process listens already; then it decides.
    ctrlc::set_handler(move || {
        if cancel.cancel() {
            std::process::exit(i32::from(EXIT_CODE));
        }
    })
    .ok();
}
