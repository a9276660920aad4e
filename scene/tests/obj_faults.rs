//! What the OBJ import refuses, and what it says.

mod common;

use common::{SQUARE, checked_message, folder, load_text, write};
use scene::obj::{ObjFault, load};

/// The error of an OBJ, and its message without the file's name.
fn refused(text: impl AsRef<[u8]>) -> (ObjFault, String) {
    let folder = folder();
    let error = load_text(&folder, text).unwrap_err();
    let message = checked_message(&error, &folder.path().join("a.obj"));
    (error.fault, message)
}

#[test]
fn nothing_but_degenerate_triangles_is_an_error() {
    let (fault, _) = refused(format!("{SQUARE}f 1 2 2\nf 1 1 1 1\n"));
    assert!(matches!(fault, ObjFault::NothingLeft { triangles: 3 }));
}

#[test]
fn reflectance_or_emission_out_of_range_names_file_and_material() {
    for (statement, word) in [
        ("Kd 0.5 -0.1 0.5", "green reflectance -0.1"),
        ("Kd nan 0 0", "reflectance NaN"),
        ("Kd 0 inf 0", "green reflectance inf"),
        ("Kd 0.5 0.5 0.5\nKe -1 0 0", "emission -1"),
        ("Kd 0.5 0.5 0.5\nKe 0 nan 0", "emission NaN"),
        ("Kd 0.5 0.5 0.5\nKe 0 0 1e39", "emission inf"),
    ] {
        let folder = folder();
        let mtl = write(&folder, "a.mtl", format!("newmtl the wall\n{statement}\n"));
        let error = load_text(
            &folder,
            format!("mtllib a.mtl\n{SQUARE}usemtl the wall\nf 1 2 3\n"),
        )
        .unwrap_err();
        let message = checked_message(&error, &mtl);
        assert!(
            message.contains("\"the wall\"") && message.contains(word),
            "{message}"
        );
        assert_eq!(
            message.contains("clamp it"),
            statement.starts_with("Kd") && !statement.contains("Ke")
        );
    }
}

#[test]
fn malformed_mtl_names_file_and_line() {
    for statement in [
        "Kd",
        "Kd 0.5 0.5",
        "Kd 0.1 0.2 0.3 0.4",
        "Kd red",
        "Kd 0.1 0.1 x",
        "Ke 1 2",
        "Kd spectral paint.rfl",
        "newmtl",
    ] {
        let folder = folder();
        let mtl = write(&folder, "a.mtl", format!("newmtl m\n{statement}\n"));
        let error = load_text(
            &folder,
            format!("mtllib a.mtl\n{SQUARE}usemtl m\nf 1 2 3\n"),
        );
        let message = checked_message(&error.unwrap_err(), &mtl);
        assert!(message.contains("line 2: "), "{message}");
    }
}

#[test]
fn missing_or_empty_file_and_folder_are_named() {
    let folder = folder();
    for path in [folder.path().join("none.obj"), folder.path().to_owned()] {
        let error = load(&path).unwrap_err();
        checked_message(&error, &path);
        assert!(matches!(error.fault, ObjFault::Io { .. }));
    }
    assert!(matches!(refused("").0, ObjFault::Empty));
}

#[test]
fn files_that_are_no_obj_are_told_so() {
    for bytes in [
        &b"\x89PNG\r\n\x1a\n\0\0\0"[..],
        b"hello\n",
        b"\n\n\n",
        b"# only a comment",
        b"solid cube\nfacet normal 0 0 1\n",
        b"\xFF\xFEv\0 \0",
        b"\xC0\xFF\xEE",
    ] {
        let (fault, message) = refused(bytes);
        assert!(matches!(fault, ObjFault::NotObj { .. }), "{message}");
    }
}

#[test]
fn vertices_without_faces_are_an_error() {
    for faces in ["", "f 1 2\n", "l 1 2 3\n", "p 1\n", "#f 1 2 3\n"] {
        let (fault, _) = refused(format!("{SQUARE}{faces}"));
        assert!(matches!(fault, ObjFault::NoFaces { vertices: 4 }));
    }
}

#[test]
fn index_out_of_range_names_line_index_and_limit() {
    for (corner, shown) in [
        ("5", 5),
        ("0", 0),
        ("-5", -5),
        ("9223372036854775807", i64::MAX),
        ("-9223372036854775808", i64::MIN),
        ("5/1/1", 5),
        ("4294967297", 1 << 32 | 1),
    ] {
        let (fault, message) = refused(format!("{SQUARE}f 1 2 3\nf 1 2 {corner}\n"));
        assert!(
            matches!(fault, ObjFault::VertexIndex { line: 6, index, vertices: 4 } if index == shown),
            "{message}"
        );
        assert!(message.contains("line 6") && message.contains("the file has 4"));
    }
    let (fault, _) = refused("f 1 2 3\n");
    assert!(matches!(fault, ObjFault::VertexIndex { vertices: 0, .. }));
}

#[test]
fn malformed_statements_name_their_line() {
    for statement in [
        "f 1 2 x",
        "f",
        "f 1 2 3.5",
        "f 1 2 /3",
        "f 1/1/1/1 2 3",
        "f 99999999999999999999 1 2",
        "v",
        "v 1 2",
        "v 1 2 x",
        "v 1,0 2,0 3,0",
        "v 1 2 1.#QNAN",
        "v 0x10 0 0",
        "v 1e 0 0",
        "v 1 2 3 0.5 0.5 red",
    ] {
        let (fault, message) = refused(format!("{SQUARE}f 1 2 3\n{statement}\n"));
        assert!(
            matches!(fault, ObjFault::Statement { line: 6, .. }),
            "{message}"
        );
    }
}

#[test]
fn coordinate_that_is_not_finite_names_its_vertex() {
    for value in [
        "nan",
        "inf",
        "-inf",
        "infinity",
        "1e999",
        "0 0 0",
        "1 0 1e-320",
    ] {
        // The last two give w = 0 and a quotient that overflows.
        let statement = match value {
            "0 0 0" => "v 1 1 1 0".to_owned(),
            "1 0 1e-320" => "v 1 0 0 1e-320".to_owned(),
            _ => format!("v 0 {value} 0"),
        };
        let (fault, message) = refused(format!("{SQUARE}{statement}\nf 1 2 3\n"));
        assert!(
            matches!(
                fault,
                ObjFault::NotFinite {
                    line: 5,
                    vertex: 5,
                    ..
                }
            ),
            "{message}"
        );
    }
}

#[test]
fn coordinate_over_single_precision_names_its_line() {
    for far in ["1e39", "-1e300", "1.7e308"] {
        let (fault, message) = refused(format!("{SQUARE}v {far} 0 0\nf 1 2 3\nf 1 2 5\n"));
        assert!(matches!(fault, ObjFault::Overflow { .. }), "{message}");
        assert!(message.contains("scale the model down"), "{message}");
    }
    // Where no face uses it, it does not matter.
    load_text(&folder(), format!("{SQUARE}v 1e300 0 0\nf 1 2 3\n")).unwrap();
}
