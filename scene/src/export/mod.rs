//! Exports to other programs' formats, one file per format.
//!
//! | module | what it is for | positions |
//! |---|---|---|
//! | [`csv`] | analysis: all values of all patches | original, f64 |
//! | [`ply`] | looking at the solution in a mesh viewer | original, f64 |
//! | [`glb`] | looking at the solution in a browser or a game engine | relative to the origin, f32; the node moves them back |
//! | [`obj`] | the mesh and the materials, for another radiosity program or a new import | original, f64 |
//!
//! Original coordinates are the model's own, in its own unit, before the scene's origin was subtracted. No format turns
//! the axes. All files replace what was there at once or not at all
//! ([`crate::file::write_atomically`]).

pub mod csv;
pub mod glb;
pub mod obj;
pub mod ply;

use std::path::Path;

use glam::{DVec3, Vec3};

use crate::file::{FileError, FileFault};
use crate::{ModelAxes, Patch, PatchId, Scene};

/// Digits behind the first of a coordinate: those of an f32 at least, and of an f64 at most.
const LEAST_DIGITS: usize = 6;
const MOST_DIGITS: usize = 16;

/// All patches, in patch order.
fn patches(scene: &Scene) -> impl Iterator<Item = Patch> + '_ {
    (0..scene.patch_count()).map(|patch| scene.patch(PatchId(patch)))
}

/// A position in the model's own coordinates. With a unit, so many digits as tell it from its neighbours, since a unit leaves
/// digits behind that the model never had.
fn original(scene: &Scene, position: Vec3) -> DVec3 {
    // Adding zero turns -0 into 0.
    let place = scene.to_model(position.as_dvec3()) + DVec3::ZERO;
    if scene.axes() == ModelAxes::default() {
        return place;
    }
    let mut shortest = place;
    for axis in 0..3 {
        let is_same = |value: &f64| {
            let place = DVec3::AXES[axis] * *value;
            scene.to_scene(place).as_vec3()[axis].to_bits() == position[axis].to_bits()
        };
        let digits = LEAST_DIGITS..=MOST_DIGITS;
        let mut rounded = digits.filter_map(|n| format!("{:.n$e}", place[axis]).parse().ok());
        shortest[axis] = rounded.find(is_same).unwrap_or(place[axis]);
    }
    shortest + DVec3::ZERO
}

/// Checks that there is one colour per patch.
fn check_colors(path: &Path, scene: &Scene, colors: &[[u8; 3]]) -> Result<(), FileError> {
    let patches = scene.patch_count();
    if colors.len() == patches as usize {
        Ok(())
    } else {
        Err(FileError {
            path: path.to_owned(),
            fault: FileFault::ColorCount {
                colors: colors.len(),
                patches,
            },
        })
    }
}
