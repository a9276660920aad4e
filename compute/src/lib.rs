//! Hemicubes, form factors and solvers.

pub mod cpu;
pub mod delta_form_factors;
pub mod hemicube;
pub mod rows;
pub mod settings;
