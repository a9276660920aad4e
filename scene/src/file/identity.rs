//! Whether two names stand for one file.

use std::path::{Path, PathBuf};

use super::write::folder_of;

/// True where two paths lead to one file, links followed; a file that is not there yet is known by its folder and name.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    a == b || matches!((resolved(a), resolved(b)), (Ok(a), Ok(b)) if a == b)
}

fn resolved(path: &Path) -> std::io::Result<PathBuf> {
    path.canonicalize().or_else(|_| {
        let folder = folder_of(path).canonicalize()?;
        Ok(folder.join(path.file_name().unwrap_or_default()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_the_same_by_whatever_way_and_before_it_is_there() {
        let folder = tempfile::tempdir().unwrap();
        let inner = folder.path().join("inner");
        std::fs::create_dir(&inner).unwrap();
        std::fs::write(inner.join("there"), "").unwrap();
        for name in ["there", "not_yet"] {
            let straight = inner.join(name);
            assert!(is_same_file(&straight, &inner.join("../inner").join(name)));
            assert!(!is_same_file(&straight, &folder.path().join(name)));
        }
        assert!(!is_same_file(&inner.join("there"), &inner.join("not_yet")));
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(inner.join("there"), folder.path().join("link")).unwrap();
            assert!(is_same_file(
                &folder.path().join("link"),
                &inner.join("there")
            ));
        }
    }
}
