//! The scenes of the reference data, solved at default accuracy.

use std::path::Path;

use crate::arguments::{Plan, Section, command_of};
use crate::measure::by_median;
use crate::program::{Program, Report, STAGES, cells_of_stages};
use crate::scenes;
use crate::text::{count, figures, heading, table};

/// Where the scenes are.
const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/src/verify/data");

/// File, name, and the seconds that a solution should take on two cores.
const SCENES: [(&str, &str, f64); 2] = [
    ("cornell.obj", "Cornell box", 0.7),
    ("room.obj", "room with columns", 1.5),
];

/// Pixels, the program's default.
const PIXELS: u32 = 128;

/// The section.
pub fn section(plan: &Plan, program: &Program) -> anyhow::Result<String> {
    let runs = plan.choose(1, 5);
    let mut rows = Vec::new();
    for (file, name, target) in SCENES {
        let path = Path::new(FOLDER).join(file);
        eprintln!("performance: {name}");
        let scene = scenes::obj(&path)?;
        let patches = scene.patch_count();
        let path = program.keep(name, &scene)?;
        let reports = (0..runs)
            .map(|_| program.solve(&path, PIXELS, &[]))
            .collect::<anyhow::Result<Vec<Report>>>()?;
        let Some(report) = by_median(reports, |report| report.seconds.total) else {
            continue;
        };
        let mut row = vec![name.to_owned(), count(patches.into())];
        row.extend(cells_of_stages(&report.seconds));
        row.push(count(report.hemicubes_drawn));
        row.push(report.iterations.to_string());
        row.push(figures(target));
        let verdict = if report.seconds.total <= target && !report.is_unfinished() {
            "held"
        } else {
            "**missed**"
        };
        row.push(verdict.to_owned());
        rows.push(row);
    }
    if rows.is_empty() {
        return Ok(String::new());
    }
    let mut header = vec!["scene", "patches"];
    header.extend(STAGES);
    header.extend(["hemicubes", "iterations", "target, s", "verdict"]);
    Ok(format!(
        "{}The two scenes that the tests compare with a path tracer (`compute/src/verify/data`), from `compute IN OUT` \
         at its defaults to a written result; every triangle is a patch. Each is the run with the median of {runs} \
         totals ({}). The targets are for two cores.\n\n{}",
        heading("Reference scenes"),
        command_of(Section::Reference),
        table(&header, 1, &rows)
    ))
}
