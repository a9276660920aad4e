//! What `verify` measures is what a run makes: of each case, a run of the program with the options that the case prints
//! comes to the value that it prints.

mod common;

use std::collections::{BTreeMap, HashMap};
use std::path::Path;

use common::{compute, folder, save, solve, stdout};
use compute::problem::Problem;
use compute::verify::case::{Case, Measure};
use compute::verify::{bank, path_tracer};
use scene::{ObjectId, Scene, Solution};
use serde_json::Value;

/// What a case printed of itself, by its name.
type Printed = HashMap<String, Value>;

/// What `compute verify` prints, whatever its verdicts.
fn verify(options: &[&str]) -> Printed {
    let output = compute(folder().path(), &[&["verify", "--json"], options].concat());
    let cases: Vec<Value> = serde_json::from_str(&stdout(&output)).unwrap();
    let by_name = cases.into_iter().map(|case| (text(&case, "name"), case));
    by_name.collect()
}

fn text(case: &Value, key: &str) -> String {
    case[key].as_str().unwrap().to_owned()
}

/// What a run leaves in its folder.
struct Run<'a> {
    folder: &'a Path,
    scene: Scene,
    solution: Solution,
}

impl Run<'_> {
    /// Sums of a column of a table by another one.
    fn sums(&self, file: &str, by: &[&str], column: &str) -> BTreeMap<Vec<String>, f64> {
        let mut sums = BTreeMap::new();
        let mut table = csv::Reader::from_path(self.folder.join(file)).unwrap();
        for row in table.deserialize() {
            let row: HashMap<String, String> = row.unwrap();
            let key = by.iter().map(|&name| row[name].clone()).collect();
            *sums.entry(key).or_insert(0.0) += row[column].parse::<f64>().unwrap();
        }
        sums
    }

    /// The same quantity as the case, from the run's files.
    fn measured(&self, case: &Case, printed: f64) -> f64 {
        let expected = case.expected.value();
        let farthest = |values: &mut dyn Iterator<Item = f64>| {
            let off = |value: &f64| (value - expected).abs();
            values.max_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
        };
        let radiosity = self.solution.radiosity(&self.scene);
        match &case.measure {
            Measure::FormFactor { from, to } => {
                let sums = self.sums("view_factors.csv", &["from", "to"], "view_factor");
                let pair = vec![(*from).to_owned(), (*to).to_owned()];
                sums.get(&pair).copied().unwrap_or(0.0)
            }
            Measure::Closure => {
                let sums = self.sums("form_factors.csv", &["from"], "form_factor");
                farthest(&mut sums.into_values())
            }
            Measure::Irradiance { of } => self.irradiance(of),
            Measure::Radiosity => farthest(&mut radiosity.iter().map(|b| f64::from(b.x))),
            Measure::Reflected {
                reference,
                statistic,
                ..
            } => {
                let problem = Problem::new(&self.scene);
                path_tracer::statistic(*statistic, &problem, &self.solution.irradiance, reference)
            }
            // Which patch and channel is the farthest is the dense solution's to say.
            Measure::DenseSolve { .. } => {
                let values = radiosity
                    .iter()
                    .flat_map(|b| <[f32; 3]>::from(*b))
                    .map(f64::from);
                let off = |value: &f64| (value - printed).abs();
                values.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap()
            }
        }
    }

    /// Mean of an object's first channel, W/m^2.
    fn irradiance(&self, object: &str) -> f64 {
        let areas = self.scene.patch_areas();
        let (mut received, mut area) = (0.0, 0.0);
        for (surface, tree) in self.scene.surfaces().iter().zip(self.scene.mesh().trees()) {
            let name = |id: ObjectId| self.scene.object(id);
            for patch in tree.patches().filter(|_| name(surface.object) == object) {
                let patch = patch as usize;
                received += areas[patch] * f64::from(self.solution.irradiance[patch].x);
                area += areas[patch];
            }
        }
        received / area
    }
}

/// Runs of all cases that are printed, each by the options that `of_case` makes of the printed ones, come to what the
/// cases print.
fn runs_come_to(printed: &Printed, of_case: impl Fn(String) -> String) {
    let folder = folder();
    let mut before: Option<(String, String)> = None;
    let mut cases = bank().unwrap();
    cases.retain(|case| printed.contains_key(&case.name));
    assert_eq!(cases.len(), printed.len());
    for case in cases {
        let line = &printed[&case.name];
        let options = of_case(text(line, "options"));
        let mut arguments = vec!["in.rad", "out.rad"];
        arguments.extend(options.split_whitespace());
        match case.measure {
            Measure::FormFactor { .. } => arguments.extend(["--view-factors", "view_factors.csv"]),
            Measure::Closure => arguments.extend(["--form-factors", "form_factors.csv"]),
            _ => (),
        }
        // The cases of a room are one run.
        let room = match case.measure {
            Measure::Reflected { room, .. } => Some((room.to_owned(), options.clone())),
            _ => None,
        };
        if room.is_none() || room != before {
            save(folder.path(), "in.rad", &case.scene.build().unwrap());
            solve(folder.path(), &arguments);
        }
        before = room;
        let (scene, solution) = scene::file::load(&folder.path().join("out.rad")).unwrap();
        let run = Run {
            folder: folder.path(),
            scene,
            solution: solution.unwrap(),
        };
        let expected = line["computed"].as_f64().unwrap();
        let measured = run.measured(&case, expected);
        // The same numbers, summed in f64 in another order: some thousand roundings of 1e-16.
        let off = (measured - expected).abs();
        let name = &case.name;
        assert!(off <= 1e-12 * expected, "{name}: {measured}, {expected}");
    }
}

/// All options are others than by default.
#[test]
fn a_case_is_a_run_with_the_options_that_it_prints() {
    let printed = verify(&[
        "32",
        "--backend",
        "cpu",
        "--points",
        "3",
        "--lamps",
        "all",
        "--seed",
        "7",
        "--maps",
        "thesis",
        "--closed-forms",
        "off",
    ]);
    runs_come_to(&printed, |options| options);
}

/// Of the options that decide form factors the runs have none, but for a resolution that makes many cases cheap.
#[test]
fn by_default_a_case_is_a_run_by_default() {
    for (asked_for, resolution) in [(&["32"][..], "32"), (&["--case", "furnace"], "")] {
        let printed = verify(&[asked_for, &["--backend", "auto"]].concat());
        assert!(printed.len() > 2);
        runs_come_to(&printed, |options| {
            let words: Vec<&str> = options.split(' ').skip(1).collect();
            let how_far = ["--solver", "--tolerance", "--iterations"];
            let kept = words.chunks(2).filter(|pair| how_far.contains(&pair[0]));
            let kept: Vec<String> = kept.map(|pair| pair.join(" ")).collect();
            format!("{resolution} --backend auto {}", kept.join(" "))
        });
    }
}
