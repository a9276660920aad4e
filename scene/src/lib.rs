//! What a radiosity problem is made of, and how it is kept.
//!
//! A [`Scene`] has few *surfaces* (triangles, which occlude) and many *patches* (the unknowns, the
//! leaves of the surfaces' bisection trees). A [`Solution`] holds the irradiance of each patch.
//! Both live in one kind of [`mod@file`]; scenes come from [`obj`] files or models, and results
//! leave as [`export`]s.
//!
//! Lengths are metres, powers W, exitances and irradiances W/m^2, colours linear RGB.

mod axes;
pub mod bisection;
mod error;
pub mod export;
pub mod file;
pub mod function;
pub mod gltf;
mod ids;
pub mod import;
pub mod layers;
mod material;
mod mesh;
pub mod obj;
pub mod planar;
mod recorded_settings;
mod scene;
mod solution;
pub mod srgb;
mod surface;
pub mod weld;

pub use axes::{Axis, ModelAxes};
pub use error::SceneError;
pub use ids::{MAX_PATCHES, MaterialId, NO_PATCH, ObjectId, PatchId, SurfaceId};
pub use material::Material;
pub use mesh::{Mesh, Tree};
pub use recorded_settings::{Difference, Recorded, RecordedSettings};
pub use scene::{Opening, Patch, Rgb, Scene};
pub use solution::{Level, Provenance, Solution, State};
pub use surface::Surface;
