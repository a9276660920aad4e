//! The Cornell box and a columned room against a path tracer's solution (`compute/src/verify/data/README.md`).

use glam::DVec3;
use tempfile::TempDir;
use tests::{PatchRow, Table, data, folder, patches, reflected_error, run};

/// How far the irradiance at the centroids is from the means over the patches, in this error measure:
/// given with the reference data, from the path tracer alone.
const CENTROID: [f64; 2] = [0.0079, 0.0103];

/// How far constant radiosities on these patches are from the means, all else being exact: given with the
/// reference data, from View3D's factors.
const DISCRETISATION: [f64; 2] = [0.0035, 0.0058];

/// Standard error of an area counted in pixels of a square grid, relative: 0.0724 (perimeter / root of
/// area) n^(-3/2) is its square for n pixels (Gundersen and Jensen, Journal of Microscopy 147,
/// 1987; Matern). A lamp of which one side is `ratio` times the other has 2 (ratio + 1) / root(ratio).
fn counting_error(pixels: f64, ratio: f64) -> f64 {
    let shape = 2.0 * (ratio + 1.0) / ratio.sqrt();
    (0.0724 * shape * pixels.powf(-1.5)).sqrt()
}

/// Pixels on the lamp as seen from below it: of a plane at distance d parallel to the top face, R^2 / 4
/// pixels cover d^2.
fn pixels_on_lamp(area: f64, distance: f64, resolution: f64) -> f64 {
    area / (distance * distance) * (resolution / 2.0).powi(2)
}

/// A folder with a model of the reference data as `a.rad`, a patch a triangle.
fn imported(name: &str) -> TempDir {
    let folder = folder();
    let obj = data(&format!("{name}.obj"));
    let model = ["a.rad", obj.to_str().unwrap(), "--max-area", "inf"];
    run(&folder, "genx", &model);
    folder
}

struct Solved {
    /// With the irradiance after convergence.
    patches: Vec<PatchRow>,
    reference: Table,
}

impl Solved {
    /// Imports, solves and exports a model of the reference data.
    fn new(name: &str, settings: &[&str]) -> Self {
        let folder = imported(name);
        let compute = [
            "a.rad",
            "a.rad",
            "128",
            "--quality",
            "mesh",
            "--backend",
            "cpu",
            "--tolerance",
            "1e-5",
        ];
        run(&folder, "compute", &[&compute, settings].concat());
        let solved = Self {
            patches: patches(&folder, "a.rad"),
            reference: Table::read(&data(&format!("{name}.csv"))),
        };
        assert_eq!(solved.patches.len(), solved.reference.len());
        solved
    }

    /// Against the columns `NAME_r`, `NAME_g`, `NAME_b`, with the solution's irradiances changed.
    fn error_of(&self, change: impl Fn(DVec3) -> DVec3, name: &str) -> f64 {
        reflected_error(
            &self.patches,
            |i| change(self.patches[i].irradiance),
            |i| self.reference.rgb(i, name),
        )
    }

    fn error(&self, name: &str) -> f64 {
        self.error_of(|irradiance| irradiance, name)
    }
}

/// Independent errors add up by their squares: the centroid's, the patches', and the lamp's pixels being
/// counted. Of the light only a part comes from the lamp directly, but walls and blocks see it at a
/// slant, in fewer pixels; the tolerance takes all of it to come from the lamp as the floor sees it.
fn tolerance(scene: usize, sampling: f64) -> f64 {
    [CENTROID[scene], DISCRETISATION[scene], sampling]
        .iter()
        .map(|e| e * e)
        .sum::<f64>()
        .sqrt()
}

/// The lamp, 0.13 m by 0.105 m, 0.5488 m above the floor, at 128 pixels.
fn cornell_sampling() -> f64 {
    counting_error(pixels_on_lamp(0.13 * 0.105, 0.5488, 128.0), 0.13 / 0.105)
}

#[test]
fn cornell_box_agrees_with_the_path_tracer() {
    let solved = Solved::new("cornell", &["--points", "centroid"]);
    let tolerance = tolerance(0, cornell_sampling());
    let error = solved.error("irradiance");
    println!("cornell, 128 pixels: error {error:.5}, tolerance {tolerance:.5}");
    assert!(error < tolerance, "{error} > {tolerance}");
    // It is tight enough to notice two percent in one channel of three.
    let wrong = solved.error_of(|h| h * DVec3::new(1.02, 1.0, 1.0), "irradiance");
    assert!(wrong > tolerance, "{wrong} <= {tolerance}");
}

/// Four points of equal area a patch: four times as many samples of the lamp's outline, and of the
/// patch. A midpoint rule over a quarter of the area has a quarter of the error, where light is smooth.
#[test]
fn more_points_come_closer_to_the_discrete_solution_and_to_the_path_tracer() {
    let one = Solved::new("cornell", &["--points", "centroid"]);
    let four = Solved::new("cornell", &["--points", "4"]);
    for name in ["irradiance", "irradiance_discrete"] {
        let (with_one, with_four) = (one.error(name), four.error(name));
        println!("cornell, {name}: {with_one:.5} with 1 point, {with_four:.5} with 4");
        assert!(with_four < with_one, "{name}: {with_four} >= {with_one}");
    }
    // At shadow edges the midpoint rule errs by the root of the area only: half of the centroid's. The
    // discrete solution has no error of discretisation.
    let half = [0.5 * CENTROID[0], 0.5 * cornell_sampling()];
    let tolerance = half[0].hypot(half[1]);
    let error = four.error("irradiance_discrete");
    assert!(error < tolerance, "discrete: {error} > {tolerance}");
    let tolerance = tolerance.hypot(DISCRETISATION[0]);
    let error = four.error("irradiance");
    assert!(error < tolerance, "{error} > {tolerance}");
}

/// Here the lamp is 0.8 m square, 4 m above the floor, and everything is parallel to everything: whole
/// rows of pixels flip at once, so counting errs by more than of shapes that lie at random. A row of w pixels has
/// w or one more, with a variance of at most 1/4 and 1/6 in the mean, in both directions.
#[test]
fn columned_room_agrees_with_the_path_tracer() {
    let across = pixels_on_lamp(0.8 * 0.8, 4.0, 128.0).sqrt();
    let sampling = (2.0 / 6.0_f64).sqrt() / across;
    let tolerance = tolerance(1, sampling);
    let solved = Solved::new("room", &["--points", "centroid"]);
    let error = solved.error("irradiance");
    println!("room, 128 pixels: error {error:.5}, tolerance {tolerance:.5}");
    assert!(error < tolerance, "{error} > {tolerance}");
    let wrong = solved.error_of(|h| h * DVec3::new(1.1, 1.0, 1.0), "irradiance");
    assert!(wrong > tolerance, "{wrong} <= {tolerance}");
}

/// By default a patch has as many points as it needs and lamps have views of their own: what is left of the
/// error of points and pixels is at most that of the data, and constant radiosity a patch is what the rest of
/// the error comes from. Squares of independent errors add up.
#[test]
fn the_default_is_as_good_as_its_patches() {
    const NOISE: f64 = 0.0009;
    let solved = Solved::new("cornell", &[]);
    let discrete = solved.error("irradiance_discrete");
    let mean = solved.error("irradiance");
    println!("cornell: {discrete:.5} to the discrete solution, {mean:.5} to the path tracer");
    // The discrete solution's own form factors are right to some 0.05 percent.
    assert!(discrete < 2.0 * NOISE, "{discrete}");
    let tolerance = DISCRETISATION[0].hypot(2.0 * NOISE);
    assert!(mean < tolerance, "{mean} > {tolerance}");
}

/// What is asked of the means of patches is stated at most, and what is stated is there: to within the factor of 1.5 that is promised of
/// estimates.
#[test]
fn means_are_as_near_as_is_asked() {
    for (name, asked) in [("cornell", 0.0045), ("room", 0.01)] {
        let folder = imported(name);
        let percent = format!("{}%", 100.0 * asked);
        let compute = [
            "a.rad",
            "a.rad",
            "--quality",
            "mesh",
            "--target-error",
            &percent,
            "--backend",
            "cpu",
            "--report",
            "r.json",
        ];
        run(&folder, "compute", &compute);
        let report = std::fs::read(folder.path().join("r.json")).unwrap();
        let report: serde_json::Value = serde_json::from_slice(&report).unwrap();
        let stated = report["function"]["error"]["total"]["power"]
            .as_f64()
            .unwrap();
        let reference = Table::read(&data(&format!("{name}.csv")));
        let patches = patches(&folder, "a.rad");
        let found = reflected_error(
            &patches,
            |i| patches[i].irradiance,
            |i| reference.rgb(i, "irradiance"),
        );
        println!("{name}: asked {asked}, stated {stated:.5}, found {found:.5}");
        assert!(stated <= asked && found < 1.5 * stated, "{stated} {found}");
    }
}

/// The data's own noise, 0.09 and 0.08 percent in the error measure, is no part of the tolerances above.
#[test]
fn the_reference_is_good_enough_to_judge_by() {
    for name in ["cornell", "room"] {
        let table = Table::read(&data(&format!("{name}.csv")));
        let (mut noise, mut size) = (0.0, 0.0);
        for row in 0..table.len() {
            noise += table.rgb(row, "irradiance_se").length_squared();
            size += table.rgb(row, "irradiance").length_squared();
        }
        let noise = f64::sqrt(noise / size);
        assert!(noise < 0.002, "{name}: {noise}");
    }
}

/// Irradiances at random points of both scenes against the path tracer's: its own noise, which is known, and what
/// constant radiosities bring. The latter is that of the means for what comes from far away, and more where a sensor
/// is nearer to a lit wall than the wall's patches are wide: a percent covers both scenes' (`DISCRETISATION` twice).
#[test]
fn sensors_receive_what_the_path_tracer_found() {
    for (scene, name) in ["cornell", "room"].into_iter().enumerate() {
        let folder = imported(name);
        run(&folder, "compute", &["a.rad", "a.rad", "--backend", "cpu"]);
        let sensors = data(&format!("sensors_{name}.csv"));
        let out = folder.path().join("values.csv");
        let arguments = [
            "gather",
            "a.rad",
            "--sensors",
            sensors.to_str().unwrap(),
            "--out",
            out.to_str().unwrap(),
        ];
        run(&folder, "compute", &arguments);
        let values = Table::read(&out);
        let (mut difference, mut noise, mut whole) = (0.0, 0.0, 0.0);
        for row in 0..values.len() {
            let expected = values.rgb(row, "in_irradiance");
            difference += (values.rgb(row, "irradiance") - expected).length_squared();
            noise += values.rgb(row, "se").length_squared();
            whole += expected.length_squared();
        }
        let [error, noise] = [difference, noise].map(|sum: f64| (sum / whole).sqrt());
        println!("{name}: rms error {error:.4}, of which the path tracer's noise {noise:.4}");
        let mesh = 2.0 * DISCRETISATION[scene];
        assert!(error < mesh.hypot(noise), "{name}: {error} {noise}");
    }
}
