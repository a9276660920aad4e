//! Qualities: names for what is asked of a run.

use clap::ValueEnum;

use crate::settings::{ClosedForms, FormFactorSettings, LampViews, Maps, Points, Seed, Target};

/// How good a result is to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(super) enum Quality {
    /// --target-error 5%,10%visible
    Draft,
    /// --target-error 2%,5%visible
    Standard,
    /// --target-error 1%,3%visible
    High,
    /// --target-error 0.3%,1%visible
    Reference,
    /// One value a patch on the mesh as it is
    Mesh,
    /// The thesis's run: its multipliers at centroids, 500 pixels, 7 iterations
    Thesis,
}

/// Iterations of the thesis's runs.
const THESIS_ITERATIONS: u64 = 7;

impl Quality {
    /// The errors that are asked for: of the power, and visible.
    pub fn target(self) -> Option<Target> {
        let errors = match self {
            Self::Draft => [0.05, 0.1],
            Self::Standard => [0.02, 0.05],
            Self::High => [0.01, 0.03],
            Self::Reference => [0.003, 0.01],
            Self::Mesh | Self::Thesis => return None,
        };
        Some(Target {
            power: Some(errors[0]),
            visible: Some(errors[1]),
            most_vertices: super::target_error::MOST_VERTICES,
        })
    }

    /// The iterations, where they are given.
    pub fn iterations(self) -> Option<u64> {
        (self == Self::Thesis).then_some(THESIS_ITERATIONS)
    }
}

/// What decides form factors where nothing else is asked for: in a run of a quality, or of one that gathers a function.
pub(super) fn form_factors(quality: Option<Quality>, has_function: bool) -> FormFactorSettings {
    if quality == Some(Quality::Thesis) {
        return FormFactorSettings {
            resolution: 500,
            maps: Maps::Thesis,
            points: Points::CENTROID,
            seed: Seed::Aligned,
            lamps: LampViews::Off,
            closed_forms: ClosedForms::Off,
        };
    }
    if has_function {
        return FormFactorSettings {
            points: Points::CENTROID,
            ..FormFactorSettings::new(32)
        };
    }
    FormFactorSettings::default()
}
