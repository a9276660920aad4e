//! `compute study`: what each setting costs on some scenes, and how wrong it is.
//!
//! Each run is one that a user could ask for: its options go through the program's own command line. Errors are measured, not
//! estimated: against a solution of the highest quality, which is made first or given, and whose own estimated error says below
//! what they mean nothing. A table is kept on the way, so that a study that was stopped goes on with what is missing.

mod grid;
mod markdown;
mod plot;
mod table;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use scene::file::{self, OutputLock, write_atomically};
use scene::{Scene, Solution};

use crate::cancel::CancelToken;
use crate::compare;
use crate::program::{cli, interrupt};
use crate::settings::{BackendChoice, SolveSettings};
use crate::solve::{Solve, StoppedBy};
use table::{Row, Table};

/// What a reference is solved with, unless it is given.
const REFERENCE: &str = "64 --quality reference";

/// What is to be studied.
#[derive(Clone, Debug, PartialEq)]
pub struct StudySettings {
    /// Scenes; those of the same surfaces have one reference.
    pub scenes: Vec<PathBuf>,
    /// Where tables, plots and references go.
    pub folder: PathBuf,
    /// A solved scene to compare with.
    pub reference: Option<PathBuf>,
    /// Only what has one of these in its name or options.
    pub only: Vec<String>,
    /// The longest run.
    pub time_limit: Duration,
    /// Who draws.
    pub backend: BackendChoice,
    /// Threads of the CPU; `None`: one for each core.
    pub threads: Option<usize>,
}

/// What others are compared with.
struct Reference {
    name: String,
    scene: Scene,
    solution: Solution,
}

/// Runs what is missing of a study, and writes its tables and plots.
///
/// # Errors
/// Files that cannot be read or written, scenes without light, and a back end that cannot go on. What was found until then is in
/// the table.
pub fn run(settings: &StudySettings, cancel: &CancelToken) -> anyhow::Result<ExitCode> {
    std::fs::create_dir_all(&settings.folder)
        .with_context(|| format!("the folder {} cannot be made", settings.folder.display()))?;
    let path = settings.folder.join("study.csv");
    let _lock = OutputLock::acquire(&path)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads.unwrap_or(0))
        .build()
        .context("the threads could not be started")?;
    let mut table = Table::read(&path)?;
    let is_whole = pool.install(|| run_all(settings, &path, &mut table, cancel))?;
    write_results(settings, &table)?;
    println!("{}", table.text());
    println!(
        "The table, plots and references are in {}.",
        settings.folder.display()
    );
    if is_whole {
        return Ok(ExitCode::SUCCESS);
    }
    eprintln!("compute: interrupted; the same command goes on with what is missing");
    Ok(ExitCode::from(interrupt::EXIT_CODE))
}

/// Runs what is missing; false where it is cancelled.
fn run_all(
    settings: &StudySettings,
    path: &Path,
    table: &mut Table,
    cancel: &CancelToken,
) -> anyhow::Result<bool> {
    let mut references: Vec<Reference> = Vec::new();
    if let Some(path) = &settings.reference {
        let (scene, solution) = file::load(path)?;
        let Some(solution) = solution else {
            bail!("{}: the reference is not solved", path.display());
        };
        references.push(Reference {
            name: name_of(path),
            scene,
            solution,
        });
    }
    for input in &settings.scenes {
        let (scene, _) = file::load(input)?;
        if scene.emitted_power().max_element() == 0.0 {
            bail!(
                "{}: nothing emits, so that there is no error of light to study",
                input.display()
            );
        }
        let name = name_of(input);
        let dark = Solution::dark(&scene);
        let is_of = |reference: &&Reference| {
            let both = ((&scene, &dark), (&reference.scene, &reference.solution));
            compare::errors(both.0, both.1).is_some()
        };
        if !references.iter().any(|reference| is_of(&reference)) {
            let Some(reference) = reference(settings, &name, &scene, cancel)? else {
                return Ok(false);
            };
            references.push(reference);
        }
        let Some(reference) = references.iter().find(is_of) else {
            continue;
        };
        for variant in grid::variants() {
            let is_asked = |only: &String| {
                variant.knob.contains(only.as_str()) || variant.options.contains(only.as_str())
            };
            let is_wanted = settings.only.is_empty() || settings.only.iter().any(is_asked);
            if !is_wanted || table.has(&name, variant) {
                continue;
            }
            eprintln!("compute: {name}: {}", variant.options);
            let Some((solution, mut row)) = solved(settings, &scene, variant.options, cancel)?
            else {
                return Ok(false);
            };
            let shown = (&scene, &solution);
            let errors = compare::errors(shown, (&reference.scene, &reference.solution));
            row.scene.clone_from(&name);
            variant.knob.clone_into(&mut row.knob);
            row.reference.clone_from(&reference.name);
            row.power = errors.map(|errors| errors.power);
            row.visible = errors.map(|errors| errors.visible);
            table.push(row);
            table.write(path)?;
        }
    }
    Ok(true)
}

/// The reference of a scene: what an earlier run of the study has made, or a new one; `None` where it is cancelled.
fn reference(
    settings: &StudySettings,
    name: &str,
    scene: &Scene,
    cancel: &CancelToken,
) -> anyhow::Result<Option<Reference>> {
    let path = settings.folder.join(format!("{name}.reference.rad"));
    if path.exists() {
        let (scene, solution) = file::load(&path)?;
        if let Some(solution) = solution {
            return Ok(Some(Reference {
                name: name.to_owned(),
                scene,
                solution,
            }));
        }
    }
    eprintln!("compute: {name}: the reference, {REFERENCE}");
    let Some((solution, row)) = solved(settings, scene, REFERENCE, cancel)? else {
        return Ok(None);
    };
    if let (Some(power), Some(visible)) = (row.stated_power, row.stated_visible) {
        eprintln!(
            "compute: {name}: its own error is estimated as {:.2} % power, {:.2} % visible",
            100.0 * power,
            100.0 * visible
        );
    }
    file::save(&path, scene, Some(&solution))?;
    Ok(Some(Reference {
        name: name.to_owned(),
        scene: scene.clone(),
        solution,
    }))
}

/// A run with these options; `None` where it is cancelled.
fn solved(
    settings: &StudySettings,
    scene: &Scene,
    options: &str,
    cancel: &CancelToken,
) -> anyhow::Result<Option<(Solution, Row)>> {
    let mut solve: SolveSettings = cli::solve_settings(options)?;
    solve.drawing.backend = settings.backend;
    solve.time_limit = Some(settings.time_limit);
    let start = Instant::now();
    let solved = Solve::new(scene).settings(solve).cancel(cancel).run()?;
    let seconds = start.elapsed().as_secs_f64();
    if solved.stopped_by == StoppedBy::Interrupt {
        return Ok(None);
    }
    let stated = solved.function.and_then(|function| function.error);
    let row = Row {
        options: options.to_owned(),
        patches: scene.patch_count(),
        seconds,
        drawing_seconds: solved.seconds.draw,
        hemicubes: solved.rows.hemicubes,
        sources: solved.sources.map(|sources| sources.count),
        vertices: solved.function.map(|function| function.vertices),
        stated_power: stated.map(|error| error.total.power),
        stated_visible: stated.map(|error| error.total.visible),
        is_late: solved.stopped_by == StoppedBy::TimeLimit,
        ..Row::default()
    };
    Ok(Some((solved.into_solution(), row)))
}

/// Writes all that is made of the table.
fn write_results(settings: &StudySettings, table: &Table) -> anyhow::Result<()> {
    let at = |name: &str| settings.folder.join(name);
    let json = serde_json::to_vec_pretty(&table.rows_with_front())?;
    write_atomically(&at("study.json"), |out| out.write_all(&json))?;
    let document = markdown::document(table);
    write_atomically(&at("study.md"), |out| out.write_all(document.as_bytes()))?;
    let pictures = at("pictures");
    std::fs::create_dir_all(&pictures)
        .with_context(|| format!("the folder {} cannot be made", pictures.display()))?;
    for scene in table.scenes() {
        for (kind, svg) in plot::of_scene(table, &scene) {
            let path = pictures.join(format!("{scene}-{kind}.svg"));
            write_atomically(&path, |out| out.write_all(svg.as_bytes()))?;
        }
    }
    Ok(())
}

/// A file's name without what comes after its last dot.
fn name_of(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}
