//! Extreme conditions on the cpu back end: each test is a law, with its expectation and tolerance derived.

#[path = "../common/mod.rs"]
mod common;

mod emission;
mod reflectance;
