//! The furnace: a closed box whose walls all emit E and reflect rho, so that B = E / (1 - rho)
//! everywhere, whatever the mesh. The standard check of a radiosity solver (Cohen and Wallace,
//! *Radiosity and Realistic Image Synthesis*, 1993).

use scene::Rgb;

use super::DEFAULT_REFLECTANCE;
use crate::Settings;
use crate::builder::Builder;
use crate::grid::Grid;

/// Default area threshold, m^2: 192 patches.
pub const MAX_AREA: f64 = 0.04;

/// Default exitance of the walls, W/m^2.
const EMISSION: f32 = 1.0;

pub fn build(settings: &Settings) -> Builder {
    let mut builder = Builder::default();
    let wall = builder.look(
        "wall",
        Rgb::splat(settings.reflectance.unwrap_or(DEFAULT_REFLECTANCE)),
        Rgb::splat(settings.light_power.unwrap_or(EMISSION)),
    );
    let unit = || vec![0.0, 1.0];
    for face in Grid::new([unit(), unit(), unit()]).faces() {
        builder.rectangle(face.plane, face.u, face.v, wall);
    }
    builder
}
