//! The thesis's table, run again.

use std::fmt::Write;
use std::path::PathBuf;

use compute::quantity::{show_duration, show_size};
use compute::settings::MOST_ON_ONE_LEVEL;
use genx::Model;

use crate::arguments::{Plan, Section, command_of};
use crate::program::{Program, Report, STAGES, cells_of_stages};
use crate::scenes;
use crate::text::{count, figures, heading, percent, table};

/// What the thesis measured of its model 2.
struct Measured {
    /// Largest area of a patch, m^2.
    max_area: f64,
    patches: u64,
    /// At each of [`PIXELS`].
    seconds: [f64; 3],
}

/// Pixels along a face of its hemicubes.
const PIXELS: [u32; 3] = [100, 200, 500];

/// Its table: minutes and seconds, in seconds.
const TABLE: [Measured; 3] = [
    Measured {
        max_area: 5.0,
        patches: 26_360,
        seconds: [280.0, 525.0, 2_380.0],
    },
    Measured {
        max_area: 1.0,
        patches: 136_512,
        seconds: [3_500.0, 4_900.0, 13_980.0],
    },
    Measured {
        max_area: 0.25,
        patches: 546_048,
        seconds: [34_980.0, 42_000.0, 90_960.0],
    },
];

/// Stands in for the table in a quick document: the areas and the pixels.
const QUICK: ([f64; 2], [u32; 2]) = ([60.0, 30.0], [32, 64]);

/// A way to run it.
struct Variant {
    title: &'static str,
    options: &'static [&'static str],
    /// Hemicubes a patch, about; for the order of the runs only.
    hemicubes: f64,
    /// Where the number is given.
    iterations: Option<u64>,
}

const VARIANTS: [Variant; 2] = [
    Variant {
        title: "Default settings",
        options: &[],
        hemicubes: 3.0,
        iterations: None,
    },
    Variant {
        title: "As the thesis measured: `--points centroid --iterations 7`",
        options: &["--points", "centroid", "--iterations", "7"],
        hemicubes: 1.0,
        iterations: Some(7),
    },
];

/// A scene of the table.
struct Size {
    path: PathBuf,
    patches: u64,
    /// By the thesis, and at which pixels.
    thesis: Option<&'static Measured>,
}

/// What became of a run.
enum State {
    Run(Report),
    Failed(String),
    NotRun,
}

/// A cell of the thesis's table, run in one way.
struct Cell<'a> {
    variant: &'a Variant,
    size: &'a Size,
    pixels: u32,
    state: State,
}

impl Cell<'_> {
    /// What its time grows with: pixels of all hemicubes, drawn once.
    fn work(&self) -> f64 {
        self.variant.hemicubes * self.size.patches as f64 * f64::from(self.pixels).powi(2)
    }

    fn thesis_seconds(&self) -> Option<f64> {
        let column = PIXELS.iter().position(|&pixels| pixels == self.pixels)?;
        self.size.thesis.map(|measured| measured.seconds[column])
    }

    fn row(&self) -> Vec<String> {
        let thesis = self.thesis_seconds();
        let mut row = vec![count(self.size.patches), self.pixels.to_string()];
        let nothing = String::new;
        match &self.state {
            State::Run(report) => {
                row.extend(cells_of_stages(&report.seconds));
                row.push(count(report.hemicubes_drawn));
                row.push(count(report.hemicubes_per_second().round() as u64));
                row.push(report.peak_memory_bytes.map_or_else(nothing, show_size));
                row.push(thesis.map_or_else(nothing, figures));
                let ratio = thesis.filter(|_| !report.is_unfinished());
                row.push(ratio.map_or_else(nothing, |s| figures(s / report.seconds.total)));
                row.push(self.end(report));
            }
            State::Failed(_) | State::NotRun => {
                row.extend(std::iter::repeat_with(nothing).take(8));
                row.push(thesis.map_or_else(nothing, figures));
                row.push(nothing());
                row.push(match &self.state {
                    State::Failed(message) => {
                        format!("failed: {}", message.replace(['\n', '|'], " "))
                    }
                    _ => "not run".to_owned(),
                });
            }
        }
        row
    }

    /// How far it got.
    fn end(&self, report: &Report) -> String {
        if !report.is_unfinished() {
            return format!("{} iterations", report.iterations);
        }
        let done = report.iterations_done();
        match (self.variant.iterations, report.residuals.last()) {
            (Some(all), _) => {
                let share = percent(done / all as f64);
                format!("not finished: {share}, {done:.2} of {all} iterations")
            }
            (None, Some(residual)) => {
                format!("not finished: {done:.1} iterations, residual {residual:.0e}")
            }
            (None, None) => format!("not finished: {} of iteration 1", percent(done)),
        }
    }
}

/// The section.
pub fn section(plan: &Plan, program: &Program) -> anyhow::Result<String> {
    let sizes = sizes(plan, program)?;
    let pixels: &[u32] = plan.choose(&QUICK.1, &PIXELS);
    let mut cells: Vec<Cell> = Vec::new();
    for variant in &VARIANTS {
        for size in &sizes {
            cells.extend(pixels.iter().map(|&pixels| Cell {
                variant,
                size,
                pixels,
                state: State::NotRun,
            }));
        }
    }
    run_cheapest_first(plan, program, &mut cells);

    let mut text = format!(
        "{}The thesis's own measurements, of its model 2 after 7 iterations on an Athlon X2 4600+ with a GeForce \
         7600GT, and the same here: `genx hall.rad 2 AREA` at the areas that give about its numbers of patches, \
         each run a process of its own ({}). The ratio is the thesis's time over this one's, the machines' \
         difference included; drawing is the hemicubes, \
         the views of lamps and their merging. A run has {} at most; rows that do not fit the default `--memory` \
         are drawn again in each iteration. Scenes of more than {} patches are solved among coarser \
         sources, from which each patch gathers once (`compute/src/two_levels.rs`).\n",
        heading("The thesis's table"),
        command_of(Section::Thesis),
        show_duration(plan.time_limit),
        count(MOST_ON_ONE_LEVEL.into()),
    );
    let mut header = vec!["patches", "pixels"];
    header.extend(STAGES);
    header.extend([
        "hemicubes",
        "a second of drawing",
        "peak memory",
        "thesis, s",
        "ratio",
        "run",
    ]);
    for variant in &VARIANTS {
        let rows: Vec<Vec<String>> = cells
            .iter()
            .filter(|cell| std::ptr::eq(cell.variant, variant))
            .map(Cell::row)
            .collect();
        write!(text, "\n### {}\n\n", variant.title).ok();
        text.push_str(&table(&header, 0, &rows));
    }
    let thesis: Vec<String> = TABLE.iter().map(|row| count(row.patches)).collect();
    writeln!(
        text,
        "\nThe thesis had {} patches. The ratio in the first table compares more work with less: more hemicubes a \
         patch, and iterations until the residual is 1e-5.",
        thesis.join(", ")
    )
    .ok();
    Ok(text)
}

fn sizes(plan: &Plan, program: &Program) -> anyhow::Result<Vec<Size>> {
    let table = TABLE.iter().map(|row| (row.max_area, Some(row)));
    let quick = QUICK.0.iter().map(|&area| (area, None));
    let areas: Vec<_> = plan.choose(quick.collect(), table.collect());
    areas
        .into_iter()
        .map(|(area, thesis)| {
            let scene = scenes::model(Model::Hall, area)?;
            Ok(Size {
                path: program.keep(&format!("hall-{area}"), &scene)?,
                patches: scene.patch_count().into(),
                thesis,
            })
        })
        .collect()
}

/// Runs what fits the budget, told by the last run of the same kind.
fn run_cheapest_first(plan: &Plan, program: &Program, cells: &mut [Cell]) {
    let mut order: Vec<usize> = (0..cells.len()).collect();
    order.sort_by(|&a, &b| cells[a].work().total_cmp(&cells[b].work()));
    for k in order {
        let cell = &cells[k];
        let estimate = cells
            .iter()
            .filter(|other| std::ptr::eq(other.variant, cell.variant))
            .filter_map(|other| match &other.state {
                State::Run(report) => Some((other.work(), report.seconds.total)),
                _ => None,
            })
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(0.0, |(work, seconds)| seconds * cell.work() / work);
        if !plan.affords(estimate.min(plan.time_limit.as_secs_f64())) {
            continue;
        }
        eprintln!(
            "performance: hall, {} patches, {} pixels {}",
            count(cell.size.patches),
            cell.pixels,
            cell.variant.options.join(" ")
        );
        cells[k].state = match program.solve(&cell.size.path, cell.pixels, cell.variant.options) {
            Ok(report) => State::Run(report),
            // One that does not fit the machine must not cost the others' hours.
            Err(error) => State::Failed(format!("{error:#}")),
        };
    }
}
