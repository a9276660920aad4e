//! The container: a `.glb` file's chunks, or JSON alone (section 4 of the specification).

use super::GltfFault;

/// Bytes of the header of a `.glb` file, and of that of a chunk.
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// The JSON of a file, and its binary part.
pub(super) fn parts(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), GltfFault> {
    if bytes.is_empty() {
        return Err(GltfFault::Empty);
    }
    if !bytes.starts_with(b"glTF") {
        let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        if text.trim_ascii_start().first() == Some(&b'{') {
            return Ok((text, None));
        }
        return Err(GltfFault::NotGltf {
            why: "it starts neither with \"glTF\", as .glb files, nor with \"{\", as .gltf files"
                .to_owned(),
        });
    }
    let cut_off = |why: String| GltfFault::Container { why };
    let number = |at: usize| -> Option<usize> {
        let (number, _) = bytes.get(at..)?.split_first_chunk()?;
        Some(u32::from_le_bytes(*number) as usize)
    };
    let (Some(version), Some(length)) = (number(4), number(8)) else {
        let have = bytes.len();
        return Err(cut_off(format!(
            "it has {have} bytes, a .glb file {HEADER} or more"
        )));
    };
    if version != 2 {
        let version = version.to_string();
        return Err(GltfFault::Version { version });
    }
    if length > bytes.len() {
        let have = bytes.len();
        return Err(cut_off(format!(
            "it has {have} bytes, its header says {length}"
        )));
    }
    let mut json = None;
    let mut blob = None;
    let mut at = HEADER;
    while at < length {
        let start = at + CHUNK_HEADER;
        let chunk = number(at).filter(|_| start <= length);
        let found = chunk.and_then(|size| bytes[..length].get(start..start.checked_add(size)?));
        let Some(chunk) = found else {
            return Err(cut_off(format!(
                "its chunk at byte {at} goes beyond its {length} bytes"
            )));
        };
        let kind = &bytes[at + 4..start];
        match (kind, json) {
            (b"JSON", None) => json = Some(chunk),
            (_, None) => break,
            (b"BIN\0", _) if blob.is_none() => blob = Some(chunk),
            // Others may be skipped, as the format says.
            _ => {}
        }
        at = start + chunk.len();
    }
    match json {
        Some(json) => Ok((json, blob)),
        None => Err(cut_off("its first chunk is not JSON".to_owned())),
    }
}
