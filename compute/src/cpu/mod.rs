//! The cpu back end: hemicubes drawn on all cores, in plain Rust. The readable twin of [`crate::gpu`].

pub mod item_buffer;
mod raster;
pub mod rows;

pub use raster::{Cull, Projection, Raster, Sample, plane_tolerance};
pub use rows::CpuRows;
