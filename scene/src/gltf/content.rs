//! What a document has for a model: its objects, the primitives of their meshes, and what is left out.

use std::collections::HashMap;
use std::collections::hash_map::Entry;

use glam::DVec3;
use gltf::json::mesh::Semantic;
use gltf::json::validation::Checked;
use gltf::json::{self, Root};

use super::GltfFault;
use super::document::{Document, unknown_extensions};
use super::error::wrong;
use super::materials::Materials;
use super::nodes::{Names, Placed};
use super::primitive::{Primitive, draws_points_or_lines};
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
    /// Index of the mesh.
    mesh: usize,
    /// The number of its first triangle.
    pub start: usize,
}

/// What nodes have.
pub(super) struct Content<'a> {
    /// By index; only those that some node has.
    meshes: HashMap<usize, Vec<Part<'a>>>,
    /// One per object.
    pub instances: Vec<Instance<'a>>,
    /// Names of the objects.
    pub objects: Vec<String>,
}

impl<'a> Content<'a> {
    /// The primitives of an object.
    pub(super) fn parts(&self, instance: &Instance) -> &[Part<'a>] {
        self.meshes
            .get(&instance.mesh)
            .map_or(&[], |parts| &parts[..])
    }

    /// Hands out the corners of all triangles, in the coordinates of the model.
    pub(super) fn for_each_corner(&self, mut use_it: impl FnMut(DVec3)) -> Result<(), GltfFault> {
        for instance in &self.instances {
            for Part { primitive, .. } in self.parts(instance) {
                for triangle in 0..primitive.triangles {
                    for position in primitive.positions(primitive.vertices(triangle)?)? {
                        use_it(instance.placed.model_from_node.transform_point3(position));
                    }
                }
            }
        }
        Ok(())
    }
}

/// Opens the meshes of all nodes.
pub(super) fn content<'a>(
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
        let parts = match content.meshes.entry(number) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => new.insert(parts(document, number, materials, report)?),
        };
        let triangles: usize = parts
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

/// Tells what the file has that no still picture of triangles shows.
pub(super) fn left_out(root: &Root) -> Vec<String> {
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
