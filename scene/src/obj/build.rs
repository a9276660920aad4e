//! From tobj's polygons to surfaces: centring, triangles, and dropping what has no area.

use std::collections::{BTreeMap, HashSet};

use glam::{DVec3, Vec3};

use super::looks::{Kept, Looks};
use super::mtl::Taken;
use super::repairs::{drop_repeated, turn_to_normals};
use super::screen::{Face, Screened, Used};
use super::{ImportOptions, ImportReport, ObjFault, ObjModel, polygon};
use crate::{ObjectId, Surface};

/// Margin on the largest extent, so that models whose extent is a power of two, which are common,
/// do not change their grid, and with it the origin, by rounding. Tuned: any odd ratio serves.
const EXTENT_MARGIN: f64 = 1.1;

/// How many names a warning has.
const MOST_NAMED: usize = 3;

/// A triangle on its way to a surface.
pub(super) struct Piece {
    pub surface: Surface,
    /// The file's triangle, from 0.
    pub face: u32,
    pub line: usize,
    /// Whether the file's own normals are on its back; `None` where there are none.
    pub is_against: Option<bool>,
}

/// Builds the model; `materials` has one element per material of the file.
pub(super) fn build(
    screened: &Screened,
    materials: Vec<Taken>,
    options: &ImportOptions,
    mut report: ImportReport,
) -> Result<ObjModel, ObjFault> {
    let models = screened.parse().map_err(ObjFault::Parser)?;
    let positions = positions_of(&models, options.axes.unit);
    let origin = origin_of(positions.iter().flatten());

    let mut looks = Looks::new(materials);
    let mut pieces: Vec<Piece> = Vec::new();
    let mut first_lines = FirstLines::default();
    let mut overlapping = 0;
    let mut triangles = 0_usize;
    let mut absent = BTreeMap::new();
    let mut faces = screened.faces.iter();
    let mut places = &screened.corners[..];
    for (model, positions) in models.iter().zip(&positions) {
        let mesh = &model.mesh;
        // Screened files name objects by their numbers, and each face has a material.
        let object = ObjectId(model.name.parse().unwrap_or_default());
        let material = mesh.material_id.unwrap_or_default();
        for (corners, &Face { line, normal }) in faces_of(mesh).zip(&mut faces) {
            let (of_corners, rest) = places.split_at(corners.len());
            places = rest;
            let polygon = corners
                .iter()
                .map(|&index| centred(positions[index as usize], origin, line))
                .collect::<Result<Vec<Vec3>, _>>()?;
            let cut = polygon::triangles(&polygon);
            if polygon.len() > 3 {
                report.polygons += 1;
                if !cut.is_planar {
                    report.non_planar_polygons += 1;
                    first_lines.non_planar.get_or_insert(line);
                }
                if cut.overlap {
                    overlapping += 1;
                    first_lines.overlapping.get_or_insert(line);
                }
            }
            let agreement = cut.normal.dot(normal);
            for corners in cut.corners {
                let face = triangles as u32;
                triangles += 1;
                if looks.is_absent(material) {
                    *absent.entry(material).or_insert(0) += 1;
                    continue;
                }
                let at = corners.map(|k| screened.texture_coordinate(of_corners[k]));
                let surface = Surface {
                    corners: corners.map(|k| polygon[k]),
                    material: looks.id(material, at, &mut report.warnings),
                    object,
                };
                if surface.is_degenerate() {
                    report.degenerate_dropped += 1;
                    first_lines.degenerate.get_or_insert(line);
                } else {
                    pieces.push(Piece {
                        surface,
                        face,
                        line,
                        is_against: (agreement != 0.0).then_some(agreement < 0.0),
                    });
                }
            }
        }
    }
    for (material, count) in absent {
        report.warnings.push(format!(
            "material \"{}\" is wholly transparent (d 0): its {count} triangles are left out",
            screened.materials[material].name
        ));
    }
    if pieces.is_empty() {
        return Err(ObjFault::NothingLeft { triangles });
    }
    first_lines.warn(overlapping, triangles, &mut report);
    if screened.has_objects {
        warn_of_places(&screened.objects, &mut report);
    }
    let objects = object_names(screened, &looks);
    turn_to_normals(&mut pieces, options.orient, &mut report);
    drop_repeated(&mut pieces, &looks, &objects, triangles, &mut report);
    let (materials, pictures) = looks.into_materials();
    let mut kept_materials = Kept::new(materials.len());
    let mut kept_objects = Kept::new(objects.len());
    for Piece { surface, .. } in &mut pieces {
        surface.material.0 = kept_materials.id(surface.material.index());
        surface.object.0 = kept_objects.id(surface.object.index());
    }
    Ok(ObjModel {
        materials: kept_materials.of(&materials),
        objects: kept_objects.of(&objects),
        faces: pieces.iter().map(|piece| piece.face).collect(),
        surfaces: pieces.into_iter().map(|piece| piece.surface).collect(),
        origin,
        axes: options.axes,
        report,
        files: pictures,
    })
}

/// The vertices of each model, metres.
fn positions_of(models: &[tobj::Model], unit: f64) -> Vec<Vec<DVec3>> {
    let of_model = |model: &tobj::Model| {
        let (points, _) = model.mesh.positions.as_chunks::<3>();
        let in_metres = |&point: &[f64; 3]| unit * DVec3::from(point);
        points.iter().map(in_metres).collect()
    };
    models.iter().map(of_model).collect()
}

/// Names of the objects. In a file that names none they are those of the materials.
fn object_names(screened: &Screened, looks: &Looks) -> Vec<String> {
    let objects = &screened.objects;
    let trimmed = |used: &Used| used.name.trim_end().to_owned();
    let different: HashSet<String> = objects.iter().map(trimmed).collect();
    let name = |used: &Used| match &used.name[..] {
        // Spaces behind a name are kept where they tell it from another one.
        name if different.len() < objects.len() => name.to_owned(),
        _ => trimmed(used),
    };
    if screened.has_objects {
        let named = |used: &Used| {
            let name = name(used);
            if name.is_empty() {
                "unnamed".into()
            } else {
                name
            }
        };
        objects.iter().map(named).collect()
    } else {
        looks.names()
    }
}

/// Tells of objects that are in several places of the file.
fn warn_of_places(objects: &[Used], report: &mut ImportReport) {
    let several: Vec<String> = objects
        .iter()
        .filter(|used| !used.name.is_empty())
        .filter_map(|used| match used.lines[..] {
            [first, second] => Some(format!("\"{}\" (lines {first} and {second})", used.name)),
            _ => None,
        })
        .collect();
    if several.is_empty() {
        return;
    }
    let more = several.len().saturating_sub(MOST_NAMED);
    let more = if more > 0 {
        format!(", and {more} more")
    } else {
        String::new()
    };
    report.warnings.push(format!(
        "objects of one name in several places of the file are one object: {}{more}",
        several[..several.len().min(MOST_NAMED)].join(", ")
    ));
}

/// Vertex indices of each face.
fn faces_of(mesh: &tobj::Mesh) -> impl Iterator<Item = &[u32]> {
    // tobj leaves the arities out where all are 3.
    let all_triangles = mesh.face_arities.is_empty();
    let triangles = if all_triangles {
        mesh.indices.len() / 3
    } else {
        0
    };
    let mut rest = &mesh.indices[..];
    mesh.face_arities
        .iter()
        .copied()
        .chain(std::iter::repeat_n(3, triangles))
        .map_while(move |arity| {
            let (face, after) = rest.split_at_checked(arity as usize)?;
            rest = after;
            Some(face)
        })
}

/// The middle of the bounding box, rounded as the module's documentation says.
fn origin_of<'a>(positions: impl Iterator<Item = &'a DVec3>) -> DVec3 {
    let (low, high) = positions.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), &p| {
        (low.min(p), high.max(p))
    });
    let grid = (EXTENT_MARGIN * (high - low).max_element())
        .log2()
        .ceil()
        .exp2();
    let origin = ((0.5 * low + 0.5 * high) / grid).round() * grid;
    // Not finite only for extents of zero, or beyond f32, where an error follows.
    if origin.is_finite() {
        origin + DVec3::ZERO // no negative zeros
    } else {
        DVec3::ZERO
    }
}

fn centred(position: DVec3, origin: DVec3, line: usize) -> Result<Vec3, ObjFault> {
    let centred = (position - origin).as_vec3();
    for axis in 0..3 {
        if !centred[axis].is_finite() {
            return Err(ObjFault::Overflow {
                line,
                value: position[axis],
                from_centre: (position - origin)[axis],
            });
        }
    }
    Ok(centred)
}

/// The first line of each kind of trouble.
#[derive(Default)]
struct FirstLines {
    non_planar: Option<usize>,
    overlapping: Option<usize>,
    degenerate: Option<usize>,
}

impl FirstLines {
    fn warn(&self, overlapping: usize, triangles: usize, report: &mut ImportReport) {
        if let Some(line) = self.non_planar {
            report.warnings.push(format!(
                "{} of {} polygons are not planar (the first in line {line}); they are fanned from their first corner",
                report.non_planar_polygons, report.polygons
            ));
        }
        if let Some(line) = self.overlapping {
            report.warnings.push(format!(
                "{overlapping} of {} polygons cross themselves, or are concave and not planar (the first in line {line}), so their triangles overlap; triangulate the model before the import",
                report.polygons
            ));
        }
        if let Some(line) = self.degenerate {
            report.warnings.push(format!(
                "{} of {triangles} triangles have no area and are dropped (the first in line {line})",
                report.degenerate_dropped
            ));
        }
    }
}
