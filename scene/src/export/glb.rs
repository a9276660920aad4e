//! A coloured triangle mesh as binary glTF 2.0.
//!
//! The light is in the vertex colours, so the material is unlit (`KHR_materials_unlit`; programs
//! without it see a white, rough material). Positions are f32 relative to the scene's origin, in metres; the node
//! makes the model's own coordinates of them. glTF takes +Y as up; the axes stay as they are.

use std::path::Path;

use glam::{DVec3, Vec3};
use serde_json::json;

use super::{check_colors, patches};
use crate::file::{FileError, write_atomically};
use crate::{Scene, srgb};

/// Bytes of a vertex's position, 3 f32.
const POSITION_BYTES: u32 = 12;
/// Bytes of a vertex's colour, 4 u16. A colour of 8 bits would band, since glTF's are linear.
const COLOR_BYTES: u32 = 8;
/// Bytes of the file's header, and of a chunk's.
const HEADER_BYTES: u32 = 12;
const CHUNK_HEADER_BYTES: u32 = 8;

// From the glTF 2.0 specification, sections 3.6.2, 3.7.2 and 4.4.
const FLOAT: u32 = 5126;
const UNSIGNED_SHORT: u32 = 5123;
const ARRAY_BUFFER: u32 = 34962;
const TRIANGLES: u32 = 4;
const VERSION: u32 = 2;

/// Writes one triangle a patch, in patch order, flat coloured.
///
/// `patch_colors` are display colours (sRGB), one per patch; they are stored linearly, as glTF
/// demands. The largest scene makes a file of 1 GB, so sizes fit the format's 32 bits.
pub fn save(path: &Path, scene: &Scene, patch_colors: &[[u8; 3]]) -> Result<(), FileError> {
    check_colors(path, scene, patch_colors)?;
    let vertices = 3 * scene.patch_count();
    let buffer_bytes = vertices * (POSITION_BYTES + COLOR_BYTES);
    let mut json = document(scene, vertices).to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let json_bytes = json.len() as u32;
    let file_bytes = HEADER_BYTES + 2 * CHUNK_HEADER_BYTES + json_bytes + buffer_bytes;

    write_atomically(path, |out| {
        out.write_all(b"glTF")?;
        out.write_all(&VERSION.to_le_bytes())?;
        out.write_all(&file_bytes.to_le_bytes())?;
        out.write_all(&json_bytes.to_le_bytes())?;
        out.write_all(b"JSON")?;
        out.write_all(&json)?;
        out.write_all(&buffer_bytes.to_le_bytes())?;
        out.write_all(b"BIN\0")?;
        for patch in patches(scene) {
            for coordinate in patch.corners.iter().flat_map(Vec3::to_array) {
                out.write_all(&coordinate.to_le_bytes())?;
            }
        }
        for color in patch_colors {
            let [r, g, b] = color.map(linear);
            let vertex = bytemuck::cast::<[u16; 4], [u8; 8]>([r, g, b, u16::MAX].map(u16::to_le));
            for _ in 0..3 {
                out.write_all(&vertex)?;
            }
        }
        Ok(())
    })
}

fn document(scene: &Scene, vertices: u32) -> serde_json::Value {
    let (low, high) = patches(scene).flat_map(|patch| patch.corners).fold(
        (Vec3::INFINITY, Vec3::NEG_INFINITY),
        |(low, high), corner| (low.min(corner), high.max(corner)),
    );
    let scale = [1.0 / scene.axes().unit; 3];
    let position_bytes = vertices * POSITION_BYTES;
    let color_bytes = vertices * COLOR_BYTES;
    json!({
        "asset": { "version": "2.0", "generator": concat!("radiosity toolkit ", env!("CARGO_PKG_VERSION")) },
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{
            "mesh": 0,
            "translation": scene.to_model(DVec3::ZERO).to_array(),
            "scale": scale,
        }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "COLOR_0": 1 },
            "material": 0,
            "mode": TRIANGLES,
        }] }],
        "materials": [{
            "name": "radiosity",
            "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 1.0 },
            "extensions": { "KHR_materials_unlit": {} },
        }],
        "buffers": [{ "byteLength": position_bytes + color_bytes }],
        "bufferViews": [
            { "buffer": 0, "byteOffset": 0, "byteLength": position_bytes, "target": ARRAY_BUFFER },
            { "buffer": 0, "byteOffset": position_bytes, "byteLength": color_bytes, "target": ARRAY_BUFFER },
        ],
        "accessors": [
            {
                "bufferView": 0, "componentType": FLOAT, "count": vertices, "type": "VEC3",
                "min": low.to_array(), "max": high.to_array(),
            },
            {
                "bufferView": 1, "componentType": UNSIGNED_SHORT, "normalized": true,
                "count": vertices, "type": "VEC4",
            },
        ],
    })
}

/// sRGB to linear, as a share of 65535.
fn linear(srgb: u8) -> u16 {
    (srgb::decode(f32::from(srgb) / 255.0) * f32::from(u16::MAX)).round() as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn linear_colors_lead_back_to_every_srgb_color() {
        let mut previous = None;
        for srgb in 0..=255 {
            let linear = linear(srgb);
            assert!(
                previous < Some(linear),
                "two colours of 8 bits share one of 16"
            );
            previous = Some(linear);
        }
        assert_eq!((linear(0), linear(255)), (0, u16::MAX));
        // The standard's mid grey: 188 is 0.5 of the light to within half a step of 8 bits.
        assert!((f64::from(linear(188)) / 65535.0 - 0.5).abs() < 0.005);
    }
}
