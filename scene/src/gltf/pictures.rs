//! Textures: their pictures, how they repeat, and where texture coordinates are in them.

use std::collections::HashMap;

use glam::{DMat2, DVec2};
use gltf::json::image::Image;
use gltf::json::texture::{Info, WrappingMode};
use gltf::json::validation::Checked;
use gltf::json::{Index, texture::Sampler};

use super::GltfFault;
use super::document::Document;
use super::error::wrong;
use super::uri::{Meaning, meaning};
use crate::Rgb;
use crate::import::{Picture, Textured, Wrap};

/// Where texture coordinates are in a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mapping {
    /// The number of the coordinates' set.
    pub set: u32,
    /// What they are multiplied by.
    pub scaled: DMat2,
    /// What is then added.
    pub offset: DVec2,
}

impl Mapping {
    pub(super) fn apply(&self, coordinates: DVec2) -> DVec2 {
        self.scaled * coordinates + self.offset
    }
}

/// The pictures of a document, each of which is taken out of it once.
pub(super) struct Pictures<'a> {
    document: &'a Document,
    /// By the file's number.
    known: HashMap<usize, Picture>,
}

impl<'a> Pictures<'a> {
    pub(super) fn new(document: &'a Document) -> Self {
        Self {
            document,
            known: HashMap::new(),
        }
    }

    /// The texture of a material's property, and where texture coordinates are in it; `None` where no picture is named that
    /// can be read.
    pub(super) fn texture(
        &mut self,
        info: &Info,
        factor: Rgb,
    ) -> Result<Option<(Textured, Mapping)>, GltfFault> {
        let texture = self.document.get(info.index)?;
        let Some(image) = self.document.root.get(texture.source) else {
            return Ok(None);
        };
        let textured = Textured {
            picture: self.picture(texture.source, image)?,
            factor,
            wrap: self.wrap(texture.sampler)?,
        };
        Ok(Some((textured, mapping(info)?)))
    }

    fn picture(&mut self, index: Index<Image>, image: &Image) -> Result<Picture, GltfFault> {
        if let Some(known) = self.known.get(&index.value()) {
            return Ok(known.clone());
        }
        let thing = format!("images[{index}]");
        let inside = |bytes: &[u8]| Picture {
            name: format!("{}: {thing}", self.document.path.display()).into(),
            bytes: Some(bytes.into()),
        };
        let picture = match (image.buffer_view, &image.uri) {
            (Some(view), _) => inside(self.document.view(view)?),
            (None, Some(uri)) => {
                let meaning = meaning(&self.document.folder, uri);
                match meaning.map_err(|why| wrong(&thing, why))? {
                    Meaning::Data(bytes) => inside(&bytes),
                    Meaning::File(name) => Picture { name, bytes: None },
                }
            }
            (None, None) => {
                return Err(wrong(thing, "it has neither a bufferView nor a URI"));
            }
        };
        self.known.insert(index.value(), picture.clone());
        Ok(picture)
    }

    fn wrap(&self, sampler: Option<Index<Sampler>>) -> Result<[Wrap; 2], GltfFault> {
        let Some(sampler) = sampler else {
            return Ok([Wrap::Repeat; 2]);
        };
        let sampler = self.document.get(sampler)?;
        Ok([sampler.wrap_s, sampler.wrap_t].map(|mode| match mode {
            Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
            Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
            _ => Wrap::Repeat,
        }))
    }
}

/// Where texture coordinates are, by `KHR_texture_transform`.
fn mapping(info: &Info) -> Result<Mapping, GltfFault> {
    let transform = info
        .extensions
        .as_ref()
        .and_then(|extensions| extensions.texture_transform.as_ref());
    let Some(transform) = transform else {
        return Ok(Mapping {
            set: info.tex_coord,
            scaled: DMat2::IDENTITY,
            offset: DVec2::ZERO,
        });
    };
    let [scale, offset] =
        [transform.scale.0, transform.offset.0].map(|pair| DVec2::from(pair.map(f64::from)));
    // Counter-clockwise as the picture is seen, whose v points down.
    let rotation = DMat2::from_angle(-f64::from(transform.rotation.0));
    let mapping = Mapping {
        set: transform.tex_coord.unwrap_or(info.tex_coord),
        scaled: rotation * DMat2::from_diagonal(scale),
        offset,
    };
    if mapping.scaled.is_finite() && mapping.offset.is_finite() {
        Ok(mapping)
    } else {
        Err(wrong(
            format!("KHR_texture_transform of textures[{}]", info.index),
            "its values are not finite",
        ))
    }
}
