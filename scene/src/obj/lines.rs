//! The statements of OBJ and MTL files: lines, names, numbers.
//!
//! Names are bytes: what is not UTF-8, as in old encodings, becomes `\xNN` a byte, so that names that differ stay different.
//! A line ends with LF, CR LF or CR.

use std::borrow::Cow;
use std::fmt::Write;

use super::ObjFault;

/// The byte order marks of UTF-16.
const UTF_16: [[u8; 2]; 2] = [[0xFE, 0xFF], [0xFF, 0xFE]];

/// The bytes of a text file; an error where they are none.
pub(super) fn text(bytes: &[u8]) -> Result<&[u8], ObjFault> {
    if bytes.is_empty() {
        return Err(ObjFault::Empty);
    }
    // Of ASCII text in UTF-16 every other byte is 0.
    let is_zero = |byte: &&u8| **byte == 0;
    let start = &bytes[..bytes.len().min(64)];
    let has_zeros = 3 * start.iter().filter(is_zero).count() > start.len();
    if UTF_16.iter().any(|mark| bytes.starts_with(mark)) || has_zeros {
        return Err(ObjFault::NotObj {
            why: "it is text in UTF-16, which has to be saved as UTF-8",
        });
    }
    if bytes.contains(&0) {
        return Err(ObjFault::NotObj {
            why: "it holds binary data",
        });
    }
    Ok(bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes))
}

/// The lines of a text with their numbers, from 1.
pub(super) fn lines(mut text: &[u8]) -> impl Iterator<Item = (usize, &[u8])> {
    let lines = std::iter::from_fn(move || {
        if text.is_empty() {
            return None;
        }
        let end = text.iter().position(|byte| b"\r\n".contains(byte));
        let (line, rest) = text.split_at(end.unwrap_or(text.len()));
        text = rest
            .strip_prefix(b"\r\n")
            .or(rest.get(1..))
            .unwrap_or_default();
        Some(line)
    });
    lines.enumerate().map(|(index, line)| (index + 1, line))
}

/// A line's keyword and what follows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Statement<'a> {
    pub line: usize,
    pub keyword: &'a str,
    /// From the first byte that is no space on.
    pub rest: &'a [u8],
}

impl<'a> Statement<'a> {
    /// `None` for lines without a statement, and those whose keyword is no ASCII.
    pub(super) fn new((number, line): (usize, &'a [u8])) -> Option<Self> {
        let line = line.trim_ascii_start();
        let end = line.iter().position(u8::is_ascii_whitespace);
        let (keyword, rest) = line.split_at(end.unwrap_or(line.len()));
        let keyword = str::from_utf8(keyword).ok().filter(|k| !k.is_empty())?;
        Some(Self {
            line: number,
            keyword,
            rest: rest.trim_ascii_start(),
        })
    }

    /// The name that follows, with all its bytes: [`names`] tells what else may be meant.
    pub(super) fn name(&self) -> Cow<'a, str> {
        decode(self.rest)
    }

    /// The words that follow, up to a comment.
    pub(super) fn words(&self) -> Vec<Cow<'a, str>> {
        words(self.rest)
    }

    pub(super) fn malformed(&self, what: impl Into<String>) -> ObjFault {
        ObjFault::Statement {
            line: self.line,
            what: what.into(),
        }
    }
}

/// Words between spaces, up to one that starts with "#".
pub(super) fn words(bytes: &[u8]) -> Vec<Cow<'_, str>> {
    let words = bytes.split(u8::is_ascii_whitespace);
    words
        .filter(|word| !word.is_empty())
        .take_while(|word| word[0] != b'#')
        .map(decode)
        .collect()
}

/// Text of bytes, each of which that is no UTF-8 is written out.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    if let Ok(text) = str::from_utf8(bytes) {
        return Cow::Borrowed(text);
    }
    let mut text = String::new();
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        for byte in chunk.invalid() {
            // Writing to a string does not fail.
            write!(text, "\\x{byte:02X}").ok();
        }
    }
    Cow::Owned(text)
}

/// What a name may mean, first what it says, then what is left without spaces and comments behind it.
pub(super) fn names(name: &str) -> impl Iterator<Item = &str> {
    let trimmed = name.trim_end();
    let comments = trimmed.match_indices('#').map(|(at, _)| at).rev();
    let cut = comments
        .map(|at| &trimmed[..at])
        .filter(|before| before.ends_with(char::is_whitespace))
        .map(str::trim_end)
        .filter(|before| !before.is_empty());
    std::iter::once(name)
        .chain((trimmed.len() < name.len() && !trimmed.is_empty()).then_some(trimmed))
        .chain(cut)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_in_three_ways() {
        let found: Vec<(usize, &[u8])> = lines(b"a\nb\r\nc\rd\n\ne").collect();
        let expected: [(usize, &[u8]); 6] = [
            (1, b"a"),
            (2, b"b"),
            (3, b"c"),
            (4, b"d"),
            (5, b""),
            (6, b"e"),
        ];
        assert_eq!(found, expected);
    }

    #[test]
    fn names_are_tried_from_whole_to_shortest() {
        let of = |name| names(name).collect::<Vec<_>>();
        assert_eq!(of("a"), ["a"]);
        assert_eq!(
            of("a #1 # old "),
            ["a #1 # old ", "a #1 # old", "a #1", "a"]
        );
        assert_eq!(of("#1"), ["#1"]);
        assert_eq!(of("a#1"), ["a#1"]);
    }

    #[test]
    fn bytes_that_are_no_text_are_told_apart() {
        assert_eq!(decode(b"a\xB0\xD7"), "a\\xB0\\xD7");
        assert_ne!(decode(b"\xB0"), decode(b"\xB1"));
    }
}
