//! The cpu back end: hemicubes drawn on all cores, in plain Rust. The readable twin of [`crate::gpu`].

mod cast;
mod clusters;
mod coarse_depth;
mod distant;
mod drawable;
mod hierarchy;
mod horizon;
pub mod item_buffer;
mod locate;
mod look_up;
mod outside;
mod over_pixels;
mod projection;
mod raster;
pub mod regions;
mod rounding;
pub mod rows;
mod runs;
mod specks;
#[cfg(test)]
mod test_scenes;
mod tried;
mod vectors;
mod walk;

pub use drawable::Drawable;
pub use projection::{Cull, Projection};
pub use raster::{Raster, Sample};
pub use rounding::{COORDINATE_ULPS, is_in_plane, plane_tolerance, reach};
pub use rows::CpuRows;
