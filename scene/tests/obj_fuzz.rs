//! No input makes the OBJ import panic or return what is not a scene.

mod common;

use common::{folder, write};
use proptest::collection::vec;
use proptest::prelude::*;
use scene::obj::load;
use scene::{Material, Scene};
use tempfile::TempDir;

const OBJ: &str = "# room\nmtllib a.mtl\nv 0 0 0\nv 1.5 0 0 1\nv 1 1e0 0 0.1 0.2 0.3\nv 0 1 0\n\
    vt 0 0\nvn 0 0 1\no room\nusemtl wall\nf 1/1/1 2/1/1 3/1/1\nf 1 2 \\\n3 4\nl 1 2 3\n\
    g lamp\nusemtl lamp\nf -1//1 -2//1 -3//1\ns off\n";
const MTL: &str = "newmtl wall\nKd 0.5 0.25 0.1\nmap_Kd a.png\nnewmtl lamp\nKd 0\nKe 10 20 30\n";

/// Loads, and makes a scene of what was accepted. True if something was.
fn import(folder: &TempDir, obj: &[u8], mtl: &[u8]) -> bool {
    write(folder, "a.mtl", mtl);
    let Ok(model) = load(&write(folder, "a.obj", obj)) else {
        return false;
    };
    assert!(!model.surfaces.is_empty());
    assert!(
        model
            .materials
            .iter()
            .all(|m: &Material| m.validate().is_ok())
    );
    Scene::with_max_area(
        model.materials,
        model.objects,
        model.surfaces,
        f64::INFINITY,
        model.origin,
    )
    .unwrap();
    true
}

fn token() -> impl Strategy<Value = String> {
    let words = prop::sample::select(vec![
        "v",
        "vt",
        "vn",
        "vp",
        "f",
        "l",
        "p",
        "o",
        "g",
        "s",
        "usemtl",
        "mtllib",
        "newmtl",
        "Kd",
        "Ke",
        "map_Kd",
        "Ka",
        "Ks",
        "Ns",
        "illum",
        "d",
        "bump",
        "a.mtl",
        ".",
        "wall",
        "\n",
        "\n",
        "\n",
        "\n",
        "\n",
        "\\\n",
        "#",
        "\t",
        "\r",
        "\u{a0}",
        "\u{2003}o",
        "\u{feff}",
        "nan",
        "inf",
        "-inf",
        "1e308",
        "-1e308",
        "1e-320",
        "1e39",
        "0",
        "-0",
        "1",
        "2",
        "3",
        "-1",
        "-2",
        "-3",
        "1/1",
        "1//1",
        "-1/-1/-1",
        "1/-9",
        "2/9223372036854775807/-9223372036854775808",
        "9223372036854775807",
        "-9223372036854775808",
        "/",
        "//",
        "1/",
        "é",
        "spectral",
        "xyz",
    ]);
    prop_oneof![
        6 => words.prop_map(str::to_owned),
        2 => (-4_i32..5).prop_map(|n| n.to_string()),
        1 => any::<f64>().prop_map(|n| n.to_string()),
    ]
}

fn soup() -> impl Strategy<Value = String> {
    vec(token(), 0..120).prop_map(|tokens| tokens.join(" "))
}

/// Statements that are right more often than not, so that deep paths are reached.
fn statements() -> impl Strategy<Value = String> {
    let coordinate = || prop_oneof![8 => -3_i32..4, 1 => Just(i32::MAX)];
    let corner = prop_oneof![60 => 1_i32..5, 1 => -3_i32..8];
    let statement = prop_oneof![
        4 => (coordinate(), coordinate(), coordinate()).prop_map(|(x, y, z)| format!("v {x} {y} {z}")),
        3 => vec(corner, 0..6).prop_map(|corners| {
            corners.iter().fold("f".to_owned(), |f, c| format!("{f} {c}"))
        }),
        1 => prop::sample::select(vec!["usemtl wall", "usemtl lamp", "usemtl no", "o a", "g", "g a"])
            .prop_map(str::to_owned),
    ];
    vec(statement, 0..40).prop_map(|lines| {
        format!(
            "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n{}\n",
            lines.join("\n")
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn random_bytes_never_panic(obj in vec(any::<u8>(), 0..400), mtl in vec(any::<u8>(), 0..200)) {
        import(&folder(), &obj, MTL.as_bytes());
        import(&folder(), OBJ.as_bytes(), &mtl);
    }

    #[test]
    fn random_tokens_never_panic(obj in soup(), mtl in soup()) {
        let folder = folder();
        import(&folder, obj.as_bytes(), mtl.as_bytes());
        import(&folder, format!("{OBJ}{obj}").as_bytes(), MTL.as_bytes());
        import(&folder, OBJ.as_bytes(), format!("{MTL}{mtl}").as_bytes());
    }

    #[test]
    fn random_statements_never_panic(obj in statements()) {
        import(&folder(), obj.as_bytes(), MTL.as_bytes());
    }

    #[test]
    fn random_changes_to_a_valid_file_never_panic(
        changes in vec((any::<prop::sample::Index>(), any::<u8>()), 1..6)
    ) {
        let (mut obj, mut mtl) = (OBJ.as_bytes().to_vec(), MTL.as_bytes().to_vec());
        for (at, byte) in &changes {
            *at.get_mut(&mut obj) = *byte;
            *at.get_mut(&mut mtl) = *byte;
        }
        let folder = folder();
        import(&folder, &obj, MTL.as_bytes());
        import(&folder, OBJ.as_bytes(), &mtl);
    }
}

#[test]
fn truncation_at_every_length_never_panics() {
    let folder = folder();
    assert!(import(&folder, OBJ.as_bytes(), MTL.as_bytes()));
    for length in 0..OBJ.len() {
        import(&folder, &OBJ.as_bytes()[..length], MTL.as_bytes());
    }
    for length in 0..MTL.len() {
        import(&folder, OBJ.as_bytes(), &MTL.as_bytes()[..length]);
    }
}

#[test]
fn inputs_that_make_tobj_panic_are_stopped_before_it() {
    let folder = folder();
    // A colour of other than three numbers; a texture or normal index far below zero.
    assert!(!import(
        &folder,
        OBJ.as_bytes(),
        b"newmtl wall\nKd 0.5 0.5\n"
    ));
    for face in ["f 1/-9 2/-9 3/-9", "f 1//-9 2//-9 3//-9"] {
        let obj = format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\n{face}\n");
        assert!(import(&folder, obj.as_bytes(), b""));
    }
}
