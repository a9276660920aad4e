//! From tobj's polygons to surfaces: centring, fanning, and dropping what has no area.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::{ImportReport, ObjFault, ObjModel};
use crate::{Material, MaterialId, ObjectId, Surface};

/// Farthest a corner of a planar polygon may lie from its mean plane, as a share of the diagonal
/// of its bounding box. Tuned: coordinates written with six digits stay well below it, and the
/// left wall of the published Cornell box, twisted by 1e-3, lies above.
const PLANARITY_TOLERANCE: f64 = 1e-4;

/// Margin on the largest extent, so that models whose extent is a power of two, which are common,
/// do not change their grid, and with it the origin, by rounding. Tuned: any odd ratio serves.
const EXTENT_MARGIN: f64 = 1.1;

/// Builds the model. `face_lines` holds the line of each face of all `models`, in their order;
/// of `materials`, the last is for the faces that have none.
pub(super) fn build(
    models: &[tobj::Model],
    face_lines: &[usize],
    materials: Vec<Material>,
    mut report: ImportReport,
) -> Result<ObjModel, ObjFault> {
    let positions: Vec<Vec<DVec3>> = models
        .iter()
        .map(|model| {
            let (points, _) = model.mesh.positions.as_chunks::<3>();
            points.iter().copied().map(DVec3::from).collect()
        })
        .collect();
    let origin = origin_of(positions.iter().flatten());

    let mut objects = Objects::default();
    let mut surfaces = Vec::new();
    let mut first_lines = FirstLines::default();
    let mut concave = 0;
    let mut triangles = 0;
    let mut lines = face_lines.iter().copied();
    for (model, positions) in models.iter().zip(&positions) {
        let mesh = &model.mesh;
        if mesh.indices.is_empty() {
            continue;
        }
        let object = objects.id(&model.name);
        let material = mesh.material_id.unwrap_or(materials.len() - 1);
        let material = MaterialId(material as u32);
        for face in faces_of(mesh) {
            let line = lines.next().unwrap_or_default();
            let polygon = face
                .iter()
                .map(|&index| centred(positions[index as usize], origin, line))
                .collect::<Result<Vec<Vec3>, _>>()?;
            if polygon.len() > 3 {
                report.polygons_fanned += 1;
                let shape = Shape::of(&polygon);
                if !shape.is_planar {
                    report.non_planar_polygons += 1;
                    first_lines.non_planar.get_or_insert(line);
                }
                if shape.is_concave {
                    concave += 1;
                    first_lines.concave.get_or_insert(line);
                }
            }
            for pair in polygon[1..].windows(2) {
                triangles += 1;
                let surface = Surface {
                    corners: [polygon[0], pair[0], pair[1]],
                    material,
                    object,
                };
                if surface.is_degenerate() {
                    report.degenerate_dropped += 1;
                    first_lines.degenerate.get_or_insert(line);
                } else {
                    surfaces.push(surface);
                }
            }
        }
    }
    if surfaces.is_empty() {
        return Err(ObjFault::NothingLeft { triangles });
    }
    first_lines.warn(concave, triangles, &mut report);
    Ok(ObjModel {
        materials,
        objects: objects.names,
        surfaces,
        origin,
        report,
    })
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

/// What fanning has to know of a polygon with four or more corners.
struct Shape {
    is_planar: bool,
    /// Some triangle of the fan faces away from the polygon.
    is_concave: bool,
}

impl Shape {
    fn of(polygon: &[Vec3]) -> Self {
        let corners: Vec<DVec3> = polygon.iter().map(|p| p.as_dvec3()).collect();
        let fan_normals: Vec<DVec3> = corners[1..]
            .windows(2)
            .map(|pair| (pair[0] - corners[0]).cross(pair[1] - corners[0]))
            .collect();
        // The sum is twice the vector area, whatever the corner the fan starts from.
        let normal = fan_normals.iter().sum::<DVec3>().normalize_or_zero();
        let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
        let (low, high) = corners
            .iter()
            .fold((corners[0], corners[0]), |(low, high), &p| {
                (low.min(p), high.max(p))
            });
        let tolerance = PLANARITY_TOLERANCE * low.distance(high);
        Self {
            is_planar: corners
                .iter()
                .all(|&p| (p - middle).dot(normal).abs() <= tolerance),
            // The same share again, so that rounding in a straight corner does not count.
            is_concave: fan_normals
                .iter()
                .any(|n| n.dot(normal) < -tolerance * low.distance(high)),
        }
    }
}

/// Object names, each once, by first use.
#[derive(Default)]
struct Objects {
    names: Vec<String>,
    ids: HashMap<String, ObjectId>,
}

impl Objects {
    fn id(&mut self, name: &str) -> ObjectId {
        if let Some(&id) = self.ids.get(name) {
            return id;
        }
        let id = ObjectId(self.names.len() as u32);
        self.names.push(name.to_owned());
        self.ids.insert(name.to_owned(), id);
        id
    }
}

/// The first line of each kind of trouble.
#[derive(Default)]
struct FirstLines {
    non_planar: Option<usize>,
    concave: Option<usize>,
    degenerate: Option<usize>,
}

impl FirstLines {
    fn warn(&self, concave: usize, triangles: usize, report: &mut ImportReport) {
        if let Some(line) = self.non_planar {
            report.warnings.push(format!(
                "{} of {} polygons are not planar (the first in line {line}); they are fanned from their first corner",
                report.non_planar_polygons, report.polygons_fanned
            ));
        }
        if let Some(line) = self.concave {
            report.warnings.push(format!(
                "{concave} of {} polygons are concave (the first in line {line}), so their triangles overlap; triangulate the model before the import",
                report.polygons_fanned
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
