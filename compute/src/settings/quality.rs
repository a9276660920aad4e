//! Qualities: names for what is asked of a run.

use super::{
    ClosedForms, FormFactorSettings, LampViews, Maps, Points, Seed, SolveSettings, Target, Wanted,
};

/// How good a result is to be.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "program", derive(clap::ValueEnum))]
pub enum Quality {
    /// --target-error 5%,10%visible
    Draft,
    /// --target-error 2%,5%visible
    #[default]
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

/// Pixels along the face of a hemicube that a function gathers with: lamps have views of their own, and what else varies
/// within so few is told by a second look (`docs/TRADEOFFS.md` has what others bring).
const FUNCTION_RESOLUTION: u32 = 32;

/// Pixels along the face of a hemicube where patches gather at as many points as their error asks for: what pixels bring
/// falls with the points.
const MEANS_RESOLUTION: u32 = 24;

impl Quality {
    /// The errors that are asked for: of the power, and visible.
    pub fn target(self) -> Option<Target> {
        let [power, visible] = match self {
            Self::Draft => [0.05, 0.1],
            Self::Standard => [0.02, 0.05],
            Self::High => [0.01, 0.03],
            Self::Reference => [0.003, 0.01],
            Self::Mesh | Self::Thesis => return None,
        };
        Some(Target::of(Some(power), Some(visible)))
    }

    /// What decides form factors where nothing else is asked for.
    pub fn form_factors(self) -> FormFactorSettings {
        match self {
            Self::Draft | Self::Standard | Self::High | Self::Reference => FormFactorSettings {
                points: Points::CENTROID,
                ..FormFactorSettings::new(FUNCTION_RESOLUTION)
            },
            Self::Mesh => FormFactorSettings::default(),
            Self::Thesis => FormFactorSettings {
                resolution: 500,
                maps: Maps::Thesis,
                points: Points::CENTROID,
                seed: Seed::Aligned,
                lamps: LampViews::Off,
                closed_forms: ClosedForms::Off,
            },
        }
    }

    /// All that is asked of a run.
    pub fn settings(self) -> SolveSettings {
        let mut settings = SolveSettings {
            target: self.target(),
            ..SolveSettings::default()
        };
        settings.solution.form_factors = self.form_factors();
        if self == Self::Thesis {
            settings.max_iterations = Some(THESIS_ITERATIONS);
            // Iterations that are counted are done, all of them.
            settings.tolerance = 0.0;
        }
        settings
    }

    /// What is asked of a run that an error is asked of, of the irradiance function.
    pub fn settings_for(error: Target) -> SolveSettings {
        SolveSettings {
            target: Some(error),
            ..Self::default().settings()
        }
    }

    /// The same of the means of patches.
    pub fn settings_for_means(error: Target) -> SolveSettings {
        let mut settings = Self::Mesh.settings();
        settings.solution.form_factors = FormFactorSettings {
            points: Points::CENTROID,
            ..FormFactorSettings::new(MEANS_RESOLUTION)
        };
        settings.target = Some(Target {
            of: Wanted::Means,
            ..error
        });
        settings
    }
}
