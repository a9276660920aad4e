//! The command line of `compute`, turned into a [`Task`].

mod form_factors;
mod gather;
mod study;
mod target_error;
mod verify;

use std::path::PathBuf;
use std::time::Duration;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Args, CommandFactory, Parser, Subcommand};
use scene::file::is_same_file;
use scene::layers::LayerKind;
use visibility::hemicube::MAX_RESOLUTION;

use self::form_factors::FormFactorArguments;
use self::target_error::TargetError;
use super::{Settings, Task};
use crate::quantity::{parse_duration, parse_size};
use crate::row_file::path_beside;
use crate::settings::{
    BackendChoice, Drawing, Quality, SolutionSettings, SolveSettings, SolverChoice, SourceArea,
    Wanted,
};
use crate::view_factors::Asked;

/// Solves a scene by hemicube radiosity.
///
/// Every patch looks through a hemicube at the surfaces around it, which gives its form factors; then
/// all patches gather each other's radiosity, again and again, until nothing changes. The result can
/// be the input of another run, which goes on where this one stopped.
#[derive(Debug, Parser)]
#[command(version, arg_required_else_help = true, after_help = EXAMPLES)]
#[command(allow_negative_numbers = true)]
#[command(args_conflicts_with_subcommands = true, subcommand_negates_reqs = true)]
#[command(disable_help_subcommand = true)]
struct CommandLine {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    solve: Option<Arguments>,
}

#[derive(Debug, Subcommand)]
enum Command {
    Gather(gather::GatherArguments),
    Study(study::StudyArguments),
    Verify(verify::VerifyArguments),
}

/// To solve a scene.
// Clap leaves the group of a struct with another one in it empty, and then takes it to be absent.
#[derive(Debug, Args)]
#[group(args = ["input", "output"])]
struct Arguments {
    /// Scene file from genx, or a result to go on with
    #[arg(value_name = "IN")]
    input: PathBuf,
    /// Where the result goes; may be IN
    #[arg(value_name = "OUT")]
    output: PathBuf,
    #[command(flatten)]
    form_factor_settings: FormFactorArguments,
    /// Who draws: auto keeps what a continued file was solved by, else takes a real GPU that draws the same rows as the
    /// CPU and is faster, else the CPU; gpu takes software GPUs too
    #[arg(long, default_value = "auto", value_parser = backend_parser())]
    backend: BackendChoice,
    /// How to solve; an iteration of shooting is one shot, by the reciprocal form factors, so that its answer differs from
    /// the others' by about as much as the form factors miss reciprocity
    #[arg(long, default_value = "jacobi", value_parser = choice(&[
        ("jacobi", SolverChoice::Jacobi), ("gauss-seidel", SolverChoice::GaussSeidel),
        ("shooting", SolverChoice::Shooting)]))]
    solver: SolverChoice,
    /// Join patches to sources of at most A m^2, solve among these, then let vertices or each patch gather from them: patches
    /// (one level), auto (where vertices gather as coarse as the error allows that is asked for; by patches in scenes of more
    /// than 65536 as an estimated error of 0.5 percent allows), or A
    #[arg(long, default_value = "auto", value_name = "A")]
    source_area: SourceArea,
    /// How wrong the light may be: 2% of the power, 4%visible of what is visible, or both, as in 2%,4%visible; power alone
    /// goes on for 2.5 times as much of what is visible while that helps, so that pictures from anywhere hold it. It is gathered
    /// at the vertices of a mesh that grows where light varies, whatever the patches, until its estimated error is no larger;
    /// with --quality mesh it is that of patches' means, which are taken at more points where they vary; where nothing emits,
    /// and with --iterations 0, it is that of the view factors between objects, drawn with more pixels or at more points
    #[arg(long, value_name = "ERROR")]
    target_error: Option<TargetError>,
    /// How good the result is to be [default: standard; mesh where nothing emits, and with --form-factors, --view-factors or
    /// --iterations 0]
    #[arg(long, value_enum)]
    quality: Option<Quality>,
    /// Take the light apart, for display to mix: into that of each lamp (an object that emits, or a material where one object has
    /// all), or into that of the first bounce, the second, the third to fifth, and the rest
    #[arg(long, value_name = "WHAT", value_parser = choice(&[
        ("lamps", LayerKind::Lamps), ("bounces", LayerKind::Bounces)]))]
    layers: Option<LayerKind>,
    /// Stop after N iterations, those that IN has had included; where vertices gather, that is the last one
    #[arg(long, value_name = "N")]
    iterations: Option<u64>,
    /// Stop when an iteration changes the radiosities by less than this share [default: 1e-5]
    #[arg(long, value_name = "T", value_parser = parse_tolerance)]
    tolerance: Option<f64>,
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
    /// What the rows of form factors may take in OUT.rows, from which a run that goes on reads them instead of drawing
    /// them again: written once a run lasts longer than --checkpoint-every, over those of another run; looked for beside IN
    /// and OUT; 0B: none
    #[arg(long, value_name = "SIZE", default_value = "8GiB", value_parser = parse_size)]
    rows_file_limit: u64,
    /// Leave OUT.rows where it is when the run ends by its tolerance
    #[arg(long)]
    keep_rows: bool,
    /// Write what happened to this file, as JSON
    #[arg(long, value_name = "FILE.json")]
    report: Option<PathBuf>,
    /// Write all form factors to this file: from,to,form_factor
    #[arg(long, value_name = "FILE.csv")]
    form_factors: Option<PathBuf>,
    /// Write the view factors between objects to this file:
    /// from,to,view_factor,area_from,area_to,row_sum_from,reciprocity_error,error (relative, estimated)
    #[arg(long, value_name = "FILE.csv")]
    view_factors: Option<PathBuf>,
    /// Tell what the run would take (rows, time, memory, disk) from a few rows, and write nothing
    #[arg(long)]
    dry_run: bool,
    /// Exit with code 1 where the certificate is beyond its tolerances (below); OUT is written all the same
    #[arg(long)]
    strict: bool,
}

const EXAMPLES: &str = "\
Examples:
  compute scene.rad solved.rad                   the light everywhere, to 2 % of its power and 5 % of what is visible
  compute scene.rad solved.rad --quality high    to 1 % and 3 %
  compute scene.rad solved.rad --quality mesh 256 --points 4
                                                 one value a patch, by four hemicubes of 256 pixels
  compute solved.rad solved.rad --tolerance 1e-7 go on with a result
  compute scene.rad out.rad --quality thesis     as the thesis measured
  compute gather solved.rad --sensors points.csv --out values.csv
                                                 irradiance at points of one's own
  compute study scene.rad --out study            what each setting costs on a scene, and how wrong it is
  compute verify                                 how far off this program is where answers are known

--strict fails beyond these, which the summary's line \"certificate\" and the report show in any run:
  openings           1e-6 of what patches see, in a scene that looks closed (less than 2 percent open);
                     what was taken out with genx --opening does not count
  back faces         0.1 percent of what patches see; patches that no other sees do not count
  power balance      1 percent of the emitted power, neither absorbed nor lost; falls with the residual
  reciprocity        5 percent rms between A_j sum F_ji and sum A_i F_ij; falls with --points, smaller patches
  closure            1e-6: a patch's form factors, openings and back faces sum to 1
Where vertices gather, their estimated error stands for balance and reciprocity: it is to be as small as asked for.
It draws the rows of form factors that the run has not needed; those that a limit left out fail it too.

Ctrl-C writes OUT and stops; the same command with OUT as IN goes on with the same bits. What it has drawn is in
OUT.rows, which goes when the run ends by its tolerance; it may be removed at any time.
Exit codes: 0 done, 1 failed, 2 wrong usage, 130 interrupted (OUT is written).";

/// The task from the process's arguments; ends the process with usage and code 2 where they are
/// wrong.
pub fn parse() -> Task {
    let usage_error = |kind, message: String| -> ! {
        CommandLine::command().error(kind, message).exit();
    };
    match CommandLine::parse() {
        CommandLine {
            command: Some(Command::Verify(arguments)),
            ..
        } => match arguments.settings() {
            Ok(settings) => Task::Verify(settings),
            Err(error) => usage_error(ErrorKind::ValueValidation, error.to_string()),
        },
        CommandLine {
            command: Some(Command::Study(arguments)),
            ..
        } => Task::Study(arguments.settings()),
        CommandLine {
            command: Some(Command::Gather(arguments)),
            ..
        } => match arguments.settings() {
            Ok(settings) => Task::Gather(settings),
            Err(message) => usage_error(ErrorKind::ValueValidation, message),
        },
        CommandLine {
            solve: Some(arguments),
            ..
        } => match arguments.check_files() {
            Ok(()) => match settings(arguments) {
                Ok(settings) => Task::Solve(Box::new(settings)),
                Err(error) => error.exit(),
            },
            Err(message) => usage_error(ErrorKind::ValueValidation, message),
        },
        CommandLine { .. } => usage_error(
            ErrorKind::MissingRequiredArgument,
            "IN and OUT are missing".into(),
        ),
    }
}

/// What is asked of a run; options that do not go together are an error.
fn settings(arguments: Arguments) -> Result<Settings, clap::Error> {
    let asks_for_form_factors = arguments.form_factors.is_some()
        || arguments.view_factors.is_some()
        || arguments.iterations == Some(0);
    let quality = match (arguments.quality, &arguments.target_error) {
        (Some(quality), _) => quality,
        (None, None) if asks_for_form_factors => Quality::Mesh,
        (None, _) => Quality::default(),
    };
    let asked_of_view_factors = arguments.asked_of_view_factors();
    let wanted = match (arguments.quality, arguments.target_error) {
        (_, None) => quality.settings(),
        (None, Some(error)) => Quality::settings_for(error.target()),
        (Some(Quality::Mesh), Some(error)) => Quality::settings_for_means(error.target()),
        (Some(_), Some(_)) => {
            let message =
                "of --quality and --target-error one says it all, unless it is --quality mesh";
            let error = CommandLine::command().error(ErrorKind::ArgumentConflict, message);
            return Err(error);
        }
    };
    let solve = arguments.solve_settings(wanted);
    Ok(Settings {
        solve,
        solve_without_light: match quality {
            Quality::Thesis => solve,
            _ => arguments.solve_settings(Quality::Mesh.settings()),
        },
        asked_of_view_factors,
        threads: arguments.threads.map(usize::from),
        rows_file_limit: arguments.rows_file_limit,
        keep_rows: arguments.keep_rows,
        strict: arguments.strict,
        is_dry_run: arguments.dry_run,
        input: arguments.input,
        output: arguments.output,
        report: arguments.report,
        form_factors_csv: arguments.form_factors,
        view_factors_csv: arguments.view_factors,
    })
}

/// What a run does that has these options after IN and OUT.
///
/// # Errors
/// Options that the program refuses.
pub fn solve_settings(options: &str) -> Result<SolveSettings, clap::Error> {
    let words = ["compute", "IN", "OUT"].into_iter();
    let line = CommandLine::try_parse_from(words.chain(options.split_whitespace()))?;
    match line.solve {
        Some(arguments) => Ok(settings(arguments)?.solve),
        None => Err(CommandLine::command().error(
            ErrorKind::MissingRequiredArgument,
            "these are no options of a run",
        )),
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

impl Arguments {
    /// What is asked for, and what is not as in these.
    fn solve_settings(&self, defaults: SolveSettings) -> SolveSettings {
        let mut target = defaults.target;
        if let Some(target) = &mut target
            && target.of == Wanted::Means
            && self.form_factor_settings.has_points()
        {
            target.of = Wanted::MeansAtPoints;
        }
        SolveSettings {
            solution: SolutionSettings {
                form_factors: self
                    .form_factor_settings
                    .settings(defaults.solution.form_factors),
                source_area: self.source_area,
                solver: self.solver,
            },
            drawing: Drawing {
                backend: self.backend,
                is_gpu_tried: true,
                memory_bytes: self.memory,
            },
            max_iterations: self.iterations.or(defaults.max_iterations),
            tolerance: self.tolerance.unwrap_or(defaults.tolerance),
            time_limit: self.time_limit,
            checkpoint_every: self.checkpoint_every,
            all_rows: self.strict,
            target,
            layers: self.layers,
        }
    }

    /// What is asked of view factors where nothing else is solved.
    fn asked_of_view_factors(&self) -> Option<Asked> {
        let error = self.target_error?.target().strictest();
        Some(Asked {
            error,
            first: self
                .form_factor_settings
                .settings(Quality::default().form_factors()),
            is_resolution_given: self.form_factor_settings.has_resolution(),
            are_points_given: self.form_factor_settings.has_points(),
        })
    }

    /// Only OUT may be another file too, namely IN.
    fn check_files(&self) -> Result<(), String> {
        let rows = path_beside(&self.output);
        let files = [
            ("IN", Some(&self.input)),
            ("OUT", Some(&self.output)),
            ("OUT's rows", rows.as_ref()),
            ("--report", self.report.as_ref()),
            ("--form-factors", self.form_factors.as_ref()),
            ("--view-factors", self.view_factors.as_ref()),
        ];
        check_different(&files, 3)
    }
}

/// Checks that the files from that number on, where they are asked for, are none of those before them.
fn check_different(files: &[(&str, Option<&PathBuf>)], from: usize) -> Result<(), String> {
    for (k, (name, path)) in files.iter().enumerate().skip(from) {
        for (other_name, other) in &files[..k] {
            if let (Some(path), Some(other)) = (path, other)
                && is_same_file(path, other)
            {
                return Err(format!(
                    "{other_name} and {name} are both {}; choose another name for one of them",
                    path.display()
                ));
            }
        }
    }
    Ok(())
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
        CommandLine::command().debug_assert();
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
