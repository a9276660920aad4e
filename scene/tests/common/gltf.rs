//! glTF files, made piece by piece.

use std::path::PathBuf;

use base64::Engine;
use scene::gltf::{GltfError, load_with};
use scene::import::{ImportOptions, ImportedModel};
use serde_json::{Value, json};
use tempfile::TempDir;

use super::write;

pub const FLOAT: u32 = 5126;
pub const U8: u32 = 5121;
pub const U16: u32 = 5123;
pub const U32: u32 = 5125;

/// How a file holds its buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Container {
    DataUri,
    ExternalFile,
    Binary,
}

impl Container {
    pub const ALL: [Self; 3] = [Self::DataUri, Self::ExternalFile, Self::Binary];
}

/// A document and its only buffer.
#[derive(Clone, Debug)]
pub struct Gltf {
    pub json: Value,
    pub buffer: Vec<u8>,
}

impl Gltf {
    pub fn new() -> Self {
        let json = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}], "nodes": [], "meshes": [],
            "accessors": [], "bufferViews": [], "buffers": [{}],
        });
        Self {
            json,
            buffer: Vec::new(),
        }
    }

    /// Adds an element to an array at the root, and gives its index.
    pub fn push(&mut self, array: &str, value: Value) -> usize {
        let array = &mut self.json[array];
        if array.is_null() {
            *array = json!([]);
        }
        let array = array.as_array_mut().unwrap();
        array.push(value);
        array.len() - 1
    }

    pub fn view(&mut self, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let offset = self.buffer.len();
        self.buffer.extend(bytes);
        self.push(
            "bufferViews",
            json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}),
        )
    }

    /// Adds an accessor of floats.
    pub fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|v| v.to_le_bytes())
            .collect();
        let view = self.view(&bytes);
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": FLOAT, "type": kind, "count": values.len(),
                   "min": vec![-1e9; N], "max": vec![1e9; N]}),
        )
    }

    /// Adds an accessor of indices of this type.
    pub fn indices(&mut self, component: u32, values: &[u32]) -> usize {
        let size = match component {
            U8 => 1,
            U16 => 2,
            _ => 4,
        };
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes()[..size].to_vec())
            .collect();
        let view = self.view(&bytes);
        self.push(
            "accessors",
            json!({"bufferView": view, "componentType": component, "type": "SCALAR", "count": values.len()}),
        )
    }

    /// Adds a node to the scene.
    pub fn root(&mut self, node: Value) -> usize {
        let index = self.push("nodes", node);
        let nodes = self.json["scenes"][0]["nodes"].as_array_mut().unwrap();
        nodes.push(json!(index));
        index
    }

    /// The file, made as `a.gltf` or `a.glb` in a folder.
    pub fn write(&self, folder: &TempDir, container: Container) -> PathBuf {
        let mut json = self.json.clone();
        json["buffers"][0]["byteLength"] = json!(self.buffer.len());
        match container {
            Container::DataUri => {
                let data = base64::prelude::BASE64_STANDARD.encode(&self.buffer);
                json["buffers"][0]["uri"] =
                    json!(format!("data:application/octet-stream;base64,{data}"));
            }
            Container::ExternalFile => {
                write(folder, "the buffer.bin", &self.buffer);
                json["buffers"][0]["uri"] = json!("the%20buffer.bin");
            }
            Container::Binary => return write(folder, "a.glb", glb(&json, &self.buffer)),
        }
        write(folder, "a.gltf", json.to_string())
    }

    pub fn load_as(&self, options: &ImportOptions) -> Result<ImportedModel, GltfError> {
        let folder = super::folder();
        load_with(&self.write(&folder, Container::Binary), options)
    }

    #[track_caller]
    pub fn load(&self) -> ImportedModel {
        self.load_as(&ImportOptions::default()).unwrap()
    }
}

/// A `.glb` file.
pub fn glb(json: &Value, buffer: &[u8]) -> Vec<u8> {
    let mut json = json.to_string().into_bytes();
    json.resize(json.len().next_multiple_of(4), b' ');
    let mut buffer = buffer.to_vec();
    buffer.resize(buffer.len().next_multiple_of(4), 0);
    let mut file = b"glTF".to_vec();
    let length = 12 + 8 + json.len() + 8 + buffer.len();
    for number in [2, length as u32, json.len() as u32] {
        file.extend(number.to_le_bytes());
    }
    file.extend(b"JSON");
    file.extend(json);
    file.extend((buffer.len() as u32).to_le_bytes());
    file.extend(b"BIN\0");
    file.extend(buffer);
    file
}

/// The corners of a unit square in the plane z = 0, counter-clockwise from its front, which is up z.
pub const SQUARE: [[f32; 3]; 4] = [
    [0.0, 0.0, 0.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.0, 0.0],
    [0.0, 1.0, 0.0],
];

/// A node with the square, which is wholly in one material.
pub fn square(material: Value) -> Gltf {
    let mut gltf = Gltf::new();
    let positions = gltf.floats(&SQUARE);
    let indices = gltf.indices(U16, &[0, 1, 2, 0, 2, 3]);
    let material = gltf.push("materials", material);
    gltf.push(
        "meshes",
        json!({"primitives": [{"attributes": {"POSITION": positions}, "indices": indices, "material": material}]}),
    );
    gltf.root(json!({"mesh": 0, "name": "square"}));
    gltf
}

/// A material of this base colour that is no metal.
pub fn painted(colour: [f64; 4]) -> Value {
    json!({"name": "paint", "pbrMetallicRoughness": {"baseColorFactor": colour, "metallicFactor": 0}})
}

/// A PNG file of rows of pixels from the top.
pub fn png(width: u32, height: u32, pixels: &[[u8; 3]]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    image::RgbImage::from_raw(width, height, pixels.concat())
        .unwrap()
        .write_to(&mut bytes, image::ImageFormat::Png)
        .unwrap();
    bytes.into_inner()
}
