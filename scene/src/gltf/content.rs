//! What a document has for a model: its objects, the primitives of their meshes, and what is left out.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::DVec3;

use super::GltfFault;
use super::document::Document;
use super::error::wrong;
use super::extensions::unknown;
use super::materials::Materials;
use super::morphs;
use super::names::{Names, first_name};
use super::nodes::{Hierarchy, Placed};
use super::primitive::{Primitive, draws_points_or_lines, has_no_positions};
use super::skins::{self, Pose};
use crate::MAX_PATCHES;
use crate::import::ImportReport;

/// A primitive, and the number of its material.
pub(super) struct Part<'a> {
    pub primitive: Primitive<'a>,
    pub material: usize,
    pub is_double_sided: bool,
}

/// An object: a node with its mesh.
pub(super) struct Instance<'a> {
    pub placed: Placed<'a>,
    pose: Pose,
    /// Of the morph targets.
    weights: Vec<f64>,
    /// Index of the mesh.
    mesh: usize,
    /// The number of its first triangle.
    pub start: usize,
}

/// A triangle of an object.
pub(super) struct Triangle {
    /// In the coordinates of the model, but for the unit.
    pub corners: [DVec3; 3],
    /// Whether it is wound the other way there: a mirror turns the winding round, but not the front.
    pub is_mirrored: bool,
    /// As [`Primitive::is_against`].
    pub is_against: Option<bool>,
}

impl Instance<'_> {
    /// A triangle in the model.
    pub(super) fn triangle(
        &self,
        primitive: &Primitive,
        vertices: [usize; 3],
    ) -> Result<Triangle, GltfFault> {
        let positions = primitive.positions(vertices, &self.weights)?;
        let is_against = primitive.is_against(vertices, positions, &self.weights)?;
        let (corners, determinant) = self.place(primitive, vertices, positions)?;
        Ok(Triangle {
            corners,
            is_mirrored: determinant < 0.0,
            is_against,
        })
    }

    /// The corners of a triangle in the model.
    fn corners(
        &self,
        primitive: &Primitive,
        vertices: [usize; 3],
    ) -> Result<[DVec3; 3], GltfFault> {
        let positions = primitive.positions(vertices, &self.weights)?;
        Ok(self.place(primitive, vertices, positions)?.0)
    }

    /// Where positions come to be, and the sum of the determinants of what takes them there.
    fn place(
        &self,
        primitive: &Primitive,
        vertices: [usize; 3],
        mut corners: [DVec3; 3],
    ) -> Result<([DVec3; 3], f64), GltfFault> {
        let mut determinant = 0.0;
        match (&self.pose, &primitive.influences) {
            (Pose::Rigid(model_from_node), _) => {
                corners = corners.map(|corner| model_from_node.transform_point3(corner));
                determinant = model_from_node.matrix3.determinant();
            }
            (Pose::Skinned(matrices), Some(influences)) => {
                for (corner, vertex) in corners.iter_mut().zip(vertices) {
                    let (place, of_corner) = influences.place(vertex, *corner, matrices)?;
                    *corner = place;
                    determinant += of_corner;
                }
            }
            (Pose::Skinned(_), None) => {
                return Err(wrong(
                    self.placed.thing(),
                    "it has a skin, but a primitive of its mesh has no JOINTS_0 and WEIGHTS_0; export the model again, or without skins",
                ));
            }
        }
        Ok((corners, determinant))
    }
}

/// What nodes have.
pub(super) struct Content<'a> {
    /// One per mesh; those that some node has are open.
    meshes: Vec<Option<Vec<Part<'a>>>>,
    /// One per object.
    pub instances: Vec<Instance<'a>>,
    /// Names of the objects.
    pub objects: Vec<String>,
}

impl<'a> Content<'a> {
    /// The primitives of an object.
    pub(super) fn parts(&self, instance: &Instance) -> Result<&[Part<'a>], GltfFault> {
        let parts = self.meshes.get(instance.mesh).and_then(Option::as_deref);
        parts.ok_or_else(|| not_there(instance.mesh))
    }

    /// Hands out the corners of all triangles, in the coordinates of the model, but for the unit.
    pub(super) fn for_each_corner(&self, mut use_it: impl FnMut(DVec3)) -> Result<(), GltfFault> {
        for instance in &self.instances {
            for Part { primitive, .. } in self.parts(instance)? {
                for triangle in 0..primitive.triangles {
                    let vertices = primitive.vertices(triangle)?;
                    for corner in instance.corners(primitive, vertices)? {
                        use_it(corner);
                    }
                }
            }
        }
        Ok(())
    }
}

fn not_there(mesh: usize) -> GltfFault {
    wrong(format!("meshes[{mesh}]"), "nothing has this index")
}

/// Opens the meshes of all nodes.
pub(super) fn content<'a>(
    document: &'a Document,
    hierarchy: &Hierarchy<'a>,
    materials: &mut Materials,
    names: &mut Names,
    report: &mut ImportReport,
) -> Result<Content<'a>, GltfFault> {
    let meshes = document.root.meshes.iter().map(|_| None);
    let mut content = Content {
        meshes: meshes.collect(),
        instances: Vec::new(),
        objects: Vec::new(),
    };
    let mut skins = HashMap::new();
    let mut start = 0;
    for &placed in &hierarchy.placed {
        let Some(index) = placed.node.mesh else {
            continue;
        };
        let mesh = document.get(index)?;
        let number = index.value();
        let opened = content.meshes.get_mut(number);
        let opened = opened.ok_or_else(|| not_there(number))?;
        let parts = match opened {
            Some(known) => known,
            None => opened.insert(parts(document, number, materials, report)?),
        };
        let triangles: usize = parts
            .iter()
            .map(|part| part.primitive.triangles)
            .fold(0, usize::saturating_add);
        if triangles == 0 {
            continue;
        }
        let pose = match placed.node.skin {
            None => Pose::Rigid(placed.model_from_node),
            Some(skin) => {
                let matrices = match skins.entry(skin) {
                    Entry::Occupied(known) => known.into_mut(),
                    Entry::Vacant(new) => new.insert(skins::matrices(document, skin, hierarchy)?),
                };
                Pose::Skinned(matrices.clone())
            }
        };
        let own_names = [placed.node.name.as_ref(), mesh.name.as_ref()];
        let name = first_name(own_names, || format!("node {}", placed.index));
        content.objects.push(names.name(&name));
        content.instances.push(Instance {
            placed,
            pose,
            weights: morphs::weights(placed.node, mesh, &placed.thing())?,
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
    let mesh = document.root.meshes.get(index);
    let mesh = mesh.ok_or_else(|| not_there(index))?;
    let mut parts = Vec::new();
    for (k, primitive) in mesh.primitives.iter().enumerate() {
        if draws_points_or_lines(primitive) {
            report.points_and_lines_ignored += 1;
            continue;
        }
        if has_no_positions(primitive) {
            continue;
        }
        let material = materials.number(primitive, &mut report.warnings)?;
        let used = materials.used(material);
        let thing = format!("meshes[{index}].primitives[{k}]");
        parts.push(Part {
            primitive: Primitive::open(document, primitive, &thing, used)?,
            material,
            is_double_sided: used.is_double_sided,
        });
    }
    Ok(parts)
}

/// Tells what the file has that no still picture of triangles shows.
pub(super) fn left_out(document: &Document) -> Vec<String> {
    let root = &document.root;
    let mut warnings = Vec::new();
    let primitives = || root.meshes.iter().flat_map(|mesh| &mesh.primitives);
    let of_no_place = primitives().filter(|p| !draws_points_or_lines(p) && has_no_positions(p));
    let animations = document.removed.animations;
    let found: Vec<String> = [
        (animations, "animations"),
        (document.removed.cameras, "cameras"),
        (
            primitives().filter(|p| draws_points_or_lines(p)).count(),
            "primitives of points or lines",
        ),
        (of_no_place.count(), "primitives without POSITION"),
    ]
    .into_iter()
    .filter(|&(count, _)| count > 0)
    .map(|(count, what)| format!("{what} ({count})"))
    .collect();
    if !found.is_empty() {
        let rest = match animations {
            0 => "",
            _ => "; what they move stays where the nodes, joints and weights of the file have it",
        };
        warnings.push(format!("left out: {}{rest}", found.join(", ")));
    }
    let unknown = unknown(root);
    if !unknown.is_empty() {
        warnings.push(format!(
            "extensions that are not known are left out: {}",
            unknown.join(", ")
        ));
    }
    warnings
}
