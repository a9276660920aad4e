//! MTL files: what they say, and what stands in for what they do not say.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::path::{Path, PathBuf};

use super::lines::{Statement, lines, names, text};
use super::screen::Used;
use super::{ObjError, ObjFault, files};
use crate::import::files::read_regular;
use crate::import::{GREY, ImportOptions, Picture, Taken, Terms, Textured, Wrap, check, left_out};
use crate::{Material, Rgb};

/// What messages call things.
pub(super) const TERMS: Terms = Terms {
    colour: "Kd",
    coordinates: "vt",
    without_picture: "Kd alone counts, or grey where that is 0",
};

/// Specular reflectances up to this are those of any dull surface.
const DULL: f64 = 0.05;

/// The first of the `illum` that mirror or refract.
const FIRST_MIRROR: f64 = 3.0;

/// A material that reflects grey and emits nothing.
fn grey(name: &str, reflectance: f32) -> Material {
    Material {
        name: name.to_owned(),
        reflectance: Rgb::splat(reflectance),
        emission: Rgb::ZERO,
    }
}

/// What a file says of a material.
#[derive(Clone, Debug, Default, PartialEq)]
struct Definition {
    /// Index of the file.
    file: usize,
    line: usize,
    diffuse: Option<[f64; 3]>,
    emission: Option<[f64; 3]>,
    /// As it stands there.
    diffuse_map: Option<Vec<u8>>,
    /// Opacity: 0 is not there.
    opacity: Option<f64>,
    transparency: Option<f64>,
    /// Statements that mean something and are not taken.
    left_out: Vec<String>,
    /// Keywords that are taken although they are spelt in another way.
    respelt: Vec<String>,
}

/// All materials of the MTL files that an OBJ file names, by name; the first definition counts.
#[derive(Debug, Default)]
pub(super) struct Library {
    files: Vec<PathBuf>,
    materials: HashMap<String, Definition>,
}

impl Library {
    /// Reads the files named in `mtllib` statements, relative to the OBJ file's folder. A missing
    /// one is a warning, a malformed one an error.
    pub(super) fn load(
        folder: &Path,
        arguments: &[Vec<u8>],
        warnings: &mut Vec<String>,
    ) -> Result<Self, ObjError> {
        let mut library = Self::default();
        for path in arguments.iter().flat_map(|a| files::named(folder, a)) {
            match read_regular(&path) {
                Ok(bytes) => library.add(&path, &bytes, warnings)?,
                Err(error) => warnings.push(format!(
                    "cannot read the material file {}: {error}",
                    path.display()
                )),
            }
        }
        Ok(library)
    }

    /// Adds what the bytes of a file say.
    pub(super) fn add(
        &mut self,
        path: &Path,
        bytes: &[u8],
        warnings: &mut Vec<String>,
    ) -> Result<(), ObjError> {
        if self.files.iter().any(|known| known == path) {
            return Ok(());
        }
        let file = self.files.len();
        self.files.push(path.to_owned());
        if bytes.is_empty() {
            return Ok(());
        }
        let found = definitions(bytes, file).map_err(|fault| ObjError::new(path, fault))?;
        for (name, definition) in found {
            match self.materials.entry(name) {
                Entry::Vacant(entry) => {
                    entry.insert(definition);
                }
                Entry::Occupied(entry) => {
                    let first = entry.get();
                    warnings.push(format!(
                        "material \"{}\" is defined in {} line {} and again in {} line {}; the first counts",
                        entry.key(),
                        self.files[first.file].display(),
                        first.line,
                        path.display(),
                        definition.line,
                    ));
                }
            }
        }
        Ok(())
    }

    /// The files that were read.
    pub(super) fn into_files(self) -> Vec<PathBuf> {
        self.files
    }

    /// The materials with these names, in this order.
    pub(super) fn materials_for(
        &self,
        used: &[Used],
        options: &ImportOptions,
        warnings: &mut Vec<String>,
    ) -> Result<Vec<Taken>, ObjError> {
        let take = |used| self.taken(used, options, warnings);
        used.iter().map(take).collect()
    }

    fn taken(
        &self,
        Used { name, faces, .. }: &Used,
        options: &ImportOptions,
        warnings: &mut Vec<String>,
    ) -> Result<Taken, ObjError> {
        let stand_in = options.reflectance.unwrap_or(GREY);
        let without = |name| Taken {
            material: grey(name, stand_in),
            reflectance: None,
            emission: None,
            absence: None,
        };
        if name.trim().is_empty() {
            warnings.push(format!(
                "{faces} faces have no material; they are grey with reflectance {stand_in}"
            ));
            return Ok(without("default"));
        }
        let Some((meant, found)) = self.find(name) else {
            warnings.push(format!(
                "material \"{name}\" of {faces} faces is not defined; it is taken as grey with reflectance {stand_in}"
            ));
            return Ok(without(name));
        };
        if meant.trim_end() != name.trim_end() {
            warnings.push(format!(
                "material \"{name}\" is not defined; \"{meant}\" is taken, as if a comment followed the name"
            ));
        }
        let path = &self.files[found.file];
        let mut taken = without(name);
        let material = &mut taken.material;
        if let Some(emission) = found.emission {
            material.emission = Rgb::from(emission.map(|v| v as f32));
        }
        taken.absence = found.is_absent().then(|| "d 0".to_owned());
        if options.reflectance.is_none() || material.is_emitter() {
            if found.diffuse.is_none() && found.diffuse_map.is_none() {
                warnings.push(format!(
                    "{}: material \"{name}\" has no Kd; its reflectance is taken as {GREY}",
                    path.display()
                ));
            }
            let diffuse = found.diffuse.map(|kd| Rgb::from(kd.map(|v| v as f32)));
            material.reflectance = diffuse.unwrap_or(Rgb::splat(GREY));
            if let Some(map) = &found.diffuse_map {
                // Programs that take the picture instead of Kd write 0 for that.
                let is_instead = diffuse.is_none_or(|kd| kd == Rgb::ZERO);
                let folder = path.parent().unwrap_or(Path::new(""));
                taken.reflectance = Some(Textured {
                    picture: Picture {
                        name: files::picture(folder, map),
                        bytes: None,
                    },
                    factor: if is_instead {
                        Rgb::ONE
                    } else {
                        material.reflectance
                    },
                    wrap: [Wrap::Repeat; 2],
                });
                if is_instead {
                    material.reflectance = Rgb::splat(GREY);
                }
            }
        }
        warnings.extend(left_out(name, &found.left_out));
        if !found.respelt.is_empty() {
            warnings.push(format!(
                "material \"{name}\": {} (the format has capitals here)",
                found.respelt.join(", ")
            ));
        }
        let valid = check(&taken.material, options);
        valid.map_err(|error| ObjError::new(path, ObjFault::Material(error)))?;
        Ok(taken)
    }

    /// The definition that a name means, and its name there.
    fn find(&self, name: &str) -> Option<(&str, &Definition)> {
        let known = |name: &str| self.materials.get_key_value(name);
        let found = names(name).find_map(known).or_else(|| {
            // Or the library has the comment.
            let means =
                |(defined, _): &(&String, _)| names(defined).any(|part| part == name.trim_end());
            self.materials
                .iter()
                .filter(means)
                .min_by_key(|(_, definition)| (definition.file, definition.line))
        });
        found.map(|(name, definition)| (&name[..], definition))
    }
}

/// All definitions of a file, with their names.
fn definitions(bytes: &[u8], file: usize) -> Result<Vec<(String, Definition)>, ObjFault> {
    let mut found: Vec<(String, Definition)> = Vec::new();
    for statement in lines(text(bytes)?).filter_map(Statement::new) {
        if statement.keyword == "newmtl" {
            let name = statement.name().into_owned();
            if name.trim().is_empty() {
                return Err(statement.malformed("\"newmtl\" has no name"));
            }
            let definition = Definition {
                file,
                line: statement.line,
                ..Definition::default()
            };
            found.push((name, definition));
        } else if let Some((_, definition)) = found.last_mut() {
            definition.read(&statement)?;
        } else {
            // Malformed all the same.
            Definition::default().read(&statement)?;
        }
    }
    Ok(found)
}

/// Keywords that are taken, as the format spells them.
const TAKEN: [&str; 3] = ["Kd", "Ke", "map_Kd"];

impl Definition {
    fn read(&mut self, statement: &Statement) -> Result<(), ObjFault> {
        let taken = TAKEN
            .into_iter()
            .find(|keyword| statement.keyword.eq_ignore_ascii_case(keyword));
        if let Some(keyword) = taken {
            if keyword != statement.keyword {
                let respelt = format!("\"{}\" is taken as {keyword}", statement.keyword);
                self.respelt.push(respelt);
            }
            match keyword {
                "Kd" => self.diffuse = Some(colour(statement)?),
                "Ke" => self.emission = Some(colour(statement)?),
                _ if statement.rest.is_empty() => {}
                _ => self.diffuse_map = Some(statement.rest.to_owned()),
            }
            return Ok(());
        }
        let words = statement.words();
        let values: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
        let most = values.iter().copied().fold(0.0, f64::max);
        let first = values.first().copied();
        let lower = statement.keyword.to_ascii_lowercase();
        let means_something = match &lower[..] {
            "d" => {
                // "d -halo 0.5" has a factor behind its option.
                self.opacity = first;
                first.is_some_and(|d| d < 1.0)
            }
            "tr" => {
                self.transparency = first;
                // Some programs write 1 for what is opaque.
                most > 0.0 && self.opacity != Some(1.0)
            }
            "tf" => values.iter().any(|&v| v < 1.0) && most > 0.0,
            "ks" => most > DULL,
            "illum" => most >= FIRST_MIRROR,
            "pm" => most > 0.0,
            "pr" => first.is_some_and(|roughness| roughness < 1.0),
            "bump" | "disp" | "decal" | "norm" | "refl" => !words.is_empty(),
            keyword => keyword.starts_with("map_") && !words.is_empty(),
        };
        if means_something {
            let value: Vec<&str> = words.iter().map(|word| &word[..]).collect();
            self.left_out
                .push(format!("{} {}", statement.keyword, value.join(" ")));
        }
        Ok(())
    }

    /// Whether nothing of it is there to see.
    fn is_absent(&self) -> bool {
        self.opacity == Some(0.0)
    }
}

/// One number for grey, or three.
fn colour(statement: &Statement) -> Result<[f64; 3], ObjFault> {
    let words = statement.words();
    let keyword = statement.keyword;
    let [r, g, b] = match &words[..] {
        [grey] => [grey; 3],
        [r, g, b] => [r, g, b],
        _ => {
            return Err(statement.malformed(format!(
                "{keyword} has {} values, expected 3 numbers",
                words.len()
            )));
        }
    };
    let mut colour = [0.0; 3];
    for (value, word) in colour.iter_mut().zip([r, g, b]) {
        *value = word
            .parse()
            .map_err(|_| statement.malformed(format!("{keyword}: {word:?} is not a number")))?;
    }
    Ok(colour)
}
