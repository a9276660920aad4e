//! What a model says of its own coordinates.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::SceneError;

/// A coordinate axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[allow(missing_docs)] // the names say all
pub enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// All three.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Z];

    /// Unit vector along the axis.
    pub fn direction(self) -> DVec3 {
        match self {
            Self::X => DVec3::X,
            Self::Y => DVec3::Y,
            Self::Z => DVec3::Z,
        }
    }
}

/// The coordinates of a model, from which a scene was made: people and files name places in these.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelAxes {
    /// What one is, metres.
    pub unit: f64,
    /// Which one points up, if that is known.
    pub up: Option<Axis>,
}

/// Metres.
impl Default for ModelAxes {
    fn default() -> Self {
        Self {
            unit: 1.0,
            up: None,
        }
    }
}

impl ModelAxes {
    /// Checks that the unit is one.
    pub(crate) fn validate(self) -> Result<Self, SceneError> {
        let value = self.unit;
        if value.is_finite() && value > 0.0 {
            Ok(self)
        } else {
            Err(SceneError::Unit { value })
        }
    }
}
