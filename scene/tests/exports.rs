//! Exports hold what the scene holds, read by independent code.

mod common;

use std::path::Path;

use common::{
    bits, checked_message, folder, listing, material, small_scene, small_solution, surface,
};
use glam::{DVec3, Vec3};
use proptest::prelude::*;
use scene::export::{csv, glb, obj, ply};
use scene::file::{FileError, FileFault};
use scene::{PatchId, Rgb, Scene, SceneError, Solution};

/// One colour per patch, all different, both ends of the range among them.
fn colors(scene: &Scene) -> Vec<[u8; 3]> {
    (0..scene.patch_count())
        .map(|p| [0, 255, 20 * p as u8])
        .collect()
}

fn exported(save: impl FnOnce(&Path) -> Result<(), FileError>) -> Vec<u8> {
    let folder = folder();
    let path = folder.path().join("a.out");
    save(&path).unwrap();
    std::fs::read(path).unwrap()
}

/// The fields of each row, quotes undone.
fn rows(csv: &str) -> Vec<Vec<String>> {
    let (mut rows, mut row, mut field) = (Vec::new(), Vec::new(), String::new());
    let mut is_quoted = false;
    let mut characters = csv.chars().peekable();
    while let Some(c) = characters.next() {
        match c {
            '"' if is_quoted && characters.peek() == Some(&'"') => {
                field.push('"');
                characters.next();
            }
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => row.push(std::mem::take(&mut field)),
            '\n' if !is_quoted => {
                row.push(std::mem::take(&mut field));
                rows.push(std::mem::take(&mut row));
            }
            _ => field.push(c),
        }
    }
    assert!(field.is_empty() && row.is_empty(), "the last line ends");
    rows
}

fn three<T: std::str::FromStr>(fields: &[String]) -> [T; 3] {
    [0, 1, 2].map(|i| fields[i].parse().ok().unwrap())
}

#[test]
fn csv_holds_every_value_to_the_last_bit() {
    let scene = small_scene();
    let solution = small_solution(&scene);
    let text = String::from_utf8(exported(|p| csv::save(p, &scene, Some(&solution)))).unwrap();
    let rows = rows(&text);
    assert_eq!(
        text.lines().next().unwrap(),
        "patch,surface,material,cx,cy,cz,area,nx,ny,nz,rho_r,rho_g,rho_b,emission_r,emission_g,emission_b,irradiance_r,irradiance_g,irradiance_b,radiosity_r,radiosity_g,radiosity_b,face,object,inside,error"
    );
    assert_eq!(rows.len(), 1 + 5);
    for (index, row) in rows[1..].iter().enumerate() {
        assert_eq!(row.len(), 26);
        let patch = scene.patch(PatchId(index as u32));
        let material = scene.patch_material(PatchId(index as u32));
        assert_eq!(row[0], index.to_string());
        assert_eq!(row[1], patch.surface.0.to_string());
        assert_eq!(row[2], material.name);
        let centroid = patch.centroid() + DVec3::new(16.0, -8.0, 0.0);
        assert_eq!(
            three::<f64>(&row[3..6]).map(f64::to_bits),
            centroid.to_array().map(f64::to_bits)
        );
        assert_eq!(
            row[6].parse::<f64>().unwrap().to_bits(),
            patch.area.to_bits()
        );
        let normal = scene.surface(patch.surface).normal().as_vec3();
        let irradiance = solution.mean_irradiance(&scene)[index];
        let radiosity = material.emission + material.reflectance * irradiance;
        let read: Vec<Rgb> = row[7..22]
            .chunks(3)
            .map(|f| Rgb::from(three::<f32>(f)))
            .collect();
        assert_eq!(
            bits(&read),
            bits(&[
                normal,
                material.reflectance,
                material.emission,
                irradiance,
                radiosity
            ])
        );
        let is_wall = patch.surface.0 == 0;
        assert_eq!(row[22], if is_wall { "3" } else { "7" });
        assert_eq!(row[23], if is_wall { "room" } else { "lamp" });
        let is_inside = scene.inside().contains(&PatchId(index as u32));
        assert_eq!(row[24], if is_inside { "1" } else { "0" });
        let error = solution.error().map(|error| error[index].to_string());
        assert_eq!(row[25], error.unwrap_or_default());
    }
}

#[test]
fn csv_of_an_unsolved_scene_has_no_irradiance_and_its_own_emission() {
    let scene = small_scene();
    let text = String::from_utf8(exported(|p| csv::save(p, &scene, None))).unwrap();
    for row in &rows(&text)[1..] {
        assert_eq!(row[16..19], ["0", "0", "0"]);
        assert_eq!(row[19..22], row[13..16]);
    }
}

#[test]
fn csv_refuses_a_solution_of_another_scene() {
    let scene = small_scene();
    let mut solution = small_solution(&scene);
    solution.irradiance.pop();
    let folder = folder();
    let path = folder.path().join("a.csv");
    let error = csv::save(&path, &scene, Some(&solution)).unwrap_err();
    checked_message(&error, &path);
    assert!(matches!(
        error.fault,
        FileFault::Scene(SceneError::SolutionLength {
            values: 4,
            patches: 5
        })
    ));
    assert_eq!(listing(folder.path()), [""; 0]);
}

proptest! {
    #[test]
    fn csv_keeps_any_name_and_any_number(
        name in "[a,\"\n\r ;é]{0,6}",
        irradiance in (0..f32::MAX.to_bits()).prop_map(f32::from_bits),
        origin in -1e15_f64..1e15,
    ) {
        let scene = Scene::new(
            vec![material(&name, [0.5; 3], [0.0; 3])],
            vec![name.clone()],
            vec![surface([[0.0; 3], [0.3, 0.0, 0.0], [0.0, 0.7, 0.0]], 0, 0)],
            &[0],
            DVec3::splat(origin),
        )
        .unwrap();
        let solution = Solution { irradiance: vec![Rgb::splat(irradiance)], ..Solution::dark(&scene) };
        let text = String::from_utf8(exported(|p| csv::save(p, &scene, Some(&solution)))).unwrap();
        let rows = rows(&text);
        prop_assert_eq!(rows.len(), 2);
        prop_assert_eq!([&rows[1][2], &rows[1][23]], [&name; 2]);
        prop_assert_eq!(rows[1][17].parse::<f32>().unwrap().to_bits(), irradiance.to_bits());
        let centroid = scene.patch(PatchId(0)).centroid().y + origin;
        prop_assert_eq!(rows[1][4].parse::<f64>().unwrap().to_bits(), centroid.to_bits());
    }
}

fn f64_at(bytes: &[u8], at: usize) -> f64 {
    f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap())
}

fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap())
}

#[test]
fn ply_holds_a_coloured_triangle_a_patch() {
    let scene = small_scene();
    let colors = colors(&scene);
    let bytes = exported(|p| ply::save(p, &scene, &colors));
    let mark = b"end_header\n";
    let start = bytes.windows(mark.len()).position(|w| w == mark).unwrap() + mark.len();
    let header = std::str::from_utf8(&bytes[..start]).unwrap();
    assert_eq!(
        header.lines().collect::<Vec<_>>(),
        [
            "ply",
            "format binary_little_endian 1.0",
            "element vertex 15",
            "property double x",
            "property double y",
            "property double z",
            "property uchar red",
            "property uchar green",
            "property uchar blue",
            "element face 5",
            "property list uchar int vertex_indices",
            "end_header"
        ]
    );
    let (vertices, faces) = bytes[start..].split_at(15 * 27);
    assert_eq!(faces.len(), 5 * 13);
    for (index, face) in faces.chunks(13).enumerate() {
        assert_eq!(face[0], 3);
        let patch = scene.patch(PatchId(index as u32));
        for (k, corner) in patch.corners.into_iter().enumerate() {
            let vertex = &vertices[27 * u32_at(face, 1 + 4 * k) as usize..][..27];
            let position = DVec3::new(f64_at(vertex, 0), f64_at(vertex, 8), f64_at(vertex, 16));
            assert_eq!(position, corner.as_dvec3() + DVec3::new(16.0, -8.0, 0.0));
            assert_eq!(vertex[24..], colors[index]);
        }
    }
}

#[test]
fn glb_holds_a_coloured_triangle_a_patch() {
    let scene = small_scene();
    let bytes = exported(|p| glb::save(p, &scene, &colors(&scene)));
    assert_eq!(&bytes[..4], b"glTF");
    assert_eq!(u32_at(&bytes, 4), 2);
    assert_eq!(u32_at(&bytes, 8) as usize, bytes.len());
    let json_bytes = u32_at(&bytes, 12) as usize;
    assert_eq!(&bytes[16..20], b"JSON");
    assert!(json_bytes.is_multiple_of(4));
    let json: serde_json::Value = serde_json::from_slice(&bytes[20..20 + json_bytes]).unwrap();
    let binary = &bytes[20 + json_bytes..];
    let buffer_bytes = u32_at(binary, 0) as usize;
    assert_eq!(&binary[4..8], b"BIN\0");
    let buffer = &binary[8..];
    assert_eq!(buffer.len(), buffer_bytes);
    assert_eq!(json["buffers"][0]["byteLength"], buffer_bytes);
    assert_eq!(json["asset"]["version"], "2.0");
    assert_eq!(
        json["nodes"][0]["translation"],
        serde_json::json!([16.0, -8.0, 0.0])
    );

    let primitive = &json["meshes"][0]["primitives"][0];
    assert_eq!(primitive["mode"], 4);
    // (accessor, its bytes), checked to lie in the buffer, tightly packed and aligned.
    let accessor = |attribute: &str, element_bytes: usize| {
        let index = primitive["attributes"][attribute].as_u64().unwrap() as usize;
        let accessor = &json["accessors"][index];
        let view = &json["bufferViews"][accessor["bufferView"].as_u64().unwrap() as usize];
        let offset = view["byteOffset"].as_u64().unwrap() as usize;
        let length = view["byteLength"].as_u64().unwrap() as usize;
        assert_eq!(accessor["count"], 15);
        assert_eq!(length, 15 * element_bytes);
        assert!(offset.is_multiple_of(4));
        (accessor, &buffer[offset..offset + length])
    };
    let (description, positions) = accessor("POSITION", 12);
    assert_eq!(
        (&description["componentType"], &description["type"]),
        (&5126.into(), &"VEC3".into())
    );
    let positions: Vec<Vec3> = positions
        .chunks(12)
        .map(|p| Vec3::from([0, 4, 8].map(|at| f32::from_bits(u32_at(p, at)))))
        .collect();
    let expected: Vec<Vec3> = (0..5)
        .flat_map(|p| scene.patch(PatchId(p)).corners)
        .collect();
    assert_eq!(bits(&positions), bits(&expected));
    let bound = |name: &str| -> Vec<f32> {
        let values = description[name].as_array().unwrap();
        values.iter().map(|v| v.as_f64().unwrap() as f32).collect()
    };
    let [low, high] = scene.bounds();
    assert_eq!(bound("min"), low.to_array());
    assert_eq!(bound("max"), high.to_array());

    let (description, colors) = accessor("COLOR_0", 8);
    assert_eq!(
        (
            &description["componentType"],
            &description["type"],
            &description["normalized"]
        ),
        (&5123.into(), &"VEC4".into(), &true.into())
    );
    for (vertex, color) in colors.chunks(8).enumerate() {
        let channels: Vec<u16> = color
            .chunks(2)
            .map(|c| u16::from_le_bytes([c[0], c[1]]))
            .collect();
        assert_eq!((channels[0], channels[1], channels[3]), (0, 65535, 65535));
        // sRGB 20, 40, 60, 80 are linear 0.006995, 0.021219, 0.045186, 0.080220 (IEC 61966-2-1).
        let expected = [0.0, 0.006_995, 0.021_219, 0.045_186, 0.080_220][vertex / 3];
        // Half a step of 16 bits and half a unit of the last digit above.
        let tolerance = 0.5 / 65535.0 + 0.5e-6;
        let blue = f64::from(channels[2]) / 65535.0;
        assert!((blue - expected).abs() <= tolerance, "{vertex}: {blue}");
    }
}

#[test]
fn wrong_number_of_colors_is_an_error_and_writes_nothing() {
    let scene = small_scene();
    let folder = folder();
    let path = folder.path().join("a.out");
    for count in [0, 4, 6] {
        let colors = vec![[0; 3]; count];
        for error in [
            ply::save(&path, &scene, &colors),
            glb::save(&path, &scene, &colors),
        ] {
            let error = error.unwrap_err();
            let message = checked_message(&error, &path);
            assert!(
                message.contains(&format!("{count} colours for 5 patches")),
                "{message}"
            );
        }
    }
    assert_eq!(listing(folder.path()), [""; 0]);
}

#[test]
fn failed_export_names_its_file_and_leaves_nothing() {
    let scene = small_scene();
    let folder = folder();
    let path = folder.path().join("none/a.obj");
    let errors = [
        csv::save(&path, &scene, None).unwrap_err(),
        ply::save(&path, &scene, &colors(&scene)).unwrap_err(),
        glb::save(&path, &scene, &colors(&scene)).unwrap_err(),
    ];
    for error in errors {
        checked_message(&error, &path);
    }
    let error = obj::save(&path, &scene).unwrap_err();
    checked_message(&error, &path.with_extension("mtl"));
    assert_eq!(listing(folder.path()), [""; 0]);
}
