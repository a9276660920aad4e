//! Textures: their pictures, how they repeat, and where texture coordinates are in them.

use glam::{DMat2, DVec2};
use gltf::json::texture::{Info, WrappingMode};
use gltf::json::validation::Checked;

use super::GltfFault;
use super::document::Document;
use super::elements::view;
use super::error::wrong;
use super::materials::Mapping;
use super::uri::{Meaning, meaning};
use crate::Rgb;
use crate::import::{Picture, Textured, Wrap};

/// The texture of a material's property, and where texture coordinates are in it; `None` where no picture is named that can
/// be read.
pub(super) fn texture(
    document: &Document,
    info: &Info,
    factor: Rgb,
) -> Result<Option<(Textured, Mapping)>, GltfFault> {
    let texture = document.get(info.index)?;
    let Some(image) = document.root.get(texture.source) else {
        return Ok(None);
    };
    let index = texture.source;
    let thing = format!("images[{index}]");
    let inside = |bytes: Vec<u8>| Picture {
        name: format!("{}: {thing}", document.path.display()).into(),
        bytes: Some(bytes.into()),
    };
    let picture = match (image.buffer_view, &image.uri) {
        (Some(index), _) => inside(view(document, index)?.to_vec()),
        (None, Some(uri)) => {
            match meaning(&document.folder, uri).map_err(|why| wrong(&thing, why))? {
                Meaning::Data(bytes) => inside(bytes),
                Meaning::File(name) => Picture { name, bytes: None },
            }
        }
        (None, None) => {
            return Err(wrong(thing, "it has neither a bufferView nor a URI"));
        }
    };
    let mut wrap = [Wrap::Repeat; 2];
    if let Some(sampler) = texture.sampler {
        let sampler = document.get(sampler)?;
        wrap = [sampler.wrap_s, sampler.wrap_t].map(|mode| match mode {
            Checked::Valid(WrappingMode::ClampToEdge) => Wrap::Clamp,
            Checked::Valid(WrappingMode::MirroredRepeat) => Wrap::Mirror,
            _ => Wrap::Repeat,
        });
    }
    let textured = Textured {
        picture,
        factor,
        wrap,
    };
    Ok(Some((textured, mapping(info)?)))
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
