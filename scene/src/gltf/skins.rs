//! Skins: vertices that follow joints (section 3.7.3 of the specification).
//!
//! p' = sum_k w_k M_k p / sum_k w_k, with M_k = (model from joint k) (joint k's inverse bind matrix): the joints place the vertex,
//! and the transform of the node that has the mesh counts for nothing. Joints are where the file's nodes have them.

use std::rc::Rc;

use glam::{DAffine3, DMat3, DVec3};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::skin::Skin;
use gltf::json::validation::Checked;
use gltf::json::{Index, accessor::Accessor};

use super::GltfFault;
use super::document::Document;
use super::elements::Elements;
use super::error::wrong;
use super::layouts::{INVERSE_BIND_MATRICES, JOINTS, WEIGHTS};
use super::nodes::{Hierarchy, affine};

/// Where vertices go.
#[derive(Clone, Debug)]
pub(super) enum Pose {
    /// With their node.
    Rigid(DAffine3),
    /// With joints: model from vertex, one per joint.
    Skinned(Rc<[DAffine3]>),
}

/// The joints of a skin, as it needs them.
pub(super) fn matrices(
    document: &Document,
    index: Index<Skin>,
    hierarchy: &Hierarchy,
) -> Result<Rc<[DAffine3]>, GltfFault> {
    let skin = document.get(index)?;
    let thing = format!("skins[{index}]");
    let inverse = skin
        .inverse_bind_matrices
        .map(|accessor| Elements::open(document, accessor, &INVERSE_BIND_MATRICES))
        .transpose()?;
    let matrix = |(k, joint): (usize, &Index<_>)| {
        let joint = joint.value();
        let model_from_joint = hierarchy.model_from_node.get(joint);
        let model_from_joint = model_from_joint.ok_or_else(|| {
            wrong(
                &thing,
                format!("joint {k} is nodes[{joint}], which is not there"),
            )
        })?;
        let Some(inverse) = &inverse else {
            return Ok(*model_from_joint);
        };
        let joint_from_vertex = affine(inverse.get(k)?);
        let joint_from_vertex = joint_from_vertex.map_err(|what| inverse.wrong(k, &what))?;
        let matrix = *model_from_joint * joint_from_vertex;
        if matrix.is_finite() {
            Ok(matrix)
        } else {
            Err(wrong(
                &thing,
                format!("the transform of joint {k} is not finite"),
            ))
        }
    };
    skin.joints.iter().enumerate().map(matrix).collect()
}

/// Which joints the vertices of a primitive follow, and how much: one set of four at least.
pub(super) struct Influences<'a> {
    /// As errors call the primitive.
    thing: String,
    /// Joints and weights, an element a vertex.
    sets: Vec<[Elements<'a>; 2]>,
}

impl<'a> Influences<'a> {
    /// Those of a primitive, if it has any.
    pub(super) fn open(
        document: &'a Document,
        primitive: &Primitive,
        thing: &str,
        vertices: usize,
    ) -> Result<Option<Self>, GltfFault> {
        let attribute = |semantic| primitive.attributes.get(&Checked::Valid(semantic)).copied();
        let open = |index: Index<Accessor>, layout| {
            let elements = Elements::open(document, index, layout)?;
            elements.check_count(vertices)?;
            Ok(elements)
        };
        let mut sets = Vec::new();
        for set in 0.. {
            let found = [Semantic::Joints(set), Semantic::Weights(set)].map(attribute);
            let [Some(joints), Some(weights)] = found else {
                break;
            };
            sets.push([open(joints, &JOINTS)?, open(weights, &WEIGHTS)?]);
        }
        let thing = thing.to_owned();
        Ok((!sets.is_empty()).then_some(Self { thing, sets }))
    }

    /// Where a vertex at some position goes, and the determinant of what takes it there.
    pub(super) fn place(
        &self,
        vertex: usize,
        position: DVec3,
        matrices: &[DAffine3],
    ) -> Result<(DVec3, f64), GltfFault> {
        let (mut linear, mut translation, mut total) = (DMat3::ZERO, DVec3::ZERO, 0.0);
        for [joints, weights] in &self.sets {
            let of_vertex: [[f64; 4]; 2] = [joints.get(vertex)?, weights.get(vertex)?];
            for (joint, weight) in of_vertex[0].into_iter().zip(of_vertex[1]) {
                if weight < 0.0 {
                    return Err(weights.wrong(vertex, &format!("the weight {weight} is below 0")));
                }
                if weight > 0.0 {
                    let matrix = matrices.get(joint as usize).ok_or_else(|| {
                        let count = matrices.len();
                        joints.wrong(vertex, &format!("joint {joint}, but the skin has {count}"))
                    })?;
                    linear += weight * matrix.matrix3;
                    translation += weight * matrix.translation;
                    total += weight;
                }
            }
        }
        if total <= 0.0 {
            return Err(wrong(
                &self.thing,
                format!(
                    "the joint weights of vertex {vertex} sum to 0; give each vertex of a skin a joint"
                ),
            ));
        }
        let linear = (1.0 / total) * linear;
        Ok((
            linear * position + translation / total,
            linear.determinant(),
        ))
    }
}
