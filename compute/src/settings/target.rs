//! The error that is asked for.

use serde::Serialize;

/// Whose error is to be as small as is asked for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Wanted {
    /// That of an irradiance function, see [`crate::function`].
    #[default]
    Function,
    /// That of patches' means, of which those gather at more points that need it, see [`crate::function::means_of_patches`].
    Means,
    /// The same, at the points that are asked for and no others.
    MeansAtPoints,
}

/// The error that is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Target {
    /// Whose.
    pub of: Wanted,
    /// The largest power error, relative.
    pub power: Option<f64>,
    /// The largest visible error, relative.
    pub visible: Option<f64>,
    /// The most vertices.
    pub most_vertices: u32,
}

/// About as much as an error of the power, what is visible is in rooms with shadows.
const VISIBLE_OVER_POWER: f64 = 2.5;

/// The most vertices, for the sake of memory: with four nodes, six edges and its light each takes some 540 bytes, and its row
/// while there is room for it.
const MOST_VERTICES: u32 = 1 << 22;

impl Target {
    /// At most these errors of an irradiance function, relative.
    pub fn of(power: Option<f64>, visible: Option<f64>) -> Self {
        Self {
            of: Wanted::Function,
            power,
            visible,
            most_vertices: MOST_VERTICES,
        }
    }

    /// The same, which also asks for what is visible where it asks for power alone: as much as goes with that. A camera may look
    /// closely at what has little of the power, and what it sees is to be no worse than was asked for.
    #[must_use]
    pub(crate) fn in_pictures(self) -> Self {
        let by_power = self.power.map(|power| VISIBLE_OVER_POWER * power);
        Self {
            visible: self.visible.or(by_power),
            ..self
        }
    }

    /// The power error that is asked for, or that goes with the visible error where that asks for more; 1 where nothing is
    /// asked for.
    pub fn strictest(&self) -> f64 {
        let by_visible = self.visible.map(|visible| visible / VISIBLE_OVER_POWER);
        let all = [self.power, by_visible, Some(1.0)];
        all.into_iter().flatten().fold(1.0, f64::min)
    }
}
