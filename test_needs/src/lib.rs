//! Tests that need something which a machine may lack, such as a GPU or the right to mount a disk. Without it they are
//! reported as ignored, with the reason: a test that returns early would be reported as passed.
//!
//! Rust's own harness decides what is ignored before a test runs. So such tests are targets of their own, with
//! `harness = false` and a `main` that lists them; a test that is left out of the list is unused code, and a warning:
//!
//! ```no_run
//! use test_needs::{ExitCode, SmallDisk, laws, run};
//!
//! fn a_disk_holds_no_more_than_its_size() {
//!     let disk = SmallDisk::mount(&std::env::temp_dir(), "64k");
//!     std::fs::write(disk.path().join("large"), [0; 1 << 20]).unwrap_err();
//! }
//!
//! fn main() -> ExitCode {
//!     run(laws![SmallDisk::can_be_mounted => a_disk_holds_no_more_than_its_size])
//! }
//! ```

// They are for tests: what cannot be done is a failure of the test.
#![allow(clippy::missing_panics_doc)]

mod disk;

use libtest_mimic::{Arguments, Completion};

pub use disk::SmallDisk;
#[cfg(unix)]
pub use disk::closed_folder;
pub use libtest_mimic::Trial;
pub use std::process::ExitCode;

/// Whether the machine has what a test needs, or else the reason why the test is ignored.
pub type Need = fn() -> Result<(), String>;

/// A test by its name: `law` panics where it does not hold.
pub fn test(name: impl Into<String>, need: Need, law: impl FnOnce() + Send + 'static) -> Trial {
    Trial::ignorable_test(name, move || match need() {
        Ok(()) => {
            law();
            Ok(Completion::Completed)
        }
        Err(reason) => Ok(Completion::ignored_with(reason)),
    })
}

/// Tests with one need, named as their functions: `laws![need => law, module::law]`.
#[macro_export]
macro_rules! laws {
    ($need:expr => $($law:path),+ $(,)?) => {
        vec![$($crate::test(stringify!($law), $need, $law)),+]
    };
}

/// Runs the tests that the command line asks for, which has the options of Rust's own harness.
pub fn run(tests: Vec<Trial>) -> ExitCode {
    libtest_mimic::run(&Arguments::from_args(), tests).exit_code()
}

/// The need for a GPU adapter, given whether there is one. With `REQUIRE_GPU=1` it counts as met, so that the
/// tests fail without one.
pub fn adapter(is_there: bool) -> Result<(), String> {
    let is_required = std::env::var_os("REQUIRE_GPU").is_some_and(|value| value == "1");
    if is_there || is_required {
        Ok(())
    } else {
        Err("there is no GPU adapter".into())
    }
}
