//! The gpu back end: hemicubes drawn and summed by wgpu, headless, on any adapter. The fast twin of
//! [`crate::cpu`].
//!
//! # Theory
//! As in [`crate::cpu`]: surfaces are drawn, patches are looked up, and the delta form factors of the
//! pixels that see a patch are summed as integers. Integer sums do not depend on their order, so
//! rows have the same bits as the cpu's wherever the item buffers agree.
//!
//! # Practice
//! The picture of a hemicube (width R, height 3R) is cut into three square *tiles*: the top face,
//! then two half faces each. Tiles of many hemicubes fill one atlas. A submission is few commands however many
//! tiles it has ([`item_buffer`]): `projection.wgsl` finds which surfaces come into which face, and all that
//! is the same for their pixels; then the fixed pipeline draws all of them in one indirect draw, or a compute
//! shader does ([`raster`]), whichever was faster in a short race. The pixels are then summed by patch on
//! the device ([`merger`]); only the non-zero
//! form factors are read back ([`rows`]). Tiles, not hemicubes, are what a submission is measured
//! in, so that the same code serves thousands of 100 x 100 hemicubes in a submission, one of
//! 4096 x 4096 in several, and a row of a thousand hemicubes.
//!
//! Submissions are timed, and their size follows, so that none comes near a driver's watchdog ([`pace`]).
//! While the device draws one, the host prepares the next and reads what the one before has given.
//! No wgpu error panics: see [`adapter`].
//!
//! # Differences
//! The cpu sets surfaces up in f64; here it is f32, relative to the eye and in the scene's axes. Where
//! a pixel's ray passes an edge (of a surface or of a patch) within rounding, the two may see different
//! patches. What lies below the horizon is left out by the host, in f64, with the cpu's tolerance ([`horizon`]);
//! what lies beside a face, by the device, where it is certain. The cpu draws coplanar neighbours as a few
//! convex pieces and asks afterwards which surface a pixel sees; here surfaces are drawn one by one.
//!
//! GPUs round corners to some 1/256 of a pixel, and what touches without sharing corners comes apart. So
//! surfaces are rasterised a little too large ([`structs::RASTERISED_OUTSET`]), and each pixel finds out
//! for itself, as on the cpu, whether its ray meets the surface, and how far away. Fronts are too large by
//! what rounding can do ([`structs::FRONT_FACE_OUTSET`]), backs by nothing: their edges are
//! the same to the bit from either side, so that no ray passes between two, and where one meets a
//! front at a silhouette, the front wins ([`structs::BACK_FACE_RETREAT`]). What a pixel sees then
//! follows from the arithmetic at its centre, whatever a rasteriser does.
//!
//! A row must have the same bits whatever it is drawn together with. So that this does not hang on how
//! corners are rounded either, a hemicube's place in the atlas follows from its number alone. Another
//! adapter may give other bits, where it rounds products and sums together.

pub mod adapter;
pub mod atlas;
pub mod horizon;
pub mod item_buffer;
pub mod merger;
pub mod pace;
mod race;
pub mod raster;
pub mod readback;
pub mod rows;
pub mod structs;

pub use raster::Raster;
pub use rows::GpuRows;
