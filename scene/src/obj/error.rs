//! Why an OBJ file or one of its MTL files could not be imported.

use std::path::{Path, PathBuf};

use crate::SceneError;

/// Why an import failed.
#[derive(Debug, thiserror::Error)]
#[error("{}: {fault}", path.display())]
pub struct ObjError {
    /// The file at fault: the OBJ file, or an MTL file it names.
    pub path: PathBuf,
    /// What is wrong with it.
    pub fault: ObjFault,
}

impl ObjError {
    pub(super) fn new(path: &Path, fault: ObjFault) -> Self {
        Self {
            path: path.to_owned(),
            fault,
        }
    }
}

/// What can be wrong with an OBJ or MTL file. Lines and vertices are counted from 1.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum ObjFault {
    #[error("cannot read: {source}")]
    Io { source: std::io::Error },
    #[error("the file is empty")]
    Empty,
    #[error("not an OBJ file: {why}; give a Wavefront OBJ with vertices (\"v\") and faces (\"f\")")]
    NotObj { why: &'static str },
    #[error("line {line}: {what}")]
    Statement { line: usize, what: String },
    #[error("line {line}: vertex {vertex}: coordinate {value} is not finite")]
    NotFinite {
        line: usize,
        vertex: usize,
        value: f64,
    },
    #[error(
        "line {line}: a face refers to vertex {index}, the file has {vertices}, counted from 1, or from -1 backwards"
    )]
    VertexIndex {
        line: usize,
        index: i64,
        vertices: usize,
    },
    #[error("{vertices} vertices but no faces (\"f\" with three or more corners)")]
    NoFaces { vertices: usize },
    #[error(
        "line {line}: coordinate {value:e} of a corner, {from_centre:e} from the model's centre, is over the limit {:e} of single precision; scale the model down",
        f32::MAX
    )]
    Overflow {
        line: usize,
        value: f64,
        from_centre: f64,
    },
    #[error(
        "all {triangles} triangles have materials that are wholly transparent; nothing is left"
    )]
    AllTransparent { triangles: usize },
    #[error("all {triangles} triangles are degenerate (no area beyond rounding); nothing is left")]
    NothingLeft { triangles: usize },
    #[error(transparent)]
    Material(SceneError),
    /// tobj refused what had passed the checks before it.
    #[error("cannot be parsed: {0}")]
    Parser(tobj::LoadError),
}
