//! Checks an OBJ file line by line and reduces it to what tobj reads safely.
//!
//! The reduced text holds first all vertices, then objects, materials and faces in their order;
//! objects and materials have numbers for names, and faces hold absolute vertex indices only, all of them in range.

use std::collections::HashMap;
use std::fmt::Write;

use glam::{DVec2, DVec3};

use super::ObjFault;
use super::lines::{Statement, lines, text, words};

/// A name that faces have.
#[derive(Debug)]
pub(super) struct Used {
    /// Empty for faces without a material.
    pub name: String,
    /// Faces that have it.
    pub faces: usize,
    /// The lines of the first statements that name it after others, at most two.
    pub lines: Vec<usize>,
}

/// An OBJ file that has passed all checks.
#[derive(Debug, Default)]
pub(super) struct Screened {
    /// `v` statements, then everything else.
    vertices: String,
    elements: String,
    /// One per face.
    pub faces: Vec<Face>,
    /// Of all faces one after the other, the corners' texture coordinates from 1, 0 where there are none.
    pub corners: Vec<u32>,
    /// `None` for those that are no numbers.
    pub texture_coordinates: Vec<Option<DVec2>>,
    /// Normals and texture coordinates that are no numbers, and the line of the first of them.
    pub bad_numbers: usize,
    pub first_bad_number: Option<usize>,
    /// Arguments of all `mtllib` statements.
    pub libraries: Vec<Vec<u8>>,
    /// Materials by first use.
    pub materials: Vec<Used>,
    /// Objects by first use; the materials if no statement names any.
    pub objects: Vec<Used>,
    /// Whether some statement names an object.
    pub has_objects: bool,
    pub points_and_lines: usize,
    /// Faces of fewer than three corners, which are among these.
    pub short_faces: usize,
    /// The line of the first of them.
    pub first_short_face: Option<usize>,
}

/// What is known of a face beside its corners.
#[derive(Clone, Copy, Debug)]
pub(super) struct Face {
    /// From 1.
    pub line: usize,
    /// The sum of the normals that the file gives its corners; 0 where it gives none.
    pub normal: DVec3,
}

impl Screened {
    /// The texture coordinate of a corner, by its number from 1.
    pub fn texture_coordinate(&self, number: u32) -> Option<DVec2> {
        let index = (number as usize).checked_sub(1)?;
        self.texture_coordinates.get(index).copied().flatten()
    }

    /// Lets tobj read the reduced text. A model's name is its object's index, its material an index into `materials`.
    pub(super) fn parse(&self) -> Result<Vec<tobj::Model>, tobj::LoadError> {
        let text = format!("mtllib used\n{}{}", self.vertices, self.elements);
        let options = tobj::LoadOptions::default();
        let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| {
            let names = (0..self.materials.len()).map(|index| index.to_string());
            let materials = names.clone().map(|name| tobj::Material {
                name,
                ..tobj::Material::default()
            });
            Ok((materials.collect(), names.zip(0..).collect()))
        })?;
        Ok(models)
    }
}

/// Checks a file and reduces it.
pub(super) fn screen(bytes: &[u8]) -> Result<Screened, ObjFault> {
    let text = text(bytes)?;
    let mut screener = Screener::default();
    // Faces may come before what they are made of.
    let mut normals = Vec::new();
    for statement in lines(text).filter_map(Statement::new) {
        match statement.keyword {
            "v" => screener.total_vertices += 1,
            "o" | "g" => screener.screened.has_objects = true,
            "vn" | "vt" => {
                let found = numbers(&statement);
                if found.is_none() {
                    screener.screened.bad_numbers += 1;
                    let first = &mut screener.screened.first_bad_number;
                    first.get_or_insert(statement.line);
                }
                if statement.keyword == "vn" {
                    normals.push(found.map_or(DVec3::ZERO, DVec3::from));
                } else {
                    let place = found.map(|[u, v, _]| DVec2::new(u, v));
                    screener.screened.texture_coordinates.push(place);
                }
            }
            _ => {}
        }
    }
    screener.total_normals = normals;
    let mut saw_face = false;
    let mut lines = lines(text);
    while let Some(line) = lines.next() {
        let Some(statement) = Statement::new(line) else {
            continue;
        };
        match statement.keyword {
            "v" | "f" | "l" | "p" => {
                // Only numbers are continued over lines: a name may well end in a backslash.
                let mut numbers: Vec<String> = own(&statement);
                while let Some(last) = numbers.last_mut().filter(|word| word.ends_with('\\')) {
                    last.pop();
                    let Some((_, next)) = lines.next() else { break };
                    numbers.extend(words(next).into_iter().map(String::from));
                }
                numbers.retain(|word| !word.is_empty());
                match statement.keyword {
                    "v" => screener.vertex(&statement, &numbers)?,
                    "f" => {
                        saw_face = true;
                        screener.face(&statement, &numbers)?;
                    }
                    _ => screener.screened.points_and_lines += 1,
                }
            }
            "vn" => screener.normals += 1,
            "vt" => screener.places += 1,
            "o" | "g" => screener.object = (statement.name().into_owned(), statement.line),
            "mtllib" if !statement.rest.is_empty() => {
                screener.screened.libraries.push(statement.rest.to_owned());
            }
            "usemtl" => screener.material = (statement.name().into_owned(), statement.line),
            _ => {}
        }
    }
    let vertices = screener.total_vertices;
    let screened = screener.screened;
    if vertices == 0 && !saw_face {
        return Err(ObjFault::NotObj {
            why: "it has no vertices and no faces",
        });
    }
    if screened.faces.is_empty() {
        return Err(ObjFault::NoFaces { vertices });
    }
    Ok(screened)
}

fn own(statement: &Statement) -> Vec<String> {
    let words = statement.words().into_iter();
    words.map(String::from).collect()
}

/// Up to three numbers, 0 for those that are missing; `None` where some word is no finite number.
fn numbers(statement: &Statement) -> Option<[f64; 3]> {
    let mut numbers = [0.0; 3];
    for (number, word) in numbers.iter_mut().zip(statement.words()) {
        *number = word
            .parse()
            .ok()
            .filter(|number: &f64| number.is_finite())?;
    }
    Some(numbers)
}

#[derive(Default)]
struct Screener {
    screened: Screened,
    /// In the whole file: faces may come before their vertices.
    total_vertices: usize,
    total_normals: Vec<DVec3>,
    /// So far: negative indices count back from here.
    vertices: usize,
    normals: usize,
    places: usize,
    /// That of the faces that follow, and the line that says so; empty if none has yet.
    material: (String, usize),
    object: (String, usize),
    /// Indices by name.
    materials: HashMap<String, usize>,
    objects: HashMap<String, usize>,
    /// Those of the last face.
    last: [Option<usize>; 2],
}

impl Screener {
    fn vertex(&mut self, statement: &Statement, words: &[String]) -> Result<(), ObjFault> {
        self.vertices += 1;
        // What follows the position is a homogeneous w if it is one number, else a colour.
        let used = if words.len() == 4 { 4 } else { 3 };
        if words.len() < 3 {
            return Err(statement.malformed(format!(
                "vertex {} has {} coordinates, expected 3",
                self.vertices,
                words.len()
            )));
        }
        let mut values = Vec::with_capacity(words.len());
        for word in words {
            let value: f64 = word.parse().map_err(|_| {
                statement.malformed(format!(
                    "vertex {}: {word:?} is not a number",
                    self.vertices
                ))
            })?;
            values.push(value);
        }
        let w = if used == 4 { values[3] } else { 1.0 };
        let [x, y, z] = [values[0], values[1], values[2]];
        for value in [x, y, z, w, x / w, y / w, z / w] {
            if !value.is_finite() {
                return Err(ObjFault::NotFinite {
                    line: statement.line,
                    vertex: self.vertices,
                    value,
                });
            }
        }
        let _ = writeln!(self.screened.vertices, "v {}", words[..used].join(" "));
        Ok(())
    }

    fn face(&mut self, statement: &Statement, words: &[String]) -> Result<(), ObjFault> {
        let line = statement.line;
        match words.len() {
            0 => return Err(statement.malformed("a face has no corners")),
            1 | 2 => {
                self.screened.points_and_lines += 1;
                self.screened.short_faces += 1;
                self.screened.first_short_face.get_or_insert(line);
            }
            _ => self.name_face(),
        }
        let is_kept = words.len() > 2;
        let mut face = String::from("f");
        let mut normal = DVec3::ZERO;
        for word in words {
            let mut parts = word.split('/');
            let index: Option<i64> = parts.next().and_then(|part| part.parse().ok());
            let Some(index) = index.filter(|_| parts.clone().count() <= 2) else {
                return Err(statement.malformed(format!(
                    "face corner {word:?} is not a vertex index like 7, 7/1 or 7/1/2"
                )));
            };
            let absolute = from_one(index, self.vertices, self.total_vertices).ok_or(
                ObjFault::VertexIndex {
                    line,
                    index,
                    vertices: self.total_vertices,
                },
            )?;
            let _ = write!(face, " {absolute}");
            // What decides no position is taken where it is there.
            let [place, of_normal] = [parts.next(), parts.next()]
                .map(|part| part.and_then(|part| part.parse::<i64>().ok()));
            let known = self.screened.texture_coordinates.len();
            let place = place.and_then(|index| from_one(index, self.places, known));
            let found =
                of_normal.and_then(|index| from_one(index, self.normals, self.total_normals.len()));
            normal += found.map_or(DVec3::ZERO, |k| self.total_normals[k - 1]);
            if is_kept {
                self.screened.corners.push(place.unwrap_or(0) as u32);
            }
        }
        if is_kept {
            let _ = writeln!(self.screened.elements, "{face}");
            self.screened.faces.push(Face { line, normal });
        }
        Ok(())
    }

    /// Names the object and the material of a face, where they are not those of the one before.
    fn name_face(&mut self) {
        let (material, material_line) = &self.material;
        // Without any statement that names objects, the materials are the objects.
        let (object, object_line) = if self.screened.has_objects {
            &self.object
        } else {
            &self.material
        };
        let used = [
            count(
                &mut self.screened.objects,
                &mut self.objects,
                object,
                *object_line,
                self.last[0],
            ),
            count(
                &mut self.screened.materials,
                &mut self.materials,
                material,
                *material_line,
                self.last[1],
            ),
        ];
        for ((index, last), keyword) in used.into_iter().zip(self.last).zip(["o", "usemtl"]) {
            if last != Some(index) {
                let _ = writeln!(self.screened.elements, "{keyword} {index}");
            }
        }
        self.last = used.map(Some);
    }
}

/// An index that counts from 1, of one that may count back from the last so far; `None` where there is no such thing.
fn from_one(index: i64, so_far: usize, total: usize) -> Option<usize> {
    let absolute = if index < 0 {
        (so_far as i64).saturating_add(index + 1)
    } else {
        index
    };
    (1..=total as i64)
        .contains(&absolute)
        .then_some(absolute as usize)
}

/// Counts a face of a name, and gives the name's index. Where it is not that of the face before, the line that names it is
/// kept: a name of several lines is in several places of the file.
fn count(
    used: &mut Vec<Used>,
    indices: &mut HashMap<String, usize>,
    name: &str,
    line: usize,
    last: Option<usize>,
) -> usize {
    let known = last.filter(|&index| used[index].name == name);
    let index = known
        .or_else(|| indices.get(name).copied())
        .unwrap_or_else(|| {
            indices.insert(name.to_owned(), used.len());
            used.push(Used {
                name: name.to_owned(),
                faces: 0,
                lines: Vec::new(),
            });
            used.len() - 1
        });
    let found = &mut used[index];
    found.faces += 1;
    if last != Some(index) && found.lines.len() < 2 {
        found.lines.push(line);
    }
    index
}
