//! What a run is asked to do: plain, checked values, whatever they were given as.

use std::path::PathBuf;

use glam::DVec3;
use scene::file::is_same_file;
use scene::{Axis, PatchId};

use crate::animation::AnimationFormat;
use crate::quantity::{Quantity, Shown};

/// The longest side of a picture, pixels.
pub const MAX_SIDE: u32 = 16_384;

/// The most pixels of a picture: its linear and its mapped form take 28 bytes a pixel, 4 GB in all.
pub const MAX_PIXELS: u64 = 1 << 27;

/// The largest coordinate of a camera; squares of it are far from overflow.
const MAX_COORDINATE: f64 = 1e12;

/// How values become colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// The logarithm of luminance as brightness.
    #[default]
    Log,
    /// A curve as film has it: in proportion where it is dark, and never quite white.
    Filmic,
    /// In proportion to the light.
    Linear,
    /// Luminance as a colour of a perceptual colour map, with a legend.
    FalseColor,
    /// Patch IDs, each in a colour of its own; or as the solver sees them ([`RenderSettings::raw_ids`]).
    Ids,
}

impl std::fmt::Display for Mode {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Log => "log",
            Self::Filmic => "filmic",
            Self::Linear => "linear",
            Self::FalseColor => "false-color",
            Self::Ids => "ids",
        })
    }
}

/// A picture's size, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Pixels in a row, 1 to [`MAX_SIDE`].
    pub width: u32,
    /// Rows, 1 to [`MAX_SIDE`].
    pub height: u32,
}

impl std::fmt::Display for Size {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}x{}", self.width, self.height)
    }
}

/// The luminances at the two ends of a scale, W/m^2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Mapped to black, or to the first colour.
    pub low: f64,
    /// Mapped to white, or to the last colour; above `low`.
    pub high: f64,
}

/// What a picture shows, and from where. The default takes all from the scene.
#[derive(Clone, Debug, Default, PartialEq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a choice of its own")]
pub struct RenderSettings {
    /// How values become colours.
    pub mode: Mode,
    /// Which values.
    pub shown: Shown,
    /// Patch IDs as R = ID >> 16, G = ID >> 8, B = ID.
    pub raw_ids: bool,
    /// Lines where luminances have these values, in the unit of what is shown.
    pub contours: Vec<f64>,
    /// Let what is behind the picture show where no surface is seen.
    pub transparent: bool,
    /// Interpolate between patches where there is no irradiance function.
    pub smooth: bool,
    /// One value a patch even where there is an irradiance function.
    pub flat: bool,
    /// Leave out the backs of surfaces, which are black otherwise.
    pub cull_back_faces: bool,
    /// Size of the whole picture, legend included.
    pub size: Option<Size>,
    /// Position of the camera in the model's own coordinates.
    pub eye: Option<DVec3>,
    /// The point in the middle of the picture, in the model's own coordinates.
    pub look_at: Option<DVec3>,
    /// Vertical angle of view, degrees, between 0 and 180.
    pub fov_degrees: Option<f64>,
    /// The axis that points up in the picture.
    pub up: Option<Axis>,
    /// The scale's ends, W/m^2.
    pub range: Option<Range>,
}

impl RenderSettings {
    /// Checks what the fields state.
    pub fn validate(&self) -> Result<(), SettingsError> {
        if let Some(Size { width, height }) = self.size {
            let sides = 1..=MAX_SIDE;
            if !sides.contains(&width) || !sides.contains(&height) {
                return Err(SettingsError::Side { width, height });
            }
            if u64::from(width) * u64::from(height) > MAX_PIXELS {
                return Err(SettingsError::Pixels { width, height });
            }
        }
        for (name, point) in [("eye", self.eye), ("look-at", self.look_at)] {
            if let Some(point) = point
                && !point.to_array().iter().all(|v| v.abs() <= MAX_COORDINATE)
            {
                return Err(SettingsError::Coordinate { name, point });
            }
        }
        if let (Some(eye), Some(look_at)) = (self.eye, self.look_at)
            && eye == look_at
        {
            return Err(SettingsError::NoDirection { eye });
        }
        if let Some(fov) = self.fov_degrees
            && !(fov > 0.0 && fov < 180.0)
        {
            return Err(SettingsError::Fov { fov });
        }
        if let Some(&value) = self.contours.iter().find(|value| !value.is_finite()) {
            return Err(SettingsError::Contour { value });
        }
        if self.mode == Mode::Ids && !self.contours.is_empty() {
            return Err(SettingsError::IdsWith {
                option: "--contours",
            });
        }
        if self.mode != Mode::Ids && self.raw_ids {
            return Err(SettingsError::RawWithoutIds);
        }
        if self.shown.is_luminous && self.shown.quantity == Quantity::Reflectance {
            return Err(SettingsError::LuminousReflectance);
        }
        if let Some(Range { low, high }) = self.range {
            if !(low.is_finite() && high.is_finite() && low < high) {
                return Err(SettingsError::Range { low, high });
            }
            if self.mode == Mode::Log && low <= 0.0 {
                return Err(SettingsError::LogRange { low });
            }
            if self.mode == Mode::Ids {
                return Err(SettingsError::IdsWith { option: "--range" });
            }
        }
        if self.mode == Mode::Ids && self.smooth {
            return Err(SettingsError::IdsWith { option: "--smooth" });
        }
        if self.mode == Mode::Ids && self.flat {
            return Err(SettingsError::IdsWith { option: "--flat" });
        }
        Ok(())
    }
}

/// A picture file's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// The mapped picture, 8 bits a channel, sRGB.
    Png,
    /// The values themselves, f32, W/m^2, linear RGB, unmapped.
    Exr,
}

/// An export's format, see [`scene::export`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)] // the names say all
pub enum ExportFormat {
    Ply,
    Glb,
    Obj,
    Csv,
}

/// What a table has a row of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rows {
    /// An object of the scene.
    Objects,
    /// A material.
    Materials,
}

/// What a picture is compared with.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparing {
    /// A picture (.exr), or another scene and solution.
    pub with: PathBuf,
    /// A picture of the pixels that count, which are white.
    pub mask: Option<PathBuf>,
}

/// Pictures along a path.
#[derive(Clone, Debug, PartialEq)]
pub struct Moving {
    /// The key frames, see [`crate::camera_path`].
    pub path: PathBuf,
    /// Where the frames go.
    pub out: PathBuf,
    /// As what.
    pub format: AnimationFormat,
    /// How many a second.
    pub frames_per_second: f64,
}

/// What the program is asked to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Job {
    /// To show a scene.
    Show(Box<Settings>),
    /// To draw the multiplier maps.
    Maps {
        /// Pixels along a hemicube's face.
        resolution: u32,
        /// Where the picture goes.
        out: PathBuf,
    },
    /// To draw charts of a run.
    Plot {
        /// What compute reported.
        report: PathBuf,
        /// Where the charts go, as SVG.
        out: PathBuf,
    },
}

/// Everything that is asked for of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The scene, with or without a solution.
    pub input: PathBuf,
    /// Where the picture goes.
    pub out: Option<(PathBuf, ImageFormat)>,
    /// Where the export goes.
    pub export: Option<(PathBuf, ExportFormat)>,
    /// What a table is printed of.
    pub table: Option<Rows>,
    /// What the picture is compared with; it is then the map of the difference that is written.
    pub comparing: Option<Comparing>,
    /// How the camera moves, and where its frames go.
    pub moving: Option<Moving>,
    /// The patch whose hemicube the picture shows, and pixels along its face.
    pub hemicube: Option<(PatchId, u32)>,
    /// Factors of the solution's layers, see [`crate::mix`].
    pub mix: Option<String>,
    /// A file whose range the picture has, as a series of pictures of one scene does.
    pub range_of: Option<PathBuf>,
    /// What is shown.
    pub render: RenderSettings,
}

impl Settings {
    /// Whether neither a file nor a line is asked for, so that a window is.
    pub fn is_window(&self) -> bool {
        let others = [
            self.out.is_some(),
            self.export.is_some(),
            self.table.is_some(),
            self.comparing.is_some(),
            self.moving.is_some(),
        ];
        !others.contains(&true)
    }

    /// Checks what the fields state.
    pub fn validate(&self) -> Result<(), SettingsError> {
        self.render.validate()?;
        let (image, export) = (self.out.as_ref(), self.export.as_ref());
        if self.range_of.is_some() && self.render.mode == Mode::Ids {
            return Err(SettingsError::IdsWith { option: "--range" });
        }
        if self.render.mode == Mode::Ids && image.is_some_and(|(_, f)| *f == ImageFormat::Exr) {
            return Err(SettingsError::IdsInExr);
        }
        if self.hemicube.is_some() {
            if self.render.mode == Mode::Ids {
                return Err(SettingsError::IdsWith {
                    option: "--hemicube",
                });
            }
            if image.is_some_and(|(_, format)| *format == ImageFormat::Exr) {
                return Err(SettingsError::HemicubeInExr);
            }
        }
        if self.comparing.is_some() {
            if self.render.mode == Mode::Ids {
                return Err(SettingsError::IdsWith {
                    option: "--compare",
                });
            }
            if image.is_some_and(|(_, format)| *format == ImageFormat::Exr) {
                return Err(SettingsError::MapInExr);
            }
            if self.render.shown.plain_unit() != "W/m^2" {
                return Err(SettingsError::CompareUnit);
            }
        }
        for path in [
            image.map(|o| &o.0),
            export.map(|e| &e.0),
            self.moving.as_ref().map(|moving| &moving.out),
        ]
        .into_iter()
        .flatten()
        {
            if is_same_file(path, &self.input) {
                return Err(SettingsError::OutputIsInput { path: path.clone() });
            }
        }
        Ok(())
    }
}

/// Settings that cannot be.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[allow(missing_docs)] // the fields are the values the message shows
pub enum SettingsError {
    #[error(
        "--quantity error: nothing has estimated the error of this file; compute --target-error does"
    )]
    NoError,
    #[error(
        "--quantity {}: the file has no light between patches, which alone tells direct from indirect; compute --quality standard does",
        .quantity.option()
    )]
    NoParts { quantity: Quantity },
    #[error("contour {value}: must be a finite number")]
    Contour { value: f64 },
    #[error("--raw is how patch IDs are shown; add --mode ids")]
    RawWithoutIds,
    #[error("--luminous: a reflectance has no lumens; leave it out or show another quantity")]
    LuminousReflectance,
    #[error("size {width}x{height}: each side must be 1 to {MAX_SIDE} pixels")]
    Side { width: u32, height: u32 },
    #[error("size {width}x{height}: the limit is {MAX_PIXELS} pixels in all; give a smaller one")]
    Pixels { width: u32, height: u32 },
    #[error("{name} {point} m: each coordinate must be a number between -1e12 and 1e12")]
    Coordinate { name: &'static str, point: DVec3 },
    #[error("eye and look-at are both {eye} m; move one of them")]
    NoDirection { eye: DVec3 },
    #[error("angle of view {fov} degrees must be between 0 and 180; 60 suits a room")]
    Fov { fov: f64 },
    #[error("range {low}:{high} W/m^2 must be two finite numbers, the lower one first")]
    Range { low: f64, high: f64 },
    #[error("range starts at {low} W/m^2, a logarithm needs more than 0; raise it or use linear")]
    LogRange { low: f64 },
    #[error("{option} has no meaning in mode ids; leave one of them out")]
    IdsWith { option: &'static str },
    #[error("an .exr holds unmapped values and no patch IDs; use .png for mode ids")]
    IdsInExr,
    #[error("a hemicube's four panels are a picture; use .png")]
    HemicubeInExr,
    #[error(
        "differences are told in W/m^2; leave out --luminous, and compare a radiosity, an irradiance, an emission or an error"
    )]
    CompareUnit,
    #[error("the map of a difference is a picture; use .png")]
    MapInExr,
    #[error("{} is the input; choose another name for the output", path.display())]
    OutputIsInput { path: PathBuf },
}
