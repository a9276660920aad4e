//! What is taken from OBJ and MTL files.

mod common;

use common::{SQUARE, folder, load_text, write};
use glam::DVec3;
use scene::import::{ImportOptions, ImportedModel};
use scene::obj::{ObjError, load, load_with};
use scene::{Rgb, Scene};

fn model(text: &str) -> ImportedModel {
    load_text(&folder(), text).unwrap()
}

fn with_mtl(obj: &str, mtl: &str) -> Result<ImportedModel, ObjError> {
    let folder = folder();
    write(&folder, "a.mtl", mtl);
    load_text(&folder, format!("mtllib a.mtl\n{SQUARE}{obj}"))
}

/// Corners of all triangles in the file's coordinates. Small binary fractions are exact.
fn triangles(model: &ImportedModel) -> Vec<[[f64; 3]; 3]> {
    let original = |p: glam::Vec3| (p.as_dvec3() + model.origin).to_array();
    model
        .surfaces
        .iter()
        .map(|s| s.corners.map(original))
        .collect()
}

#[test]
fn triangles_come_in_file_order_whatever_their_group_and_material() {
    let folder = folder();
    write(
        &folder,
        "a.mtl",
        "newmtl red\nKd 0.5 0 0\nnewmtl lamp\nKd 0 0 0\nKe 10 20 30\n",
    );
    let model = load_text(
        &folder,
        format!(
            "mtllib a.mtl\n{SQUARE}o first\nusemtl red\nf 1 2 3\ng second\nusemtl lamp\nf 2 3 4\n\
             o first\nusemtl red\nf 3 4 1\nusemtl lamp\nf 4 1 2\n"
        ),
    )
    .unwrap();
    let p = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    assert_eq!(
        triangles(&model),
        [
            [p[0], p[1], p[2]],
            [p[1], p[2], p[3]],
            [p[2], p[3], p[0]],
            [p[3], p[0], p[1]]
        ]
    );
    assert_eq!(model.objects, ["first", "second"]);
    let objects: Vec<u32> = model.surfaces.iter().map(|s| s.object.0).collect();
    assert_eq!(objects, [0, 1, 0, 0]);
    let materials: Vec<u32> = model.surfaces.iter().map(|s| s.material.0).collect();
    assert_eq!(materials, [0, 1, 0, 1]);
    assert_eq!(model.materials[0].name, "red");
    assert_eq!(model.materials[0].reflectance, Rgb::new(0.5, 0.0, 0.0));
    assert_eq!(model.materials[1].emission, Rgb::new(10.0, 20.0, 30.0));
    assert_eq!(model.report.faces, 4);
    let [warning] = &model.report.warnings[..] else {
        panic!("{:?}", model.report.warnings)
    };
    assert!(warning.contains("\"first\" (lines 6 and 12)"), "{warning}");
}

#[test]
fn polygon_is_fanned_from_its_first_corner() {
    let model = model("v 0 0 0\nv 2 0 0\nv 3 1 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\nf 5 4 3 2 1\n");
    let p = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [3.0, 1.0, 0.0],
        [2.0, 2.0, 0.0],
        [0.0, 2.0, 0.0],
    ];
    assert_eq!(
        triangles(&model),
        [
            [p[0], p[1], p[2]],
            [p[0], p[2], p[3]],
            [p[0], p[3], p[4]],
            [p[4], p[3], p[2]],
            [p[4], p[2], p[1]],
            [p[4], p[1], p[0]]
        ]
    );
    assert_eq!((model.report.faces, model.report.polygons), (2, 2));
    assert_eq!(model.report.non_planar_polygons, 0);
}

#[test]
fn negative_indices_count_back_from_the_last_vertex_so_far() {
    let by_count = model(&format!("{SQUARE}f -4 -3 -2\nv 0 0 1\nf -5 -1 1\n"));
    let by_index = model(&format!("{SQUARE}f 1 2 3\nv 0 0 1\nf 1 5 1\n"));
    assert_eq!(triangles(&by_count), triangles(&by_index));
    // The second face has corner 1 twice.
    assert_eq!(by_count.report.degenerate_dropped, 1);
}

#[test]
fn faces_may_come_before_their_vertices() {
    assert_eq!(
        triangles(&model(&format!("g a\nf 1 2 3\ng b\n{SQUARE}"))),
        triangles(&model(&format!("{SQUARE}f 1 2 3\n")))
    );
}

#[test]
fn normals_and_texture_coordinates_change_nothing() {
    let plain = model(&format!("{SQUARE}f 1 2 3\nf 1 3 4\n"));
    for faces in [
        "vn 0 0 -1\nf 1//1 2//1 3//1\nf 1//1 3//1 4//1\n",
        "vt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1/1 3/1 4/1\n",
        // Indices that do not exist, one of which makes tobj overflow.
        "vt 0 0\nf 1/-9 2/99 3/1\nf 1 3 4\n",
        "f 1/1/1 2/2/2 3/3/3\nf 1/ 3// 4\n",
        "vn nonsense\nf 1 2 3\nf 1 3 4\n",
        "vn 0 0 1.#IND\nvt nan 0\nf 1/1/1 2/1/1 3/1/1\nf 1 3 4\n",
    ] {
        let other = model(&format!("{SQUARE}{faces}"));
        assert_eq!(other.surfaces, plain.surfaces, "{faces}");
    }
}

#[test]
fn odd_but_legal_spellings_are_read() {
    let plain = model(&format!("{SQUARE}f 1 2 3 4\n"));
    for text in [
        format!("{SQUARE}f 1 2 \\\n3 \\\n 4"),
        format!("{SQUARE}f 1 2 3 4 # a floor\n").replace('\n', "\r\n"),
        format!("\u{feff}# comment\n{SQUARE}  f\t1\t2  3 4"),
        "v 0 0 0 1.0\nv 2 0 0 2\nv 1 1 0 1 0.5 0\nv 0 1e0 0 # top\nf 1 2 3 4\ns off\nvp 1\n".into(),
    ] {
        assert_eq!(model(&text).surfaces, plain.surfaces, "{text}");
    }
}

#[test]
fn names_keep_spaces_and_odd_characters() {
    let folder = folder();
    write(&folder, "my file.mtl", "newmtl wei\u{df}#2 \\\nKd 0.25\n");
    let model = load_text(
        &folder,
        format!(
            "mtllib my file.mtl\n{SQUARE}\t o  the  floor \\ \nusemtl\twei\u{df}#2 \\\nf 1 2 3\n"
        ),
    )
    .unwrap();
    assert_eq!(model.objects, ["the  floor \\"]);
    assert_eq!(model.materials[0].name, "wei\u{df}#2 \\");
    // One number stands for three.
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.25));
    assert_eq!(model.report.warnings, [""; 0]);
}

#[test]
fn triangles_that_repeat_others_are_left_out_and_told() {
    // Both of the floor's triangles once more from other corners, one of them twice; the ceiling's
    // faces the other way and is none.
    let model = model(&format!(
        "{SQUARE}v 1 0 0\no floor\nusemtl m\nf 1 2 3 4\no rug\nf 3 4 1\nf 3 1 5\no mat\nf 1 3 4\no ceiling\nf 3 2 1\n"
    ));
    assert_eq!(model.objects, ["floor", "ceiling"]);
    assert_eq!(model.faces, [0, 1, 5]);
    assert_eq!(model.report.repeated_dropped, 3);
    let warning = model.report.warnings.last().unwrap();
    assert!(
        warning.contains("3 of 6 triangles")
            && warning.contains("line 10")
            && warning.contains("\"rug\""),
        "{warning}"
    );
    let all = model.report.warnings.join("\n");
    assert_eq!(all.matches("where another one lies").count(), 1, "{all}");
}

/// One reflectance for all that do not emit: what the file says of theirs does not matter.
#[test]
fn only_the_reflectance_that_is_used_is_judged() {
    let folder = folder();
    let obj = write(
        &folder,
        "a.obj",
        format!(
            "mtllib a.mtl\n{SQUARE}usemtl white\nf 1 2 3\nusemtl lamp\nf 1 3 4\nusemtl no\nf 1 2 4\n"
        ),
    );
    let mtl = |lamp: &str| {
        format!("newmtl white\nKd -1 1 1\nmap_Kd wood.png\nnewmtl lamp\nKd {lamp}\nKe 1 0 0\n")
    };
    write(&folder, "a.mtl", mtl("0.9"));
    let grey = ImportOptions {
        reflectance: Some(0.25),
        ..ImportOptions::default()
    };
    assert!(load(&obj).is_err());
    let model = load_with(&obj, &grey).unwrap();
    let reds: Vec<f32> = model.materials.iter().map(|m| m.reflectance.x).collect();
    assert_eq!(reds, [0.25, 0.9, 0.25]);
    let [warning] = &model.report.warnings[..] else {
        panic!("{:?}", model.report.warnings)
    };
    assert!(
        warning.contains("\"no\"") && warning.contains("0.25"),
        "{warning}"
    );
    write(&folder, "a.mtl", mtl("-1"));
    let error = load_with(&obj, &grey).unwrap_err();
    assert!(error.to_string().contains("\"lamp\""), "{error}");
}

#[test]
fn bytes_that_are_no_utf8_are_read_in_comments_and_names() {
    let folder = folder();
    let mut text = b"# caf\xE9\no caf\xE9\n".to_vec();
    text.extend(SQUARE.bytes());
    text.extend(b"f 1 2 3\n");
    let model = load_text(&folder, text).unwrap();
    assert_eq!(model.objects, ["caf\\xE9"]);
}

#[test]
fn several_material_files_may_stand_in_one_line() {
    let folder = folder();
    write(&folder, "a.mtl", "newmtl a\nKd 0.1 0.1 0.1\n");
    write(&folder, "b.mtl", "newmtl b\nKd 0.2 0.2 0.2\n");
    let model = load_text(
        &folder,
        format!("mtllib a.mtl b.mtl\n{SQUARE}usemtl b\nf 1 2 3\nusemtl a\nf 1 3 4\n"),
    )
    .unwrap();
    let reds: Vec<f32> = model.materials.iter().map(|m| m.reflectance.x).collect();
    assert_eq!(reds, [0.2, 0.1]);
}

#[test]
fn points_and_lines_are_counted_and_not_drawn() {
    let model = model(&format!(
        "{SQUARE}p 1 2\nl 1 2 3\nl 1 2 3 4\nf 1 2\nf 1 2 3\n"
    ));
    assert_eq!(model.surfaces.len(), 1);
    assert_eq!(model.report.points_and_lines_ignored, 4);
    assert_eq!(model.report.faces, 1);
    // A face that is none is likely to be a mistake.
    let warnings = model.report.warnings.join("\n");
    assert!(
        warnings.contains("1 of 2 faces have fewer than three corners (the first in line 8)"),
        "{warnings}"
    );
}

#[test]
fn non_planar_polygon_is_fanned_and_counted() {
    // Lifting one corner by h moves all corners of a square h/4 off the mean plane; the diagonal
    // is sqrt 2. So the limit of 1e-4 is reached at h = 5.66e-4.
    for (height, expected) in [(5.6e-4, 0), (5.7e-4, 1)] {
        let model = model(&format!(
            "v 0 0 0\nv 1 0 0\nv 1 1 {height}\nv 0 1 0\nf 1 2 3 4\n"
        ));
        assert_eq!(model.surfaces.len(), 2);
        assert_eq!(model.report.non_planar_polygons, expected);
        let warned = model.report.warnings.iter().any(|w| w.contains("planar"));
        assert_eq!(warned, expected == 1);
    }
}

/// Two triangles without area and a polygon of each kind: the concave one is cut by its ears, into as many triangles.
#[test]
fn faces_count_all_triangles_of_the_file_those_dropped_and_those_of_polygons() {
    let model = model(&format!(
        "{SQUARE}v 2 0 0\nv 0.5 0.1 0\n\
         f 1 2 2\n\
         f 1 2 3 4\n\
         f 1 2\n\
         f 1 2 5\n\
         f 2 3 4 1 6\n\
         f 1 2 3\n"
    ));
    assert_eq!(model.report.degenerate_dropped, 2);
    // 5 is where 2 is, and 7 where 1 is.
    assert_eq!(model.report.repeated_dropped, 2);
    assert_eq!(model.faces, [1, 2, 4, 6]);
    assert_eq!(model.surfaces.len(), model.faces.len());
    let first = triangles(&model)[0];
    assert_eq!(first, [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]);
}

#[test]
fn degenerate_triangles_are_dropped_counted_and_warned_of() {
    let model = model(&format!("{SQUARE}f 1 2 2\nf 1 2 3\nv 2 0 0\nf 1 2 5\n"));
    assert_eq!(model.surfaces.len(), 1);
    assert_eq!(model.report.degenerate_dropped, 2);
    let [_, warning] = &model.report.warnings[..] else {
        panic!("{:?}", model.report.warnings)
    };
    assert!(
        warning.contains("2 of 3 triangles") && warning.contains("line 5"),
        "{warning}"
    );
}

#[test]
fn missing_mtl_is_a_warning_and_grey() {
    let model = model(&format!("mtllib none.mtl\n{SQUARE}usemtl wall\nf 1 2 3\n"));
    assert_eq!(model.materials.len(), 1);
    assert_eq!(model.materials[0].name, "wall");
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.5));
    assert_eq!(model.materials[0].emission, Rgb::ZERO);
    let warnings = model.report.warnings.join("\n");
    assert!(
        warnings.contains("none.mtl") && warnings.contains("\"wall\""),
        "{warnings}"
    );
}

#[test]
fn missing_material_is_a_warning_and_grey_and_keeps_its_name() {
    let model = with_mtl(
        "usemtl no\nf 1 2 3\nf 1 3 4\nusemtl yes\nf 1 2 4\n",
        "newmtl yes\nKd 0.1 0.2 0.3\n",
    )
    .unwrap();
    let names: Vec<&str> = model.materials.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["no", "yes"]);
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.5));
    let [warning] = &model.report.warnings[..] else {
        panic!("{:?}", model.report.warnings)
    };
    assert!(
        warning.contains("\"no\"") && warning.contains("2 faces"),
        "{warning}"
    );
}

#[test]
fn faces_without_a_material_are_grey_and_warned_of() {
    let model = with_mtl("f 1 2 3\nusemtl m\nf 1 3 4\n", "newmtl m\nKd 0.1 0.1 0.1\n").unwrap();
    let reds: Vec<f32> = model
        .surfaces
        .iter()
        .map(|s| model.materials[s.material.index()].reflectance.x)
        .collect();
    assert_eq!(reds, [0.5, 0.1]);
    assert!(model.report.warnings[0].contains("1 faces have no material"));
}

#[test]
fn material_without_kd_is_grey_and_warned_of_and_still_emits() {
    let model = with_mtl("usemtl m\nf 1 2 3\n", "newmtl m\nKe 1 2 3\n").unwrap();
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.5));
    assert_eq!(model.materials[0].emission, Rgb::new(1.0, 2.0, 3.0));
    let warning = &model.report.warnings[0];
    assert!(
        warning.contains("a.mtl") && warning.contains("no Kd"),
        "{warning}"
    );
}

#[test]
fn texture_that_is_missing_is_warned_of() {
    let model = with_mtl(
        "usemtl m\nf 1 2 3\n",
        "newmtl m\nKd 0.8 0.8 0.8\nmap_Kd wood.png\n",
    );
    assert!(model.unwrap().report.warnings[0].contains("wood.png"));
}

#[test]
fn materials_that_no_face_uses_are_left_out_and_not_judged() {
    let model = with_mtl(
        "usemtl m\nf 1 2 3\n",
        "newmtl bad\nKd 1 1 1\nnewmtl m\nKd 0.1 0.1 0.1\n",
    )
    .unwrap();
    assert_eq!(model.materials.len(), 1);
}

#[cfg(unix)]
#[test]
fn material_file_that_is_a_device_or_a_folder_is_a_warning() {
    for name in ["/dev/zero", "/", "."] {
        let model = model(&format!("mtllib {name}\n{SQUARE}f 1 2 3\n"));
        assert!(model.report.warnings[0].contains("not a regular file"));
    }
}

#[test]
fn model_far_from_zero_keeps_its_shape() {
    // Single precision at 5e6 resolves 0.5; a shape of 0.01 would be lost without the origin.
    let model =
        model("v 5000000.01 -3e6 0\nv 5000000.02 -3e6 0\nv 5000000.01 -2999999.99 0\nf 1 2 3\n");
    // Doubles at 5e6 are 2^-30 apart, so sides of 0.01 are true to 2^-30 / 0.01 = 1e-7, and the
    // area, a product of two, to 2e-7; single precision near the origin adds less.
    let area = model.surfaces[0].area();
    assert!((area / 5e-5 - 1.0).abs() < 4e-7, "{area:e}");
    assert!(model.origin.distance(DVec3::new(5e6, -3e6, 0.0)) < 0.1);
}

#[test]
fn model_at_or_around_zero_keeps_its_coordinates() {
    for text in [
        format!("{SQUARE}f 1 2 3\n"),
        "v 0 0 0\nv 0.556 0 0\nv 0 0.5488 0.5592\nf 1 2 3\n".into(),
        "v -3 -1 0\nv 5 -1 0\nv 0 7 0\nf 1 2 3\n".into(),
        "v 0 0 0\nv 1e-20 0 0\nv 0 1e-20 0\nf 1 2 3\n".into(),
        "v 0 0 0\nv 1e38 0 0\nv 0 1e38 0\nf 1 2 3\n".into(),
    ] {
        assert_eq!(model(&text).origin, DVec3::ZERO, "{text}");
    }
}

#[test]
fn no_coordinate_is_over_the_grid_that_the_origin_is_rounded_to() {
    // By axis: half a grid step from rounding the origin and half the extent, which is at most a
    // step. The extent is 1, so that the step is 2.
    for offset in [0.0, 0.3, 0.5, 0.99, 1.0, 1.01, 7.77, 1234.5, -1e6] {
        let [a, b] = [offset, offset + 1.0];
        let model = model(&format!("v {a} 0 {a}\nv {b} 0 {a}\nv {a} 1 {b}\nf 1 2 3\n"));
        for corner in model.surfaces[0].corners {
            assert!(corner.abs().max_element() <= 2.0, "{offset}: {corner}");
        }
        assert_eq!(model.origin % 2.0, DVec3::ZERO, "{offset}");
    }
}

#[test]
fn imported_model_makes_a_scene_with_a_patch_a_triangle() {
    let model = model(&format!("{SQUARE}f 1 2 3 4\nf 4 3 2 1\n"));
    let triangles = triangles(&model);
    let scene = Scene::with_max_area(
        model.materials,
        model.objects,
        model.surfaces,
        f64::INFINITY,
        model.origin,
    )
    .unwrap();
    assert_eq!(scene.patch_count(), 4);
    for (patch, expected) in triangles.into_iter().enumerate() {
        let centroid = expected.map(DVec3::from).into_iter().sum::<DVec3>() / 3.0;
        let found = scene.patch(scene::PatchId(patch as u32)).centroid();
        // Rotating the corners changes the order of the sum: rounding of f64 at 1.
        assert!((found - centroid).abs().max_element() <= 4.0 * f64::EPSILON);
    }
}
