//! The command line.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{CommandFactory, Parser, ValueEnum, error::ErrorKind};
use glam::DVec3;

use crate::settings::{
    Axis, ExportFormat, ImageFormat, Mode, Quantity, Range, RenderSettings, Settings, Size,
};

/// Shows a scene or its solution: pictures and exports, without a graphics card.
#[derive(Debug, Parser)]
#[command(name = "display", version, arg_required_else_help = true)]
struct Args {
    /// The scene, with or without a solution
    file: PathBuf,
    /// s: like --smooth; c: like --mode ids
    style: Option<Style>,
    /// Write the picture: .png mapped for the eye, .exr linear in W/m^2
    #[arg(long, value_name = "IMAGE.png|.exr", value_parser = image_path)]
    out: Option<(PathBuf, ImageFormat)>,
    /// How values become colours [default: log]
    #[arg(long)]
    mode: Option<ModeArg>,
    /// Which values are shown, both in W/m^2
    #[arg(long, default_value = "radiosity")]
    quantity: QuantityArg,
    /// Interpolate between patches, but not over creases or between materials
    #[arg(long)]
    smooth: bool,
    /// Leave out the backs of surfaces, to look into closed rooms
    #[arg(long)]
    cull_back: bool,
    /// Size of the picture in pixels [default: 768 rows]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,
    /// Position of the camera, in the model's own coordinates [default: chosen by the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// What the camera looks at, in the model's own coordinates
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    look_at: Option<DVec3>,
    /// Vertical angle of view, degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    fov: Option<f64>,
    /// The axis that points up in the picture [default: guessed from the scene]
    #[arg(long)]
    up: Option<AxisArg>,
    /// Luminances at the ends of the scale, W/m^2 [default: chosen by the patches]
    #[arg(long, value_name = "LO:HI", value_parser = range, allow_hyphen_values = true)]
    range: Option<Range>,
    /// Write the patches: .ply and .glb with the picture's colours, .obj, or .csv with all values
    #[arg(long, value_name = "FILE.ply|.glb|.obj|.csv", value_parser = export_path)]
    export: Option<(PathBuf, ExportFormat)>,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Style {
    S,
    C,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum ModeArg {
    Log,
    Linear,
    FalseColor,
    Ids,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum QuantityArg {
    Radiosity,
    Irradiance,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum AxisArg {
    X,
    Y,
    Z,
}

/// The settings that the process's arguments ask for; with wrong ones, the usage, and exit 2.
pub fn parse() -> Settings {
    let args = Args::parse();
    let usage = |message: String| {
        Args::command()
            .error(ErrorKind::ValueValidation, message)
            .exit()
    };
    let settings = match args.into_settings() {
        Ok(settings) => settings,
        Err(message) => usage(message),
    };
    match settings.validate() {
        Ok(()) => settings,
        Err(error) => usage(error.to_string()),
    }
}

impl Args {
    fn into_settings(self) -> Result<Settings, String> {
        let mode = match (self.style, self.mode) {
            (Some(Style::C), None | Some(ModeArg::Ids)) => ModeArg::Ids,
            (Some(Style::C), Some(_)) => {
                return Err("c means --mode ids; leave out c or the other mode".into());
            }
            (_, mode) => mode.unwrap_or(ModeArg::Log),
        };
        Ok(Settings {
            input: self.file,
            out: self.out,
            export: self.export,
            render: RenderSettings {
                mode: match mode {
                    ModeArg::Log => Mode::Log,
                    ModeArg::Linear => Mode::Linear,
                    ModeArg::FalseColor => Mode::FalseColor,
                    ModeArg::Ids => Mode::Ids,
                },
                quantity: match self.quantity {
                    QuantityArg::Radiosity => Quantity::Radiosity,
                    QuantityArg::Irradiance => Quantity::Irradiance,
                },
                smooth: self.smooth || self.style == Some(Style::S),
                cull_back_faces: self.cull_back,
                size: self.size,
                eye: self.eye,
                look_at: self.look_at,
                fov_degrees: self.fov,
                up: self.up.map(|axis| match axis {
                    AxisArg::X => Axis::X,
                    AxisArg::Y => Axis::Y,
                    AxisArg::Z => Axis::Z,
                }),
                range: self.range,
            },
        })
    }
}

/// The path with the format that its extension names.
fn with_format<F: Copy>(text: &str, formats: &[(&str, F)]) -> Result<(PathBuf, F), String> {
    let path = PathBuf::from(text);
    let extension = path
        .extension()
        .unwrap_or_default()
        .to_string_lossy()
        .to_lowercase();
    if let Some(&(_, format)) = formats.iter().find(|(name, _)| *name == extension) {
        return Ok((path, format));
    }
    let names: Vec<String> = formats.iter().map(|(name, _)| format!(".{name}")).collect();
    Err(format!("unknown extension; use {}", names.join(" or ")))
}

fn image_path(text: &str) -> Result<(PathBuf, ImageFormat), String> {
    with_format(
        text,
        &[("png", ImageFormat::Png), ("exr", ImageFormat::Exr)],
    )
}

fn export_path(text: &str) -> Result<(PathBuf, ExportFormat), String> {
    with_format(
        text,
        &[
            ("ply", ExportFormat::Ply),
            ("glb", ExportFormat::Glb),
            ("obj", ExportFormat::Obj),
            ("csv", ExportFormat::Csv),
        ],
    )
}

/// N numbers between separators.
fn numbers<T: FromStr, const N: usize>(text: &str, separator: char) -> Option<[T; N]> {
    let numbers: Result<Vec<T>, _> = text.split(separator).map(|n| n.trim().parse()).collect();
    numbers.ok()?.try_into().ok()
}

fn point(text: &str) -> Result<DVec3, String> {
    numbers(text, ',')
        .map(DVec3::from_array)
        .ok_or_else(|| "give three numbers, in metres, as in 1.5,-2,0".into())
}

fn size(text: &str) -> Result<Size, String> {
    numbers(&text.to_lowercase(), 'x')
        .map(|[width, height]| Size { width, height })
        .ok_or_else(|| "give two whole numbers, in pixels, as in 1024x768".into())
}

fn range(text: &str) -> Result<Range, String> {
    numbers(text, ':')
        .map(|[low, high]| Range { low, high })
        .ok_or_else(|| "give two numbers, in W/m^2, as in 0.1:50".into())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn settings(arguments: &[&str]) -> Settings {
        let all = ["display", "f"].iter().chain(arguments);
        Args::try_parse_from(all).unwrap().into_settings().unwrap()
    }

    #[test]
    fn command_is_consistent() {
        Args::command().debug_assert();
    }

    #[test]
    fn negative_numbers_are_values_and_not_options() {
        let render = settings(&["--eye", "-1,-2.5,-3e1", "--look-at", "-.5,0,1"]).render;
        assert_eq!(render.eye, Some(DVec3::new(-1.0, -2.5, -30.0)));
        assert_eq!(render.look_at, Some(DVec3::new(-0.5, 0.0, 1.0)));
    }

    #[test]
    fn shorthands_mean_what_they_stand_for() {
        assert_eq!(settings(&["s"]), settings(&["--smooth"]));
        assert_eq!(settings(&["c"]), settings(&["--mode", "ids"]));
    }

    #[test]
    fn extensions_decide_the_format_in_any_case() {
        let settings = settings(&["--out", "a.PNG", "--export", "b.c.Ply"]);
        assert_eq!(settings.out, Some(("a.PNG".into(), ImageFormat::Png)));
        assert_eq!(settings.export, Some(("b.c.Ply".into(), ExportFormat::Ply)));
    }
}
