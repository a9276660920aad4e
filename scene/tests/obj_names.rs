//! Names of materials, objects and files, as people's programs write them.

mod common;

use common::{SQUARE, folder, load_text, write};
use scene::Rgb;
use scene::import::ImportedModel;

/// A square of four faces with these statements before each.
fn faces(before: [&str; 4]) -> String {
    let faces = ["f 1 2 3", "f 1 3 4", "f 3 2 1", "f 4 3 1"];
    let lines: Vec<&str> = before
        .into_iter()
        .zip(faces)
        .flat_map(<[&str; 2]>::from)
        .collect();
    lines.join("\n") + "\n"
}

fn with_mtl(mtl: &[u8], obj: &[u8]) -> ImportedModel {
    let folder = folder();
    write(&folder, "a.mtl", mtl);
    load_text(
        &folder,
        [format!("mtllib a.mtl\n{SQUARE}").as_bytes(), obj].concat(),
    )
    .unwrap()
}

/// Reflectances of the surfaces, red.
fn reds(model: &ImportedModel) -> Vec<f32> {
    let material = |s: &scene::Surface| &model.materials[s.material.index()];
    model
        .surfaces
        .iter()
        .map(|s| material(s).reflectance.x)
        .collect()
}

fn objects(model: &ImportedModel) -> Vec<u32> {
    model.surfaces.iter().map(|s| s.object.0).collect()
}

/// A number sign, a byte of an old encoding, a space at the end and a quote tell names apart.
#[test]
fn names_that_differ_in_any_byte_are_different() {
    for [one, other] in [
        [&b"Grey #1"[..], b"Grey #2"],
        [b"\xBA\xDA", b"\xB0\xD7"],
        [b"wall", b"wall "],
        [b"wall", b"\"wall\""],
        [b"#", b"##"],
    ] {
        let mtl = [
            b"newmtl ",
            one,
            b"\nKd 0.8\nnewmtl ",
            other,
            b"\r\nKd 0.1\r\n",
        ]
        .concat();
        let of = |name: &[u8], face: &[u8]| [b"o ", name, b"\nusemtl ", name, b"\n", face].concat();
        let obj = [of(other, b"f 1 2 3\n"), of(one, b"f 1 3 4\n")].concat();
        let model = with_mtl(&mtl, &obj);
        assert_eq!(reds(&model), [0.1, 0.8], "{model:?}");
        assert_eq!(objects(&model), [0, 1], "{model:?}");
        assert_ne!(model.objects[0], model.objects[1]);
        assert_eq!(model.report.warnings, [""; 0]);
    }
}

/// Where the library has no such name, what follows "#" is taken as a comment, and told.
#[test]
fn comments_behind_names_of_materials_are_found_by_the_library() {
    let mtl = b"newmtl red # of brick\nKd 0.5\nnewmtl grey\nKd 0.2\nnewmtl grey #1\nKd 0.3\n";
    let obj = faces([
        "usemtl red",
        "usemtl grey # dull",
        "usemtl grey #1 # new",
        "usemtl grey",
    ]);
    let model = with_mtl(mtl, obj.as_bytes());
    assert_eq!(reds(&model), [0.5, 0.2, 0.3, 0.2]);
    let told = &model.report.warnings;
    assert_eq!(told.len(), 3, "{told:?}");
    for (warning, parts) in told.iter().zip([
        ["\"red\"", "\"red # of brick\""],
        ["\"grey # dull\"", "\"grey\""],
        ["\"grey #1 # new\"", "\"grey #1\""],
    ]) {
        assert!(parts.iter().all(|part| warning.contains(part)), "{warning}");
    }
}

#[test]
fn spaces_behind_names_are_no_part_of_them_where_none_differs_by_them() {
    let model = with_mtl(
        b"newmtl wall \t\nKd 0.3\n",
        faces(["o floor  ", "usemtl wall", "o roof\t", ""]).as_bytes(),
    );
    assert_eq!(model.objects, ["floor", "roof"]);
    assert_eq!(reds(&model)[1..], [0.3, 0.3, 0.3]);
}

#[test]
fn of_two_definitions_the_first_counts_and_both_are_named() {
    let folder = folder();
    write(
        &folder,
        "a.mtl",
        "newmtl m\nKd 0.8\nnewmtl n\nKd 0.4\nnewmtl n\nKd 0.3\n",
    );
    write(&folder, "b.mtl", "\nnewmtl m\nKd 0.1\n");
    let obj = format!(
        "mtllib a.mtl b.mtl\nmtllib ./a.mtl\n{SQUARE}{}",
        faces(["usemtl m", "", "usemtl n", ""])
    );
    let model = load_text(&folder, obj).unwrap();
    assert_eq!(reds(&model), [0.8, 0.8, 0.4, 0.4]);
    let told = model.report.warnings.join("\n");
    assert!(
        told.contains("a.mtl line 1") && told.contains("b.mtl line 2"),
        "{told}"
    );
    assert!(
        told.contains("a.mtl line 3") && told.contains("a.mtl line 5"),
        "{told}"
    );
}

#[test]
fn a_file_without_objects_has_its_materials_as_objects() {
    let model = with_mtl(
        b"newmtl wall\nKd 0.5\n",
        faces(["", "usemtl wall", "usemtl ", "usemtl wall"]).as_bytes(),
    );
    assert_eq!(model.objects, ["default", "wall"]);
    assert_eq!(objects(&model), [0, 1, 0, 1]);
    assert!(
        model
            .report
            .warnings
            .iter()
            .all(|w| !w.contains("several places"))
    );
}

/// What comes before the first object is none of those that follow, even where a material has the name of one.
#[test]
fn faces_before_the_first_object_are_an_object_of_their_own() {
    let model = with_mtl(
        b"newmtl wall\nKd 0.5\n",
        faces(["usemtl wall", "o wall", "o roof", "o wall"]).as_bytes(),
    );
    assert_eq!(model.objects, ["unnamed", "wall", "roof"]);
    assert_eq!(objects(&model), [0, 1, 2, 1]);
}

#[test]
fn objects_in_several_places_are_told() {
    let model = with_mtl(b"", faces(["o a", "o b", "o a", "g a"]).as_bytes());
    assert_eq!(model.objects, ["a", "b"]);
    let told = model.report.warnings.join("\n");
    assert!(told.contains("\"a\" (lines 6 and 10)"), "{told}");
    assert!(!told.contains("\"b\""), "{told}");
}

/// Windows programs write names that other systems do not find.
#[test]
fn material_files_are_found_however_they_are_spelt() {
    for name in [
        "Sub\\Mat 1.MTL",
        "sub/mat 1.mtl",
        "\"sub/mat 1.mtl\"",
        ".\\sub\\mat 1.mtl",
        "./sub/mat 1.mtl   ",
        "C:\\models\\here.mtl",
        "sub/mat 1.mtl # the materials",
    ] {
        let folder = folder();
        std::fs::create_dir(folder.path().join("sub")).unwrap();
        let mtl = "newmtl m\nKd 0.3\n";
        let file = if name.contains("here") {
            "Here.mtl"
        } else {
            "sub/mat 1.mtl"
        };
        write(&folder, file, mtl);
        let model = load_text(
            &folder,
            format!("mtllib {name}\n{SQUARE}usemtl m\nf 1 2 3\n"),
        );
        let model = model.unwrap();
        assert_eq!(model.materials[0].reflectance, Rgb::splat(0.3), "{name}");
        assert_eq!(model.report.warnings, [""; 0], "{name}");
        assert!(
            model.files.iter().any(|path| path.ends_with(file)),
            "{:?}",
            model.files
        );
    }
}

#[test]
fn lines_end_in_carriage_returns_too() {
    let text = format!("mtllib a.mtl\n{SQUARE}o floor\nusemtl m\nf 1 2 \\\n3\nf 1 3 4\n");
    let mtl = "newmtl m\nKd 0.3\n";
    let models = ["\n", "\r\n", "\r"].map(|end| {
        let folder = folder();
        write(&folder, "a.mtl", mtl.replace('\n', end));
        load_text(&folder, text.replace('\n', end)).unwrap()
    });
    for model in &models {
        assert_eq!(model.surfaces, models[0].surfaces);
        assert_eq!(model.objects, ["floor"]);
        assert_eq!(reds(model), [0.3, 0.3]);
        assert_eq!(model.report.warnings, [""; 0]);
    }
}

#[test]
fn utf_16_is_named() {
    let text = format!("{SQUARE}f 1 2 3\n");
    for has_mark in [true, false] {
        let mark = has_mark.then_some(0xFEFF);
        let words = mark.into_iter().chain(text.encode_utf16());
        let bytes: Vec<u8> = words.flat_map(u16::to_le_bytes).collect();
        let error = load_text(&folder(), bytes).unwrap_err().to_string();
        assert!(
            error.contains("UTF-16") && error.contains("UTF-8"),
            "{error}"
        );
    }
}
