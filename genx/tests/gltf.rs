//! glTF files at the command line.

mod common;

use common::program::{failure, files, folder, load, make, stderr, stdout};
use scene::{Scene, Surface};
use tempfile::TempDir;

/// What names may hold: a line of its own, and the start of an escape sequence.
const FORGED: &str = r"a\n        1  1.0e0  forged\u001b[31m";

/// A square of 1 m^2 with texture coordinates, with a light above it, and a picture of a black texel left of a white one.
fn parts() -> (String, Vec<u8>) {
    let corners = [[0.0f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let mut buffer: Vec<u8> = corners
        .iter()
        .flat_map(|&[x, y]| [x, y, 0.0])
        .flat_map(f32::to_le_bytes)
        .collect();
    buffer.extend(corners.iter().flatten().flat_map(|v| v.to_le_bytes()));
    buffer.extend([0, 1, 2, 0, 2, 3].map(|k: u16| k.to_le_bytes()).concat());
    let picture = buffer.len();
    buffer.extend(bmp());
    let length = buffer.len();
    let json = format!(
        r#"{{"asset": {{"version": "2.0"}}, "buffers": [{{"byteLength": {length} URI}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 48}}, {{"buffer": 0, "byteOffset": 48, "byteLength": 32}},
            {{"buffer": 0, "byteOffset": 80, "byteLength": 12}},
            {{"buffer": 0, "byteOffset": {picture}, "byteLength": {}}}],
        "accessors": [
            {{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 4, "min": [0, 0, 0], "max": [1, 1, 0]}},
            {{"bufferView": 1, "componentType": 5126, "type": "VEC2", "count": 4}},
            {{"bufferView": 2, "componentType": 5123, "type": "SCALAR", "count": 6}}],
        "images": [{{"bufferView": 3}}], "textures": [{{"source": 0}}],
        "materials": [{{"name": "paint", "pbrMetallicRoughness": {{"metallicFactor": 0 TEXTURE}}}}],
        "meshes": [{{"primitives": [{{"attributes": {{"POSITION": 0, "TEXCOORD_0": 1}}, "indices": 2, "material": 0}}]}}],
        "extensions": {{"KHR_lights_punctual": {{"lights": [{{"type": "point", "intensity": 2}}]}}}},
        "nodes": [{{"mesh": 0, "name": "NAME"}},
            {{"name": "bulb", "translation": [0.5, 0.5, 1], "extensions": {{"KHR_lights_punctual": {{"light": 0}}}}}}]}}"#,
        length - picture
    );
    (json, buffer)
}

/// An uncompressed picture (Windows bitmap of 24 bits).
fn bmp() -> Vec<u8> {
    let mut file = b"BM".to_vec();
    for number in [62u32, 0, 54, 40, 2, 1] {
        file.extend(number.to_le_bytes());
    }
    file.extend([1, 0, 24, 0]);
    for number in [0u32, 8, 0, 0, 0, 0] {
        file.extend(number.to_le_bytes());
    }
    file.extend([0, 0, 0, 255, 255, 255, 0, 0]);
    file
}

const TEXTURED: &str =
    r#", "baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": {"index": 0}"#;

/// Writes the square as a binary file.
fn write(folder: &TempDir, name: &str, of_node: &str, material: &str) {
    let (json, buffer) = parts();
    let json = json
        .replace("URI", "")
        .replace("NAME", of_node)
        .replace("TEXTURE", material);
    std::fs::write(folder.path().join(name), glb(&json, &buffer)).unwrap();
}

fn glb(json: &str, buffer: &[u8]) -> Vec<u8> {
    let padded = |bytes: &[u8], with| {
        let mut bytes = bytes.to_vec();
        bytes.resize(bytes.len().next_multiple_of(4), with);
        bytes
    };
    let (json, buffer) = (padded(json.as_bytes(), b' '), padded(buffer, 0));
    let number = |number: usize| (number as u32).to_le_bytes().to_vec();
    let length = 12 + 8 + json.len() + 8 + buffer.len();
    [
        b"glTF".to_vec(),
        number(2),
        number(length),
        number(json.len()),
        b"JSON".to_vec(),
        json,
        number(buffer.len()),
        b"BIN\0".to_vec(),
        buffer,
    ]
    .concat()
}

/// The surfaces of an object.
fn of_object<'s>(scene: &'s Scene, name: &str) -> Vec<&'s Surface> {
    let surfaces = scene.surfaces().iter();
    surfaces
        .filter(|s| scene.object(s.object) == name)
        .collect()
}

/// Corners are f32: near 1, of triangles of half a radius of 1 cm, each side is wrong by this share of it at most.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64 / 0.01;

#[test]
fn the_light_radius_changes_the_lamps_area_and_not_its_power() {
    let folder = folder();
    write(&folder, "m.glb", "square", "");
    let made = |more: &[&str]| {
        make(
            &folder,
            &[&["a.rad", "m.glb", "--max-area", "inf"], more].concat(),
        );
        let scene = load(&folder, "a.rad");
        let area: f64 = of_object(&scene, "bulb")
            .into_iter()
            .map(Surface::area)
            .sum();
        (area, scene.emitted_power().y)
    };
    let expected = 4.0 * std::f64::consts::PI * 2.0;
    for (more, radius) in [(&[][..], 0.01f64), (&["--light-radius", "0.05"], 0.05)] {
        let (area, power) = made(more);
        let sphere = 4.0 * std::f64::consts::PI * radius.powi(2);
        assert!(
            (area - sphere).abs() <= ROUNDING * sphere,
            "{area} {sphere}"
        );
        assert!(
            (power - expected).abs() <= ROUNDING * expected,
            "{power} {expected}"
        );
    }
}

#[test]
fn a_light_radius_without_such_lights_is_told() {
    let folder = folder();
    std::fs::write(
        folder.path().join("m.obj"),
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
    )
    .unwrap();
    for model in ["m.obj", "1"] {
        let said = stderr(&make(&folder, &["a.rad", model, "--light-radius", "0.1"]));
        assert!(said.contains("--light-radius changes nothing"), "{said}");
    }
    write(&folder, "m.glb", "square", "");
    let said = stderr(&make(&folder, &["a.rad", "m.glb", "--light-radius", "0.1"]));
    assert!(!said.contains("changes nothing"), "{said}");
}

#[test]
fn names_of_files_end_in_any_case() {
    let folder = folder();
    write(&folder, "m.GLB", "square", "");
    let (json, buffer) = parts();
    let json = json
        .replace("URI", r#", "uri": "m.bin""#)
        .replace("TEXTURE", "");
    std::fs::write(folder.path().join("m.Gltf"), json.replace("NAME", "square")).unwrap();
    std::fs::write(folder.path().join("m.bin"), buffer).unwrap();
    make(&folder, &["a.rad", "m.GLB"]);
    make(&folder, &["b.rad", "m.Gltf"]);
    assert_eq!(load(&folder, "a.rad"), load(&folder, "b.rad"));
    let message = failure(&folder, &["m.bin", "m.Gltf"]);
    assert!(message.contains("OUT is a file of the model"), "{message}");
}

/// Of the square's triangles a quarter and three quarters are white: 0.5 of a base colour of 0.5.
#[test]
fn the_list_has_one_line_a_name_with_means_by_area() {
    let folder = folder();
    write(&folder, "m.glb", "square", TEXTURED);
    let text = stdout(&make(
        &folder,
        &["a.rad", "m.glb", "--list", "--max-area", "inf"],
    ));
    assert_eq!(load(&folder, "a.rad").materials().len(), 3);
    let lines = |name: &str| -> Vec<Vec<&str>> {
        let lines = text
            .lines()
            .filter(|line| line.ends_with(&format!("  {name}")));
        lines
            .map(|line| line.split_whitespace().collect())
            .collect()
    };
    assert_eq!(
        lines("paint"),
        [["2", "1.000000e0", "~0.25", "0", "paint"]],
        "{text}"
    );
    assert_eq!(lines("square"), [["2", "1.000000e0", "square"]], "{text}");
    assert_eq!(lines("bulb").len(), 1, "{text}");
    let lamp = &lines("light bulb")[0];
    assert_eq!(lamp[0], "80", "{text}");
    assert_eq!(lamp[2], "0", "{text}");
}

#[test]
fn white_that_is_given_a_reflectance_is_not_told() {
    let folder = folder();
    write(&folder, "m.glb", "square", "");
    let said = |more: &[&str]| stderr(&make(&folder, &[&["a.rad", "m.glb"], more].concat()));
    assert!(said(&[]).contains("its base colour 1 1 1 is taken as 0.95"));
    assert!(!said(&["--reflectance", "paint=0.5"]).contains("is taken as"));
    // Another one's is still told.
    assert!(said(&["--reflectance", "light bulb=0.5"]).contains("is taken as 0.95"));
}

#[test]
fn control_characters_of_names_are_escaped_wherever_they_are_printed() {
    let folder = folder();
    let is_clean = |text: &str| !text.chars().any(|c| c.is_control() && c != '\n');
    write(&folder, "m.glb", FORGED, "");
    let output = make(&folder, &["a.rad", "m.glb", "--list"]);
    let (text, said) = (stdout(&output), stderr(&output));
    assert!(is_clean(&text) && is_clean(&said), "{text}{said}");
    assert!(
        text.contains(r"a\n        1  1.0e0  forged\u{1b}[31m"),
        "{text}"
    );
    assert!(
        !text.lines().any(|line| line.ends_with("  forged")),
        "{text}"
    );
    // The name of a material, in a warning, and of a node, in an error.
    let (json, buffer) = parts();
    let json = json.replace("URI", "").replace("TEXTURE", "");
    let named = json.replace("paint", FORGED);
    std::fs::write(folder.path().join("n.glb"), glb(&named, &buffer)).unwrap();
    let said = stderr(&make(&folder, &["a.rad", "n.glb"]));
    assert!(is_clean(&said) && said.contains(r"\u{1b}"), "{said}");
    assert!(
        said.lines().all(|line| line.starts_with("genx: warning: ")),
        "{said}"
    );
    let broken = json.replace(
        r#""name": "NAME""#,
        r#""name": "NAME", "rotation": [0, 0, 0, 0]"#,
    );
    let broken = broken.replace("NAME", FORGED);
    std::fs::write(folder.path().join("o.glb"), glb(&broken, &buffer)).unwrap();
    let message = failure(&folder, &["b.rad", "o.glb"]);
    assert!(
        is_clean(&message) && message.lines().count() == 1,
        "{message}"
    );
}

#[test]
fn bad_gltf_files_fail_and_leave_nothing() {
    let folder = folder();
    let (json, buffer) = parts();
    let json = json
        .replace("URI", "")
        .replace("NAME", "square")
        .replace("TEXTURE", "");
    let whole = glb(&json, &buffer);
    let of_nowhere = json.replace(r#""byteLength": 48"#, r#""byteLength": 48000"#);
    for (name, contents) in [
        ("empty.glb", vec![]),
        ("cut.glb", whole[..whole.len() - 9].to_vec()),
        ("text.gltf", b"this is a letter".to_vec()),
        ("view.glb", glb(&of_nowhere, &buffer)),
        (
            "light.glb",
            glb(
                &json.replace(r#""intensity": 2"#, r#""intensity": -2"#),
                &buffer,
            ),
        ),
    ] {
        std::fs::write(folder.path().join(name), contents).unwrap();
        let message = failure(&folder, &["a.rad", name]);
        assert!(message.contains(name), "{message}");
    }
    let message = failure(&folder, &["a.rad", "missing.glb"]);
    assert!(message.contains("missing.glb"), "{message}");
    write(&folder, "m.glb", "square", "");
    let message = failure(&folder, &["a.rad", "m.glb", "--light-radius", "1e30"]);
    assert!(
        message.contains("light \"bulb\"") && message.contains("1e30"),
        "{message}"
    );
    assert!(!files(folder.path()).contains(&"a.rad".to_owned()));
}

#[test]
fn without_light_both_formats_words_for_it_are_told() {
    let folder = folder();
    let (json, buffer) = parts();
    let dark = json.replace("URI", "").replace("TEXTURE", "");
    let dark = dark.replace(r#""intensity": 2"#, r#""intensity": 0"#);
    std::fs::write(folder.path().join("m.glb"), glb(&dark, &buffer)).unwrap();
    let said = stderr(&make(&folder, &["a.rad", "m.glb"]));
    assert!(said.contains("MTL: Ke, glTF: emissiveFactor"), "{said}");
}
