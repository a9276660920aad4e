//! A study as a document.

use std::fmt::Write as _;

use super::table::{Row, Table};

const HEAD: &str = "\
# Speed and accuracy

What settings cost, and how wrong they are: power and visible error of the light as a picture shows it, over all surfaces that light
reaches, against a solution of the highest quality (`64 --quality reference`). Written by

```
genx cornell.rad cornell
genx room.rad compute/src/verify/data/room.obj
genx hall.rad 2
genx hall-coarse.rad 2 --max-area 20
compute study cornell.rad room.rad hall.rad hall-coarse.rad --out study --time-limit 2min --backend cpu
cp study/study.md docs/TRADEOFFS.md
cp study/pictures/*-power.svg docs/pictures/
```

which also writes the table as CSV and JSON and plots as SVG. Seconds are those of the wall, without files; **bold** errors are those that no
faster run of the scene is below. What is stated is the run's own estimate.

## What to take
- **A student** who wants to see: nothing at all. `--quality standard`, the default, takes about a second for these scenes;
  `--iterations 1`, `2` show its bounces, and `--quality mesh --points centroid` the patches of the textbooks.
- **A baker of light**: `--quality high`. The patches are no matter, so leave the model's mesh as it is; look at
  `display --quantity error` for what is left.
- **An engineer**: `--target-error` with what the report has to keep, and the last line of the run in it; for form factors
  `--view-factors FILE.csv --iterations 0 --target-error 0.1%`, whose last line is about them.
";

/// What the thesis left open, and the runs that tell.
const QUESTIONS: [(&str, &[&str]); 7] = [
    (
        "Does antialiasing do what a doubled viewport does? Four hemicubes a patch, turned each by its own angle, against one of twice \
         the pixels, and against what it began with.",
        &[
            "64 --quality mesh --points 4",
            "--quality mesh --points centroid",
            "50 --quality mesh --points centroid",
        ],
    ),
    (
        "What do more pixels bring (its figure 4.6)? From 26 to 800 along a face; the error is the mesh's.",
        &[
            "26 --quality mesh --points centroid",
            "100 --quality mesh --points centroid",
            "400 --quality mesh --points centroid",
            "800 --quality mesh --points centroid",
        ],
    ),
    (
        "Does a finer model with a coarser raster pay? Compare the hall with the same of a quarter of the patches.",
        &[
            "26 --quality mesh --points centroid",
            "400 --quality mesh --points centroid",
        ],
    ),
    (
        "Hemicubes at centroids or at vertices?",
        &[
            "--quality mesh --points centroid",
            "--quality mesh --points vertices",
        ],
    ),
    (
        "Jacobi or Gauss-Seidel?",
        &[
            "--quality mesh --points centroid --solver jacobi",
            "--quality mesh --points centroid --solver gauss-seidel",
        ],
    ),
    (
        "What does it cost that its multipliers forget that a pixel's solid angle falls with 1/r^3? Exact ones, then its own.",
        &[
            "--quality mesh --points centroid --seed aligned --lamps off",
            "--quality mesh --points centroid --seed aligned --lamps off --maps thesis",
        ],
    ),
    (
        "What would an adaptive mesh bring? Vertices where light varies, against one value a patch.",
        &["--quality standard", "--quality mesh"],
    ),
];

/// Answers to these, scene by scene.
fn answers(table: &Table) -> String {
    let mut text = "\n## What the thesis left open\n".to_owned();
    for (question, options) in QUESTIONS {
        write!(text, "\n{question}\n\n| |").ok();
        for options in options {
            write!(text, " `{options}` |").ok();
        }
        write!(text, "\n|---|{}\n", "--:|".repeat(options.len())).ok();
        for scene in table.scenes() {
            write!(text, "| {scene} |").ok();
            for &options in options {
                let row = table.of_scene(&scene).find(|row| row.options == options);
                let told = row.and_then(|row| {
                    let [power, visible] = [row.power?, row.visible?].map(percent);
                    Some(format!("{power}, {visible}, {:.2} s", row.seconds))
                });
                write!(text, " {} |", told.unwrap_or_default()).ok();
            }
            text.push('\n');
        }
    }
    text
}

/// All scenes of a study.
pub(super) fn document(table: &Table) -> String {
    let mut text = HEAD.to_owned();
    text += &answers(table);
    for scene in table.scenes() {
        let first = table.of_scene(&scene).next();
        let patches = first.map_or(0, |row| row.patches);
        write!(text, "\n## {scene}, {patches} patches\n").ok();
        let picture = format!("pictures/{scene}-power.svg").replace(' ', "%20");
        write!(text, "\n![power error against seconds]({picture})\n").ok();
        let mut knob = "";
        for row in table.of_scene(&scene) {
            if row.knob != knob {
                knob = &row.knob;
                write!(
                    text,
                    "\n| {knob} | seconds | power error | visible error | stated | vertices |\n|---|--:|--:|--:|--:|--:|\n"
                )
                .ok();
            }
            let error = |error: fn(&Row) -> Option<f64>| {
                let shown = error(row).map_or_else(String::new, percent);
                if table.is_on_front(row, error) {
                    format!("**{shown}**")
                } else {
                    shown
                }
            };
            let stated = row.stated_power.zip(row.stated_visible);
            let stated = stated.map_or_else(String::new, |(power, visible)| {
                format!("{}, {}", percent(power), percent(visible))
            });
            let vertices = row.vertices.map_or_else(String::new, |v| v.to_string());
            writeln!(
                text,
                "| `{}`{} | {:.2} | {} | {} | {stated} | {vertices} |",
                row.options,
                if row.is_late { ", stopped" } else { "" },
                row.seconds,
                error(|row| row.power),
                error(|row| row.visible),
            )
            .ok();
        }
    }
    text
}

fn percent(error: f64) -> String {
    format!("{:.2} %", 100.0 * error)
}
