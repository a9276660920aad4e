//! Units, extents, and what is too far away.

mod common;

use std::fmt::Write as _;

use common::program::{failure, folder, genx, load, make, stderr, stdout, usage_error};
use glam::DVec3;
use scene::Axis;

/// A closed box from one corner to the other, fronts inside, with a lamp for a ceiling.
fn room(low: [f64; 3], high: [f64; 3]) -> String {
    let sides = scene::planar::box_sides(low.into(), high.into());
    let mut text = String::from("mtllib m.mtl\n");
    for (k, side) in sides.iter().enumerate() {
        let name = ["floor", "ceiling", "south", "north", "west", "east"][k];
        let material = if k == 1 { "lamp" } else { "wall" };
        for p in side {
            writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
        }
        writeln!(text, "o {name}\nusemtl {material}\nf -4 -3 -2 -1").unwrap();
    }
    text
}

const MTL: &str = "newmtl wall\nKd 0.5\nnewmtl lamp\nKd 0.5\nKe 10\n";

/// The same room in all units: areas and powers are the same, and its own coordinates stay what they are.
#[test]
fn areas_and_powers_are_in_metres_and_places_in_the_models_own_coordinates() {
    for (unit, metres) in [
        ("m", 1.0),
        ("cm", 0.01),
        ("mm", 0.001),
        ("in", 0.0254),
        ("ft", 0.3048),
    ] {
        let folder = folder();
        let write =
            |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
        write("m.mtl", MTL);
        let size = [4.0, 3.0, 2.5].map(|side: f64| (side / metres).round());
        let low = [1000.0, -500.0, 20.0];
        let high = [0, 1, 2].map(|k| low[k] + size[k]);
        write("m.obj", &room(low, high));
        let output = make(
            &folder,
            &[
                "a.rad", "m.obj", "0.2", "0.5", "10", "--unit", unit, "--up", "z",
            ],
        );
        let scene = load(&folder, "a.rad");
        assert_eq!(
            (scene.axes().unit, scene.axes().up),
            (metres, Some(Axis::Z))
        );
        let [x, y, z] = size.map(|side| side * metres);
        let area = 2.0 * (x * y + y * z + z * x);
        assert!(
            (scene.area() / area - 1.0).abs() < 1e-5,
            "{unit}: {}",
            scene.area()
        );
        let power = 10.0 * x * y;
        assert!((scene.emitted_power().x / power - 1.0).abs() < 1e-5);
        assert!(stdout(&output).contains("extent "), "{output:?}");
        // Corners are f32 in metres, relative to the middle: so much of the model's own coordinates.
        let rounding = 3.0 * 2.0_f64.powi(-24) * 4.0 / metres;
        let corners = scene.surfaces().iter().flat_map(|s| s.corners);
        for corner in corners {
            let place = scene.to_model(corner.as_dvec3());
            for k in 0..3 {
                let off = (place[k] - low[k]).abs().min((place[k] - high[k]).abs());
                assert!(off <= rounding, "{unit}: {place}");
            }
            assert!(scene.to_scene(place).distance(corner.as_dvec3()) <= 1e-12);
        }
    }
}

#[test]
fn a_room_of_thousands_of_metres_is_asked_for_its_unit() {
    for (scale, unit) in [
        (1.0, None),
        (10.0, None),
        (100.0, Some("cm")),
        (1000.0, Some("mm")),
    ] {
        let folder = folder();
        std::fs::write(folder.path().join("m.mtl"), MTL).unwrap();
        let obj = room([0.0; 3], [4.0 * scale, 3.0 * scale, 2.5 * scale]);
        std::fs::write(folder.path().join("m.obj"), obj).unwrap();
        let said = stderr(&make(&folder, &["a.rad", "m.obj"]));
        match unit {
            None => assert_eq!(said, ""),
            Some(unit) => {
                assert!(said.contains(&format!("give --unit {unit}")), "{said}");
                let said = stderr(&make(&folder, &["a.rad", "m.obj", "--unit", unit]));
                assert_eq!(said, "");
            }
        }
    }
    let message = usage_error(&["a.rad", "1", "--unit", "yards"]);
    assert!(message.contains("m, cm, mm, in, ft"), "{message}");
}

/// A room at the coordinates of a map is as good as one at zero; with a triangle left at zero it is not.
#[test]
fn what_lies_so_far_away_that_all_else_suffers_is_named() {
    let folder = folder();
    std::fs::write(folder.path().join("m.mtl"), MTL).unwrap();
    let at = DVec3::new(457_000.0, 5_428_000.0, 116.0);
    let at_map = room(at.to_array(), (at + DVec3::new(4.0, 3.0, 2.5)).to_array());
    std::fs::write(folder.path().join("m.obj"), &at_map).unwrap();
    assert_eq!(stderr(&make(&folder, &["a.rad", "m.obj"])), "");
    let stray = format!("{at_map}v 0 0 0\nv 1 0 0\nv 0 1 0\no left over\nf -3 -2 -1\n");
    std::fs::write(folder.path().join("m.obj"), stray).unwrap();
    let message = failure(&folder, &["b.rad", "m.obj"]);
    for part in ["\"left over\"", "5447", "steps of 0.5 m"] {
        assert!(message.contains(part), "{part} is missing in {message}");
    }
    // A tree a mile away does no harm.
    let tree = room([0.0; 3], [4.0, 3.0, 2.5])
        + "v 1600 0 0\nv 1601 0 0\nv 1600 1 0\no tree\nf -3 -2 -1\n";
    std::fs::write(folder.path().join("m.obj"), tree).unwrap();
    let output = genx(&folder, &["c.rad", "m.obj"]);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
}
