//! Which back end draws, and that a file which goes on keeps it.
//!
//! Without an adapter those that need one are ignored; with `REQUIRE_GPU=1` they fail instead.

mod common;

use std::path::Path;
use std::process::{Command, Output};
use std::sync::LazyLock;

use common::{
    assert_same, block, folder, furnished_room, load, material, program, save, scene, stderr,
    stdout,
};
use compute::backend::{RowOrigin, agreement};
use compute::gpu::adapter::Gpu;
use compute::rows::BackendError;
use compute::settings::AdapterChoice;
use glam::Vec3;
use scene::{MaterialId, Solution};
use serde_json::Value;
use tempfile::TempDir;
use test_needs::{ExitCode, laws, run as run_tests};

const SETTINGS: [&str; 4] = ["32", "--tolerance", "0", "--iterations"];

/// Solves so many iterations in all, and reports.
fn command(folder: &Path, files: [&str; 2], iterations: &str, more: &[&str]) -> Command {
    let arguments = [&files[..], &SETTINGS, &[iterations], more].concat();
    let arguments = [&arguments[..], &["--report", "report.json"]].concat();
    program(folder, &arguments)
}

#[track_caller]
fn run(mut command: Command) -> Output {
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    output
}

fn report(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap()
}

/// Where the rows come from, as a file says.
fn origin(solution: &Solution) -> String {
    let settings = solution.provenance.settings.as_ref().unwrap();
    RowOrigin::recorded_in(settings).unwrap().to_string()
}

/// Hides all Vulkan drivers.
fn without_adapters(mut command: Command) -> Command {
    command.env("VK_DRIVER_FILES", "/nowhere.json");
    command.env("VK_ICD_FILENAMES", "/nowhere.json");
    command
}

/// A room with two blocks: nobody has formulas there.
fn folder_with_furnished_room() -> TempDir {
    let folder = folder();
    save(folder.path(), "in.rad", &furnished_room(0.5));
    folder
}

/// A room without anything in it, whose ceiling is a lamp: `auto` takes formulas.
fn folder_with_empty_room() -> TempDir {
    let folder = folder();
    let mut surfaces = block(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.5), false, 0);
    for surface in &mut surfaces[2..4] {
        surface.material = MaterialId(1);
    }
    let materials = vec![material(0.6, 0.0), material(0.2, 9.0)];
    save(folder.path(), "in.rad", &scene(materials, surfaces, 1.0));
    folder
}

fn a_gpu_that_was_asked_for_is_tried_and_the_report_tells() {
    let folder = folder_with_furnished_room();
    let files = ["in.rad", "out.rad"];
    let output = run(command(folder.path(), files, "1", &["--backend", "gpu"]));
    assert!(!stderr(&output).contains("warning"), "{output:?}");
    let report = report(folder.path());
    assert_eq!(report["backend"]["name"], "gpu");
    let trial = &report["backend"]["trial"];
    let number = |name: &str| trial[name].as_f64().unwrap();
    assert!(number("hemicubes") >= 4.0, "{trial}");
    assert!(number("cpu_hemicubes_per_second") > 0.0, "{trial}");
    assert!(number("gpu_hemicubes_per_second") > 0.0, "{trial}");
    assert!(number("bound").to_bits() == agreement::bound(32).to_bits());
    // That it can be more is shown where a fake draws something else.
    assert!(number("difference") <= number("bound"), "{trial}");
}

/// Whatever `auto` would take, the file was solved on the CPU.
fn a_file_from_the_cpu_goes_on_there_with_the_same_bits_and_without_a_trial() {
    // In the one room formulas would be taken by default.
    for folder in [folder_with_empty_room(), folder_with_furnished_room()] {
        let folder = folder.path();
        for solver in ["jacobi", "shooting"] {
            let solve = |files, iterations, backend| {
                let more = ["--backend", backend, "--solver", solver];
                run(command(folder, files, iterations, &more))
            };
            solve(["in.rad", "whole.rad"], "6", "cpu");
            solve(["in.rad", "part.rad"], "2", "cpu");
            let output = solve(["part.rad", "part.rad"], "6", "auto");
            assert_eq!(stderr(&output), "");
            let report = report(folder);
            assert_eq!(report["backend"]["name"], "cpu");
            assert_eq!(report["backend"]["trial"], Value::Null);
            let part = load(folder, "part.rad");
            assert_same(&part, &load(folder, "whole.rad"), "");
            assert_eq!(origin(&part), "cpu");
        }
    }
}

/// Rows that are written as a table are those that the solver goes on with.
fn form_factors_of_a_file_that_goes_on_come_from_where_its_rows_came_from() {
    let folder = folder_with_empty_room();
    let table = |name: &str, backend: &str, input: &str| {
        let more = ["--backend", backend, "--form-factors", name];
        run(command(folder.path(), [input, "out.rad"], "2", &more));
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let by_cpu = table("cpu.csv", "cpu", "in.rad");
    assert!(table("again.csv", "auto", "out.rad") == by_cpu);
    assert!(table("formulas.csv", "auto", "in.rad") != by_cpu);
}

fn a_file_from_the_gpu_goes_on_there_with_the_same_bits_and_without_a_trial() {
    let folder = folder_with_empty_room();
    let folder = folder.path();
    let solve = |files, iterations, backend| {
        run(command(folder, files, iterations, &["--backend", backend]))
    };
    solve(["in.rad", "whole.rad"], "4", "gpu");
    solve(["in.rad", "part.rad"], "2", "gpu");
    let output = solve(["part.rad", "part.rad"], "4", "auto");
    // Libraries of the system may say something.
    assert!(!stderr(&output).contains("compute: "), "{output:?}");
    assert_eq!(report(folder)["backend"]["name"], "gpu");
    assert_eq!(report(folder)["backend"]["trial"], Value::Null);
    let part = load(folder, "part.rad");
    assert_same(&part, &load(folder, "whole.rad"), "");
    assert_eq!(origin(&part), "gpu");
}

fn where_the_gpu_of_a_file_is_missing_the_cpu_starts_from_its_radiosities() {
    let folder = folder_with_empty_room();
    let folder = folder.path();
    let files = ["in.rad", "gpu.rad"];
    run(command(folder, files, "2", &["--backend", "gpu"]));
    let files = ["gpu.rad", "out.rad"];
    let more = ["--backend", "auto"];
    let output = run(without_adapters(command(folder, files, "3", &more)));
    let said = stderr(&output);
    for part in [
        "was solved with backend gpu, now cpu; its radiosities are the start",
        "the GPU that the solution is from is not used: no GPU adapter was found",
    ] {
        assert!(said.contains(part), "{said}");
    }
    let solution = load(folder, "out.rad");
    assert_eq!(origin(&solution), "cpu");
    // Those of the GPU's iterations tell nothing about the CPU's rows.
    assert_eq!(solution.provenance.residuals.len(), 1);
    assert_eq!(solution.provenance.iterations, 3);
    // Asked for, it is an error.
    let more = ["--backend", "gpu"];
    let mut command = without_adapters(command(folder, files, "3", &more));
    assert_eq!(command.output().unwrap().status.code(), Some(1));
}

fn another_back_end_that_is_asked_for_is_told_and_starts_from_the_radiosities() {
    let folder = folder_with_empty_room();
    let folder = folder.path();
    for (before, now, told) in [
        ("auto", "cpu", "backend formulas, now cpu"),
        ("cpu", "gpu", "backend cpu, now gpu"),
        ("auto", "gpu", "backend formulas, now gpu"),
        ("gpu", "cpu", "backend gpu, now cpu"),
    ] {
        let files = ["in.rad", "before.rad"];
        run(command(folder, files, "2", &["--backend", before]));
        let files = ["before.rad", "now.rad"];
        let output = run(command(folder, files, "3", &["--backend", now]));
        let told = format!("was solved with {told}; its radiosities are the start");
        assert!(stderr(&output).contains(&told), "{output:?}");
        let solution = load(folder, "now.rad");
        assert_eq!(origin(&solution), now);
        assert_eq!(solution.provenance.residuals.len(), 1);
    }
}

/// Files of an older version do not tell, and any back end goes on with them.
fn a_file_that_does_not_tell_its_back_end_goes_on_with_any() {
    let folder = folder_with_empty_room();
    let folder = folder.path();
    run(command(
        folder,
        ["in.rad", "whole.rad"],
        "4",
        &["--backend", "cpu"],
    ));
    run(command(
        folder,
        ["in.rad", "part.rad"],
        "2",
        &["--backend", "cpu"],
    ));
    let path = folder.join("part.rad");
    let (scene, solution) = scene::file::load(&path).unwrap();
    let mut solution = solution.unwrap();
    let settings = solution.provenance.settings.as_ref().unwrap();
    let mut fields = serde_json::to_value(settings).unwrap();
    fields.as_object_mut().unwrap().remove("backend").unwrap();
    solution.provenance.settings = Some(serde_json::from_value(fields).unwrap());
    scene::file::save(&path, &scene, Some(&solution)).unwrap();
    for (backend, origin_now) in [("auto", "formulas"), ("cpu", "cpu")] {
        let files = ["part.rad", "out.rad"];
        let output = run(command(folder, files, "4", &["--backend", backend]));
        assert_eq!(stderr(&output), "");
        let out = load(folder, "out.rad");
        assert_eq!(out.provenance.residuals.len(), 4);
        assert_eq!(origin(&out), origin_now);
    }
    assert_same(&load(folder, "out.rad"), &load(folder, "whole.rad"), "");
}

/// Without an adapter the CPU takes over, and says why.
fn sensors_are_drawn_by_what_drew_for_the_solution() {
    let folder = folder_with_furnished_room();
    let folder = folder.path();
    std::fs::write(folder.join("p.csv"), "x,y,z,nx,ny,nz\n2,1.5,0.1,0,0,1\n").unwrap();
    let gather = [
        "gather",
        "out.rad",
        "--sensors",
        "p.csv",
        "--out",
        "v.csv",
        "32",
        "--backend",
        "auto",
    ];
    for (backend, name) in [("cpu", "cpu"), ("gpu", "gpu")] {
        let more = ["--backend", backend];
        run(command(folder, ["in.rad", "out.rad"], "1", &more));
        let output = run(program(folder, &gather));
        let said = stdout(&output);
        assert!(said.contains(&format!("back end       {name}")), "{said}");
    }
    let output = run(without_adapters(program(folder, &gather)));
    assert!(stdout(&output).contains("back end       cpu"), "{output:?}");
    assert!(stderr(&output).contains("is not used"), "{output:?}");
}

/// With other settings nothing goes on whose bits could be kept.
fn a_file_that_goes_on_with_other_settings_chooses_anew() {
    let folder = folder_with_empty_room();
    let folder = folder.path();
    run(command(
        folder,
        ["in.rad", "cpu.rad"],
        "2",
        &["--backend", "cpu"],
    ));
    let more = ["--backend", "auto", "--seed", "7"];
    let output = run(command(folder, ["cpu.rad", "out.rad"], "3", &more));
    assert!(
        stderr(&output).contains("was solved with seed 0, now 7; its"),
        "{output:?}"
    );
    assert_eq!(origin(&load(folder, "out.rad")), "formulas");
}

fn main() -> ExitCode {
    let mut tests = laws![an_adapter =>
        a_gpu_that_was_asked_for_is_tried_and_the_report_tells,
        a_file_from_the_gpu_goes_on_there_with_the_same_bits_and_without_a_trial,
        where_the_gpu_of_a_file_is_missing_the_cpu_starts_from_its_radiosities,
        another_back_end_that_is_asked_for_is_told_and_starts_from_the_radiosities,
        sensors_are_drawn_by_what_drew_for_the_solution,
    ];
    tests.extend(laws![|| Ok(()) =>
        a_file_from_the_cpu_goes_on_there_with_the_same_bits_and_without_a_trial,
        form_factors_of_a_file_that_goes_on_come_from_where_its_rows_came_from,
        a_file_that_does_not_tell_its_back_end_goes_on_with_any,
        a_file_that_goes_on_with_other_settings_chooses_anew,
    ]);
    run_tests(tests)
}

fn an_adapter() -> Result<(), String> {
    static IS_THERE: LazyLock<bool> = LazyLock::new(|| {
        let opened = Gpu::open(AdapterChoice::Any);
        !matches!(opened, Err(BackendError::NoAdapter))
    });
    test_needs::adapter(*IS_THERE)
}
