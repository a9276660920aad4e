//! The cpu back end: hemicubes drawn on all cores, in plain Rust. The readable twin of [`crate::gpu`].

pub mod item_buffer;
mod look_up;
mod projection;
mod raster;
pub mod rows;

pub use projection::{COORDINATE_ULPS, Cull, Projection, is_in_plane, plane_tolerance, reach};
pub use raster::{Raster, Sample};
pub use rows::CpuRows;
