//! A file taken apart: the container, the JSON, whether all of it is valid and known, and the buffers.

use std::path::{Path, PathBuf};

use gltf::json::validation::{Error as Invalid, Validate};
use gltf::json::{Index, Root, root::Get};
use serde::Deserialize;

use super::GltfFault;
use super::error::wrong;
use super::uri::{Meaning, meaning};
use crate::import::files::read_regular;

/// Bytes of the header of a `.glb` file, and of that of a chunk.
const HEADER: usize = 12;
const CHUNK_HEADER: usize = 8;

/// Extensions that a model may require: they are taken, or told as left out.
const KNOWN: [&str; 4] = [
    "KHR_lights_punctual",
    "KHR_materials_emissive_strength",
    "KHR_mesh_quantization",
    "KHR_texture_transform",
];

/// Extensions of materials: what they say is told as left out.
const OF_MATERIALS: [&str; 2] = ["KHR_materials_", "EXT_materials_"];

/// A glTF file that is valid, with its buffers.
pub(super) struct Document {
    pub root: Root,
    /// One per buffer, each at least as long as the document says.
    pub buffers: Vec<Vec<u8>>,
    /// What pictures inside of the file are named by.
    pub path: PathBuf,
    /// Where other files are.
    pub folder: PathBuf,
    /// The files of the buffers.
    pub files: Vec<PathBuf>,
}

/// What has to be known before the rest can be understood.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Head {
    asset: Asset,
    #[serde(default)]
    extensions_required: Vec<String>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Asset {
    version: String,
    min_version: Option<String>,
}

impl Document {
    pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Self, GltfFault> {
        let (json, blob) = parts(bytes)?;
        if let Ok(head) = serde_json::from_slice::<Head>(json) {
            check_head(&head)?;
        }
        let root = Root::from_slice(json).map_err(GltfFault::Json)?;
        validate(&root)?;
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        let mut document = Self {
            root,
            buffers: Vec::new(),
            path: path.to_owned(),
            folder,
            files: Vec::new(),
        };
        for index in 0..document.root.buffers.len() {
            let bytes = document.buffer(index, blob)?;
            document.buffers.push(bytes);
        }
        Ok(document)
    }

    /// What an index means.
    pub(super) fn get<T>(&self, index: Index<T>) -> Result<&T, GltfFault>
    where
        Root: Get<T>,
    {
        // Validation has found all that is used; a file that gets here has surprised it.
        self.root
            .get(index)
            .ok_or_else(|| wrong(format!("index {index}"), "nothing has it"))
    }

    /// The bytes of a buffer, as many as the document says or more.
    fn buffer(&mut self, index: usize, blob: Option<&[u8]>) -> Result<Vec<u8>, GltfFault> {
        let buffer = &self.root.buffers[index];
        let thing = format!("buffers[{index}]");
        let mut file = None;
        let bytes = match (&buffer.uri, blob) {
            (Some(uri), _) => match meaning(&self.folder, uri).map_err(|why| wrong(&thing, why))? {
                Meaning::Data(bytes) => bytes,
                Meaning::File(path) => {
                    let bytes = read_regular(&path).map_err(|error| {
                        let path = path.display();
                        wrong(
                            &thing,
                            format!("cannot read its file {path}: {error}; put it beside the model, or export one .glb file"),
                        )
                    })?;
                    file = Some(path);
                    bytes
                }
            },
            (None, Some(blob)) if index == 0 => blob.to_vec(),
            (None, _) => {
                return Err(wrong(
                    thing,
                    "it has no URI, and the file has no binary part for it; export the model again",
                ));
            }
        };
        if (bytes.len() as u64) < buffer.byte_length.0 {
            let place = match &file {
                Some(path) => path.display().to_string(),
                None => "the file".to_owned(),
            };
            return Err(wrong(
                thing,
                format!(
                    "it has {} bytes by its byteLength, but {place} holds {}",
                    buffer.byte_length.0,
                    bytes.len()
                ),
            ));
        }
        self.files.extend(file);
        Ok(bytes)
    }
}

/// The JSON of a file, and its binary part.
fn parts(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), GltfFault> {
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

/// Whether the version and what the model requires are known.
fn check_head(head: &Head) -> Result<(), GltfFault> {
    let is_known = |version: &str| version == "2.0" || version == "2";
    let Asset {
        version,
        min_version,
    } = &head.asset;
    // A later version with the same major number can be read, unless it says otherwise.
    let of_version_2 = version.split('.').next() == Some("2");
    let needed = min_version.as_deref().filter(|&version| !is_known(version));
    if !of_version_2 || needed.is_some() {
        let version = needed.unwrap_or(version).to_owned();
        return Err(GltfFault::Version { version });
    }
    let unknown = head.extensions_required.iter().find(|name| {
        let is_of_material = OF_MATERIALS.iter().any(|prefix| name.starts_with(prefix));
        !(is_of_material || KNOWN.contains(&&name[..]))
    });
    match unknown {
        Some(extension) => Err(GltfFault::Extension {
            extension: extension.clone(),
            remedy: remedy(extension),
        }),
        None => Ok(()),
    }
}

/// What to do about an extension.
fn remedy(extension: &str) -> &'static str {
    match extension {
        "KHR_draco_mesh_compression" | "EXT_meshopt_compression" | "KHR_meshopt_compression" => {
            "export the model without compression"
        }
        "KHR_texture_basisu" | "EXT_texture_webp" | "EXT_texture_avif" | "MSFT_texture_dds" => {
            "export its textures as PNG or JPEG"
        }
        _ => "export the model without it",
    }
}

/// Extensions that the model uses and that nothing here tells of in detail.
pub(super) fn unknown_extensions(root: &Root) -> Vec<&str> {
    let used = root.extensions_used.iter().map(String::as_str);
    used.filter(|name| !KNOWN.contains(name))
        .filter(|name| !OF_MATERIALS.iter().any(|prefix| name.starts_with(prefix)))
        .collect()
}

/// Checks the whole document, but what is not used.
fn validate(root: &Root) -> Result<(), GltfFault> {
    // The crate looks up accessors before it checks their indices.
    let accessors = root.accessors.len();
    for (m, mesh) in root.meshes.iter().enumerate() {
        for (p, primitive) in mesh.primitives.iter().enumerate() {
            let beyond = |index: &&_| Index::value(*index) >= accessors;
            if let Some(index) = primitive.attributes.values().find(beyond) {
                return Err(wrong(
                    format!("meshes[{m}].primitives[{p}]"),
                    format!("an attribute has accessor {index}, the file has {accessors}"),
                ));
            }
        }
    }
    let mut first = None;
    let mut report = |path: &dyn Fn() -> gltf::json::Path, error: Invalid| {
        if first.is_some() {
            return;
        }
        let path = path().to_string();
        // Extensions have been checked, and the others are not used.
        let is_used = !path.starts_with("animations")
            && !path.starts_with("cameras")
            && !path.starts_with("skins")
            && !path.starts_with("extensionsRequired")
            && !path.ends_with("min")
            && !path.ends_with("max")
            && !path.contains("<invalid semantic name>");
        if is_used {
            first = Some((path, error));
        }
    };
    root.validate(root, gltf::json::Path::new, &mut report);
    match first {
        None => Ok(()),
        Some((thing, error)) => Err(wrong(
            thing,
            match error {
                Invalid::IndexOutOfBounds => "there is nothing of this index",
                Invalid::Missing => "it is missing",
                Invalid::Oversize => "it is larger than memory can be",
                Invalid::Invalid => "its value is none of those that glTF 2.0 has",
                Invalid::Unsupported => "it is not known",
            },
        )),
    }
}
