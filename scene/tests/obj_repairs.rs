//! What is mended on import: faces that are wound the wrong way, and faces that are there twice.

mod common;

use common::{SQUARE, folder, load_text, write};
use scene::import::{ImportOptions, ImportedModel, Orient};
use scene::obj::load_with;
use scene::weld::places;

/// Three upward squares, the last of which is wound downwards; all normals are up.
const TURNED: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\nv 3 0 0\nv 3 1 0\nvn 0 0 1\n\
    f 1//1 2//1 3//1 4//1\nf 2//1 5//1 6//1 3//1\nf 5//1 6//1 8//1 7//1\n";

fn oriented(text: &str, orient: Orient) -> ImportedModel {
    let folder = folder();
    let path = write(&folder, "a.obj", text);
    let options = ImportOptions {
        orient,
        ..ImportOptions::default()
    };
    load_with(&path, &options).unwrap()
}

/// Which surfaces face up.
fn are_up(model: &ImportedModel) -> Vec<bool> {
    model.surfaces.iter().map(|s| s.normal().z > 0.0).collect()
}

#[test]
fn a_minority_that_is_wound_against_its_normals_is_turned() {
    let up = [true; 4];
    for (orient, last) in [
        (Orient::Auto, true),
        (Orient::Normals, true),
        (Orient::Winding, false),
    ] {
        let model = oriented(TURNED, orient);
        assert_eq!(are_up(&model)[..4], up);
        assert_eq!(are_up(&model)[4..], [last; 2], "{orient:?}");
        assert_eq!(model.report.turned, if last { 2 } else { 0 });
        let told = model.report.warnings.join("\n");
        assert_eq!(
            told.contains("2 triangles, 33 percent of the area"),
            last,
            "{told}"
        );
    }
    // A model that is wound clockwise throughout is told, and left, unless its normals are asked for.
    let clockwise = TURNED.replace("vn 0 0 1", "vn 0 0 -1");
    let model = oriented(&clockwise, Orient::Auto);
    assert_eq!(are_up(&model), are_up(&oriented(TURNED, Orient::Winding)));
    assert!(
        model
            .report
            .warnings
            .join("\n")
            .contains("--orient normals")
    );
    assert_eq!(are_up(&oriented(&clockwise, Orient::Normals)), [false; 6]);
}

/// Both sides of a sheet with the normals of one: turned, one side would be there twice and the other not at all.
#[test]
fn sheets_keep_both_sides() {
    let sheet = format!("{TURNED}f 4//1 3//1 2//1 1//1\n");
    let model = oriented(&sheet, Orient::Normals);
    assert_eq!(
        are_up(&model),
        [true, true, true, true, true, true, false, false]
    );
    assert_eq!(model.report.repeated_dropped, 0);
}

/// Which of two triangles in one place stays does not depend on which comes first.
#[test]
fn of_triangles_in_one_place_the_lamp_stays_in_any_order() {
    let folder = folder();
    write(
        &folder,
        "a.mtl",
        "newmtl a\nKd 0.5\nnewmtl z\nKd 0.2\nKe 9 9 9\nnewmtl b\nKd 0.1\n",
    );
    let faces = [
        "o x\nusemtl a\nf 1 2 3\n",
        "o y\nusemtl z\nf 2 3 1\n",
        "o w\nusemtl b\nf 3 1 2\n",
    ];
    let dull = ["o x\nusemtl a\nf 1 3 4\n", "o w\nusemtl b\nf 3 4 1\n"];
    let mut seen = Vec::new();
    for order in [[0, 1, 2], [2, 1, 0], [1, 2, 0]] {
        let mut text = format!("mtllib a.mtl\n{SQUARE}");
        text.extend(order.map(|k| faces[k]));
        text.extend([order[0] % 2, 1 - order[0] % 2].map(|k| dull[k]));
        let model = load_text(&folder, text).unwrap();
        let mut left: Vec<_> = model
            .surfaces
            .iter()
            .map(|s| {
                let material = &model.materials[s.material.index()].name;
                (
                    places(s.corners),
                    material.clone(),
                    model.objects[s.object.index()].clone(),
                )
            })
            .collect();
        left.sort();
        assert_eq!(left.len(), 2);
        assert!(
            left.iter()
                .any(|(_, material, object)| material == "z" && object == "y")
        );
        assert!(
            left.iter()
                .any(|(_, material, object)| material == "a" && object == "x")
        );
        seen.push(left);
        let told = model.report.warnings.join("\n");
        assert!(
            told.contains("3 of 5 triangles lie where another one lies"),
            "{told}"
        );
    }
    assert!(seen.iter().all(|left| *left == seen[0]));
}
