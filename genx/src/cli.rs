//! The command line, turned into settings.

use std::ffi::OsString;
use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser};
use genx::cut::Cut;
use genx::{Change, Look, Model, Settings};
use scene::file::is_same_file;
use scene::import::Orient;
use scene::{Axis, Rgb};

/// What the user asks for.
pub struct Request {
    /// The file to write.
    pub out: PathBuf,
    /// What goes into it.
    pub settings: Settings,
    /// Whether objects and materials are listed.
    pub is_listed: bool,
}

/// Why there is nothing to do: a usage error, or help or the version was asked for.
pub struct Stop(clap::Error);

impl Stop {
    fn usage(kind: ErrorKind, message: impl std::fmt::Display) -> Self {
        Self(Arguments::command().error(kind, message))
    }

    /// Prints the text, to standard error if it is an error, and gives the exit code.
    pub fn print(&self) -> u8 {
        // If the text cannot be printed there is nowhere left to say so.
        if self.0.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
            || !self.0.use_stderr()
        {
            self.0.print().ok();
        } else {
            eprint!("genx: {}", self.0.render());
        }
        self.0.exit_code() as u8
    }
}

const EXAMPLES: &str = "\
Models:
  1        a cube, 10 m wide, with a small square lamp in its ceiling
  2        a hall with two rows of columns, a partition and many kinds of shadow,
           sized for the thresholds 5, 1 and 0.25: about 26, 137 and 546 thousand patches
  3        a corridor in the shape of a U: light bends round an obstacle into a region
           that no direct light reaches
  cornell  the Cornell box: published geometry, reflectances and light; its front is open
  furnace  a closed unit box whose walls all emit and reflect alike: the solution is
           LIGHT_POWER / (1 - REFLECTANCE) everywhere
  FILE.obj triangles and polygons of a Wavefront OBJ file; Kd of its MTL file is the
           reflectance, Ke the emission (exitance, W/m^2), map_Kd a texture of which each
           triangle has the mean; polygons are fanned, concave ones cut so that nothing overlaps
  FILE.glb, FILE.gltf
           triangles of a glTF 2.0 file: the base colour and its texture are the reflectance, the
           emissive factor times pi the emission, and a small sphere stands in for each point light,
           a small disc for each spot light, 1 W/sr a candela. Blender writes 683 candela for 1 W/sr
           unless its exporter's lighting mode is \"Unitless\"

FILE is any of these files.

REFLECTANCE replaces the colours by one grey: of all surfaces in models 1 to 3 and furnace, of all
materials that do not emit in cornell and FILE. LIGHT_POWER is the exitance of every lamp in
models 1 to 3 and of every wall in furnace; in cornell and FILE all emission is scaled so that
the brightest channel of the brightest emitter is LIGHT_POWER.

Defaults:
  model     AREA_THRESHOLD  REFLECTANCE           LIGHT_POWER
  1         0.2             0.5                   1000
  2         5               a colour an object    1000, tinted
  3         0.05            0.7                   1000
  cornell   0.001           as published          as published (57.76, 43.94, 21.22)
  furnace   0.04            0.5                   1
  FILE      area / 4000     as in the file        as in the file

Examples:
  genx cube.rad 1 2.5 0.15 100000       the thesis's example
  genx hall.rad 2 --max-area 1          a finer hall in its own colours
  genx box.rad cornell
  genx mine.rad mine.obj --max-area inf one patch for each triangle of the file
  genx mine.rad mine.glb --light-radius 0.05
                                        a glTF file with larger lamps
  genx mine.rad mine.obj --list         the names of its objects and materials
  genx mine.rad mine.obj --light Lamp=50,45,40 --reflectance Wall=0.8
                                        light and paint for what has these names";

/// Makes a scene for `compute` to solve: a test model, or an OBJ or glTF file.
///
/// Surfaces are bisected until no patch is larger than the area threshold. What was made is
/// printed; what deserves a second look goes to standard error. Exit codes: 0 done, 1 failed, 2
/// wrong usage.
#[derive(Parser)]
#[command(name = "genx", version, after_long_help = EXAMPLES, after_help = "See --help for the models, their defaults and examples.")]
#[command(arg_required_else_help = true, allow_negative_numbers = true)]
#[command(
    override_usage = "genx OUT MODEL [AREA_THRESHOLD REFLECTANCE LIGHT_POWER]\n       genx OUT MODEL --max-area A"
)]
struct Arguments {
    /// File to write; replaced whole, or on errors left as it was
    out: PathBuf,
    /// 1, 2, 3, cornell, furnace, FILE.obj, FILE.gltf or FILE.glb
    model: OsString,
    /// Largest area of a patch, m^2; inf keeps each triangle as one patch
    area_threshold: Option<f64>,
    /// Reflectance, dimensionless, from 0 to below 1
    reflectance: Option<f32>,
    /// Exitance of the lamps, W/m^2
    light_power: Option<f32>,
    /// The same as AREA_THRESHOLD, with the model's own reflectances and lamps
    #[arg(long, value_name = "A")]
    max_area: Option<f64>,
    /// The largest reflectance that FILE may have; without it, what is 1 or more is taken as 0.95, and all else as it is
    #[arg(long, value_name = "R")]
    max_reflectance: Option<f32>,
    /// Which side of a face of FILE is its front: auto (as it is wound, but faces of a minority that is wound against
    /// the file's own normals are turned), normals, or winding
    #[arg(long, default_value = "auto", value_parser = ORIENTS.map(|(name, _)| name))]
    orient: String,
    /// What the coordinates of FILE are: m, cm, mm, in or ft; areas and powers are in m^2 and W all the same [default: m]
    #[arg(long, value_name = "UNIT", value_parser = UNITS.map(|(name, _)| name))]
    unit: Option<String>,
    /// The axis that points up, for pictures: x, y or z; else guessed
    #[arg(long, value_name = "AXIS", value_parser = UPS.map(|(name, _)| name))]
    up: Option<String>,
    /// Give a material or an object this reflectance
    #[arg(long = "reflectance", value_name = "NAME=R,G,B", value_parser = named_colour)]
    reflectance_of: Vec<(String, Rgb)>,
    /// Give a material or an object this exitance, W/m^2
    #[arg(long, value_name = "NAME=R,G,B", value_parser = named_colour)]
    light: Vec<(String, Rgb)>,
    /// Let all surfaces of a material or an object emit this power together, W
    #[arg(long = "light-power", value_name = "NAME=W", value_parser = named_colour)]
    light_power_of: Vec<(String, Rgb)>,
    /// Radius of the bodies that stand in for lights without extent in a glTF file, m [default: 0.01]
    #[arg(long, value_name = "R")]
    light_radius: Option<f64>,
    /// Where faces of FILE overlap in one plane, as a lamp in a ceiling: on (they are cut, and the lamp or the smaller thing
    /// stays), off, or report (it is only told)
    #[arg(long, default_value = "on", value_parser = CUTS.map(|(name, _)| name))]
    cut: String,
    /// Turn a material's or an object's faces round: their front is where their back was
    #[arg(long, value_name = "NAME")]
    flip: Vec<String>,
    /// Give a material's or an object's faces fronts on both sides
    #[arg(long, value_name = "NAME")]
    two_sided: Vec<String>,
    /// Take a material's or an object's faces out, as those of a window: light leaves there, and what cuts the same plane
    /// below them goes too; compute --strict expects this hole and judges the rest
    #[arg(long, value_name = "NAME")]
    opening: Vec<String>,
    /// Print the objects and materials with their areas
    #[arg(long)]
    list: bool,
}

/// The words of --orient.
const ORIENTS: [(&str, Orient); 3] = [
    ("auto", Orient::Auto),
    ("normals", Orient::Normals),
    ("winding", Orient::Winding),
];

/// The units of --unit, in metres.
const UNITS: [(&str, f64); 5] = [
    ("m", 1.0),
    ("cm", 0.01),
    ("mm", 0.001),
    ("in", 0.0254),
    ("ft", 0.3048),
];

/// The words of --up.
const UPS: [(&str, Axis); 3] = [("x", Axis::X), ("y", Axis::Y), ("z", Axis::Z)];

/// The words of --cut.
const CUTS: [(&str, Cut); 3] = [("on", Cut::On), ("off", Cut::Off), ("report", Cut::Report)];

/// What a word stands for.
fn meaning<T: Copy>(words: &[(&str, T)], word: Option<&String>) -> Option<T> {
    let found = words
        .iter()
        .find(|(name, _)| word.is_some_and(|word| word == name));
    found.map(|(_, value)| *value)
}

/// A name and one number or three; the last "=" ends the name.
fn named_colour(text: &str) -> Result<(String, Rgb), String> {
    let wrong =
        || format!("\"{text}\" is not a name, \"=\", and one number or three, as in lamp=50,40,30");
    let (name, values) = text.rsplit_once('=').ok_or_else(wrong)?;
    let values: Vec<f32> = values
        .split(',')
        .map(|value| value.trim().parse().map_err(|_| wrong()))
        .collect::<Result<_, _>>()?;
    match values[..] {
        [grey] => Ok((name.to_owned(), Rgb::splat(grey))),
        [r, g, b] => Ok((name.to_owned(), Rgb::new(r, g, b))),
        _ => Err(wrong()),
    }
}

/// Reads the arguments, the program's name first.
pub fn parse(arguments: impl IntoIterator<Item = OsString>) -> Result<Request, Stop> {
    let arguments = Arguments::try_parse_from(arguments).map_err(Stop)?;
    let invalid =
        |message: &dyn std::fmt::Display| Stop::usage(ErrorKind::ValueValidation, message);
    let model = Model::try_from(arguments.model.as_os_str()).map_err(|e| invalid(&e))?;
    let positionals = [
        arguments.area_threshold.is_some(),
        arguments.reflectance.is_some(),
        arguments.light_power.is_some(),
    ];
    if positionals[0] && arguments.max_area.is_some() {
        return Err(Stop::usage(
            ErrorKind::ArgumentConflict,
            "AREA_THRESHOLD and --max-area say the same; give one of them",
        ));
    }
    if positionals[0] && !positionals[2] {
        return Err(Stop::usage(
            ErrorKind::MissingRequiredArgument,
            "AREA_THRESHOLD, REFLECTANCE and LIGHT_POWER are given all or none; for the area alone use --max-area",
        ));
    }
    let settings = Settings {
        model,
        max_area: arguments.area_threshold.or(arguments.max_area),
        reflectance: arguments.reflectance,
        light_power: arguments.light_power,
        max_reflectance: arguments.max_reflectance,
        orient: meaning(&ORIENTS, Some(&arguments.orient)).unwrap_or_default(),
        unit: meaning(&UNITS, arguments.unit.as_ref()),
        up: meaning(&UPS, arguments.up.as_ref()),
        light_radius: arguments.light_radius,
        cut: meaning(&CUTS, Some(&arguments.cut)).unwrap_or_default(),
        changes: [
            changes(arguments.reflectance_of, Look::Reflectance),
            changes(arguments.light, Look::Emission),
            changes(arguments.light_power_of, Look::Power),
            turns(arguments.flip, Look::Flipped),
            turns(arguments.two_sided, Look::TwoSided),
        ]
        .concat(),
        openings: arguments.opening,
    };
    settings.validate().map_err(|e| invalid(&e))?;
    if let Model::File { path: input, .. } = &settings.model
        && is_same_file(input, &arguments.out)
    {
        return Err(invalid(&format!(
            "OUT is the model itself, {}; choose another name",
            input.display()
        )));
    }
    Ok(Request {
        out: arguments.out,
        settings,
        is_listed: arguments.list,
    })
}

/// What is done to the faces of names.
fn turns(names: Vec<String>, to: Look) -> Vec<Change> {
    names.into_iter().map(|name| Change { name, to }).collect()
}

/// What names are given.
fn changes(names: Vec<(String, Rgb)>, look: fn(Rgb) -> Look) -> Vec<Change> {
    let to = |(name, rgb)| Change {
        name,
        to: look(rgb),
    };
    names.into_iter().map(to).collect()
}
