//! What decides form factors and solutions: plain, checked values, whatever they were given as.

mod quality;
mod target;

pub use quality::Quality;
pub use target::{Target, Wanted};

use std::iter;
use std::str::FromStr;
use std::time::Duration;

use scene::RecordedSettings;
use scene::layers::LayerKind;

use serde::{Serialize, Serializer};
use serde_json::json;

/// Where on a patch its hemicubes stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Points {
    /// One or more in each patch, as its surroundings ask for, see [`crate::receivers`].
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

impl FromStr for Points {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let most = 1_u32 << Self::MAX_BISECTIONS;
        match text {
            "auto" => Ok(Self::Auto),
            "centroid" => Ok(Self::CENTROID),
            "vertices" => Ok(Self::Vertices),
            _ => match text.parse::<u32>() {
                Ok(n) if n.is_power_of_two() && n <= most => Ok(Self::Bisected {
                    bisections: n.trailing_zeros(),
                }),
                Ok(n) if n.is_multiple_of(3) && (n / 3).is_power_of_two() && n / 3 <= most => {
                    Ok(Self::ThreePoint {
                        bisections: (n / 3).trailing_zeros(),
                    })
                }
                _ => Err(format!(
                    "\"{text}\" is none of auto, centroid, vertices, a power of two from 1 to {most}, or \
                     three times that"
                )),
            },
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
pub enum Seed {
    /// All along their patches' reference edges.
    Aligned,
    /// Each by an angle of its own; another number gives other angles.
    Number(u32),
}

impl Seed {
    /// What a run does unless it is asked for something else.
    pub const DEFAULT: Self = Self::Number(0);
}

impl std::fmt::Display for Seed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Aligned => f.write_str("aligned"),
            Self::Number(seed) => write!(f, "{seed}"),
        }
    }
}

impl Seed {
    /// Other angles.
    pub(crate) fn otherwise(self) -> Self {
        match self {
            Self::Aligned => Self::Number(0),
            Self::Number(seed) => Self::Number(seed ^ 1 << 31),
        }
    }
}

impl FromStr for Seed {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse()) {
            ("aligned", _) => Ok(Self::Aligned),
            (_, Ok(seed)) => Ok(Self::Number(seed)),
            _ => Err(format!(
                "\"{text}\" is neither aligned nor a whole number from 0 to {}",
                u32::MAX
            )),
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
    /// What a continued file has; else the GPU where a real one draws the same rows as the CPU and is faster, see
    /// [`crate::backend`]; else the CPU.
    Auto,
    /// The CPU.
    Cpu,
    /// Any wgpu adapter, a software one too.
    Gpu,
}

/// Which adapters are accepted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AdapterChoice {
    /// Graphics cards only: discrete, integrated or virtual.
    RealOnly,
    /// Software adapters too, where there is no graphics card.
    Any,
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

/// Scenes with more patches than this have automatic sources. Tuned on the hall at 100
/// pixels: the rows of 26,928 patches take an eighth of the default memory, those of 134,016 more than all of it, and
/// are then drawn again in each iteration.
pub const MOST_ON_ONE_LEVEL: u32 = 1 << 16;

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

impl FromStr for SourceArea {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match (text, text.parse::<f64>()) {
            ("auto", _) => Ok(Self::Auto),
            ("patches", _) => Ok(Self::Patches),
            (_, Ok(area)) if area > 0.0 => Ok(Self::AtMost(area)),
            _ => Err(format!(
                "\"{text}\" is none of auto, patches and an area above 0 m^2"
            )),
        }
    }
}

/// Files and reports have these as the command line has them.
macro_rules! serialize_as_shown {
    ($($setting:ty),*) => {$(
        impl Serialize for $setting {
            fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
                serializer.collect_str(self)
            }
        }
    )*};
}
serialize_as_shown!(Points, Seed, SourceArea);

/// What decides the form factors.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct FormFactorSettings {
    /// Pixels along a hemicube's face: even, 2 to 4096.
    pub resolution: u32,
    /// The pixels' multipliers.
    pub maps: Maps,
    /// Where a patch's hemicubes stand.
    pub points: Points,
    /// How they are turned.
    pub seed: Seed,
    /// Which lamps get a view of their own.
    pub lamps: LampViews,
    /// Whether form factors are formulas where they can be; a back end that was asked for draws.
    pub closed_forms: ClosedForms,
}

impl FormFactorSettings {
    /// What a run does unless it is asked for something else, at some resolution.
    pub const fn new(resolution: u32) -> Self {
        Self {
            resolution,
            maps: Maps::Exact,
            points: Points::Auto,
            seed: Seed::DEFAULT,
            lamps: LampViews::Auto,
            closed_forms: ClosedForms::Auto,
        }
    }
}

/// As a run has it by default.
impl Default for FormFactorSettings {
    fn default() -> Self {
        Self::new(128)
    }
}

/// How form factors are drawn and kept, which decides no bit of them but by the back end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Drawing {
    /// Who draws.
    pub backend: BackendChoice,
    /// Whether a GPU that was asked for is compared with the CPU before it draws; one that nobody asked for always is.
    pub is_gpu_tried: bool,
    /// What kept rows may take, bytes.
    pub memory_bytes: u64,
}

/// As a run has it by default.
impl Default for Drawing {
    fn default() -> Self {
        Self {
            backend: BackendChoice::Auto,
            is_gpu_tried: true,
            memory_bytes: 4 << 30,
        }
    }
}

/// What decides a solution: a file made with the same, and by the same back end, goes on bit for bit. The names
/// and values are those of the command line, of the report and of the provenance in a file, which has the
/// [back end](crate::backend::RowOrigin) beside them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct SolutionSettings {
    /// What decides the form factors.
    #[serde(flatten)]
    pub form_factors: FormFactorSettings,
    /// How coarse sources are.
    pub source_area: SourceArea,
    /// Who solves.
    pub solver: SolverChoice,
}

/// As a run has it by default.
impl Default for SolutionSettings {
    fn default() -> Self {
        Self {
            form_factors: FormFactorSettings::default(),
            source_area: SourceArea::Auto,
            solver: SolverChoice::Jacobi,
        }
    }
}

impl SolutionSettings {
    /// What the file of a scene of so many patches says of them: what makes no difference there is the same.
    pub fn recorded(self, patches: u32) -> RecordedSettings {
        let source_area = match self.source_area {
            SourceArea::Patches if patches <= MOST_ON_ONE_LEVEL => SourceArea::Auto,
            area => area,
        };
        RecordedSettings::new(&Self {
            source_area,
            ..self
        })
    }
}

/// How a scene is solved, and how far.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolveSettings {
    /// What decides the solution.
    pub solution: SolutionSettings,
    /// How form factors are drawn and kept.
    pub drawing: Drawing,
    /// Stop after this many iterations, those that the start has had included.
    pub max_iterations: Option<u64>,
    /// Stop at this relative residual.
    pub tolerance: f64,
    /// Stop after this long.
    pub time_limit: Option<Duration>,
    /// Hand out what there is this often.
    pub checkpoint_every: Duration,
    /// Whether all rows are drawn, those too that the solution does not need, so that they can be certified.
    pub all_rows: bool,
    /// The error that is asked for; `None` where there is no irradiance function, and nobody asks for the error of patches' means.
    pub target: Option<Target>,
    /// What the light is taken apart into in the end.
    pub layers: Option<LayerKind>,
}

/// As a run has it by `--quality mesh`.
impl Default for SolveSettings {
    fn default() -> Self {
        Self {
            solution: SolutionSettings::default(),
            drawing: Drawing::default(),
            max_iterations: None,
            tolerance: 1e-5,
            time_limit: None,
            checkpoint_every: Duration::from_mins(1),
            all_rows: false,
            target: None,
            layers: None,
        }
    }
}

impl SolveSettings {
    /// What an irradiance function is asked for that is gathered in the end; `None` where patches' means are all.
    pub fn function(&self) -> Option<Target> {
        self.target.filter(|target| target.of == Wanted::Function)
    }

    /// The command line after IN and OUT that asks for these, but for when a run saves and stops on the way.
    pub fn options(&self) -> String {
        let mut settings = RecordedSettings::new(&self.solution);
        settings.set("backend", json!(self.drawing.backend));
        settings.set("tolerance", self.tolerance);
        if let Some(iterations) = self.max_iterations {
            settings.set("iterations", iterations);
        }
        let others = settings.iter().filter(|(name, _)| *name != "resolution");
        let options = others.map(|(name, value)| format!("--{} {value}", name.replace('_', "-")));
        let resolution = self.solution.form_factors.resolution.to_string();
        let words: Vec<String> = iter::once(resolution).chain(options).collect();
        words.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use std::fmt::{Debug, Display};

    use super::*;

    /// What is read shows as it was written, in files too; what is not is an error.
    fn reads_back<T>(good: &[&str], bad: &[&str])
    where
        T: FromStr<Err = String> + Display + Serialize + Debug,
    {
        for text in good {
            let setting: T = text.parse().unwrap();
            assert_eq!(setting.to_string(), *text);
            assert_eq!(serde_json::to_value(setting).unwrap(), *text);
        }
        for text in bad {
            assert!(text.parse::<T>().is_err(), "{text}");
        }
    }

    #[test]
    fn points_seeds_and_areas_read_back_as_they_show() {
        reads_back::<Points>(
            &[
                "auto", "centroid", "vertices", "2", "3", "64", "96", "1024", "3072",
            ],
            &["0", "5", "9", "2048", "6144", "-1", "middle", ""],
        );
        assert_eq!("1".parse(), Ok(Points::CENTROID));
        reads_back::<Seed>(
            &["aligned", "0", "7", "4294967295"],
            &["4294967296", "-1", "0.5", "on", ""],
        );
        reads_back::<SourceArea>(
            &["auto", "patches", "0.25", "inf"],
            &["0", "-1", "nan", "none", ""],
        );
    }

    #[test]
    fn only_in_large_scenes_patches_are_other_sources_than_automatic_ones() {
        let recorded = |source_area, patches| {
            let settings = SolutionSettings {
                source_area,
                ..SolutionSettings::default()
            };
            settings.recorded(patches)
        };
        for (patches, differing) in [(MOST_ON_ONE_LEVEL, 0), (MOST_ON_ONE_LEVEL + 1, 1)] {
            let automatic = recorded(SourceArea::Auto, patches);
            let by_patches = recorded(SourceArea::Patches, patches);
            let differences = automatic.differences(&by_patches);
            assert_eq!(differences.len(), differing);
            assert!(differences.iter().all(|d| d.name == "source_area"));
            let coarse = recorded(SourceArea::AtMost(0.5), patches);
            assert_eq!(automatic.differences(&coarse).len(), 1);
        }
    }
}
