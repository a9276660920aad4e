//! `compute gather`: what sensors receive, the tables they stand in, and what is wrong with some.

mod common;

use std::fs;
use std::path::Path;

use common::{block, compute, files, folder, furnished_room, material, save, scene, solve, stderr};
use glam::Vec3;
use tempfile::TempDir;

/// The numbers of some columns, row by row.
fn columns(folder: &Path, file: &str, names: &[&str]) -> Vec<Vec<f64>> {
    let text = fs::read_to_string(folder.join(file)).unwrap();
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let header = lines.next().unwrap();
    let place = |name: &&str| {
        let place = header.iter().position(|column| column == name);
        place.unwrap_or_else(|| panic!("no {name} in {header:?}"))
    };
    let places: Vec<usize> = names.iter().map(place).collect();
    lines
        .map(|line| places.iter().map(|&k| line[k].parse().unwrap()).collect())
        .collect()
}

const IRRADIANCE: [&str; 3] = ["irradiance_r", "irradiance_g", "irradiance_b"];

/// A folder with a solved scene and a table of sensors.
fn folder_with(scene: &scene::Scene, table: &str) -> TempDir {
    let folder = folder();
    save(folder.path(), "in.rad", scene);
    solve(
        folder.path(),
        &["in.rad", "solved.rad", "32", "--tolerance", "1e-7"],
    );
    fs::write(folder.path().join("points.csv"), table).unwrap();
    folder
}

/// The table `points.csv` to `values.csv`.
const GATHER: [&str; 7] = [
    "gather",
    "solved.rad",
    "--sensors",
    "points.csv",
    "--out",
    "values.csv",
    "32",
];

fn gather(folder: &TempDir) -> String {
    stderr(&solve(folder.path(), &GATHER))
}

/// In a furnace every point receives B = E / (1 - rho) from wherever it looks; what comes from the emitters, all of
/// which are seen, is E. The iteration stops within 1e-7 / (1 - rho) of B, and f32 rounds a few times.
#[test]
fn every_sensor_in_a_furnace_receives_the_same() {
    let table = "x,y,z,nx,ny,nz\n\
        0.5,0.5,0.5,0,0,1\n\
        0.1,0.9,0.3,-1,2,0.5\n\
        0.25,0.5,0,0,0,1\n\
        0.7,1,0.2,0,-3,0\n\
        0.999999,0.3,0.4,-1,0,0\n";
    let folder = folder_with(&common::furnace(0.5, 1.0, 0.05), table);
    // In such a room a run by default has formulas for its patches.
    for backend in ["cpu", "auto"] {
        let run = [
            "in.rad",
            "solved.rad",
            "32",
            "--tolerance",
            "1e-7",
            "--backend",
            backend,
        ];
        solve(folder.path(), &run);
        let arguments = [&GATHER[..], &["--backend", backend]].concat();
        assert_eq!(stderr(&solve(folder.path(), &arguments)), "");
        every_row_is_of_the_furnace(folder.path());
    }
}

fn every_row_is_of_the_furnace(folder: &Path) {
    let names = [IRRADIANCE[0], "direct_r", "openings", "back_faces"];
    for row in columns(folder, "values.csv", &names) {
        assert!(
            (row[0] - 2.0).abs() < 1e-6 && (row[1] - 1.0).abs() < 1e-6,
            "{row:?}"
        );
        assert_eq!(row[2..], [0.0, 0.0]);
    }
}

/// Where a sensor lies on a wall is known to the digits of the table: a little in front of it, in it or a little
/// behind it, it sees the same.
#[test]
fn a_sensor_that_is_behind_its_wall_by_rounding_sees_the_room() {
    let heights = ["-0.00001", "-0.0000001", "0", "0.0000001", "0.00001"];
    let rows = heights.map(|z| format!("1.2,0.7,{z},0,0,1\n"));
    let table = format!("x,y,z,nx,ny,nz\n{}", rows.concat());
    let folder = folder_with(&furnished_room(0.3), &table);
    gather(&folder);
    let values = columns(folder.path(), "values.csv", &IRRADIANCE);
    assert!(values[0][0] > 0.0);
    // On the wall all of them stand at one point.
    assert!(values.iter().all(|row| *row == values[0]), "{values:?}");
}

/// A sensor in a solid block sees nothing but the backs of its sides, which is no error.
#[test]
fn a_sensor_inside_a_solid_sees_backs_and_is_told() {
    let table = "x,y,z,nx,ny,nz\n1.3,1.2,0.9,0,0,1\n2,2.5,1,0,0,1\n";
    let folder = folder_with(&furnished_room(0.3), table);
    let told = gather(&folder);
    assert!(told.contains("1 of 2 sensors see more backs"), "{told}");
    let names = [IRRADIANCE[0], "back_faces"];
    let values = columns(folder.path(), "values.csv", &names);
    assert_eq!(values[0], [0.0, 1.0]);
    assert!(values[1][0] > 0.0 && values[1][1] == 0.0, "{values:?}");
}

/// Over a box, outside of it, a sensor that looks up sees the sky alone.
#[test]
fn what_sees_nothing_is_an_opening() {
    let boxes = block(Vec3::ZERO, Vec3::ONE, true, 0);
    let scene = scene(vec![material(0.5, 1.0)], boxes, 1.0);
    let folder = folder_with(&scene, "x,y,z,nx,ny,nz\n0.5,0.5,2,0,0,1\n");
    gather(&folder);
    let names = [IRRADIANCE[0], "openings"];
    assert_eq!(columns(folder.path(), "values.csv", &names)[0], [0.0, 1.0]);
}

#[test]
fn columns_in_any_order_are_passed_through_and_those_that_clash_renamed() {
    let table = "\u{feff}note,nz,z,irradiance_r,y,x,ny,in_irradiance_r,nx\n\
        \"left, low\",1,0.5,7,0.4,0.3,0,8,0\n\
        plain,-1,0.25,9,0.2,0.1,0,10,0\n";
    let folder = folder_with(&common::furnace(0.5, 1.0, 0.5), table);
    gather(&folder);
    let text = fs::read_to_string(folder.path().join("values.csv")).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next().unwrap(),
        "note,nz,z,in_in_irradiance_r,y,x,ny,in_irradiance_r,nx,irradiance_r,irradiance_g,irradiance_b,direct_r,\
         direct_g,direct_b,openings,back_faces"
    );
    assert!(
        lines
            .next()
            .unwrap()
            .starts_with("\"left, low\",1,0.5,7,0.4,0.3,0,8,0,")
    );
    assert!(
        lines
            .next()
            .unwrap()
            .starts_with("plain,-1,0.25,9,0.2,0.1,0,10,0,")
    );
}

/// A model's own coordinates are those before the scene's origin was subtracted.
#[test]
fn sensors_are_in_the_models_own_coordinates() {
    let room = furnished_room(0.3);
    let depths: Vec<u32> = room.mesh().trees().iter().map(|tree| tree.depth).collect();
    let (materials, objects) = (room.materials().to_vec(), room.objects().to_vec());
    let origin = glam::DVec3::new(1e5, -2e5, 3e5);
    let moved = scene::Scene::new(
        materials,
        objects,
        room.surfaces().to_vec(),
        &depths,
        origin,
    )
    .unwrap();
    let table = "x,y,z,nx,ny,nz\n100002,-199997.5,300001,0,0,1\n";
    let here = folder_with(&room, "x,y,z,nx,ny,nz\n2,2.5,1,0,0,1\n");
    let there = folder_with(&moved, table);
    gather(&here);
    gather(&there);
    let [a, b] = [&here, &there].map(|f| columns(f.path(), "values.csv", &IRRADIANCE));
    assert_eq!(a, b);
}

/// Each fault names its line, and leaves no output.
#[test]
fn faulty_tables_are_refused_with_their_lines() {
    let folder = folder_with(&common::furnace(0.5, 1.0, 0.5), "");
    let before = files(folder.path());
    for (table, parts) in [
        ("", vec!["no column \"x\""]),
        (
            "x,y,z,nx,ny\n1,2,3,0,1\n",
            vec!["no column \"nz\"", "x, y, z, nx, ny"],
        ),
        ("x,y,z,nx,ny,nz\n", vec!["no sensors"]),
        (
            "x,y,z,nx,ny,nz,x\n1,2,3,0,0,1,1\n",
            vec!["column \"x\"", "more than once"],
        ),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0,nan,0,0,0,1\n",
            vec!["line 3", "y", "\"nan\""],
        ),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,inf\n",
            vec!["line 2", "nz", "\"inf\""],
        ),
        (
            "x,y,z,nx,ny,nz\n0,0,here,0,0,1\n",
            vec!["line 2", "z", "\"here\""],
        ),
        ("x,y,z,nx,ny,nz\n0,0,0,0,0,0\n", vec!["line 2", "normal"]),
        (
            "x,y,z,nx,ny,nz\n0,0,0,0,0,1\n\n0,0,0,0,1\n",
            vec!["line 4", "5 fields"],
        ),
    ] {
        fs::write(folder.path().join("points.csv"), table).unwrap();
        let output = compute(folder.path(), &GATHER);
        assert_eq!(output.status.code(), Some(1), "{table:?}: {output:?}");
        let message = stderr(&output);
        assert!(message.contains("points.csv"), "{message}");
        for part in parts {
            assert!(message.contains(part), "{part} is missing in {message}");
        }
        assert_eq!(files(folder.path()), before);
    }
}

#[test]
fn a_scene_that_is_not_solved_and_an_output_that_is_an_input_are_refused() {
    let folder = folder_with(
        &common::furnace(0.5, 1.0, 0.5),
        "x,y,z,nx,ny,nz\n0.5,0.5,0.5,0,0,1\n",
    );
    let before = files(folder.path());
    for (solved, out, code, part) in [
        ("in.rad", "values.csv", 1, "not solved"),
        ("solved.rad", "solved.rad", 2, "SOLVED and --out"),
        ("solved.rad", "points.csv", 2, "--sensors and --out"),
        ("solved.rad", "nowhere/values.csv", 1, "nowhere/values.csv"),
    ] {
        let arguments = ["gather", solved, "--sensors", "points.csv", "--out", out];
        let output = compute(folder.path(), &arguments);
        assert_eq!(output.status.code(), Some(code), "{output:?}");
        assert!(stderr(&output).contains(part), "{output:?}");
        assert_eq!(files(folder.path()), before);
    }
}
