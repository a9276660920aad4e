//! Form factors by hemicubes, and solvers of the radiosity equation: the library of the program `compute`.
//!
//! ```
//! # let scene = genx::make(&genx::Settings::new(genx::Model::Furnace)).unwrap().scene;
//! let solved = compute::Solve::new(&scene).resolution(64).run()?;
//! println!("{}", solved.certificate().summary());
//! // In a furnace of reflectance 0.5 that emits 1 W/m^2 everything has a radiosity of 2 W/m^2.
//! assert!(solved.radiosity().iter().all(|b| (b - 2.0).abs().max_element() < 1e-4));
//! # Ok::<(), compute::solve::SolveError>(())
//! ```
//!
//! Hemicubes stand at [`receivers`] and see [`sources`]. [`FormFactors`] puts their [rows] together: item buffers of
//! [`visibility`], drawn by the [`cpu`] or the gpu, weighted by [`delta_form_factors`]; views of [`lamps`]; formulas of
//! [`convex`] rooms. Rows are kept in a [`row_cache`], and a [`solver`] iterates on them. [`Solve`] joins all of it.
//!
//! # Features
//! `gpu` is the gpu back end, `program` the command line with what it needs; both are on by default.

pub mod backend;
pub mod cancel;
pub mod certificate;
pub mod compact_rows;
pub mod compare;
pub mod convex;
pub mod cpu;
pub mod delta_form_factors;
pub mod energy;
pub mod finer;
mod foot;
pub mod form_factors;
pub mod form_factors_csv;
pub mod function;
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
pub mod stand_in;
mod triangle;
pub mod two_levels;
pub mod unlit;
pub mod verify;
pub mod view_factors;
pub mod walls;

pub use cancel::CancelToken;
pub use form_factors::FormFactors;
pub use solve::{Solve, Solved};

/// The examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../../README.md")]
struct Readme;
