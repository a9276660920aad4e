//! Patches that no light can reach cost nothing, and no answer changes by that.

mod common;

use std::path::Path;

use common::{block, folder, load, material, quad, save, scene, solve};
use glam::{DVec3, Quat, Vec3};
use scene::{Scene, Solution};
use serde_json::Value;

const SOLVERS: [&str; 3] = ["jacobi", "gauss-seidel", "shooting"];

/// A closed house of thin walls, lit inside, with a box on its floor: the outsides and the box's bottom are
/// unlit. Turned and moved, so that no plane's coordinates are round.
fn house(emission: f32) -> (Scene, u32) {
    let (low, high) = (Vec3::ZERO, Vec3::new(4.0, 3.0, 2.5));
    let mut surfaces = block(low, high, false, 0);
    surfaces.extend(block(
        Vec3::new(1.0, 1.0, 0.0),
        Vec3::new(2.0, 2.0, 1.0),
        true,
        0,
    ));
    let lamp = [[1.0, 1.0], [1.0, 2.0], [2.0, 2.0], [2.0, 1.0]].map(|[x, y]| Vec3::new(x, y, 2.4));
    surfaces.extend(quad(lamp, 1));
    surfaces.extend(block(low - 0.1, high + 0.1, true, 0));
    let turn = Quat::from_euler(glam::EulerRot::XYZ, 0.3, 0.7, 1.1);
    for surface in &mut surfaces {
        surface.corners = surface
            .corners
            .map(|p| turn * p + Vec3::new(7.0, -3.0, 5.0));
    }
    let materials = vec![material(0.6, 0.0), material(0.2, emission)];
    let scene = scene(materials, surfaces, 0.3);
    let areas = scene.mesh().trees().iter().enumerate();
    // Surfaces in order: room 12, box 12 (its bottom among them), lamp 2, outside 12.
    let unlit: u32 = areas
        .filter(|(k, _)| *k >= 26 || is_bottom(&scene, *k, turn))
        .map(|(_, tree)| tree.patches().len() as u32)
        .sum();
    (scene, unlit)
}

/// True for the two triangles of the box that lie on the floor.
fn is_bottom(scene: &Scene, surface: usize, turn: Quat) -> bool {
    let down = (turn * Vec3::NEG_Z).as_dvec3();
    let normal: DVec3 = scene.surfaces()[surface].normal();
    (12..24).contains(&surface) && normal.dot(down) > 0.9
}

fn report(folder: &Path, arguments: &[&str]) -> Value {
    solve(folder, &[arguments, &["--report", "report.json"]].concat());
    serde_json::from_slice(&std::fs::read(folder.join("report.json")).unwrap()).unwrap()
}

/// With all rows written to a file none is left out.
#[test]
fn unlit_patches_are_not_drawn_and_change_no_bit() {
    let folder = folder();
    let (scene, unlit) = house(5.0);
    save(folder.path(), "in.rad", &scene);
    for solver in SOLVERS {
        let some = [
            "in.rad", "some.rad", "32", "--solver", solver, "--points", "centroid",
        ];
        let limits = ["--iterations", "9", "--tolerance", "0"];
        let some = report(folder.path(), &[&some[..], &limits].concat());
        let all = [
            "in.rad", "all.rad", "32", "--solver", solver, "--points", "centroid",
        ];
        let all_rows = ["--form-factors", "f.csv"];
        let all = report(folder.path(), &[&all[..], &limits, &all_rows].concat());
        assert_eq!(some["unlit_patches"], unlit, "{solver}");
        assert_eq!(all["unlit_patches"], 0, "{solver}");
        assert_eq!(all["hemicubes_drawn"], scene.patch_count());
        let (some_solution, all_solution) = (
            load(folder.path(), "some.rad"),
            load(folder.path(), "all.rad"),
        );
        assert!(some_solution == all_solution, "{solver}: the bits differ");
        if solver != "shooting" {
            assert_eq!(some["hemicubes_drawn"], scene.patch_count() - unlit);
            for path in ["/energy/imbalance", "/energy/lost_w"] {
                let known = |report: &Value| report.pointer(path).cloned().unwrap();
                assert!(
                    !known(&some).is_null() && known(&some) == known(&all),
                    "{path}"
                );
            }
            assert!(!some["certificate"]["reciprocity"].is_null());
        }
    }
}

#[test]
fn a_scene_without_light_needs_no_row() {
    let folder = folder();
    let (scene, _) = house(0.0);
    save(folder.path(), "in.rad", &scene);
    let report = report(folder.path(), &["in.rad", "out.rad", "32"]);
    assert_eq!(report["hemicubes_drawn"], 0);
    assert_eq!(report["unlit_patches"], scene.patch_count());
    assert_eq!(report["stopped_by"], "tolerance");
}

/// A file may bring light to where none can come from; then all rows are needed to take it back.
#[test]
fn a_start_with_light_on_unlit_patches_is_solved_with_all_rows() {
    let folder = folder();
    let (scene, _) = house(5.0);
    let start = Solution {
        irradiance: vec![Vec3::ONE; scene.patch_count() as usize],
        ..Solution::dark(&scene)
    };
    scene::file::save(&folder.path().join("in.rad"), &scene, Some(&start)).unwrap();
    let first = ["in.rad", "out.rad", "32", "--iterations", "2"];
    let report_of_first = report(folder.path(), &first);
    assert_eq!(report_of_first["unlit_patches"], 0);
}
