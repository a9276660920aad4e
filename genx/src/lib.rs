//! Scenes to solve: the thesis's three models, the Cornell box, a furnace, and any OBJ or glTF file.
//!
//! [`make`] turns [`Settings`] into a [`scene::Scene`]. A model is a few *surfaces*, triangles whose
//! longest side is at most twice their shortest; the area threshold then decides how many patches
//! the bisection mesh lays over them. Surfaces meet corner to corner (no corner lies inside another
//! surface's side) and share the same bits there, so that what draws them leaves no cracks.
//!
//! Lengths are metres with y up, exitances W/m^2, colours linear RGB.

mod builder;
mod changes;
pub mod cut;
mod extent;
mod grid;
mod models;
mod openings;
mod settings;

pub use changes::{Change, Look, UnknownName};
pub use extent::FarAway;
pub use models::make;
pub use settings::{Format, Model, Settings, SettingsError, UnknownModel};

/// What [`make`] made.
#[derive(Clone, Debug)]
pub struct Made {
    /// The scene, without a solution.
    pub scene: scene::Scene,
    /// What a user should know but need not act on, one sentence each.
    pub warnings: Vec<String>,
    /// What was read, when it came from a file.
    pub imported: Option<Imported>,
    /// All files that were read, or asked for.
    pub files: Vec<std::path::PathBuf>,
}

/// What a file held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Imported {
    /// Faces in the file, of any number of corners.
    pub faces: usize,
    /// Those with more than three corners, which were cut into triangles.
    pub polygons: usize,
}

/// Why a scene could not be made.
#[derive(Debug, thiserror::Error)]
pub enum GenxError {
    /// A setting is outside its range.
    #[error(transparent)]
    Settings(#[from] SettingsError),
    /// The OBJ file cannot be used.
    #[error(transparent)]
    Obj(#[from] scene::obj::ObjError),
    /// The glTF file cannot be used.
    #[error(transparent)]
    Gltf(#[from] scene::gltf::GltfError),
    /// Something lies so far away that nothing else is where it should be.
    #[error(transparent)]
    FarAway(#[from] FarAway),
    /// More overlaps in one plane than can be put in order.
    #[error(transparent)]
    TooMuchToCut(#[from] cut::TooMuchToCut),
    /// Something is to change that is not there.
    #[error(transparent)]
    UnknownName(#[from] UnknownName),
    /// The result is no valid scene, for example for too many patches.
    #[error(transparent)]
    Scene(#[from] scene::SceneError),
}
