//! Import of glTF 2.0 models: `.gltf` with its buffers and pictures, or `.glb`.
//!
//! # What is taken
//! - The triangles of the meshes that nodes of the default scene have, with the nodes' transforms: lists, strips and fans,
//!   with and without indices, sparse and quantized accessors. A transform that mirrors turns no front to the back.
//! - Meshes with skins are where the joints have them, moved by morph targets of the file's weights (`skins.rs`, `morphs.rs`).
//! - Each node with a mesh is an object; its name is the node's, else the mesh's. Of equal names the later ones have
//!   numbers: "Cube", "Cube.2".
//! - The base colour is the reflectance: the factor, which is linear, times the mean of the texture over each triangle
//!   (`import/texture_mean.rs`), times the mean of the corners' vertex colours (`COLOR_0`, section 3.9.2). A metal has it too,
//!   although it does not reflect diffusely. A reflectance of 1 or more is 0.95; primitives without a material have their
//!   vertex colours, else a grey of 0.5. Of `KHR_materials_pbrSpecularGlossiness` the diffuse colour counts.
//! - The emissive factor, times `KHR_materials_emissive_strength` and the mean of the texture, is a radiance L, W/(m^2 sr);
//!   the emission is the exitance M = pi L of a diffuse emitter.
//! - Double-sided materials have fronts on both sides.
//! - Lights of `KHR_lights_punctual` have no extent; bodies stand in for them (`lights.rs`).
//!
//! # What is left out
//! What [`crate::import`] says; wholly transparent is an alpha of 0 in the modes BLEND and MASK. Besides animations, cameras,
//! points and lines, primitives without POSITION, other scenes than the default one, and extensions that are not named here;
//! what a file has of these is told. A required extension that is not known is an error. What does not change a diffuse
//! reflectance is not told: roughness, ambient occlusion, and that a surface is a little glossy.
//!
//! # What is checked
//! What is used, and the document as a whole: indices, types, the trees of nodes. What nothing uses is not: values of
//! attributes that no material or skin asks for, normals of double-sided materials, buffers without views, bounds of accessors.
//!
//! # Coordinates
//! Metres with +Y up, as the format says, unless the options say otherwise.
//!
//! # How
//! The `gltf` crate has the types of the document and its validation; both of its layers above index without checks, so
//! that they panic on some files, and are not used. `document.rs` takes files apart, `json.rs` puts in order what the crate's
//! types would refuse or read wrongly, `elements.rs` reads accessors within their bounds, element by element, so that no count
//! in a file decides how much memory is taken.

mod build;
mod clusters;
mod container;
mod content;
mod document;
mod elements;
mod error;
mod extensions;
mod json;
mod layouts;
mod lights;
mod materials;
mod morphs;
mod names;
mod nodes;
mod pictures;
mod primitive;
mod shapes;
mod skins;
mod uri;
mod validity;

use std::path::Path;

pub use error::{GltfError, GltfFault};

use crate::import::{ImportOptions, ImportedModel};
use document::Document;

/// Reads a `.gltf` or `.glb` file, whichever it is, with the buffers and pictures that it names.
///
/// # Errors
/// Name the file and the thing at fault; see [`GltfFault`].
pub fn load(path: &Path) -> Result<ImportedModel, GltfError> {
    load_with(path, &ImportOptions::default())
}

/// The same, as the options say.
///
/// # Errors
/// As [`load`].
pub fn load_with(path: &Path, options: &ImportOptions) -> Result<ImportedModel, GltfError> {
    let fail = |fault| GltfError::new(path, fault);
    if let Some(value) = options.light_radius
        && !(value.is_finite() && value > 0.0)
    {
        return Err(fail(GltfFault::LightRadius { value }));
    }
    let bytes = std::fs::read(path).map_err(|source| fail(GltfFault::Io { source }))?;
    let document = Document::read(path, &bytes).map_err(fail)?;
    build::build(&document, options).map_err(fail)
}
