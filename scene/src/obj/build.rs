//! From tobj's polygons to surfaces: centring, triangles, and dropping what has no area.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::{ImportReport, ObjFault, ObjModel, polygon};
use crate::weld::{Place, places};
use crate::{Material, MaterialId, ObjectId, Surface};

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
    let mut surfaces: Vec<Surface> = Vec::new();
    let mut faces = Vec::new();
    let mut surface_lines = Vec::new();
    let mut first_lines = FirstLines::default();
    let mut overlapping = 0;
    let mut triangles = 0_usize;
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
            for corners in cut.corners {
                let face = triangles as u32;
                triangles += 1;
                let surface = Surface {
                    corners: corners.map(|k| polygon[k]),
                    material,
                    object,
                };
                if surface.is_degenerate() {
                    report.degenerate_dropped += 1;
                    first_lines.degenerate.get_or_insert(line);
                } else {
                    surfaces.push(surface);
                    faces.push(face);
                    surface_lines.push(line);
                }
            }
        }
    }
    if surfaces.is_empty() {
        return Err(ObjFault::NothingLeft { triangles });
    }
    first_lines.warn(overlapping, triangles, &mut report);
    if let Some(repeated) = Repeated::among(&surfaces) {
        report.warnings.push(format!(
            "{} of {triangles} triangles have the same corners and front as one before (the first in line {}, of object \"{}\"); all are kept, but only one of them is seen in each place: remove the others from the model",
            repeated.count,
            surface_lines[repeated.first],
            objects.names[surfaces[repeated.first].object.index()],
        ));
    }
    Ok(ObjModel {
        materials,
        objects: objects.names,
        surfaces,
        faces,
        origin,
        report,
    })
}

/// Triangles that lie where another one lies, facing the same way.
struct Repeated {
    count: usize,
    /// The index of the first of them.
    first: usize,
}

impl Repeated {
    fn among(surfaces: &[Surface]) -> Option<Self> {
        let keys = surfaces.iter().map(|surface| places(surface.corners));
        let mut keyed: Vec<([Place; 3], usize)> = keys.zip(0..).collect();
        keyed.sort_unstable();
        let repeated = keyed
            .windows(2)
            .filter(|pair| pair[0].0 == pair[1].0)
            .map(|pair| pair[1].1);
        let (count, first) = repeated.fold((0, usize::MAX), |(count, first), index| {
            (count + 1, first.min(index))
        });
        (count > 0).then_some(Self { count, first })
    }
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
