//! Files on disks that are full, and files that no disk has room for. Ignored where there are no such disks.

mod common;

use std::path::Path;

use common::{checked_message, folder, listing, small_scene, small_solution};
use scene::file::{FileFault, load, save};
use test_needs::{ExitCode, SmallDisk, laws, run};

fn full_disk_is_an_error_and_leaves_the_old_file() {
    let folder = folder();
    let disk = SmallDisk::mount(folder.path(), "64k");
    let path = disk.path().join("a.rad");
    let scene = small_scene();
    let solution = small_solution(&scene);
    save(&path, &scene, Some(&solution)).unwrap();
    // 2^13 patches of 12 bytes do not fit; the old file does.
    let large = scene::Scene::new(
        scene.materials().to_vec(),
        scene.objects().to_vec(),
        scene.surfaces().to_vec(),
        &[0, 13],
        scene.origin(),
    )
    .unwrap();
    let dark = scene::Solution::dark(&large);
    let error = save(&path, &large, Some(&dark)).unwrap_err();
    checked_message(&error, &path);
    assert!(
        matches!(&error.fault, FileFault::Io { source, .. } if source.kind() == std::io::ErrorKind::StorageFull),
        "{error}"
    );
    assert_eq!(load(&path).unwrap(), (scene, Some(solution)));
    assert_eq!(listing(disk.path()), ["a.rad"]);
}

/// A tebibyte that takes no space: reading it would take minutes and all memory.
fn make_huge(path: &Path) -> std::io::Result<()> {
    std::fs::File::create(path)?.set_len(1 << 40)
}

fn files_can_be_huge() -> Result<(), String> {
    let folder = folder();
    make_huge(&folder.path().join("huge"))
        .map_err(|_| "this file system has no sparse files of 1 TiB".into())
}

fn huge_file_of_another_kind_is_refused_without_reading_it() {
    let folder = folder();
    let path = folder.path().join("huge");
    make_huge(&path).unwrap();
    assert!(matches!(load(&path).unwrap_err().fault, FileFault::Magic));
}

fn main() -> ExitCode {
    let mut tests =
        laws![SmallDisk::can_be_mounted => full_disk_is_an_error_and_leaves_the_old_file];
    tests.extend(
        laws![files_can_be_huge => huge_file_of_another_kind_is_refused_without_reading_it],
    );
    run(tests)
}
