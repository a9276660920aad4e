//! The files that statements name: with options, quotes, spaces and comments.

use std::path::{Path, PathBuf};

use super::lines::words;
use crate::import::files::find;

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
