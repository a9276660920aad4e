//! Checks an OBJ file line by line and reduces it to what tobj reads safely.
//!
//! The reduced text holds first all vertices, then objects, materials and faces in their order;
//! faces hold absolute vertex indices only, all of them in range.

use std::borrow::Cow;
use std::collections::HashMap;
use std::fmt::Write;

use super::ObjFault;

/// A material that faces use.
#[derive(Debug)]
pub(super) struct UsedMaterial {
    pub name: String,
    /// Faces that use it.
    pub faces: usize,
}

/// An OBJ file that has passed all checks.
#[derive(Debug, Default)]
pub(super) struct Screened {
    /// `v` statements, then everything else.
    vertices: String,
    elements: String,
    /// Line of each face, from 1; one per face.
    pub face_lines: Vec<usize>,
    /// Arguments of all `mtllib` statements.
    pub libraries: Vec<String>,
    /// By first use.
    pub used_materials: Vec<UsedMaterial>,
    pub faces_without_material: usize,
    pub points_and_lines: usize,
    /// Faces of fewer than three corners, which are among these.
    pub short_faces: usize,
    /// The line of the first of them.
    pub first_short_face: Option<usize>,
}

impl Screened {
    /// Lets tobj read the reduced text. A model's material is an index into `used_materials`.
    pub(super) fn parse(&self) -> Result<Vec<tobj::Model>, tobj::LoadError> {
        let text = format!("mtllib used\n{}{}", self.vertices, self.elements);
        let options = tobj::LoadOptions::default();
        let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| {
            let materials = self.used_materials.iter().map(|used| tobj::Material {
                name: used.name.clone(),
                ..tobj::Material::default()
            });
            let indices = self.used_materials.iter().enumerate();
            Ok((
                materials.collect(),
                indices.map(|(i, used)| (used.name.clone(), i)).collect(),
            ))
        })?;
        Ok(models)
    }
}

/// The text of an OBJ or MTL file. Names in old encodings are common, hence lossily.
pub(super) fn decode(bytes: &[u8]) -> Cow<'_, str> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    String::from_utf8_lossy(bytes)
}

pub(super) fn malformed(line: usize, what: impl Into<String>) -> ObjFault {
    ObjFault::Statement {
        line,
        what: what.into(),
    }
}

/// Checks a file and reduces it.
pub(super) fn screen(bytes: &[u8]) -> Result<Screened, ObjFault> {
    if bytes.is_empty() {
        return Err(ObjFault::Empty);
    }
    if bytes.contains(&0) {
        return Err(ObjFault::NotObj {
            why: "it holds binary data",
        });
    }
    let text = decode(bytes);
    let vertices = text
        .lines()
        .filter(|l| l.split_whitespace().next() == Some("v"))
        .count();
    let mut screener = Screener {
        screened: Screened::default(),
        total_vertices: vertices,
        vertices: 0,
        material: None,
        indices: HashMap::new(),
    };
    let mut saw_face = false;
    let mut lines = text.lines().enumerate();
    while let Some((index, line)) = lines.next() {
        let number = index + 1;
        let (keyword, rest) = statement(line);
        let name = name_of(rest);
        match keyword {
            "v" | "f" | "l" | "p" => {
                // Only numbers are continued over lines: a name may well end in a backslash.
                let mut numbers = without_comment(rest).to_owned();
                while let Some(start) = numbers.strip_suffix('\\') {
                    numbers.truncate(start.len());
                    let Some((_, next)) = lines.next() else { break };
                    numbers.push(' ');
                    numbers.push_str(without_comment(next));
                }
                match keyword {
                    "v" => screener.vertex(number, &numbers)?,
                    "f" => {
                        saw_face = true;
                        screener.face(number, &numbers)?;
                    }
                    _ => screener.screened.points_and_lines += 1,
                }
            }
            "o" | "g" => {
                let _ = writeln!(screener.screened.elements, "o {name}");
            }
            "mtllib" if !rest.is_empty() => screener.screened.libraries.push(rest.to_owned()),
            "usemtl" => {
                if name.is_empty() {
                    return Err(malformed(number, "\"usemtl\" names no material"));
                }
                screener.material = Some(name.to_owned());
                let _ = writeln!(screener.screened.elements, "usemtl {name}");
            }
            _ => {}
        }
    }
    let screened = screener.screened;
    if vertices == 0 && !saw_face {
        return Err(ObjFault::NotObj {
            why: "it has no vertices and no faces",
        });
    }
    if screened.face_lines.is_empty() {
        return Err(ObjFault::NoFaces { vertices });
    }
    Ok(screened)
}

/// A line's keyword and the rest.
pub(super) fn statement(line: &str) -> (&str, &str) {
    let line = line.trim();
    line.split_once(char::is_whitespace)
        .map_or((line, ""), |(keyword, rest)| (keyword, rest.trim()))
}

/// Where the comment behind a name starts: at a "#" that follows a space. Inside and at the start
/// of a name a "#" is part of it, unless it stands alone.
pub(crate) fn comment_start(rest: &str) -> Option<usize> {
    let is_comment = |&at: &usize| {
        let (before, after) = (&rest[..at], &rest[at + 1..]);
        if before.is_empty() {
            after.chars().next().is_none_or(char::is_whitespace)
        } else {
            before.ends_with(char::is_whitespace)
        }
    };
    rest.match_indices('#').map(|(at, _)| at).find(is_comment)
}

/// A name without the comment behind it.
pub(super) fn name_of(rest: &str) -> &str {
    comment_start(rest).map_or(rest, |at| rest[..at].trim_end())
}

/// Numbers without the comment behind them.
fn without_comment(line: &str) -> &str {
    line.split('#').next().unwrap_or_default().trim()
}

struct Screener {
    screened: Screened,
    /// In the whole file: faces may come before their vertices.
    total_vertices: usize,
    /// So far: negative indices count back from here.
    vertices: usize,
    material: Option<String>,
    /// Of `used_materials`, by name.
    indices: HashMap<String, usize>,
}

impl Screener {
    fn vertex(&mut self, line: usize, numbers: &str) -> Result<(), ObjFault> {
        self.vertices += 1;
        let words: Vec<&str> = numbers.split_whitespace().collect();
        // What follows the position is a homogeneous w if it is one number, else a colour.
        let used = if words.len() == 4 { 4 } else { 3 };
        let Some(words) = words.get(..used) else {
            return Err(malformed(
                line,
                format!(
                    "vertex {} has {} coordinates, expected 3",
                    self.vertices,
                    words.len()
                ),
            ));
        };
        let mut values = [0.0_f64, 0.0, 0.0, 1.0];
        for (value, word) in values.iter_mut().zip(words) {
            *value = word.parse().map_err(|_| {
                malformed(
                    line,
                    format!("vertex {}: {word:?} is not a number", self.vertices),
                )
            })?;
        }
        let [x, y, z, w] = values;
        for value in [x, y, z, w, x / w, y / w, z / w] {
            if !value.is_finite() {
                return Err(ObjFault::NotFinite {
                    line,
                    vertex: self.vertices,
                    value,
                });
            }
        }
        let _ = writeln!(self.screened.vertices, "v {}", words.join(" "));
        Ok(())
    }

    fn face(&mut self, line: usize, numbers: &str) -> Result<(), ObjFault> {
        let start = self.screened.elements.len();
        self.screened.elements.push('f');
        let mut corners = 0;
        for word in numbers.split_whitespace() {
            corners += 1;
            let mut parts = word.split('/');
            let index: Option<i64> = parts.next().and_then(|part| part.parse().ok());
            let Some(index) = index.filter(|_| parts.count() <= 2) else {
                return Err(malformed(
                    line,
                    format!("face corner {word:?} is not a vertex index like 7, 7/1 or 7/1/2"),
                ));
            };
            let absolute = if index < 0 {
                (self.vertices as i64).saturating_add(index + 1)
            } else {
                index
            };
            if absolute < 1 || absolute > self.total_vertices as i64 {
                return Err(ObjFault::VertexIndex {
                    line,
                    index,
                    vertices: self.total_vertices,
                });
            }
            let _ = write!(self.screened.elements, " {absolute}");
        }
        match corners {
            0 => return Err(malformed(line, "a face has no corners")),
            1 | 2 => {
                self.screened.elements.truncate(start);
                self.screened.points_and_lines += 1;
                self.screened.short_faces += 1;
                self.screened.first_short_face.get_or_insert(line);
            }
            _ => {
                self.screened.elements.push('\n');
                self.screened.face_lines.push(line);
                self.count_material();
            }
        }
        Ok(())
    }

    fn count_material(&mut self) {
        let Some(name) = &self.material else {
            self.screened.faces_without_material += 1;
            return;
        };
        let used = &mut self.screened.used_materials;
        if let Some(&index) = self.indices.get(name) {
            used[index].faces += 1;
        } else {
            self.indices.insert(name.clone(), used.len());
            used.push(UsedMaterial {
                name: name.clone(),
                faces: 1,
            });
        }
    }
}
