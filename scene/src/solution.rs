//! A solution: what the solver knows about each patch, and how it came to know it.
//!
//! B = E + rho H, for each patch and channel: radiosity B (total exitance), emission E
//! (self-emitted exitance) and irradiance H, all W/m^2, reflectance rho, dimensionless. The
//! irradiance is what is stored; the radiosity follows from it.

use serde::{Deserialize, Deserializer, Serialize};

use crate::function::IrradianceFunction;
use crate::layers::Layers;
use crate::{PatchId, RecordedSettings, Rgb, Scene, SceneError};

/// How a solution was made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// The settings on which the result depends, compared when a run is continued; `None` where a file of version 1
    /// does not say, and where nothing has been solved.
    pub settings: Option<RecordedSettings>,
    /// Iterations the solution has had.
    pub iterations: u64,
    /// Relative residual after each of those iterations that were done with these settings,
    /// dimensionless.
    #[serde(deserialize_with = "numbers_or_null")]
    pub residuals: Vec<f64>,
    /// Among what the irradiances were solved.
    pub level: Level,
    /// Where the first iteration has not ended: the irradiances are what so many shots of the brightest patches brought, for the eye
    /// alone. A solver goes on from darkness.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub start_up_shots: u64,
}

#[expect(clippy::trivially_copy_pass_by_ref, reason = "serde hands references")]
fn is_zero(number: &u64) -> bool {
    *number == 0
}

/// Where a solution stands between levels: coarser sources, nodes of the surfaces' bisection trees, may be solved
/// before the patches have irradiances of their own.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Level {
    /// All patches have irradiances of their own.
    #[default]
    Patches,
    /// As well; sources have been tried, and none of them was good enough.
    PatchesAfterSources,
    /// Sources are being solved: each patch has the irradiance of its source.
    Sources {
        /// Their largest area, m^2, where patches are smaller.
        max_area: f64,
    },
    /// Sources are solved, each patch has the irradiance of its source, and the patches are gathering their own.
    Gathering {
        /// The sources' largest area, m^2, where patches are smaller.
        max_area: f64,
        /// What the first patches have gathered, W/m^2. A file has it outside of the provenance.
        #[serde(skip)]
        gathered: Vec<Rgb>,
    },
}

impl Level {
    /// The largest area of the sources whose irradiances the patches have, m^2; `None` where they have their own.
    pub fn source_area(&self) -> Option<f64> {
        match *self {
            Self::Patches | Self::PatchesAfterSources => None,
            Self::Sources { max_area } | Self::Gathering { max_area, .. } => Some(max_area),
        }
    }
}

/// JSON knows no infinity and no NaN, and writes null for them. A result must stay readable with
/// such a residual in its history.
fn numbers_or_null<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Vec<f64>, D::Error> {
    let values = Vec::<Option<f64>>::deserialize(deserializer)?;
    Ok(values.into_iter().map(|v| v.unwrap_or(f64::NAN)).collect())
}

/// What a solver has under way, beside the irradiances.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum State {
    /// Nothing: every solver can start from here.
    #[default]
    AtRest,
    /// A gathering solver's iteration that was stopped on its way.
    Unfinished {
        /// The next iteration's irradiances of the first patches, W/m^2.
        irradiance: Vec<Rgb>,
    },
    /// All that shooting has to know.
    Shooting {
        /// Unshot radiosity, W/m^2, one per patch, may be negative.
        unshot: Vec<Rgb>,
        /// What the exact sum of all that a patch received is more than its irradiance, W/m^2, one per patch, may be
        /// negative and is less than a rounding.
        remainder: Vec<Rgb>,
    },
}

impl State {
    /// The same of other patches or sources, each of whose arrays `map` makes of one of these.
    #[must_use]
    pub fn map(self, map: impl Fn(&[Rgb]) -> Vec<Rgb>) -> Self {
        match self {
            Self::AtRest => Self::AtRest,
            Self::Unfinished { irradiance } => Self::Unfinished {
                irradiance: map(&irradiance),
            },
            Self::Shooting { unshot, remainder } => Self::Shooting {
                unshot: map(&unshot),
                remainder: map(&remainder),
            },
        }
    }
}

/// Irradiances of all patches, and what is needed to go on from them.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// Irradiance H, W/m^2, one per patch.
    pub irradiance: Vec<Rgb>,
    /// How it was made.
    pub provenance: Provenance,
    /// What its solver has under way.
    pub state: State,
    /// The irradiance between the patches' means, where it was gathered.
    pub function: Option<IrradianceFunction>,
    /// Parts of the light, where they were asked for.
    pub layers: Option<Layers>,
}

impl Solution {
    /// The start of every solver: no irradiance anywhere.
    pub fn dark(scene: &Scene) -> Self {
        Self {
            irradiance: vec![Rgb::ZERO; scene.patch_count() as usize],
            provenance: Provenance::default(),
            state: State::AtRest,
            function: None,
            layers: None,
        }
    }

    /// Checks the lengths, that a source's area is above 0, that every value is finite, and that irradiances are at least 0.
    pub fn validate(&self, scene: &Scene) -> Result<(), SceneError> {
        if let Some(value) = self.provenance.level.source_area()
            && !(value > 0.0 && value.is_finite())
        {
            return Err(SceneError::SourceArea { value });
        }
        let patches = scene.patch_count();
        let check = |values: &[Rgb], is_complete: bool, least: f32| {
            let count = patches as usize;
            if values.len() > count || (is_complete && values.len() != count) {
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
            Ok(())
        };
        check(&self.irradiance, true, 0.0)?;
        if let Some(layers) = &self.layers {
            layers.validate(scene, self.function.as_ref())?;
        }
        let errors = self.error().map_or(0, <[f32]>::len);
        if errors != 0 && errors != patches as usize {
            return Err(SceneError::ErrorLength { errors, patches });
        }
        if let Level::Gathering { gathered, .. } = &self.provenance.level {
            check(gathered, false, 0.0)?;
        }
        match &self.state {
            State::AtRest => Ok(()),
            State::Unfinished { irradiance } => check(irradiance, false, 0.0),
            State::Shooting { unshot, remainder } => {
                check(unshot, true, f32::MIN)?;
                check(remainder, true, f32::MIN)
            }
        }
    }

    /// Share of the next iteration that is done, 0 to 1.
    pub fn next_iteration_share(&self) -> f64 {
        match &self.state {
            State::Unfinished { irradiance } => {
                irradiance.len() as f64 / self.irradiance.len() as f64
            }
            State::AtRest | State::Shooting { .. } => 0.0,
        }
    }

    /// Mean irradiances of patches as they are best known, W/m^2, one per patch: those of the function on surfaces that have
    /// one, else the solver's.
    pub fn mean_irradiance(&self, scene: &Scene) -> Vec<Rgb> {
        let Some(function) = &self.function else {
            return self.irradiance.clone();
        };
        let values = function.irradiance();
        let patches = (0..).map(PatchId).zip(&self.irradiance);
        let mean = |patch, solved| function.mean_over(scene, values, patch).unwrap_or(solved);
        patches
            .map(|(patch, &solved)| mean(patch, solved))
            .collect()
    }

    /// Estimates of the error of the function, one per patch, see [`IrradianceFunction::error`]; `None` where there are none.
    pub fn error(&self) -> Option<&[f32]> {
        let function = self.function.as_ref()?;
        Some(function.error()).filter(|error| !error.is_empty())
    }

    /// Radiosities B = E + rho H, W/m^2, one per patch, of the solver's irradiances.
    pub fn radiosity(&self, scene: &Scene) -> Vec<Rgb> {
        radiosity(scene, &self.irradiance)
    }

    /// The same of the [mean irradiances](Self::mean_irradiance).
    pub fn mean_radiosity(&self, scene: &Scene) -> Vec<Rgb> {
        radiosity(scene, &self.mean_irradiance(scene))
    }
}

/// Radiosities of patches with these irradiances, both W/m^2, one per patch.
fn radiosity(scene: &Scene, irradiance: &[Rgb]) -> Vec<Rgb> {
    let mut radiosity = scene.patch_emissions();
    let reflectance = scene.patch_reflectances();
    for ((b, rho), h) in radiosity.iter_mut().zip(reflectance).zip(irradiance) {
        *b += rho * *h;
    }
    radiosity
}
