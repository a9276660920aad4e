//! The command line of `compute`, turned into [`Settings`].

use std::path::PathBuf;
use std::time::Duration;

use clap::Parser;
use clap::builder::PossibleValuesParser;
use clap::builder::TypedValueParser;

use crate::hemicube::MAX_RESOLUTION;
use crate::quantity::{parse_duration, parse_size};
use crate::settings::{BackendChoice, FormFactorSettings, Maps, Points, Settings, SolverChoice};

/// Solves a scene by hemicube radiosity.
///
/// Every patch looks through a hemicube at the surfaces around it, which gives its form factors; then
/// all patches gather each other's radiosity, again and again, until nothing changes. The result can
/// be the input of another run, which goes on where this one stopped.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true, after_help = EXAMPLES)]
struct Arguments {
    /// Scene file from genx, or a result to go on with
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// Where the result goes; may be IN
    #[arg(value_name = "OUT")]
    output: PathBuf,
    /// Pixels along a hemicube's face: even, 2 to 4096
    #[arg(value_name = "RESOLUTION", default_value = "128", value_parser = parse_resolution)]
    resolution: u32,
    /// Who draws: auto takes a real GPU where there is one, else the CPU; gpu takes software GPUs too
    #[arg(long, default_value = "auto", value_parser = backend_parser())]
    backend: BackendChoice,
    /// How to solve; an iteration of shooting is one shot
    #[arg(long, default_value = "jacobi", value_parser = choice(&[
        ("jacobi", SolverChoice::Jacobi), ("gauss-seidel", SolverChoice::GaussSeidel),
        ("shooting", SolverChoice::Shooting)]))]
    solver: SolverChoice,
    /// What the pixels count: exact integrals, or the thesis's multipliers for comparison
    #[arg(long, default_value = "exact", value_parser = choice(&[
        ("exact", Maps::Exact), ("thesis", Maps::Thesis)]))]
    maps: Maps,
    /// Where a patch's hemicubes stand: centroid, vertices, or N = 2, 4, 8 ... 1024 points of equal area
    #[arg(long, default_value = "centroid", value_parser = parse_points)]
    points: Points,
    /// Stop after N iterations, those that IN has had included
    #[arg(long, value_name = "N")]
    iterations: Option<u64>,
    /// Stop when an iteration changes the radiosities by less than this share
    #[arg(long, value_name = "T", default_value = "1e-5", value_parser = parse_tolerance)]
    tolerance: f64,
    /// Stop after this long, for example 90s or 5min
    #[arg(long, value_name = "TIME", value_parser = parse_duration)]
    time_limit: Option<Duration>,
    /// Write OUT this often on the way
    #[arg(long, value_name = "TIME", default_value = "60s", value_parser = parse_duration)]
    checkpoint_every: Duration,
    /// Threads of the CPU; one for each core if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// What kept form factors may take; those that do not fit are drawn again in each iteration
    #[arg(long, value_name = "SIZE", default_value = "4GiB", value_parser = parse_size)]
    memory: u64,
    /// Write what happened to this file, as JSON
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
    /// Write all form factors to this file: from,to,form_factor
    #[arg(long, value_name = "FILE.csv")]
    form_factors: Option<PathBuf>,
}

const EXAMPLES: &str = "\
Examples:
  compute scene.rad solved.rad                   solve at 128 pixels to a residual of 1e-5
  compute scene.rad solved.rad 256 --points 4    finer: four hemicubes of 256 pixels a patch
  compute solved.rad solved.rad --tolerance 1e-7 go on with a result
  compute scene.rad out.rad 100 --iterations 7   as the thesis measured

Ctrl-C writes OUT and stops; the same command with OUT as IN goes on with the same bits.
Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted (OUT is written).";

/// Settings from the process's arguments; ends the process with usage and code 2 where they are
/// wrong.
pub fn parse() -> Settings {
    let arguments = Arguments::parse();
    Settings {
        input: arguments.input,
        output: arguments.output,
        form_factors: FormFactorSettings {
            resolution: arguments.resolution,
            maps: arguments.maps,
            points: arguments.points,
        },
        backend: arguments.backend,
        solver: arguments.solver,
        max_iterations: arguments.iterations,
        tolerance: arguments.tolerance,
        time_limit: arguments.time_limit,
        checkpoint_every: arguments.checkpoint_every,
        threads: arguments.threads.map(usize::from),
        memory_bytes: arguments.memory,
        report: arguments.report,
        form_factors_csv: arguments.form_factors,
    }
}

/// A parser of `auto`, `cpu` and `gpu`.
pub fn backend_parser() -> impl TypedValueParser<Value = BackendChoice> {
    choice(&[
        ("auto", BackendChoice::Auto),
        ("cpu", BackendChoice::Cpu),
        ("gpu", BackendChoice::Gpu),
    ])
}

/// A parser of one of a few words, which help and errors list.
fn choice<T: Copy + Send + Sync + 'static>(
    choices: &'static [(&'static str, T)],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(choices.iter().map(|(name, _)| *name)).try_map(|name| {
        let found = choices
            .iter()
            .find(|(n, _)| *n == name)
            .map(|(_, value)| *value);
        found.ok_or("unknown value")
    })
}

/// Reads a hemicube's resolution and checks it.
pub fn parse_resolution(text: &str) -> Result<u32, String> {
    match text.parse::<u32>() {
        Ok(value) if value.is_multiple_of(2) && (2..=MAX_RESOLUTION).contains(&value) => Ok(value),
        Ok(value) => Err(format!(
            "resolution {value} must be an even number from 2 to {MAX_RESOLUTION}"
        )),
        Err(_) => Err(format!("\"{text}\" is not a whole number")),
    }
}

fn parse_points(text: &str) -> Result<Points, String> {
    let most = 1_u32 << Points::MAX_BISECTIONS;
    match text {
        "centroid" => Ok(Points::CENTROID),
        "vertices" => Ok(Points::Vertices),
        _ => match text.parse::<u32>() {
            Ok(n) if n.is_power_of_two() && n <= most => Ok(Points::Bisected {
                bisections: n.trailing_zeros(),
            }),
            _ => Err(format!(
                "\"{text}\" is none of centroid, vertices, or a power of two from 1 to {most}"
            )),
        },
    }
}

fn parse_tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err(format!("\"{text}\" is not a finite number >= 0")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_consistent() {
        use clap::CommandFactory;
        Arguments::command().debug_assert();
    }

    #[test]
    fn points_read_back_as_they_show() {
        for text in ["centroid", "vertices", "2", "64", "1024"] {
            assert_eq!(parse_points(text).unwrap().to_string(), text);
        }
        assert_eq!(parse_points("1"), Ok(Points::CENTROID));
        for bad in ["0", "3", "2048", "-1", "middle", ""] {
            assert!(parse_points(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn resolutions_are_even_and_bounded() {
        for good in ["2", "128", "4096"] {
            assert!(parse_resolution(good).is_ok());
        }
        for bad in ["0", "1", "127", "4098", "-2", "1e2", ""] {
            assert!(parse_resolution(bad).is_err(), "{bad}");
        }
    }
}
