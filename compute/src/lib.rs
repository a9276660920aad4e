//! Hemicubes, form factors and solvers: the program `compute` and what it is made of.
//!
//! Each patch looks through a [hemicube](visibility::hemicube) at the scene's surfaces. The patches its pixels see, an
//! item buffer drawn by the [`cpu`] or the [`gpu`], weighted by [`delta_form_factors`], are its
//! [row](rows) of form factors. Rows are kept in a [`row_cache`], and a [`solver`] iterates on them;
//! [`run`](mod@run) joins all of it, with checkpoints, and [`report`]s.

pub mod backend;
pub mod cancel;
pub mod certificate;
pub mod compact_rows;
pub mod convex;
pub mod cpu;
pub mod delta_form_factors;
pub mod energy;
pub mod form_factors;
pub mod form_factors_csv;
pub mod gather;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod hemicubes;
pub mod lamps;
pub mod polygon_form_factor;
pub mod problem;
#[cfg(feature = "program")]
pub mod program;
pub mod quantity;
pub mod received;
pub mod receivers;
pub mod report;
pub mod row_cache;
pub mod row_file;
pub mod rows;
pub mod settings;
pub mod solve;
pub mod solver;
pub mod sources;
mod sphere;
mod triangle;
pub mod two_levels;
pub mod unlit;
pub mod verify;
pub mod view_factors;

pub use cancel::CancelToken;
pub use form_factors::FormFactors;
pub use solve::{Solve, Solved};
