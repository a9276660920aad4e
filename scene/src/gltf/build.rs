//! From a document to the triangles of a model.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use gltf::json::{self, Root};

use super::GltfFault;
use super::document::{Document, unknown_extensions};
use super::error::wrong;
use super::lights::{self, Body};
use super::materials::{Materials, TERMS};
use super::nodes::{self, Names, Placed};
use super::primitive::{Primitive, draws_points_or_lines};
use crate::import::origin::{Bounds, Overflow, centred};
use crate::import::{Draft, ImportOptions, ImportReport, ImportedModel, Looks, Piece};
use crate::{Axis, MAX_PATCHES, MaterialId, ModelAxes, ObjectId, Surface};

/// A primitive, and the number of its material.
struct Part<'a> {
    primitive: Primitive<'a>,
    material: usize,
    is_double_sided: bool,
}

/// An object: a node with its mesh.
struct Instance<'a> {
    placed: Placed<'a>,
    /// Index of the mesh.
    mesh: usize,
    /// The number of its first triangle.
    start: usize,
}

/// Builds the model.
pub(super) fn build(
    document: &Document,
    options: &ImportOptions,
) -> Result<ImportedModel, GltfFault> {
    let mut report = ImportReport::default();
    let placed = nodes::placed(&document.root, &mut report.warnings)?;
    let mut materials = Materials::new(document, options);
    let mut names = Names::default();
    let Content {
        meshes,
        instances,
        mut objects,
    } = content(document, &placed, &mut materials, &mut names, &mut report)?;
    let bodies = lights::bodies(document, &placed, options, &mut report.warnings)?;
    report.warnings.extend(left_out(&document.root));

    let model_from_node = |instance: &Instance, position: DVec3| {
        options.axes.unit * instance.placed.model_from_node.transform_point3(position)
    };
    let mut bounds = Bounds::NOTHING;
    for instance in &instances {
        for Part { primitive, .. } in &meshes[&instance.mesh] {
            for triangle in 0..primitive.triangles {
                for position in primitive.positions(primitive.vertices(triangle)?)? {
                    bounds = bounds.with(model_from_node(instance, position));
                }
            }
        }
    }
    for corner in bodies
        .iter()
        .flat_map(|body| body.triangles.iter().flatten())
    {
        bounds = bounds.with(*corner);
    }
    let origin = bounds.origin();

    let first_of_bodies = objects.len();
    objects.extend(bodies.iter().map(|body| names.name(&body.name)));
    report.warnings.extend(names.warning());
    let of_bodies: Vec<usize> = bodies
        .iter()
        .map(|body| materials.add(body.material.clone()))
        .collect();
    let mut draft = Draft {
        pieces: Vec::new(),
        looks: Looks::new(materials.into_taken(), options, TERMS),
        objects,
        triangles: 0,
        absent: BTreeMap::new(),
        origin,
        axes: ModelAxes {
            up: options.axes.up.or(Some(Axis::Y)),
            ..options.axes
        },
        report,
    };
    let mut first_degenerate = None;
    for (object, instance) in instances.iter().enumerate() {
        // A mirror turns the winding round, but not the front.
        let is_mirrored = instance.placed.model_from_node.matrix3.determinant() < 0.0;
        for part in &meshes[&instance.mesh] {
            for triangle in 0..part.primitive.triangles {
                let place = draft.triangles;
                draft.triangles += 1;
                if draft.leaves_out(part.material) {
                    continue;
                }
                let vertices = part.primitive.vertices(triangle)?;
                let local = part.primitive.positions(vertices)?;
                let at = part.primitive.coordinates(vertices)?;
                let mut corners = [glam::Vec3::ZERO; 3];
                for (corner, position) in corners.iter_mut().zip(local) {
                    let position = model_from_node(instance, position);
                    *corner = centred(position, origin)
                        .map_err(|overflow| too_far(instance.placed, overflow))?;
                }
                if is_mirrored {
                    corners.swap(1, 2);
                }
                let surface = Surface {
                    corners,
                    material: draft
                        .looks
                        .id(part.material, at, &mut draft.report.warnings),
                    object: ObjectId(object as u32),
                };
                if surface.is_degenerate() {
                    draft.report.degenerate_dropped += 1;
                    first_degenerate.get_or_insert(place);
                } else if part.is_double_sided {
                    push_both_sides(&mut draft.pieces, surface, place);
                } else {
                    draft.pieces.push(Piece {
                        surface,
                        face: place as u32,
                        place,
                        is_against: part.primitive.is_against(vertices, local)?,
                    });
                }
            }
        }
    }
    draft.warn_of_absent();
    if draft.pieces.is_empty() {
        return Err(GltfFault::NothingLeft {
            triangles: draft.triangles,
        });
    }
    let starts: Vec<usize> = instances.iter().map(|instance| instance.start).collect();
    let named = draft.objects.clone();
    let place = |place: usize| {
        let instance = starts.partition_point(|&start| start <= place).max(1) - 1;
        match (starts.get(instance), named.get(instance)) {
            (Some(start), Some(name)) => {
                format!("triangle {} of object \"{name}\"", place - start + 1)
            }
            _ => format!("triangle {}", place + 1),
        }
    };
    if let Some(first) = first_degenerate {
        draft.report.warnings.push(format!(
            "{} of {} triangles have no area and are dropped (the first is {})",
            draft.report.degenerate_dropped,
            draft.triangles,
            place(first)
        ));
    }
    for ((body, material), object) in bodies.iter().zip(of_bodies).zip(first_of_bodies..) {
        add_body(&mut draft, body, material, object)?;
    }
    let mut model = draft.finish(options, &place);
    model.files.extend(document.files.iter().cloned());
    Ok(model)
}

/// What nodes have.
struct Content<'a> {
    /// By index; only those that some node has.
    meshes: HashMap<usize, Vec<Part<'a>>>,
    /// One per object.
    instances: Vec<Instance<'a>>,
    objects: Vec<String>,
}

/// Opens the meshes of all nodes.
fn content<'a>(
    document: &'a Document,
    placed: &[Placed<'a>],
    materials: &mut Materials,
    names: &mut Names,
    report: &mut ImportReport,
) -> Result<Content<'a>, GltfFault> {
    let mut content = Content {
        meshes: HashMap::new(),
        instances: Vec::new(),
        objects: Vec::new(),
    };
    let mut start = 0;
    for &placed in placed {
        let Some(index) = placed.node.mesh else {
            continue;
        };
        let number = index.value();
        if !content.meshes.contains_key(&number) {
            let parts = parts(document, number, materials, report)?;
            content.meshes.insert(number, parts);
        }
        let triangles: usize = content.meshes[&number]
            .iter()
            .map(|part| part.primitive.triangles)
            .fold(0, usize::saturating_add);
        if triangles == 0 {
            continue;
        }
        let of_mesh = document.get(index)?.name.as_ref();
        let name = placed.node.name.as_ref().or(of_mesh);
        let name = name.filter(|name| !name.trim().is_empty()).cloned();
        let name = name.unwrap_or_else(|| format!("node {}", placed.index));
        content.objects.push(names.name(&name));
        content.instances.push(Instance {
            placed,
            mesh: number,
            start,
        });
        start = start.saturating_add(triangles);
        if start as u64 > u64::from(MAX_PATCHES) {
            let triangles = start as u64;
            return Err(GltfFault::TooManyTriangles { triangles });
        }
    }
    if start == 0 {
        return Err(GltfFault::NoTriangles);
    }
    report.faces = start;
    Ok(content)
}

/// The primitives of a mesh that draw triangles.
fn parts<'a>(
    document: &'a Document,
    index: usize,
    materials: &mut Materials,
    report: &mut ImportReport,
) -> Result<Vec<Part<'a>>, GltfFault> {
    let Some(mesh) = document.root.meshes.get(index) else {
        return Err(wrong(format!("meshes[{index}]"), "nothing has this index"));
    };
    let mut parts = Vec::new();
    for (k, primitive) in mesh.primitives.iter().enumerate() {
        if draws_points_or_lines(primitive) {
            report.points_and_lines_ignored += 1;
            continue;
        }
        let material = materials.number(primitive.material, &mut report.warnings)?;
        let used = materials.used(material);
        let thing = format!("meshes[{index}].primitives[{k}]");
        parts.push(Part {
            primitive: Primitive::open(document, primitive, &thing, used.mappings)?,
            material,
            is_double_sided: used.is_double_sided,
        });
    }
    Ok(parts)
}

/// Adds a triangle that has fronts on both sides.
fn push_both_sides(pieces: &mut Vec<Piece>, surface: Surface, place: usize) {
    let [a, b, c] = surface.corners;
    for corners in [[a, b, c], [a, c, b]] {
        pieces.push(Piece {
            surface: Surface { corners, ..surface },
            face: place as u32,
            place,
            is_against: None,
        });
    }
}

/// Adds what stands in for a light.
fn add_body(
    draft: &mut Draft,
    body: &Body,
    material: usize,
    object: usize,
) -> Result<(), GltfFault> {
    for corners in &body.triangles {
        let place = draft.triangles;
        draft.triangles += 1;
        let mut rounded = [glam::Vec3::ZERO; 3];
        for (rounded, &corner) in rounded.iter_mut().zip(corners) {
            *rounded = centred(corner, draft.origin).map_err(|overflow| GltfFault::Overflow {
                thing: format!("light \"{}\"", body.name),
                value: overflow.value,
                from_centre: overflow.from_centre,
            })?;
        }
        let surface = Surface {
            corners: rounded,
            material: MaterialId(material as u32),
            object: ObjectId(object as u32),
        };
        if surface.is_degenerate() {
            return Err(wrong(
                format!("light \"{}\"", body.name),
                "the model is so large that the body that stands in for it vanishes in rounding; give a larger --light-radius",
            ));
        }
        draft.pieces.push(Piece {
            surface,
            face: place as u32,
            place,
            is_against: None,
        });
    }
    Ok(())
}

fn too_far(placed: Placed, overflow: Overflow) -> GltfFault {
    let Overflow { value, from_centre } = overflow;
    GltfFault::Overflow {
        thing: nodes::thing(placed.index, placed.node),
        value,
        from_centre,
    }
}

/// Tells what the file has that no still picture of triangles shows.
fn left_out(root: &Root) -> Vec<String> {
    let mut warnings = Vec::new();
    let primitives = || root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let having = |has: fn(&json::mesh::Primitive) -> bool| primitives().filter(|p| has(p)).count();
    let found: Vec<String> = [
        (root.animations.len(), "animations"),
        (root.cameras.len(), "cameras"),
        (root.skins.len(), "skins"),
        (having(|p| p.targets.is_some()), "primitives' morph targets"),
        (
            having(draws_points_or_lines),
            "primitives of points or lines",
        ),
        (having(has_colours), "primitives' vertex colours"),
    ]
    .into_iter()
    .filter(|&(count, _)| count > 0)
    .map(|(count, what)| format!("{what} ({count})"))
    .collect();
    if !found.is_empty() {
        warnings.push(format!(
            "left out: {}; meshes stay as they are at rest",
            found.join(", ")
        ));
    }
    let unknown = unknown_extensions(root);
    if !unknown.is_empty() {
        warnings.push(format!(
            "extensions that are not known are left out: {}",
            unknown.join(", ")
        ));
    }
    warnings
}

fn has_colours(primitive: &json::mesh::Primitive) -> bool {
    let mut semantics = primitive.attributes.keys();
    semantics.any(|semantic| matches!(semantic, Checked::Valid(Semantic::Colors(_))))
}
