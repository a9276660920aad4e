//! A solution: what the solver knows about each patch, and how it came to know it.
//!
//! B = E + rho H, for each patch and channel: radiosity B (total exitance), emission E
//! (self-emitted exitance) and irradiance H, all W/m^2, reflectance rho, dimensionless. The
//! irradiance is what is stored; the radiosity follows from it.

use serde::{Deserialize, Deserializer, Serialize};

use crate::{Rgb, Scene, SceneError};

/// How a solution was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name of the solver.
    pub solver: String,
    /// The settings that change the result, as text; compared when a run is continued.
    pub settings: String,
    /// Iterations the solution has had.
    pub iterations: u64,
    /// Relative residual after each of those iterations that were done with these settings,
    /// dimensionless.
    #[serde(deserialize_with = "numbers_or_null")]
    pub residuals: Vec<f64>,
    /// Where the irradiances are those of coarser sources, and each patch has that of its source: what is left
    /// to do until it has its own.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sources: Option<Sources>,
}

/// Coarse sources, each a node of a surface's bisection tree, on the way to a solution of the patches.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Sources {
    /// Their largest area, m^2, where patches are smaller.
    pub max_area: f64,
    /// Whether they are solved, and the patches are gathering from them: what is unfinished then is what the first
    /// patches have gathered.
    pub is_gathering: bool,
}

/// JSON knows no infinity and no NaN, and writes null for them. A result must stay readable with
/// such a residual in its history.
fn numbers_or_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    let values = Vec::<Option<f64>>::deserialize(deserializer)?;
    Ok(values.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect())
}

/// An iteration that was stopped on its way.
#[derive(Clone, Debug, PartialEq)]
pub struct Unfinished {
    /// The next iteration's irradiances of the first patches, W/m^2.
    pub irradiance: Vec<Rgb>,
}

/// Irradiances of all patches, and what is needed to go on from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Irradiance H, W/m^2, one per patch.
    pub irradiance: Vec<Rgb>,
    /// How it was made.
    pub provenance: Provenance,
    /// What an interrupted iteration had reached, if one was.
    pub unfinished: Option<Unfinished>,
    /// Unshot radiosity, W/m^2, one per patch, may be negative; shooting only.
    pub unshot: Option<Vec<Rgb>>,
    /// What the exact sum of all that a patch received is more than its irradiance, W/m^2, one per patch, may
    /// be negative and is less than a rounding; shooting only. Older files do not have it and go on without.
    pub remainder: Option<Vec<Rgb>>,
}

impl Solution {
    /// The start of every solver: no irradiance anywhere.
    pub fn dark(scene: &Scene) -> Self {
        Self {
            irradiance: vec![Rgb::ZERO; scene.patch_count() as usize],
            provenance: Provenance::default(),
            unfinished: None,
            unshot: None,
            remainder: None,
        }
    }

    /// Checks the lengths, that a source's area is above 0, that every value is finite, and that irradiances are at least 0.
    pub fn validate(&self, scene: &Scene) -> Result<(), SceneError> {
        let patches = scene.patch_count();
        if let Some(sources) = self.provenance.sources
            && !(sources.max_area > 0.0 && sources.max_area.is_finite())
        {
            return Err(SceneError::SourceArea {
                value: sources.max_area,
            });
        }
        let unfinished = self.unfinished.as_ref().map(|u| &u.irradiance);
        for (values, complete, least) in [
            (Some(&self.irradiance), true, 0.0),
            (unfinished, false, 0.0),
            (self.unshot.as_ref(), true, f32::MIN),
            (self.remainder.as_ref(), true, f32::MIN),
        ] {
            let Some(values) = values else { continue };
            if values.len() > patches as usize || (complete && values.len() != patches as usize) {
                return Err(SceneError::SolutionLength {
                    values: values.len(),
                    patches,
                });
            }
            for (patch, value) in values.iter().enumerate() {
                for value in value.to_array() {
                    if !(value.is_finite() && value >= least) {
                        return Err(SceneError::Irradiance {
                            patch: patch as u32,
                            value,
                        });
                    }
                }
            }
        }
        Ok(())
    }

    /// Share of the next iteration that is done, 0 to 1.
    pub fn next_iteration_share(&self) -> f64 {
        let done = self.unfinished.as_ref().map_or(0, |u| u.irradiance.len());
        done as f64 / self.irradiance.len() as f64
    }

    /// Radiosities B = E + rho H, W/m^2, one per patch.
    pub fn radiosity(&self, scene: &Scene) -> Vec<Rgb> {
        let mut radiosity = scene.patch_emissions();
        let reflectance = scene.patch_reflectances();
        for ((b, rho), h) in radiosity.iter_mut().zip(reflectance).zip(&self.irradiance) {
            *b += rho * *h;
        }
        radiosity
    }
}
