//! Materials: diffuse reflectance and emission, linear RGB.

use crate::{Rgb, SceneError};

/// A diffuse, opaque, one-sided material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name, from MTL's `newmtl` or given by the model; need not be unique.
    pub name: String,
    /// Diffuse hemispherical reflectance rho, dimensionless, each channel in [0, 1).
    pub reflectance: Rgb,
    /// Self-emitted exitance E, W/m^2, each channel finite and at least 0.
    pub emission: Rgb,
}

impl Material {
    /// True where some channel emits.
    pub fn is_emitter(&self) -> bool {
        self.emission.max_element() > 0.0
    }

    /// Checks the ranges the fields state.
    pub fn validate(&self) -> Result<(), SceneError> {
        for (channel, value) in ["red", "green", "blue"]
            .into_iter()
            .zip(self.reflectance.to_array())
        {
            if !(0.0..1.0).contains(&value) {
                return Err(SceneError::Reflectance {
                    material: self.name.clone(),
                    channel,
                    value,
                });
            }
        }
        for (channel, value) in ["red", "green", "blue"]
            .into_iter()
            .zip(self.emission.to_array())
        {
            if !(value.is_finite() && value >= 0.0) {
                return Err(SceneError::Emission {
                    material: self.name.clone(),
                    channel,
                    value,
                });
            }
        }
        Ok(())
    }
}
