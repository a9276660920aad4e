//! Files that a model names, as people's machines spell them: backslashes, quotes, another case, folders that are not here.

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::lines::words;

/// The MTL files that a `mtllib` argument means: one whose name holds spaces or a "#", or several.
pub(super) fn named(folder: &Path, argument: &[u8]) -> Vec<PathBuf> {
    let argument = argument.trim_ascii_end();
    let whole = find(folder, argument);
    if whole.exists() {
        return vec![whole];
    }
    let (quoted, rest) = split_quoted(argument);
    let mut several: Vec<&[u8]> = quoted;
    several.extend(
        rest.split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty()),
    );
    if let Some(comment) = several.iter().position(|word| word[0] == b'#') {
        several.truncate(comment);
    }
    // One name with spaces, and a comment behind it.
    let before_comment = rest
        .iter()
        .position(|&byte| byte == b'#')
        .unwrap_or(rest.len());
    let one = find(folder, rest[..before_comment].trim_ascii());
    if one.is_file() && words(argument).len() > 1 {
        return vec![one];
    }
    let several: Vec<PathBuf> = several.into_iter().map(|name| find(folder, name)).collect();
    if several.len() == 1 || several.iter().any(|path| path.exists()) {
        several
    } else {
        vec![whole]
    }
}

/// Names in quotes at the start, and what follows them.
fn split_quoted(mut argument: &[u8]) -> (Vec<&[u8]>, &[u8]) {
    let mut quoted = Vec::new();
    while let Some(inside) = argument.strip_prefix(b"\"") {
        let Some(end) = inside.iter().position(|&byte| byte == b'"') else {
            break;
        };
        quoted.push(&inside[..end]);
        argument = inside[end + 1..].trim_ascii_start();
    }
    (quoted, argument)
}

/// The picture that a `map_` statement means: what follows its options.
pub(super) fn picture(folder: &Path, argument: &[u8]) -> PathBuf {
    let argument = argument.trim_ascii();
    let whole = find(folder, argument);
    if whole.exists() || !argument.starts_with(b"-") {
        return whole;
    }
    // An option and its values: "-s 1 1 1 -clamp on name with spaces.png".
    let mut rest = argument;
    while rest.starts_with(b"-") {
        rest = after_word(rest);
        while is_value(rest) {
            rest = after_word(rest);
        }
    }
    find(folder, rest)
}

/// What follows the first word.
fn after_word(text: &[u8]) -> &[u8] {
    let end = text.iter().position(u8::is_ascii_whitespace);
    text[end.unwrap_or(text.len())..].trim_ascii_start()
}

/// Whether a text starts with the value of an option: a number, or on, off and the channels.
fn is_value(text: &[u8]) -> bool {
    let end = text.iter().position(u8::is_ascii_whitespace).unwrap_or(0);
    let Ok(word) = str::from_utf8(&text[..end]) else {
        return false;
    };
    let words = ["on", "off", "r", "g", "b", "m", "l", "z"];
    word.parse::<f64>().is_ok() || words.contains(&word)
}

/// The file of a name: as it is spelt, else in another case, else in the model's own folder.
fn find(folder: &Path, name: &[u8]) -> PathBuf {
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
