//! What to make, checked.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use scene::import::{ImportOptions, Orient};
use scene::{Axis, ModelAxes, Rgb};

use crate::changes::{Change, Look};
use crate::cut::Cut;

/// The models.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Model {
    /// "1": a cube with a small square lamp shining into it.
    Cube,
    /// "2": a hall with columns and many kinds of shadow.
    Hall,
    /// "3": light bending round an obstacle into a region without direct light.
    Bend,
    /// "cornell": the Cornell box.
    Cornell,
    /// "furnace": a closed box whose walls all emit and reflect alike.
    Furnace,
    /// Triangles and polygons of a file.
    File {
        /// What it is.
        format: Format,
        /// Where it is.
        path: PathBuf,
    },
}

/// Formats of files that models come in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Wavefront OBJ.
    Obj,
    /// glTF 2.0, as JSON or binary.
    Gltf,
}

impl Format {
    /// The format of a file, by the end of its name in any case.
    pub fn of(path: &Path) -> Option<Self> {
        let extension = path.extension()?.to_str()?.to_ascii_lowercase();
        match &extension[..] {
            "obj" => Some(Self::Obj),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }
}

/// A MODEL that names nothing.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "model \"{}\" is unknown; choose 1, 2, 3, cornell, furnace or a file whose name ends in .obj, .gltf or .glb", name.display()
)]
pub struct UnknownModel {
    name: PathBuf,
}

impl TryFrom<&OsStr> for Model {
    type Error = UnknownModel;

    /// Names as on the command line. Whether a file exists is not looked at.
    fn try_from(name: &OsStr) -> Result<Self, UnknownModel> {
        let path = Path::new(name);
        match name.to_str() {
            Some("1") => Ok(Self::Cube),
            Some("2") => Ok(Self::Hall),
            Some("3") => Ok(Self::Bend),
            Some("cornell") => Ok(Self::Cornell),
            Some("furnace") => Ok(Self::Furnace),
            _ => match Format::of(path) {
                Some(format) => Ok(Self::File {
                    format,
                    path: path.to_owned(),
                }),
                None => Err(UnknownModel {
                    name: path.to_owned(),
                }),
            },
        }
    }
}

/// What to make. What is `None` has a default that suits the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The model.
    pub model: Model,
    /// The largest area a patch may have, m^2, above 0; infinity keeps each surface as one patch.
    pub max_area: Option<f64>,
    /// Reflectance, dimensionless, in [0, 1): of every material without emission in `Cornell` and
    /// `File`, of every surface elsewhere. It replaces colours by grey.
    pub reflectance: Option<f32>,
    /// Exitance of the lamps, W/m^2, finite and at least 0. `Cornell` and `File` keep the ratios of
    /// their emissions and scale the brightest channel of the brightest one to this; elsewhere
    /// every lamp emits this in each channel.
    pub light_power: Option<f32>,
    /// The largest reflectance of a `File`'s materials, dimensionless, in [0, 1), see [`ImportOptions`].
    pub max_reflectance: Option<f32>,
    /// Which side of a `File`'s faces is their front.
    pub orient: Orient,
    /// What one is in the coordinates of a `File`, metres, finite and above 0.
    pub unit: Option<f64>,
    /// The axis of the model that points up.
    pub up: Option<Axis>,
    /// The radius of the bodies that stand in for a `File`'s lights without extent, metres, finite and above 0, see
    /// [`ImportOptions`].
    pub light_radius: Option<f64>,
    /// What is done where faces of a `File` overlap in one plane.
    pub cut: Cut,
    /// What materials and objects are given by name, after all else.
    pub changes: Vec<Change>,
    /// Materials and objects that are taken out, and whose holes are meant.
    pub openings: Vec<String>,
}

/// A setting outside its range.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the messages show
pub enum SettingsError {
    #[error(
        "area threshold {value} m^2 is not a number above 0; use inf to keep each triangle as one patch"
    )]
    MaxArea { value: f64 },
    #[error("REFLECTANCE {value} is outside [0, 1); a surface cannot reflect all it receives")]
    Reflectance { value: f32 },
    #[error("LIGHT_POWER {value} W/m^2 is not a finite number >= 0")]
    LightPower { value: f32 },
    #[error(
        "--max-reflectance {value} is outside [0, 1); a surface cannot reflect all it receives"
    )]
    MaxReflectance { value: f32 },
    #[error("--light-radius {value} m is not a finite number above 0")]
    LightRadius { value: f64 },
    #[error(
        "--reflectance \"{name}\": {value} is outside [0, 1); a surface cannot reflect all it receives"
    )]
    ReflectanceOf { name: String, value: f32 },
    #[error("the light of \"{name}\": {value} is not a finite number >= 0")]
    LightOf { name: String, value: f32 },
}

impl Settings {
    /// A model with its defaults.
    pub fn new(model: Model) -> Self {
        Self {
            model,
            max_area: None,
            reflectance: None,
            light_power: None,
            max_reflectance: None,
            orient: Orient::Auto,
            unit: None,
            up: None,
            light_radius: None,
            cut: Cut::On,
            changes: Vec::new(),
            openings: Vec::new(),
        }
    }

    /// How a file is to be taken.
    pub fn import(&self) -> ImportOptions {
        ImportOptions {
            reflectance: self.reflectance,
            max_reflectance: self.max_reflectance,
            repainted: self.repainted(),
            orient: self.orient,
            axes: self.axes(),
            light_radius: self.light_radius,
        }
    }

    /// Names that are given a reflectance.
    fn repainted(&self) -> Vec<String> {
        let given = self.changes.iter();
        let given = given.filter(|change| matches!(change.to, Look::Reflectance(_)));
        given.map(|change| change.name.clone()).collect()
    }

    /// What the model's coordinates are.
    pub fn axes(&self) -> ModelAxes {
        ModelAxes {
            unit: self.unit.unwrap_or(1.0),
            up: self.up,
        }
    }

    /// Checks the ranges the fields state.
    pub fn validate(&self) -> Result<(), SettingsError> {
        if let Some(value) = self.max_area
            && (value.is_nan() || value <= 0.0)
        {
            return Err(SettingsError::MaxArea { value });
        }
        if let Some(value) = self.reflectance
            && !(0.0..1.0).contains(&value)
        {
            return Err(SettingsError::Reflectance { value });
        }
        if let Some(value) = self.light_power
            && !(value >= 0.0 && value.is_finite())
        {
            return Err(SettingsError::LightPower { value });
        }
        if let Some(value) = self.max_reflectance
            && !(0.0..1.0).contains(&value)
        {
            return Err(SettingsError::MaxReflectance { value });
        }
        if let Some(value) = self.light_radius
            && !(value > 0.0 && value.is_finite())
        {
            return Err(SettingsError::LightRadius { value });
        }
        for Change { name, to } in &self.changes {
            let name = || name.clone();
            match to {
                Look::Reflectance(rgb) => {
                    if let Some(value) = outside(*rgb, |value| (0.0..1.0).contains(&value)) {
                        return Err(SettingsError::ReflectanceOf {
                            name: name(),
                            value,
                        });
                    }
                }
                Look::Flipped | Look::TwoSided => {}
                Look::Emission(rgb) | Look::Power(rgb) => {
                    if let Some(value) = outside(*rgb, |v| v >= 0.0 && v.is_finite()) {
                        return Err(SettingsError::LightOf {
                            name: name(),
                            value,
                        });
                    }
                }
            }
        }
        Ok(())
    }
}

/// The first channel that is not as it should be.
fn outside(rgb: Rgb, is_good: impl Fn(f32) -> bool) -> Option<f32> {
    rgb.to_array().into_iter().find(|&value| !is_good(value))
}
