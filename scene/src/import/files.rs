//! Files that a model names, as people's machines spell them: backslashes, quotes, another case, folders that are not here.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// Reads a file. A device or pipe that a model names could be endless.
pub(crate) fn read_regular(path: &Path) -> std::io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(std::io::Error::other("not a regular file"));
    }
    std::fs::read(path)
}

/// The file of a name: as it is spelt, else in another case, else in the model's own folder.
pub(crate) fn find(folder: &Path, name: &[u8]) -> PathBuf {
    let exact = folder.join(path(name));
    if exact.exists() {
        return exact;
    }
    let unquoted = name.trim_ascii();
    let unquoted = unquoted.strip_prefix(b"\"").unwrap_or(unquoted);
    let unquoted = unquoted.strip_suffix(b"\"").unwrap_or(unquoted);
    let slashed: Vec<u8> = unquoted
        .iter()
        .map(|&byte| if byte == b'\\' { b'/' } else { byte })
        .collect();
    let spelt = path(&slashed);
    let alone = spelt.file_name().map(PathBuf::from);
    let found = in_any_case(folder, &spelt).or_else(|| in_any_case(folder, &alone?));
    found.unwrap_or(exact)
}

/// The file of a path below a folder, whatever the case of its letters.
fn in_any_case(folder: &Path, path: &Path) -> Option<PathBuf> {
    let exact = folder.join(path);
    if exact.exists() {
        return Some(exact);
    }
    let mut found = folder.to_owned();
    for part in path.components() {
        let next = found.join(part);
        if next.exists() {
            found = next;
            continue;
        }
        let wanted = part.as_os_str().to_string_lossy().to_lowercase();
        let folder = if found.as_os_str().is_empty() {
            Path::new(".")
        } else {
            &found
        };
        let mut same: Vec<OsString> = std::fs::read_dir(folder)
            .ok()?
            .filter_map(|entry| Some(entry.ok()?.file_name()))
            .filter(|name| name.to_string_lossy().to_lowercase() == wanted)
            .collect();
        same.sort();
        found.push(same.first()?);
    }
    Some(found)
}

/// The path of a name's bytes.
#[cfg(unix)]
fn path(name: &[u8]) -> PathBuf {
    use std::os::unix::ffi::OsStringExt;
    OsString::from_vec(name.to_owned()).into()
}

/// The path of a name's bytes.
#[cfg(not(unix))]
fn path(name: &[u8]) -> PathBuf {
    String::from_utf8_lossy(name).into_owned().into()
}
