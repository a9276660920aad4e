//! What a run is asked to do: plain, checked values, whatever they were given as.

use std::path::PathBuf;
use std::time::Duration;

use serde::Serialize;

/// Where on a patch its hemicubes stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// One or more in each patch, as its surroundings ask for, see [`crate::hemicubes`].
    Auto,
    /// At the centroids of the 2^bisections triangles the patch's own bisection makes; 0 is the
    /// patch's centroid.
    Bisected {
        /// At most [`Points::MAX_BISECTIONS`].
        bisections: u32,
    },
    /// At three points in each of these triangles, which is right to a higher order.
    ThreePoint {
        /// At most [`Points::MAX_BISECTIONS`].
        bisections: u32,
    },
    /// At the three corners, drawn in a little; the thesis's smoother variant.
    Vertices,
}

impl Points {
    /// The patch's centroid.
    pub const CENTROID: Self = Self::Bisected { bisections: 0 };
    /// More points would leave too few units to a delta form factor.
    pub const MAX_BISECTIONS: u32 = 10;
}

impl std::fmt::Display for Points {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match *self {
            Self::Auto => f.write_str("auto"),
            Self::CENTROID => f.write_str("centroid"),
            Self::Bisected { bisections } => write!(f, "{}", 1_u32 << bisections),
            Self::ThreePoint { bisections } => write!(f, "{}", 3_u32 << bisections),
            Self::Vertices => f.write_str("vertices"),
        }
    }
}

/// Which multipliers the pixels have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Maps {
    /// Exact integrals over the pixels.
    Exact,
    /// The thesis's, for comparison.
    Thesis,
}

/// How hemicubes are turned about their normals.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turns {
    /// All along their patches' reference edges.
    Aligned,
    /// Each by an angle of its own; another number gives other angles.
    Seeded(u32),
}

impl Turns {
    /// What a run does unless it is asked for something else.
    pub const DEFAULT: Self = Self::Seeded(0);
}

impl std::fmt::Display for Turns {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Aligned => f.write_str("aligned"),
            Self::Seeded(seed) => write!(f, "{seed}"),
        }
    }
}

/// Which lamps get a view of their own.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LampViews {
    /// Those that matter, see [`crate::lamps`].
    Auto,
    /// None: hemicubes alone.
    Off,
    /// All emitting surfaces.
    All,
}

/// Whether form factors are formulas where they can be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ClosedForms {
    /// Where nothing hides anything and they cost less than hemicubes, see [`crate::convex`].
    Auto,
    /// Never: hemicubes alone.
    Off,
}

/// Which back end draws the hemicubes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum BackendChoice {
    /// The GPU where there is a real one, else the CPU.
    Auto,
    /// The CPU.
    Cpu,
    /// Any wgpu adapter, a software one too.
    Gpu,
}

/// How the radiosity equation is solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum SolverChoice {
    /// Every patch gathers the last iteration's radiosities.
    Jacobi,
    /// Every patch gathers the newest radiosities.
    GaussSeidel,
    /// The patch with the most unshot power shoots.
    Shooting,
}

impl std::fmt::Display for SolverChoice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Jacobi => "jacobi",
            Self::GaussSeidel => "gauss-seidel",
            Self::Shooting => "shooting",
        })
    }
}

/// How coarse sources are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SourceArea {
    /// As the scene's patches, but in the largest scenes as coarse as the error allows, see
    /// [`crate::two_levels`].
    Auto,
    /// As the scene's patches.
    Patches,
    /// Patches are joined to sources of at most this area, m^2.
    AtMost(f64),
}

impl std::fmt::Display for SourceArea {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Auto => f.write_str("auto"),
            Self::Patches => f.write_str("patches"),
            Self::AtMost(area) => write!(f, "{area}"),
        }
    }
}

/// What decides the form factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FormFactorSettings {
    /// Pixels along a hemicube's face: even, 2 to 4096.
    pub resolution: u32,
    /// The pixels' multipliers.
    pub maps: Maps,
    /// Where a patch's hemicubes stand.
    pub points: Points,
    /// How they are turned.
    pub turns: Turns,
}

impl FormFactorSettings {
    /// What a run does unless it is asked for something else, at some resolution.
    pub const fn new(resolution: u32) -> Self {
        Self {
            resolution,
            maps: Maps::Exact,
            points: Points::Auto,
            turns: Turns::DEFAULT,
        }
    }
}

/// Everything `compute` is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The scene, with or without a solution to go on from.
    pub input: PathBuf,
    /// Where the solution goes; may be `input`.
    pub output: PathBuf,
    /// What decides the form factors.
    pub form_factors: FormFactorSettings,
    /// Which lamps get a view of their own.
    pub lamps: LampViews,
    /// Whether form factors are formulas where they can be; a back end that was asked for draws.
    pub closed_forms: ClosedForms,
    /// How coarse sources are.
    pub source_area: SourceArea,
    /// Who draws.
    pub backend: BackendChoice,
    /// Who solves.
    pub solver: SolverChoice,
    /// Stop after this many iterations, those of a continued file included.
    pub max_iterations: Option<u64>,
    /// Stop at this relative residual.
    pub tolerance: f64,
    /// Stop after this long.
    pub time_limit: Option<Duration>,
    /// Write a checkpoint this often.
    pub checkpoint_every: Duration,
    /// Threads of the CPU; `None`: one for each core.
    pub threads: Option<usize>,
    /// What cached form factor rows may take, bytes.
    pub memory_bytes: u64,
    /// Where the report goes.
    pub report: Option<PathBuf>,
    /// Where the form factors go.
    pub form_factors_csv: Option<PathBuf>,
    /// Where the view factors between objects go.
    pub view_factors_csv: Option<PathBuf>,
    /// Whether a certificate beyond its tolerances is a failure.
    pub strict: bool,
}
