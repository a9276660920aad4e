//! The radiosity equation's known quantities, one per patch.

use scene::{Rgb, Scene};

/// What is known of each patch. All vectors have one element per patch.
#[derive(Clone, Debug)]
pub struct Problem {
    /// Area A, m^2.
    pub areas: Vec<f64>,
    /// Reflectance rho, dimensionless.
    pub reflectance: Vec<Rgb>,
    /// Emission E, W/m^2.
    pub emission: Vec<Rgb>,
}

impl Problem {
    /// The problem a scene poses.
    pub fn new(scene: &Scene) -> Self {
        Self {
            areas: scene.patch_areas(),
            reflectance: scene.patch_reflectances(),
            emission: scene.patch_emissions(),
        }
    }

    /// Number of patches.
    pub fn patch_count(&self) -> usize {
        self.areas.len()
    }

    /// Radiosity B = E + rho H of one patch, W/m^2.
    #[inline]
    pub fn radiosity(&self, patch: usize, irradiance: Rgb) -> Rgb {
        self.emission[patch] + self.reflectance[patch] * irradiance
    }
}
