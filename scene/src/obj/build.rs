//! From tobj's polygons to the triangles of a model.

use std::collections::{BTreeMap, HashSet};

use glam::{DVec3, Vec3};

use super::mtl::TERMS;
use super::screen::{Face, Screened, Used};
use super::{ObjFault, polygon};
use crate::import::origin::{Bounds, Overflow, centred};
use crate::import::{
    Draft, ImportOptions, ImportReport, ImportedModel, Looks, Piece, Place, Taken,
};
use crate::{ObjectId, Rgb, Surface};

/// How many names a warning has.
const MOST_NAMED: usize = 3;

/// Builds the model; `materials` has one element per material of the file.
pub(super) fn build(
    screened: &Screened,
    materials: Vec<Taken>,
    options: &ImportOptions,
    report: ImportReport,
) -> Result<ImportedModel, ObjFault> {
    let models = screened.parse().map_err(ObjFault::Parser)?;
    let positions = positions_of(&models, options.axes.unit);
    let all = positions.iter().flatten();
    let origin = all
        .fold(Bounds::NOTHING, |bounds, &p| bounds.with(p))
        .origin();

    let looks = Looks::new(materials, options, TERMS);
    let mut draft = Draft {
        pieces: Vec::new(),
        objects: object_names(screened, &looks),
        looks,
        triangles: 0,
        absent: BTreeMap::new(),
        origin,
        axes: options.axes,
        report,
    };
    let mut first_lines = FirstLines::default();
    let mut overlapping = 0;
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
                .map(|&index| centred(positions[index as usize], origin))
                .collect::<Result<Vec<Vec3>, _>>()
                .map_err(|overflow| too_far(overflow, line))?;
            let cut = polygon::triangles(&polygon);
            if polygon.len() > 3 {
                draft.report.polygons += 1;
                if !cut.is_planar {
                    draft.report.non_planar_polygons += 1;
                    first_lines.non_planar.get_or_insert(line);
                }
                if cut.overlap {
                    overlapping += 1;
                    first_lines.overlapping.get_or_insert(line);
                }
            }
            let agreement = cut.normal.dot(normal);
            for corners in cut.corners {
                let face = draft.triangles as u32;
                draft.triangles += 1;
                if draft.leaves_out(material) {
                    continue;
                }
                let at = corners.map(|k| screened.texture_coordinate(of_corners[k]));
                let place = Place {
                    of_reflectance: at,
                    of_emission: [None; 3],
                    tint: Rgb::ONE,
                };
                let warnings = &mut draft.report.warnings;
                let surface = Surface {
                    corners: corners.map(|k| polygon[k]),
                    material: draft.looks.id(material, &place, warnings),
                    object,
                };
                if surface.is_degenerate() {
                    draft.report.degenerate_dropped += 1;
                    first_lines.degenerate.get_or_insert(line);
                } else {
                    draft.pieces.push(Piece {
                        surface,
                        face,
                        place: line,
                        is_against: (agreement != 0.0).then_some(agreement < 0.0),
                    });
                }
            }
        }
    }
    draft.warn_of_absent();
    if draft.pieces.is_empty() {
        let triangles = draft.triangles;
        return Err(match first_lines.degenerate {
            Some(_) => ObjFault::NothingLeft { triangles },
            None => ObjFault::AllTransparent { triangles },
        });
    }
    first_lines.warn(overlapping, draft.triangles, &mut draft.report);
    if screened.has_objects {
        warn_of_places(&screened.objects, &mut draft.report);
    }
    Ok(draft.finish(options, &|line| format!("line {line}")))
}

fn too_far(overflow: Overflow, line: usize) -> ObjFault {
    let Overflow { value, from_centre } = overflow;
    ObjFault::Overflow {
        line,
        value,
        from_centre,
    }
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
