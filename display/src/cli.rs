//! The command line.

use std::path::PathBuf;
use std::str::FromStr;

use clap::{CommandFactory, Parser, ValueEnum, error::ErrorKind};
use glam::DVec3;

use scene::{Axis, PatchId};

use crate::animation::AnimationFormat;
use crate::quantity::{Channel, Quantity, Shown};
use crate::settings::{
    Comparing, ExportFormat, ImageFormat, Job, Mode, Moving, Range, RenderSettings, Rows, Settings,
    Size,
};

/// Shows a scene or its solution: in a window, and as pictures and exports, without a graphics card.
///
/// FILE alone opens a window. With --out, --export and the like there is none; what was written is printed, and what deserves a
/// second look goes to standard error.
#[derive(Debug, Parser)]
#[command(name = "display", version, arg_required_else_help = true, after_help = EXAMPLES)]
#[expect(clippy::struct_excessive_bools, reason = "switches of a command line")]
struct Args {
    /// The scene, with or without a solution [default: none, which --plot and --maps do without]
    #[arg(required_unless_present_any = ["plot", "maps"])]
    file: Option<PathBuf>,
    /// s: like --smooth; c: like --mode ids [default: neither]
    style: Option<Style>,
    /// Write the picture: .png mapped for the eye, .exr linear in W/m^2; with --path .png numbered frames, .apng or .gif an
    /// animation; with --plot .svg [default: no picture]
    #[arg(long, value_name = "IMAGE.png|.exr", value_parser = image_path)]
    out: Option<(PathBuf, OutFormat)>,
    /// How values become colours [default: log, of errors false-color]
    #[arg(long)]
    mode: Option<ModeArg>,
    /// Which values are shown, in W/m^2: the radiosity (light that leaves), the radiance (the same as a camera measures it, in
    /// W/(m^2 sr)), the irradiance (light that arrives) or its direct and indirect part, the emission, the reflectance
    /// (dimensionless), or the error, patch by patch, that compute estimates
    #[arg(long, default_value = "radiosity")]
    quantity: QuantityArg,
    /// Show one channel, or the luminance, as a grey [default: all, in colour]
    #[arg(long)]
    channel: Option<ChannelArg>,
    /// In lumens instead of watts: irradiance in lx, radiance in cd/m^2, by 179 lm/W and the luminance of BT.709 [default: watts]
    #[arg(long)]
    luminous: bool,
    /// Interpolate between patches, but not over creases or between materials, where the file has no light between
    /// them [default: each patch in one colour]
    #[arg(long)]
    smooth: bool,
    /// Show each patch in one colour even where the file has the light between them, by compute --target-error
    /// [default: that light]
    #[arg(long, conflicts_with = "smooth")]
    flat: bool,
    /// Leave out the backs of surfaces, to look into closed rooms [default: they are black]
    #[arg(long)]
    cull_back: bool,
    /// Size of the picture in pixels [default: 768 rows, as wide as suits the scene]
    #[arg(long, value_name = "WxH", value_parser = size)]
    size: Option<Size>,
    /// Position of the camera, in the model's own coordinates [default: chosen by the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    eye: Option<DVec3>,
    /// What the camera looks at, in the model's own coordinates [default: from a given eye the scene's
    /// middle, else chosen by the scene]
    #[arg(long, value_name = "X,Y,Z", value_parser = point, allow_hyphen_values = true)]
    look_at: Option<DVec3>,
    /// Vertical angle of view, degrees, between 0 and 180 [default: from a given eye 60, else chosen by
    /// the scene]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    fov: Option<f64>,
    /// The axis that points up in the picture [default: guessed from the scene]
    #[arg(long)]
    up: Option<AxisArg>,
    /// Luminances at the ends of the scale, in the unit of what is shown, or a file whose range is taken, for a series of
    /// pictures [default: chosen by what does not emit]
    #[arg(long, value_name = "LO:HI|FILE", value_parser = range, allow_hyphen_values = true)]
    range: Option<RangeArg>,
    /// Dim and colour lamps, or leave out bounces, of a file of compute --layers: a factor a layer, or three for red:green:blue,
    /// seen in the range of all light [default: all layers as they are]
    #[arg(long, value_name = "NAME=F,...", allow_hyphen_values = true)]
    mix: Option<String>,
    /// Draw lines where luminances have these values, in the unit of what is shown [default: none]
    #[arg(
        long,
        value_name = "A,B,...",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    contours: Vec<f64>,
    /// Show in --mode ids each ID as R = ID >> 16, G = ID >> 8, B = ID [default: in a colour that tells it from others]
    #[arg(long)]
    raw: bool,
    /// Let the picture be transparent where there is no surface [default: it is black there]
    #[arg(long)]
    transparent: bool,
    /// Print a table: of each object or material the area, the least, mean and largest value, and the power that it receives and
    /// emits [default: no table]
    #[arg(long, value_name = "WHAT")]
    by: Option<ByArg>,
    /// Compare the picture with this one, or with one of this scene: print what differs, and write a map of it to --out
    /// [default: no comparison]
    #[arg(long, value_name = "FILE.exr|.rad", conflicts_with_all = ["by", "path", "export"])]
    compare: Option<PathBuf>,
    /// Compare only the pixels that are white in this picture [default: those that see a front that does not emit]
    #[arg(long, value_name = "FILE.png", requires = "compare")]
    mask: Option<PathBuf>,
    /// Move the camera through key frames, a line each: seconds, x,y,z of the eye, x,y,z of what it looks at, and the angle of
    /// view if it changes [default: one picture]
    #[arg(long, value_name = "FILE", requires = "out", conflicts_with_all = ["eye", "look_at", "transparent"])]
    path: Option<PathBuf>,
    /// Frames a second along --path
    #[arg(long, value_name = "N", default_value_t = 25.0, requires = "path")]
    fps: f64,
    /// Show what a patch sees: its hemicube unfolded, as patch IDs, radiosities, delta form factors and their product
    /// [default: the scene]
    #[arg(long, value_name = "PATCH", requires = "out", conflicts_with_all = [
        "compare", "path", "quantity", "channel", "luminous", "contours", "transparent"])]
    hemicube: Option<u32>,
    /// Show the maps that hemicubes' pixels are multiplied by, the exact ones and the thesis's; no FILE is needed
    /// [default: the scene]
    #[arg(long, requires = "out", conflicts_with_all = ["file", "compare", "path", "by", "export", "hemicube"])]
    maps: bool,
    /// Pixels along the face of a hemicube that is shown, an even number
    #[arg(long, value_name = "N", default_value_t = 128)]
    resolution: u32,
    /// Draw charts of what compute --report wrote: residuals, errors, time [default: none]
    #[arg(long, value_name = "REPORT.json", requires = "out", conflicts_with_all = ["file", "compare", "path", "by", "export"])]
    plot: Option<PathBuf>,
    /// Write the patches: .ply and .glb with the picture's colours, .obj and its .mtl, or .csv with all
    /// values [default: no export]
    #[arg(long, value_name = "FILE.ply|.glb|.obj|.csv", value_parser = export_path)]
    export: Option<(PathBuf, ExportFormat)>,
}

const EXAMPLES: &str = "\
Examples:
  display solved.rad                                     a window: turn it, click it
  display solved.rad --out room.png                      a picture, camera and range chosen by the scene
  display solved.rad s --out room.png --size 1600x1200   interpolated, larger
  display solved.rad --out meter.png --mode false-color --quantity irradiance --range 0.1:50
                                                         what light meters would show, with a legend
  display solved.rad --out view.png --eye 1,1.7,4 --look-at 0,1,0 --fov 50
  display solved.rad --out outside.png --cull-back       into a closed room from outside
  display solved.rad --out lux.png --mode false-color --quantity irradiance --luminous --contours 100,200,300
                                                         illuminance, with lines
  display solved.rad --by object --quantity irradiance   a table of what walls receive
  display after2.rad --out after2.png --range solved.rad
                                                         as bright as a picture of the other file
  display layers.rad --mix lantern=0.2,panel=1:0.6:0.3 --out dimmed.png
                                                         lamps dimmed and coloured
  display solved.rad --compare reference.rad --out difference.png
                                                         both errors, and where it is too bright or too dark
  display solved.rad --path walk.txt --out walk.gif --size 320x240
                                                         an animation along key frames
  display solved.rad --hemicube 812 --out sees.png       what patch 812 sees, and what that brings it
  display --maps --out maps.png                          exact and thesis's multiplier maps
  display --plot report.json --out report.svg            residuals, errors and time of a run
  display scene.rad c --out ids.png                      the patches, each in a colour of its own
  display solved.rad --export values.csv                 all numbers, one row a patch
Lengths are in the unit of the model's coordinates; values are in W/m^2, linear RGB. Watts of a whole are the mean of the channels.
Exit codes: 0 done, 1 failed, 2 wrong usage.";

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Style {
    S,
    C,
}

#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum ModeArg {
    Log,
    Filmic,
    Linear,
    FalseColor,
    Ids,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum QuantityArg {
    Radiosity,
    Radiance,
    Irradiance,
    Direct,
    Indirect,
    Emission,
    Reflectance,
    Error,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ChannelArg {
    Red,
    Green,
    Blue,
    Luminance,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum ByArg {
    Object,
    Material,
}

#[derive(Clone, Debug)]
enum RangeArg {
    Ends(Range),
    Of(PathBuf),
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum AxisArg {
    X,
    Y,
    Z,
}

/// What the process's arguments ask for; with wrong ones, the usage, and exit 2.
pub fn parse() -> Job {
    let usage = |message| Args::command().error(ErrorKind::ValueValidation, message);
    let checked = |args: Args| {
        let job = args.into_job().map_err(usage)?;
        match &job {
            Job::Show(settings) => match settings.validate() {
                Ok(()) => Ok(job),
                Err(error) => Err(usage(error.to_string())),
            },
            Job::Maps { .. } | Job::Plot { .. } => Ok(job),
        }
    };
    Args::try_parse()
        .and_then(checked)
        .unwrap_or_else(|error| stop(&error))
}

/// Prints help, the version or a usage error, and ends the process.
fn stop(error: &clap::Error) -> Job {
    let is_help = error.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand;
    if error.use_stderr() && !is_help {
        eprint!("display: ");
    }
    error.exit()
}

impl Args {
    fn into_job(mut self) -> Result<Job, String> {
        if self.maps {
            return match self.out {
                Some((out, OutFormat::Png)) => Ok(Job::Maps {
                    resolution: self.resolution,
                    out,
                }),
                _ => Err("the maps are a picture; give --out FILE.png".into()),
            };
        }
        let Some(report) = self.plot.take() else {
            return Ok(Job::Show(Box::new(self.into_settings()?)));
        };
        match self.out {
            Some((out, OutFormat::Chart)) => Ok(Job::Plot { report, out }),
            _ => Err("charts are written to an .svg; give --out FILE.svg".into()),
        }
    }

    fn into_settings(self) -> Result<Settings, String> {
        let mode = match (self.style, self.mode) {
            (Some(Style::C), None | Some(ModeArg::Ids)) => ModeArg::Ids,
            (Some(Style::C), Some(_)) => {
                return Err("c means --mode ids; leave out c or the other mode".into());
            }
            (_, Some(mode)) => mode,
            (_, None) if matches!(self.quantity, QuantityArg::Error) => ModeArg::FalseColor,
            (_, None) => ModeArg::Log,
        };
        let (range, range_of) = match self.range {
            Some(RangeArg::Ends(range)) => (Some(range), None),
            Some(RangeArg::Of(file)) => (None, Some(file)),
            None => (None, None),
        };
        let (out, moving) = outputs(self.out, self.path.as_ref(), self.fps)?;
        let mask = self.mask;
        Ok(Settings {
            input: self.file.unwrap_or_default(),
            out,
            moving,
            hemicube: self.hemicube.map(|patch| (PatchId(patch), self.resolution)),
            comparing: self.compare.map(|with| Comparing { with, mask }),
            export: self.export,
            table: self.by.map(|by| match by {
                ByArg::Object => Rows::Objects,
                ByArg::Material => Rows::Materials,
            }),
            range_of,
            mix: self.mix,
            render: RenderSettings {
                mode: match mode {
                    ModeArg::Log => Mode::Log,
                    ModeArg::Filmic => Mode::Filmic,
                    ModeArg::Linear => Mode::Linear,
                    ModeArg::FalseColor => Mode::FalseColor,
                    ModeArg::Ids => Mode::Ids,
                },
                shown: Shown {
                    quantity: match self.quantity {
                        QuantityArg::Radiosity => Quantity::Radiosity,
                        QuantityArg::Radiance => Quantity::Radiance,
                        QuantityArg::Irradiance => Quantity::Irradiance,
                        QuantityArg::Direct => Quantity::Direct,
                        QuantityArg::Indirect => Quantity::Indirect,
                        QuantityArg::Emission => Quantity::Emission,
                        QuantityArg::Reflectance => Quantity::Reflectance,
                        QuantityArg::Error => Quantity::Error,
                    },
                    channel: match self.channel {
                        None => Channel::All,
                        Some(ChannelArg::Red) => Channel::Red,
                        Some(ChannelArg::Green) => Channel::Green,
                        Some(ChannelArg::Blue) => Channel::Blue,
                        Some(ChannelArg::Luminance) => Channel::Luminance,
                    },
                    is_luminous: self.luminous,
                },
                raw_ids: self.raw,
                contours: self.contours,
                transparent: self.transparent,
                smooth: self.smooth || self.style == Some(Style::S),
                flat: self.flat,
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
                range,
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

/// What is written, by its name.
#[derive(Clone, Copy, Debug, PartialEq)]
enum OutFormat {
    Png,
    Exr,
    Apng,
    Gif,
    Chart,
}

fn image_path(text: &str) -> Result<(PathBuf, OutFormat), String> {
    with_format(
        text,
        &[
            ("png", OutFormat::Png),
            ("exr", OutFormat::Exr),
            ("apng", OutFormat::Apng),
            ("gif", OutFormat::Gif),
            ("svg", OutFormat::Chart),
        ],
    )
}

/// A picture or the frames of a path, whichever is asked for.
#[expect(clippy::type_complexity, reason = "two fields of the settings")]
fn outputs(
    out: Option<(PathBuf, OutFormat)>,
    path: Option<&PathBuf>,
    frames_per_second: f64,
) -> Result<(Option<(PathBuf, ImageFormat)>, Option<Moving>), String> {
    let Some((out, format)) = out else {
        return Ok((None, None));
    };
    let picture = |format| Ok((Some((out.clone(), format)), None));
    let frames = |path: &PathBuf, format| {
        let (path, out) = (path.clone(), out.clone());
        let moving = Moving {
            path,
            out,
            format,
            frames_per_second,
        };
        Ok((None, Some(moving)))
    };
    match (format, path) {
        (OutFormat::Png, None) => picture(ImageFormat::Png),
        (OutFormat::Exr, None) => picture(ImageFormat::Exr),
        (OutFormat::Png, Some(path)) => frames(path, AnimationFormat::Numbered),
        (OutFormat::Apng, Some(path)) => frames(path, AnimationFormat::Apng),
        (OutFormat::Gif, Some(path)) => frames(path, AnimationFormat::Gif),
        (OutFormat::Apng | OutFormat::Gif, None) => {
            Err("an animation needs a path; add --path FILE, or write a .png".into())
        }
        (OutFormat::Exr, Some(_)) => Err("frames are .png, .apng or .gif".into()),
        (OutFormat::Chart, _) => Err("an .svg has the charts of a report; add --plot FILE".into()),
    }
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
        .ok_or_else(|| "give three numbers, in the model's own coordinates, as in 1.5,-2,0".into())
}

fn size(text: &str) -> Result<Size, String> {
    numbers(&text.to_lowercase(), 'x')
        .map(|[width, height]| Size { width, height })
        .ok_or_else(|| "give two whole numbers, in pixels, as in 1024x768".into())
}

/// What reads as two numbers is no file's name.
fn range(text: &str) -> Result<RangeArg, String> {
    if let Some([low, high]) = numbers(text, ':') {
        return Ok(RangeArg::Ends(Range { low, high }));
    }
    let path = PathBuf::from(text);
    if path.extension().is_some_and(|extension| extension == "rad") || path.is_file() {
        return Ok(RangeArg::Of(path));
    }
    Err(
        "give two numbers, in the unit of what is shown, as in 0.1:50, or a file that has a range"
            .into(),
    )
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
    fn help_says_every_default_and_its_examples_are_right() {
        for argument in Args::command().get_arguments() {
            let help = argument.get_help().unwrap().to_string();
            let has_default = !argument.get_default_values().is_empty();
            assert!(
                argument.is_required_set() || has_default || help.contains("[default: "),
                "{help}"
            );
        }
        let examples: Vec<&str> = EXAMPLES
            .lines()
            .filter(|l| l.starts_with("  display"))
            .collect();
        assert!(examples.len() > 5);
        for example in examples {
            // What it does stands two spaces behind it.
            let words = example.trim().split("  ").next().unwrap().split(' ');
            let args = Args::try_parse_from(words).unwrap();
            if let Job::Show(settings) = args.into_job().unwrap() {
                settings.validate().unwrap();
            }
        }
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
