//! How costs grow: over patches, pixels, surfaces and threads.

use std::fmt::Write;
use std::time::Instant;

use genx::Model;
use scene::Scene;

use crate::arguments::{Plan, Section, command_of};
use crate::machine::cores;
use crate::measure::{by_median, item_buffer, one_a_patch, row};
use crate::program::{Program, Report, STAGES, cells_of_stages};
use crate::scenes;
use crate::text::{Point, count, figures, heading, percent, plot, table};

/// Pixels where something else is varied.
const PIXELS: u32 = 100;

/// What of a hemicube was measured.
struct Measured {
    item_buffer_ms: f64,
    row_ms: f64,
    /// Seconds until the first hemicube can be drawn.
    open: f64,
}

fn measure(plan: &Plan, scene: &Scene, resolution: u32) -> anyhow::Result<Measured> {
    let start = Instant::now();
    let hemicubes = one_a_patch(scene, resolution);
    let open = start.elapsed().as_secs_f64();
    Ok(Measured {
        item_buffer_ms: 1e3 * item_buffer(plan, &hemicubes)?.median,
        row_ms: 1e3 * row(plan, &hemicubes)?.timing.median,
        open,
    })
}

impl Measured {
    fn points(&self) -> Vec<Point> {
        vec![(self.item_buffer_ms, 'i'), (self.row_ms, 'r')]
    }
}

/// The section.
pub fn section(plan: &Plan, program: &Program) -> anyhow::Result<String> {
    let mut text = heading("Scaling");
    writeln!(
        text,
        "How costs grow with one thing while the others stay ({}). In the plots i is a hemicube's item buffer and \
         r its whole row, on one core; where both fall together i is shown. Hemicubes have {PIXELS} pixels where \
         nothing else is said.",
        command_of(Section::Scaling)
    )
    .ok();
    text.push_str(&over_patches(plan)?);
    text.push_str(&over_pixels(plan)?);
    text.push_str(&over_surfaces(plan)?);
    text.push_str(&over_threads(plan, program)?);
    Ok(text)
}

/// Title, table and plot of some measurements.
fn shown(
    title: &str,
    header: &[&str],
    measured: &[(String, Measured)],
    cells: impl Fn(&Measured) -> Vec<String>,
) -> String {
    let rows: Vec<Vec<String>> = measured
        .iter()
        .map(|(label, measured)| [vec![label.clone()], cells(measured)].concat())
        .collect();
    let lines: Vec<(String, Vec<Point>)> = measured
        .iter()
        .map(|(label, measured)| (label.clone(), measured.points()))
        .collect();
    format!(
        "\n### {title}\n\n{}{}",
        table(header, 0, &rows),
        plot("ms", &lines)
    )
}

fn milliseconds(measured: &Measured) -> Vec<String> {
    vec![figures(measured.item_buffer_ms), figures(measured.row_ms)]
}

fn over_patches(plan: &Plan) -> anyhow::Result<String> {
    let cornell: &[f64] = plan.choose(&[1e-2, 1e-3], &[1e-2, 1e-3, 2.5e-4, 6e-5, 1.6e-5, 4e-6]);
    let hall: &[f64] = plan.choose(&[50.0, 20.0], &[50.0, 20.0, 5.0, 1.0, 0.25]);
    let mut text = String::new();
    for (name, model, areas) in [
        ("Cornell box", Model::Cornell, cornell),
        ("hall", Model::Hall, hall),
    ] {
        let mut measured = Vec::new();
        let mut surfaces = 0;
        for &area in areas {
            let scene = scenes::model(model.clone(), area)?;
            let patches = count(scene.patch_count().into());
            surfaces = scene.surfaces().len();
            eprintln!("performance: scaling, {name}, {patches} patches");
            measured.push((patches, measure(plan, &scene, PIXELS)?));
        }
        let title = format!("Patches: {name}, {} surfaces", count(surfaces as u64));
        let header = ["patches", "item buffer, ms", "whole row, ms"];
        text.push_str(&shown(&title, &header, &measured, milliseconds));
    }
    Ok(text)
}

fn over_pixels(plan: &Plan) -> anyhow::Result<String> {
    let resolutions: &[u32] = plan.choose(&[64, 128, 256], &[64, 128, 256, 512, 1024]);
    let mut text = String::new();
    for (name, model, area) in [
        ("Cornell box", Model::Cornell, 1e-3),
        ("hall", Model::Hall, plan.choose(50.0, 5.0)),
    ] {
        let scene = scenes::model(model, area)?;
        let mut measured = Vec::new();
        for &resolution in resolutions {
            eprintln!("performance: scaling, {name}, {resolution} pixels");
            measured.push((resolution.to_string(), measure(plan, &scene, resolution)?));
        }
        let patches = count(scene.patch_count().into());
        let title = format!("Pixels: {name}, {patches} patches");
        let header = ["pixels", "item buffer, ms", "whole row, ms"];
        text.push_str(&shown(&title, &header, &measured, milliseconds));
    }
    Ok(text)
}

/// Makes a scene of about so many triangles.
type Make = fn(u32) -> anyhow::Result<Scene>;

fn over_surfaces(plan: &Plan) -> anyhow::Result<String> {
    let largest = plan.choose(10_000, 1_000_000);
    let scenes: [(&str, Make); 2] = [
        ("a closed box full of small tetrahedra", scenes::tetrahedra),
        ("a bumpy sphere from inside", scenes::bumpy_sphere),
    ];
    let mut text = String::new();
    for (name, make) in scenes {
        let mut measured = Vec::new();
        for triangles in [1_000, 3_000, 10_000, 30_000, 100_000, 300_000, 1_000_000] {
            if triangles > largest {
                break;
            }
            let scene = make(triangles)?;
            let surfaces = count(scene.surfaces().len() as u64);
            eprintln!("performance: scaling, {name}, {surfaces} surfaces");
            measured.push((surfaces, measure(plan, &scene, PIXELS)?));
        }
        let title = format!("Surfaces: {name}, one patch a triangle");
        let header = ["surfaces", "item buffer, ms", "whole row, ms", "open, s"];
        let cells = |measured: &Measured| {
            let mut cells = milliseconds(measured);
            cells.push(figures(measured.open));
            cells
        };
        text.push_str(&shown(&title, &header, &measured, cells));
    }
    Ok(text)
}

/// 1, 2, 4 ... and all cores.
fn thread_counts() -> Vec<usize> {
    let cores = cores();
    let mut counts: Vec<usize> = (0..usize::BITS)
        .map(|k| 1 << k)
        .take_while(|&threads| threads < cores)
        .collect();
    counts.push(cores);
    counts
}

fn over_threads(plan: &Plan, program: &Program) -> anyhow::Result<String> {
    let scene = scenes::model(Model::Hall, plan.choose(50.0, 5.0))?;
    let path = program.keep("threads", &scene)?;
    let runs = plan.choose(1, 3);
    let mut reports = Vec::new();
    for threads in thread_counts() {
        eprintln!("performance: scaling, threads {threads}");
        let given = threads.to_string();
        let options = [
            "--points",
            "centroid",
            "--iterations",
            "7",
            "--threads",
            &given,
        ];
        let of_threads = (0..runs)
            .map(|_| program.solve(&path, PIXELS, &options))
            .collect::<anyhow::Result<Vec<Report>>>()?;
        if let Some(report) = by_median(of_threads, |report| report.seconds.total) {
            reports.push((threads, report));
        }
    }
    let Some(one) = reports.first().map(|(_, report)| report.seconds) else {
        return Ok(String::new());
    };
    let mut rows = Vec::new();
    let mut lines = Vec::new();
    for (threads, report) in &reports {
        let seconds = report.seconds;
        let faster = one.total / seconds.total;
        let mut row = vec![threads.to_string()];
        row.extend(cells_of_stages(&seconds));
        row.push(figures(faster));
        row.push(figures(one.draw / seconds.draw));
        row.push(figures(one.solve / seconds.solve));
        row.push(percent(faster / *threads as f64));
        rows.push(row);
        let points = vec![
            (seconds.total, 't'),
            (seconds.draw, 'd'),
            (seconds.solve, 's'),
        ];
        lines.push((threads.to_string(), points));
    }
    let mut header = vec!["threads"];
    header.extend(STAGES);
    header.extend(["times as fast", "drawing", "solving", "efficiency"]);
    Ok(format!(
        "\n### Threads: a whole run, hall, {} patches\n\n\
         `compute IN OUT {PIXELS} --points centroid --iterations 7 --threads N`, the run with the median of {runs} \
         totals. In the plot t is the total, d drawing, s solving.\n\n{}{}",
        count(scene.patch_count().into()),
        table(&header, 0, &rows),
        plot("s", &lines)
    ))
}
