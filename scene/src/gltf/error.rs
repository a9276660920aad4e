//! Why a glTF file could not be imported.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use gltf::json;

use crate::{MAX_PATCHES, SceneError};

/// Why an import failed.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct GltfError {
    /// The `.gltf` or `.glb` file.
    pub path: PathBuf,
    /// What is wrong with it, or with a file that it names.
    pub fault: GltfFault,
}

impl GltfError {
    pub(super) fn new(path: &Path, fault: GltfFault) -> Self {
        Self {
            path: path.to_owned(),
            fault,
        }
    }
}

/// What can be wrong with a glTF file. Things are named as in its JSON and counted from 0.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum GltfFault {
    #[error("cannot read: {source}")]
    Io { source: std::io::Error },
    #[error("the file is empty")]
    Empty,
    #[error("not a glTF file: {why}")]
    NotGltf { why: String },
    #[error("the file is cut off or damaged: {why}")]
    Container { why: String },
    #[error("the JSON is not that of a glTF 2.0 file: {0}")]
    Json(json::Error),
    #[error("{place}: {source}")]
    Member { place: String, source: json::Error },
    #[error("glTF version {version} is not known, only 2.0 is; export the model again as glTF 2.0")]
    Version { version: String },
    #[error("the model requires the extension {extension}, which is not known; {remedy}")]
    Extension {
        extension: String,
        remedy: &'static str,
    },
    #[error("{thing}: {what}")]
    Thing { thing: String, what: String },
    #[error(
        "{thing}: coordinate {value:e} of a corner, {from_centre:e} from the model's centre, is over the limit {:e} of single precision; scale the model down",
        f32::MAX
    )]
    Overflow {
        thing: String,
        value: f64,
        from_centre: f64,
    },
    #[error("no node of the scene has triangles; export the model's meshes with it")]
    NoTriangles,
    #[error(
        "the nodes have {triangles} triangles or more, the limit is {MAX_PATCHES} (24-bit patch IDs); simplify the model"
    )]
    TooManyTriangles { triangles: u64 },
    #[error("light radius {value} m is not a finite number above 0")]
    LightRadius { value: f64 },
    #[error(
        "all {triangles} triangles have materials that are wholly transparent; nothing is left"
    )]
    AllTransparent { triangles: usize },
    #[error("all {triangles} triangles are degenerate (no area beyond rounding); nothing is left")]
    NothingLeft { triangles: usize },
    #[error(transparent)]
    Material(SceneError),
}

/// What is wrong with a thing.
pub(super) fn wrong(thing: impl Display, what: impl Display) -> GltfFault {
    GltfFault::Thing {
        thing: thing.to_string(),
        what: what.to_string(),
    }
}
