//! Disks and folders that cannot be written to, by root neither.

use std::path::{Path, PathBuf};
use std::process::Command;

/// A file system in memory, until the end of the test: one that can be filled, or made read-only.
#[derive(Debug)]
pub struct SmallDisk(PathBuf);

impl SmallDisk {
    /// The need for one: most users may not mount, and only Linux mounts file systems in memory in this way.
    pub fn can_be_mounted() -> Result<(), String> {
        let folder = tempfile::tempdir().unwrap();
        Self::try_mount(folder.path().join("disk"), "64k")
            .map(drop)
            .ok_or_else(|| "this user cannot mount a disk".to_owned())
    }

    /// One over a new folder `disk` in `folder`, which outlives it; its size as `mount` takes it, such as `64k`.
    pub fn mount(folder: &Path, size: &str) -> Self {
        Self::try_mount(folder.join("disk"), size).unwrap()
    }

    fn try_mount(path: PathBuf, size: &str) -> Option<Self> {
        std::fs::create_dir(&path).unwrap();
        let mounted = Command::new("mount")
            .args(["-t", "tmpfs", "-o", &format!("size={size}"), "none"])
            .arg(&path)
            .output();
        let is_mounted = mounted.is_ok_and(|output| output.status.success());
        is_mounted.then(|| Self(path))
    }

    /// Where its files are.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// From now on nobody can write to it.
    pub fn make_read_only(&self) {
        let remounted = Command::new("mount")
            .args(["-o", "remount,ro"])
            .arg(self.path())
            .status();
        assert!(remounted.unwrap().success());
    }

    /// Fills it to the last byte, by a file `filler`.
    pub fn fill(&self) {
        let mut filler = std::fs::File::create(self.path().join("filler")).unwrap();
        while std::io::Write::write(&mut filler, &[1; 4096]).is_ok() {}
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        Command::new("umount").arg(self.path()).status().ok();
    }
}

/// A folder in which this user can make no file: a new one in `folder` without the right to write, or, as that does
/// not bind root, one in which the system itself makes no files, on Linux and on macOS.
#[cfg(unix)]
pub fn closed_folder(folder: &Path) -> PathBuf {
    use std::os::unix::fs::PermissionsExt;
    let closed = folder.join("closed");
    std::fs::create_dir(&closed).unwrap();
    std::fs::set_permissions(&closed, std::fs::Permissions::from_mode(0o555)).unwrap();
    let is_closed = |folder: &PathBuf| {
        let probe = folder.join("probe");
        let written = std::fs::write(&probe, "");
        std::fs::remove_file(&probe).ok();
        folder.is_dir() && written.is_err()
    };
    [closed, "/sys".into(), "/System".into()]
        .into_iter()
        .find(is_closed)
        .expect("a folder that this user cannot write to")
}
