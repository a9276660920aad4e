//! The laws of textures: each triangle has the mean of its part, and no light is lost.

mod common;

use std::f64::consts::PI;

use common::gltf::{Gltf, SQUARE, png, square};
use proptest::prelude::*;
use scene::import::ImportedModel;
use scene::{Rgb, Surface, srgb};
use serde_json::{Value, json};

/// Means keep 12 bits behind the leading one, so that they are right to half of the last of these, relatively.
const ROUNDING: f64 = 1.0 / 8192.0;

const BLACK: [u8; 3] = [0; 3];
const WHITE: [u8; 3] = [255; 3];

/// Texture coordinates that put a picture upright on the square; v points down.
const UPRIGHT: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];

/// The square with a picture, in a material that uses texture 0.
fn with_picture(material: Value, picture: &[u8], at: &[[f32; 2]; 4]) -> Gltf {
    let mut gltf = square(material);
    let coordinates = gltf.floats(at);
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = json!(coordinates);
    let view = gltf.view(picture);
    gltf.push("images", json!({"bufferView": view}));
    gltf.push("textures", json!({"source": 0}));
    gltf
}

fn wall() -> Value {
    json!({"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 0.5, 0.5, 1], "baseColorTexture": {"index": 0}}})
}

fn lamp(strength: f64) -> Value {
    json!({"pbrMetallicRoughness": {"metallicFactor": 0, "baseColorFactor": [0.5, 0.5, 0.5, 1]},
        "emissiveFactor": [1, 1, 1], "emissiveTexture": {"index": 0},
        "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": strength}}})
}

/// The mean of the picture on each of the square's two triangles, lower right first.
fn means(picture: &[u8], at: &[[f32; 2]; 4]) -> Vec<f64> {
    of_triangles(&with_picture(wall(), picture, at).load())
}

fn of_triangles(model: &ImportedModel) -> Vec<f64> {
    let of = |s: &Surface| 2.0 * f64::from(model.materials[s.material.index()].reflectance.x);
    model.surfaces.iter().map(of).collect()
}

#[track_caller]
fn assert_near(found: &[f64], expected: [f64; 2]) {
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= ROUNDING * expected,
            "{found} {expected}"
        );
    }
}

#[test]
fn a_half_white_picture_is_a_quarter_and_three_quarters_of_the_triangles() {
    for width in [2, 6, 64, 300] {
        let row: Vec<[u8; 3]> = (0..width)
            .map(|x| if x < width / 2 { BLACK } else { WHITE })
            .collect();
        let found = means(&png(width, 1, &row), &UPRIGHT);
        assert_near(&found, [0.75, 0.25]);
    }
}

#[test]
fn a_checker_is_grey_on_both_triangles() {
    for size in [2, 4, 30] {
        let texel = |k: u32| {
            if (k % size + k / size).is_multiple_of(2) {
                BLACK
            } else {
                WHITE
            }
        };
        let texels: Vec<[u8; 3]> = (0..size * size).map(texel).collect();
        assert_near(&means(&png(size, size, &texels), &UPRIGHT), [0.5, 0.5]);
    }
}

/// The picture three and a half times along u: of 7 halves 4 are black, of which the diagonal leaves the lower triangle
/// sum (2k + 1) / 49 over the white ones, k = 1, 3, 5.
#[test]
fn a_picture_that_repeats_counts_in_each_of_its_places() {
    let at = UPRIGHT.map(|[u, v]| [3.5 * u, v]);
    let found = means(&png(2, 1, &[BLACK, WHITE]), &at);
    let lower = (3.0 + 7.0 + 11.0) / 49.0;
    assert_near(&found, [lower, 2.0 * 3.0 / 7.0 - lower]);
}

/// Along a line u = s + t over the triangle, a quarter of whose area is below 1/2; in one point all is one texel.
#[test]
fn coordinates_on_a_line_and_in_a_point_have_means() {
    let picture = png(2, 1, &[BLACK, WHITE]);
    let on_line = [[0.0, 0.5], [1.0, 0.5], [1.0, 0.5], [0.0, 0.5]];
    // The second triangle's corners have u = 0, 1 and 0: 3/4 of it is below 1/2.
    assert_near(&means(&picture, &on_line), [0.75, 0.25]);
    assert_near(&means(&picture, &[[0.75, 0.5]; 4]), [1.0, 1.0]);
    assert_near(&means(&picture, &[[0.25, 0.0]; 4]), [0.0, 0.0]);
}

/// The power of the square, W.
fn power(model: &ImportedModel) -> f64 {
    let of = |s: &Surface| s.area() * f64::from(model.materials[s.material.index()].emission.y);
    model.surfaces.iter().map(of).sum()
}

/// Wherever lit texels are, also in pictures of more texels than are looked at.
#[test]
fn a_lamp_of_few_texels_keeps_its_power() {
    let strength = 10_000.0;
    for (size, side, at) in [
        (128, 1, [70, 60]),
        (512, 4, [300, 200]),
        (701, 1, [350, 349]),
        (1024, 1, [513, 510]),
    ] {
        let is_lit = |k: u32| {
            let [x, y] = [k % size, k / size];
            (at[0]..at[0] + side).contains(&x) && (at[1]..at[1] + side).contains(&y)
        };
        let texels: Vec<[u8; 3]> = (0..size * size)
            .map(|k| if is_lit(k) { WHITE } else { BLACK })
            .collect();
        let model = with_picture(lamp(strength), &png(size, size, &texels), &UPRIGHT).load();
        let expected = PI * strength * f64::from(side * side) / f64::from(size * size);
        let found = power(&model);
        assert!(
            (found - expected).abs() <= ROUNDING * expected,
            "{size}: {found} {expected}"
        );
    }
}

#[test]
fn dim_light_is_not_rounded_away() {
    let model = with_picture(lamp(10_000.0), &png(1, 1, &[[1; 3]]), &UPRIGHT).load();
    let expected = PI * 10_000.0 * f64::from(srgb::decode(1.0 / 255.0));
    assert!(
        (power(&model) - expected).abs() <= ROUNDING * expected,
        "{}",
        power(&model)
    );
}

/// A quarter of the triangle each: the means of the parts have the mean of the whole.
fn quarters([a, b, c]: [[f32; 2]; 3]) -> [[[f32; 2]; 3]; 4] {
    let mid = |p: [f32; 2], q: [f32; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
    let [ab, bc, ca] = [mid(a, b), mid(b, c), mid(c, a)];
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// The mean over each triangle of coordinates, all of which are on triangles of the same size.
fn means_of(triangles: &[[[f32; 2]; 3]], picture: &[u8], wrap: [u32; 2]) -> Vec<f64> {
    let mut gltf = Gltf::new();
    let corner = |k: usize| {
        let [x, y, _] = SQUARE[k % 3];
        [x, y, (k / 3) as f32]
    };
    let positions: Vec<[f32; 3]> = (0..3 * triangles.len()).map(corner).collect();
    let positions = gltf.floats(&positions);
    let coordinates = gltf.floats(&triangles.concat());
    let view = gltf.view(picture);
    gltf.push("images", json!({"bufferView": view}));
    gltf.push("samplers", json!({"wrapS": wrap[0], "wrapT": wrap[1]}));
    gltf.push("textures", json!({"source": 0, "sampler": 0}));
    gltf.push("materials", wall());
    let attributes = json!({"POSITION": positions, "TEXCOORD_0": coordinates});
    gltf.push(
        "meshes",
        json!({"primitives": [{"attributes": attributes, "material": 0}]}),
    );
    gltf.root(json!({"mesh": 0}));
    of_triangles(&gltf.load())
}

fn place() -> impl Strategy<Value = [f32; 2]> {
    // In steps that f32 halves exactly.
    [-2048i16..2048, -2048i16..2048].prop_map(|steps| steps.map(|step| f32::from(step) / 512.0))
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(60) })]

    #[test]
    fn parts_of_a_triangle_have_its_mean_together(
        corners in [place(), place(), place()],
        wrap in [prop::sample::select(vec![10497u32, 33648, 33071]), prop::sample::select(vec![10497u32, 33648, 33071])],
        size in [1u32..9, 1u32..9],
        seed in any::<u32>(),
    ) {
        let count = size[0] * size[1];
        let texel = |k: u32| [if seed.rotate_left(k) & 1 == 0 { 0 } else { 255 }; 3];
        let picture = png(size[0], size[1], &(0..count).map(texel).collect::<Vec<_>>());
        let mut triangles = vec![corners];
        triangles.extend(quarters(corners));
        let found = means_of(&triangles, &picture, wrap);
        let mean = found[1..].iter().sum::<f64>() / 4.0;
        prop_assert!((found[0] - mean).abs() <= 2.0 * ROUNDING * mean, "{found:?}");
    }
}

#[test]
fn a_picture_that_is_too_large_is_left_out_and_told() {
    // 20,000 x 20,000 texels of one bit: its header says so, and nothing more is needed to refuse it.
    let mut picture = png(1, 1, &[BLACK]);
    picture[16..24].copy_from_slice(&[0, 0, 0x4E, 0x20, 0, 0, 0x4E, 0x20]);
    let crc = crc32(&picture[12..29]);
    picture[29..33].copy_from_slice(&crc.to_be_bytes());
    let model = with_picture(wall(), &picture, &UPRIGHT).load();
    let told = model.report.warnings.join("\n");
    assert!(
        told.contains("20000 x 20000 texels") && told.contains("268435456"),
        "{told}"
    );
    assert_eq!(model.materials[0].reflectance, Rgb::splat(0.5));
}

/// The checksum of PNG (ISO/IEC 15948, annex D).
fn crc32(bytes: &[u8]) -> u32 {
    !bytes.iter().fold(u32::MAX, |crc, &byte| {
        (0..8).fold(crc ^ u32::from(byte), |crc, _| {
            (crc >> 1) ^ if crc & 1 == 1 { 0xEDB8_8320 } else { 0 }
        })
    })
}
