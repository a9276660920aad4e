//! Whatever happens while writing, the old file stays whole; and two programs do not share a name.

mod common;

use std::path::Path;

use common::{checked_message, folder, listing, small_scene, small_solution, write};
use scene::file::{FileFault, OutputLock, load, save, write_atomically};
use scene::{Rgb, SceneError};

#[test]
fn failed_write_leaves_the_old_file_and_nothing_else() {
    let folder = folder();
    let path = write(&folder, "a.rad", "old");
    let error = write_atomically(&path, |out| {
        // More than any buffer, so that some of it is on the disk.
        out.write_all(&vec![7; 5 << 20])?;
        Err(std::io::ErrorKind::StorageFull.into())
    })
    .unwrap_err();
    let message = checked_message(&error, &path);
    assert!(message.contains("cannot write"), "{message}");
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    assert_eq!(listing(folder.path()), ["a.rad"]);
}

#[test]
fn old_file_is_whole_until_the_new_one_is() {
    let folder = folder();
    let path = write(&folder, "a.rad", "old");
    write_atomically(&path, |out| {
        out.write_all(&vec![7; 5 << 20])?;
        assert_eq!(std::fs::read(&path)?, b"old");
        Ok(())
    })
    .unwrap();
    assert_eq!(std::fs::metadata(&path).unwrap().len(), 5 << 20);
    assert_eq!(listing(folder.path()), ["a.rad"]);
}

#[cfg(target_os = "linux")]
#[test]
fn device_is_written_to_and_never_replaced() {
    // By links of our own: a failure must not destroy the devices of the machine.
    let folder = folder();
    let link = |name: &str| {
        let path = folder.path().join(name);
        std::os::unix::fs::symlink(Path::new("/dev").join(name), &path).unwrap();
        path
    };
    let (null, full) = (link("null"), link("full"));
    save(&null, &small_scene(), None).unwrap();
    let error = save(&full, &small_scene(), None).unwrap_err();
    checked_message(&error, &full);
    assert!(
        matches!(error.fault, FileFault::Io { source, .. } if source.kind() == std::io::ErrorKind::StorageFull)
    );
    assert!(null.is_symlink() && full.is_symlink());
}

#[test]
fn missing_folder_is_an_error_for_lock_and_save() {
    let folder = folder();
    let path = folder.path().join("none/a.rad");
    let lock = OutputLock::acquire(&path).unwrap_err();
    let save = save(&path, &small_scene(), None).unwrap_err();
    for error in [lock, save] {
        checked_message(&error, &path);
        assert!(
            matches!(error.fault, FileFault::Io { source, .. } if source.kind() == std::io::ErrorKind::NotFound)
        );
    }
}

#[cfg(unix)]
#[test]
fn read_only_folder_is_an_error_for_lock_and_save() {
    let folder = folder();
    let path = test_needs::closed_folder(folder.path()).join("a.rad");
    let lock = OutputLock::acquire(&path).unwrap_err();
    let save = save(&path, &small_scene(), None).unwrap_err();
    for error in [lock, save] {
        let message = checked_message(&error, &path);
        assert!(message.contains("cannot write"), "{message}");
    }
}

#[test]
fn folder_in_place_of_the_output_is_an_error() {
    let folder = folder();
    let path = folder.path().join("sub");
    std::fs::create_dir(&path).unwrap();
    checked_message(&OutputLock::acquire(&path).unwrap_err(), &path);
    checked_message(&save(&path, &small_scene(), None).unwrap_err(), &path);
    assert_eq!(listing(folder.path()), ["sub"]);
}

#[test]
fn unreadable_solution_never_replaces_a_good_one() {
    let folder = folder();
    let path = folder.path().join("a.rad");
    let scene = small_scene();
    let good = small_solution(&scene);
    save(&path, &scene, Some(&good)).unwrap();
    let mut short = good.clone();
    short.irradiance.pop();
    let mut not_a_number = good.clone();
    not_a_number.irradiance[4] = Rgb::NAN;
    for bad in [short, not_a_number] {
        let error = save(&path, &scene, Some(&bad)).unwrap_err();
        checked_message(&error, &path);
        assert!(matches!(
            error.fault,
            FileFault::Scene(SceneError::SolutionLength { .. } | SceneError::Irradiance { .. })
        ));
        assert_eq!(load(&path).unwrap(), (scene.clone(), Some(good.clone())));
    }
}

#[test]
fn output_locked_by_another_is_refused_until_it_is_released() {
    let folder = folder();
    let path = folder.path().join("a.rad");
    let held = OutputLock::acquire(&path).unwrap();
    let error = OutputLock::acquire(&path).unwrap_err();
    let message = checked_message(&error, &path);
    assert!(matches!(error.fault, FileFault::Locked { .. }), "{message}");
    // Another output in the same folder is free.
    OutputLock::acquire(&folder.path().join("b.rad")).unwrap();
    drop(held);
    assert_eq!(listing(folder.path()), [""; 0]);
    OutputLock::acquire(&path).unwrap();
}

#[test]
fn lock_file_left_by_a_killed_program_locks_nothing() {
    let folder = folder();
    write(&folder, ".a.rad.lock", "");
    OutputLock::acquire(&folder.path().join("a.rad")).unwrap();
}

#[test]
fn of_many_programs_at_most_one_holds_the_lock() {
    use std::sync::atomic::{AtomicU32, Ordering};
    let folder = folder();
    let path = folder.path().join("a.rad");
    let (holders, taken) = (AtomicU32::new(0), AtomicU32::new(0));
    std::thread::scope(|scope| {
        for _ in 0..8 {
            scope.spawn(|| {
                for _ in 0..200 {
                    if let Ok(lock) = OutputLock::acquire(&path) {
                        assert_eq!(holders.fetch_add(1, Ordering::SeqCst), 0);
                        taken.fetch_add(1, Ordering::SeqCst);
                        std::thread::yield_now();
                        holders.fetch_sub(1, Ordering::SeqCst);
                        drop(lock);
                    }
                }
            });
        }
    });
    assert!(taken.into_inner() > 0);
}

#[cfg(unix)]
#[test]
fn output_is_readable_by_others_as_the_umask_allows() {
    use std::os::unix::fs::PermissionsExt;
    let folder = folder();
    let plain = write(&folder, "plain", "");
    let path = folder.path().join("a.rad");
    save(&path, &small_scene(), None).unwrap();
    let mode = |path: &Path| std::fs::metadata(path).unwrap().permissions().mode();
    assert_eq!(mode(&path), mode(&plain));
}
