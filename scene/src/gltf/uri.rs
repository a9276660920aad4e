//! What URIs in a model mean: data of their own, or files.

use std::borrow::Cow;
use std::path::{Path, PathBuf};

use base64::Engine;
use base64::alphabet::STANDARD;
use base64::engine::{DecodePaddingMode, GeneralPurpose, GeneralPurposeConfig};
use percent_encoding::percent_decode_str;

use crate::import::files::find;

/// Programs leave the padding out.
const BASE64: GeneralPurpose = GeneralPurpose::new(
    &STANDARD,
    GeneralPurposeConfig::new().with_decode_padding_mode(DecodePaddingMode::Indifferent),
);

/// What a URI means.
#[derive(Debug)]
pub(super) enum Meaning {
    Data(Vec<u8>),
    File(PathBuf),
}

/// What a URI of a model in some folder means, or what is wrong with it.
pub(super) fn meaning(folder: &Path, uri: &str) -> Result<Meaning, String> {
    if let Some(rest) = after_data(uri) {
        return data(rest).map(Meaning::Data);
    }
    if let Some((scheme, _)) = uri.split_once("://") {
        return Err(format!(
            "its URI has the scheme \"{scheme}\"; put the file beside the model, or embed it"
        ));
    }
    let decoded: Cow<[u8]> = percent_decode_str(uri).into();
    let path = find(folder, &decoded);
    // Some programs write names as they are.
    let plain = folder.join(uri);
    let is_plain = !path.exists() && plain.exists();
    Ok(Meaning::File(if is_plain { plain } else { path }))
}

fn after_data(uri: &str) -> Option<&str> {
    let (scheme, rest) = uri.split_once(':')?;
    scheme.eq_ignore_ascii_case("data").then_some(rest)
}

/// The bytes of a data URI, of which "data:" is cut off.
fn data(rest: &str) -> Result<Vec<u8>, String> {
    let (kind, payload) = rest
        .split_once(',')
        .ok_or("its data URI has no comma before the data")?;
    let payload: Cow<[u8]> = percent_decode_str(payload).into();
    if kind.to_ascii_lowercase().ends_with(";base64") {
        let bytes = BASE64.decode(payload.trim_ascii());
        bytes.map_err(|error| {
            let error = error.to_string();
            format!("its data URI is no base64: {}", error.trim_end_matches('.'))
        })
    } else {
        Ok(payload.into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bytes(uri: &str) -> Result<Vec<u8>, String> {
        match meaning(Path::new(""), uri)? {
            Meaning::Data(bytes) => Ok(bytes),
            Meaning::File(path) => Err(path.display().to_string()),
        }
    }

    #[test]
    fn data_is_read_with_and_without_base64_and_padding() {
        for uri in [
            "data:application/octet-stream;base64,AQI=",
            "data:;base64,AQI",
            "DATA:;BASE64,AQI%3D",
            "data:,%01%02",
        ] {
            assert_eq!(bytes(uri).unwrap(), [1, 2], "{uri}");
        }
    }

    #[test]
    fn what_cannot_be_read_is_told() {
        for (uri, told) in [
            ("data:;base64", "comma"),
            ("data:;base64,A?", "base64"),
            ("https://example.org/a.bin", "https"),
        ] {
            assert!(bytes(uri).unwrap_err().contains(told), "{uri}");
        }
    }

    #[test]
    fn names_of_files_are_decoded() {
        assert_eq!(bytes("a%20b.bin").unwrap_err(), "a b.bin");
    }
}
