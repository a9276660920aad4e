//! A file taken apart: the container, the JSON, whether all of it is valid and known, and the buffers.

use std::collections::{BTreeSet, HashMap};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use gltf::json::buffer::View;
use gltf::json::{Index, Root, root::Get};

use super::error::wrong;
use super::json::Removed;
use super::uri::{Meaning, meaning};
use super::{GltfFault, container, json, validity};
use crate::import::files::read_regular;

/// A glTF file that is valid, with its buffers.
pub(super) struct Document {
    pub root: Root,
    /// What it had besides.
    pub removed: Removed,
    /// One per buffer, each at least as long as the document says; `None` where no view shows it.
    buffers: Vec<Option<Arc<[u8]>>>,
    /// What pictures inside of the file are named by.
    pub path: PathBuf,
    /// Where other files are.
    pub folder: PathBuf,
    /// The files of the buffers.
    pub files: Vec<PathBuf>,
}

impl Document {
    pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Self, GltfFault> {
        let (text, blob) = container::parts(bytes)?;
        let (root, removed) = json::read(text)?;
        validity::check(&root)?;
        let mut document = Self {
            root,
            removed,
            buffers: Vec::new(),
            path: path.to_owned(),
            folder: path.parent().unwrap_or(Path::new("")).to_owned(),
            files: Vec::new(),
        };
        document.read_buffers(blob)?;
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

    /// The bytes of a view.
    pub(super) fn view(&self, index: Index<View>) -> Result<&[u8], GltfFault> {
        let view = self.get(index)?;
        let buffer = view.buffer.value();
        let length = self.get(view.buffer)?.byte_length.0;
        let offset = view.byte_offset.unwrap_or_default().0;
        let end = offset.checked_add(view.byte_length.0);
        let found = end.filter(|&end| end <= length).and_then(|end| {
            let bytes = self.buffers.get(buffer)?.as_ref()?;
            bytes.get(usize::try_from(offset).ok()?..usize::try_from(end).ok()?)
        });
        found.ok_or_else(|| {
            wrong(
                format!("bufferViews[{index}]"),
                format!(
                    "{} bytes from byte {offset} on go beyond the {length} bytes of buffers[{buffer}]",
                    view.byte_length.0
                ),
            )
        })
    }

    /// Reads what views show, each file once.
    fn read_buffers(&mut self, blob: Option<&[u8]>) -> Result<(), GltfFault> {
        let views = self.root.buffer_views.iter();
        let shown: BTreeSet<usize> = views.map(|view| view.buffer.value()).collect();
        let mut files = HashMap::new();
        self.buffers = vec![None; self.root.buffers.len()];
        for (index, bytes) in self.buffers.iter_mut().enumerate() {
            let Some(buffer) = self
                .root
                .buffers
                .get(index)
                .filter(|_| shown.contains(&index))
            else {
                continue;
            };
            let thing = format!("buffers[{index}]");
            let mut place = "the file".to_owned();
            let found = match (&buffer.uri, blob) {
                (Some(uri), _) => {
                    match meaning(&self.folder, uri).map_err(|why| wrong(&thing, why))? {
                        Meaning::Data(bytes) => bytes.into(),
                        Meaning::File(path) => {
                            place = path.display().to_string();
                            file(path, &thing, &mut files, &mut self.files)?
                        }
                    }
                }
                (None, Some(blob)) if index == 0 => blob.into(),
                (None, _) => {
                    return Err(wrong(
                        thing,
                        "it has no URI, and the file has no binary part for it; export the model again",
                    ));
                }
            };
            let (length, has) = (buffer.byte_length.0, found.len());
            if (has as u64) < length {
                return Err(wrong(
                    thing,
                    format!("it has {length} bytes by its byteLength, but {place} holds {has}"),
                ));
            }
            *bytes = Some(found);
        }
        Ok(())
    }
}

/// The bytes of a buffer's file, which is read once.
fn file(
    path: PathBuf,
    thing: &str,
    known: &mut HashMap<PathBuf, Arc<[u8]>>,
    files: &mut Vec<PathBuf>,
) -> Result<Arc<[u8]>, GltfFault> {
    if let Some(bytes) = known.get(&path) {
        return Ok(bytes.clone());
    }
    let bytes: Arc<[u8]> = read_regular(&path)
        .map_err(|error| {
            let path = path.display();
            wrong(
                thing,
                format!("cannot read its file {path}: {error}; put it beside the model, or export one .glb file"),
            )
        })?
        .into();
    files.push(path.clone());
    known.insert(path, bytes.clone());
    Ok(bytes)
}
