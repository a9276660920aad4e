//! How a run ended, and what it took.

use std::time::Duration;

use serde::{Deserialize, Serialize};

/// Why a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StoppedBy {
    /// The residual reached the tolerance.
    Tolerance,
    /// The iterations asked for were done.
    Iterations,
    /// The time was over.
    TimeLimit,
    /// The user asked.
    Interrupt,
}

impl StoppedBy {
    /// As the end of a sentence about the run.
    pub fn describe(self) -> &'static str {
        match self {
            Self::Tolerance => "converged to the tolerance",
            Self::Iterations => "stopped by --iterations",
            Self::TimeLimit => "stopped by --time-limit, not converged",
            Self::Interrupt => "interrupted, not converged",
        }
    }
}

/// What was solved among, before the patches gathered.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct SourcesReport {
    /// How many.
    pub count: u32,
    /// Their largest area, where patches are smaller, m^2.
    pub max_area: f64,
    /// About the error of irradiance that they bring, relative, root mean square by area; null where it was not asked
    /// for.
    pub estimated_error: Option<f64>,
    /// Share of the patches that have gathered from them, 0 to 1; the others have what their source has. Null where an irradiance
    /// function gathers instead.
    pub gathered_share: Option<f64>,
}

impl SourcesReport {
    /// So many sources of at most `max_area`, m^2, from which no patch has gathered yet.
    pub fn new(count: u32, max_area: f64) -> Self {
        Self {
            count,
            max_area,
            estimated_error: None,
            gathered_share: Some(0.0),
        }
    }
}

/// Seconds by stage.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Seconds {
    /// Reading the scene.
    pub load: f64,
    /// Opening the back end.
    pub open: f64,
    /// Drawing hemicubes and merging their pixels.
    pub draw: f64,
    /// Everything else of the iterations.
    pub solve: f64,
    /// Writing results and checkpoints; reading and writing rows.
    pub write: f64,
    /// All.
    pub total: f64,
}

impl Seconds {
    /// Takes what is not known of the total for solving.
    pub fn finish(&mut self, total: Duration) {
        self.total = total.as_secs_f64();
        self.solve = (self.total - self.load - self.open - self.draw - self.write).max(0.0);
    }
}
