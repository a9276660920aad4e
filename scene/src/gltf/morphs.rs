//! Morph targets: vertices that are moved by weighted displacements (sections 3.7.2.2 and 3.7.4 of the specification).
//!
//! p' = p + sum_k w_k d_k. The weights are those of the node, else those of the mesh, else 0; no animation changes them.

use glam::DVec3;
use gltf::json::mesh::{Mesh, Primitive};
use gltf::json::scene::Node;

use super::GltfFault;
use super::document::Document;
use super::elements::Elements;
use super::error::wrong;
use super::layouts::DISPLACEMENTS;

/// Displacements of a primitive's vertices; one of each per target, `None` where it moves nothing.
pub(super) struct Morphs<'a> {
    pub positions: Vec<Option<Elements<'a>>>,
    pub normals: Vec<Option<Elements<'a>>>,
}

impl<'a> Morphs<'a> {
    pub(super) fn open(
        document: &'a Document,
        primitive: &Primitive,
        vertices: usize,
    ) -> Result<Self, GltfFault> {
        let mut morphs = Self {
            positions: Vec::new(),
            normals: Vec::new(),
        };
        for target in primitive.targets.iter().flatten() {
            let open = |index| {
                let elements = Elements::open(document, index, &DISPLACEMENTS)?;
                elements.check_count(vertices)?;
                Ok(elements)
            };
            morphs
                .positions
                .push(target.positions.map(open).transpose()?);
            morphs.normals.push(target.normals.map(open).transpose()?);
        }
        Ok(morphs)
    }
}

/// What displacements add to an attribute of a vertex.
pub(super) fn displacement(
    targets: &[Option<Elements>],
    weights: &[f64],
    vertex: usize,
) -> Result<DVec3, GltfFault> {
    let mut sum = DVec3::ZERO;
    for (target, &weight) in targets.iter().zip(weights) {
        if let Some(target) = target.as_ref().filter(|_| weight != 0.0) {
            sum += weight * DVec3::from_array(target.get(vertex)?);
        }
    }
    Ok(sum)
}

/// The weights of a node's mesh; none where nothing is moved.
///
/// # Errors
/// Other numbers of weights than of targets.
pub(super) fn weights(node: &Node, mesh: &Mesh, thing: &str) -> Result<Vec<f64>, GltfFault> {
    let Some(weights) = node.weights.as_ref().or(mesh.weights.as_ref()) else {
        return Ok(Vec::new());
    };
    for (k, primitive) in mesh.primitives.iter().enumerate() {
        let targets = primitive.targets.as_ref().map_or(0, Vec::len);
        if targets != weights.len() {
            let weights = weights.len();
            return Err(wrong(
                thing,
                format!(
                    "{weights} weights, but primitive {k} of its mesh has {targets} morph targets"
                ),
            ));
        }
    }
    Ok(weights.iter().map(|&weight| f64::from(weight)).collect())
}
