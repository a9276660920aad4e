//! MTL files: what they say, and what stands in for what they do not say.

use std::collections::HashMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use super::screen::{UsedMaterial, decode, malformed, name_of, statement};
use super::{ObjError, ObjFault};
use crate::{Material, Rgb};

/// Reflectance of what has none, dimensionless.
pub(super) const GREY: f32 = 0.5;

/// A material that reflects grey and emits nothing.
pub(super) fn grey(name: &str, reflectance: f32) -> Material {
    Material {
        name: name.to_owned(),
        reflectance: Rgb::splat(reflectance),
        emission: Rgb::ZERO,
    }
}

/// All materials of the MTL files that an OBJ file names, by name; the last definition counts.
pub(super) struct Library {
    materials: HashMap<String, (tobj::Material, PathBuf)>,
}

impl Library {
    /// Reads the files named in `mtllib` statements, relative to the OBJ file's folder. A missing
    /// one is a warning, a malformed one an error.
    pub(super) fn load(
        folder: &Path,
        arguments: &[String],
        warnings: &mut Vec<String>,
    ) -> Result<Self, ObjError> {
        let mut materials = HashMap::new();
        for path in arguments.iter().flat_map(|a| candidates(folder, a)) {
            let bytes = match read_regular(&path) {
                Ok(bytes) => bytes,
                Err(error) => {
                    warnings.push(format!(
                        "cannot read the material file {}: {error}",
                        path.display()
                    ));
                    continue;
                }
            };
            materials.extend(Self::of(&path, &bytes)?.materials);
        }
        Ok(Self { materials })
    }

    /// The materials of the text of one file.
    pub(super) fn of(path: &Path, bytes: &[u8]) -> Result<Self, ObjError> {
        let parsed = screen(&decode(bytes))
            .and_then(|text| tobj::load_mtl_buf(&mut text.as_bytes()).map_err(ObjFault::Parser));
        let (found, _) = parsed.map_err(|fault| ObjError::new(path, fault))?;
        let named = found.into_iter();
        let materials = named.map(|material| (material.name.clone(), (material, path.to_owned())));
        Ok(Self {
            materials: materials.collect(),
        })
    }

    /// The materials with these names, in this order. `reflectance` stands in for what those that
    /// do not emit say of theirs.
    pub(super) fn materials_for(
        &self,
        used: &[UsedMaterial],
        reflectance: Option<f32>,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<Material>, ObjError> {
        let reflectance_of_none = reflectance.unwrap_or(GREY);
        used.iter()
            .map(|UsedMaterial { name, faces }| {
                let mut material = grey(name, reflectance_of_none);
                let Some((found, path)) = self.materials.get(name) else {
                    warnings.push(format!(
                        "material \"{name}\" of {faces} faces is not defined; it is taken as grey with reflectance {reflectance_of_none}"
                    ));
                    return Ok(material);
                };
                if let Some(emission) = found.emissive {
                    material.emission = Rgb::from(emission.map(|v| v as f32));
                }
                if reflectance.is_none() || material.is_emitter() {
                    material.reflectance = own_reflectance(found, path, warnings);
                }
                material
                    .validate()
                    .map_err(|error| ObjError::new(path, ObjFault::Material(error)))?;
                Ok(material)
            })
            .collect()
    }
}

/// What a material of an MTL file says of its reflectance, not judged.
fn own_reflectance(found: &tobj::Material, path: &Path, warnings: &mut Vec<String>) -> Rgb {
    let name = &found.name;
    if found.diffuse.is_none() {
        warnings.push(format!(
            "{}: material \"{name}\" has no Kd; its reflectance is taken as {GREY}",
            path.display()
        ));
    }
    if let Some(texture) = &found.diffuse_texture {
        warnings.push(format!(
            "{}: material \"{name}\": texture {texture} is ignored, only Kd counts",
            path.display()
        ));
    }
    found
        .diffuse
        .map_or(Rgb::splat(GREY), |kd| Rgb::from(kd.map(|v| v as f32)))
}

/// The files a `mtllib` argument may mean: one whose name holds spaces, or several.
fn candidates(folder: &Path, argument: &str) -> Vec<PathBuf> {
    let with_comment = folder.join(argument);
    if with_comment.exists() {
        return vec![with_comment];
    }
    let argument = name_of(argument);
    let whole = folder.join(argument);
    if whole.exists() || !argument.contains(char::is_whitespace) {
        return vec![whole];
    }
    let several: Vec<PathBuf> = argument
        .split_whitespace()
        .map(|name| folder.join(name))
        .collect();
    if several.iter().any(|path| path.exists()) {
        several
    } else {
        vec![whole]
    }
}

/// A device or pipe that a model names could be endless.
fn read_regular(path: &Path) -> std::io::Result<Vec<u8>> {
    if !std::fs::metadata(path)?.is_file() {
        return Err(std::io::Error::other("not a regular file"));
    }
    std::fs::read(path)
}

/// Checks an MTL file and reduces it to the statements that are used.
fn screen(text: &str) -> Result<String, ObjFault> {
    let mut reduced = String::new();
    for (index, line) in text.lines().enumerate() {
        let number = index + 1;
        let (keyword, rest) = statement(line);
        let name = name_of(rest);
        match keyword {
            "newmtl" if name.is_empty() => {
                return Err(malformed(number, "\"newmtl\" has no name"));
            }
            "newmtl" => {
                let _ = writeln!(reduced, "newmtl {name}");
            }
            "Kd" | "Ke" => {
                let words: Vec<&str> = rest
                    .split('#')
                    .next()
                    .unwrap_or_default()
                    .split_whitespace()
                    .collect();
                let [r, g, b] = match words[..] {
                    [grey] => [grey; 3],
                    [r, g, b] => [r, g, b],
                    _ => {
                        return Err(malformed(
                            number,
                            format!("{keyword} has {} values, expected 3 numbers", words.len()),
                        ));
                    }
                };
                for word in [r, g, b] {
                    if word.parse::<f64>().is_err() {
                        return Err(malformed(
                            number,
                            format!("{keyword}: {word:?} is not a number"),
                        ));
                    }
                }
                let _ = writeln!(reduced, "{keyword} {r} {g} {b}");
            }
            "map_Kd" if !name.is_empty() => {
                let _ = writeln!(reduced, "map_Kd {name}");
            }
            _ => {}
        }
    }
    Ok(reduced)
}
