//! The hierarchy of nodes: which of them are in the scene, and where (section 3.5 of the specification).

use glam::{DAffine3, DMat4, DQuat, DVec3, DVec4};
use gltf::json::scene::Node;
use gltf::json::{Index, Root};

use super::GltfFault;
use super::error::wrong;

/// A node of the scene.
#[derive(Clone, Copy, Debug)]
pub(super) struct Placed<'a> {
    pub index: usize,
    pub node: &'a Node,
    /// From its own coordinates to those of the model.
    pub model_from_node: DAffine3,
}

impl Placed<'_> {
    /// How errors call it.
    pub(super) fn thing(&self) -> String {
        thing(self.index, self.node)
    }
}

fn thing(index: usize, node: &Node) -> String {
    match &node.name {
        Some(name) => format!("nodes[{index}] \"{name}\""),
        None => format!("nodes[{index}]"),
    }
}

/// All nodes of a file.
pub(super) struct Hierarchy<'a> {
    /// Those of the scene, each before its children.
    pub placed: Vec<Placed<'a>>,
    /// From the coordinates of each node to those of the model; one per node of the file.
    pub model_from_node: Vec<DAffine3>,
}

/// Places all nodes.
///
/// # Errors
/// Nodes that are no trees (section 3.5.2), scenes of other nodes than roots, and transforms that are none (3.5.3).
pub(super) fn hierarchy<'a>(
    root: &'a Root,
    warnings: &mut Vec<String>,
) -> Result<Hierarchy<'a>, GltfFault> {
    let parents = parents(root)?;
    let is_root = |&index: &usize| parents.get(index).is_some_and(Option::is_none);
    let roots: Vec<usize> = (0..root.nodes.len()).filter(is_root).collect();
    let order = depth_first(root, &roots);
    if order.len() < root.nodes.len() {
        let mut is_reached = vec![false; root.nodes.len()];
        for &index in &order {
            is_reached[index] = true;
        }
        let index = is_reached.iter().position(|&reached| !reached);
        return Err(not_a_tree(
            root,
            index.unwrap_or_default(),
            "it is below itself",
        ));
    }
    let mut model_from_node = vec![DAffine3::IDENTITY; root.nodes.len()];
    for index in order {
        let Some(node) = root.nodes.get(index) else {
            continue;
        };
        let model_from_parent = parents[index].map_or(DAffine3::IDENTITY, |k| model_from_node[k]);
        model_from_node[index] = model_from_parent * parent_from_node(index, node)?;
        if !model_from_node[index].is_finite() {
            return Err(wrong(
                thing(index, node),
                "its transform, with those of its parents, is not finite",
            ));
        }
    }
    let tops = tops(root, &roots, warnings);
    let mut is_listed = vec![false; root.nodes.len()];
    for &index in &tops {
        if let Some(Some(parent)) = parents.get(index) {
            let what =
                format!("it is in the scene and below nodes[{parent}], as if it had two parents");
            return Err(not_a_tree(root, index, &what));
        }
        let is_known = is_listed.get_mut(index);
        if is_known.is_some_and(|known| std::mem::replace(known, true)) {
            return Err(not_a_tree(root, index, "it is in the scene twice"));
        }
    }
    let placed = depth_first(root, &tops).into_iter().filter_map(|index| {
        Some(Placed {
            index,
            node: root.nodes.get(index)?,
            model_from_node: *model_from_node.get(index)?,
        })
    });
    Ok(Hierarchy {
        placed: placed.collect(),
        model_from_node,
    })
}

/// The parent of each node.
fn parents(root: &Root) -> Result<Vec<Option<usize>>, GltfFault> {
    let mut parents = vec![None; root.nodes.len()];
    for (index, node) in root.nodes.iter().enumerate() {
        for child in node.children.iter().flatten().map(Index::value) {
            let Some(parent) = parents.get_mut(child) else {
                let count = root.nodes.len();
                return Err(wrong(
                    thing(index, node),
                    format!("it has the child {child}, but the file has {count} nodes"),
                ));
            };
            if child == index {
                return Err(not_a_tree(root, child, "it is below itself"));
            }
            if let Some(other) = parent.replace(index) {
                let what = format!("it has two parents, nodes[{other}] and nodes[{index}]");
                return Err(not_a_tree(root, child, &what));
            }
        }
    }
    Ok(parents)
}

fn not_a_tree(root: &Root, index: usize, what: &str) -> GltfFault {
    let thing = match root.nodes.get(index) {
        Some(node) => thing(index, node),
        None => format!("nodes[{index}]"),
    };
    wrong(thing, format!("{what}; nodes have to be trees"))
}

/// Some nodes and all below them, each before its children. None may be below itself.
fn depth_first(root: &Root, tops: &[usize]) -> Vec<usize> {
    let mut waiting: Vec<usize> = tops.iter().rev().copied().collect();
    let mut order = Vec::new();
    while let Some(index) = waiting.pop() {
        order.push(index);
        let children = root
            .nodes
            .get(index)
            .and_then(|node| node.children.as_ref());
        waiting.extend(children.into_iter().flatten().rev().map(Index::value));
    }
    order
}

/// The nodes without parents of the default scene, else of the first one, else of the file.
fn tops(root: &Root, roots: &[usize], warnings: &mut Vec<String>) -> Vec<usize> {
    let taken = root.scene.as_ref().map_or(0, Index::value);
    if root.scenes.len() > 1 {
        warnings.push(format!(
            "the file has {} scenes; scenes[{taken}] is taken",
            root.scenes.len()
        ));
    }
    if let Some(scene) = root.scenes.get(taken) {
        return scene.nodes.iter().map(Index::value).collect();
    }
    roots.to_vec()
}

/// The transform that a node says.
fn parent_from_node(index: usize, node: &Node) -> Result<DAffine3, GltfFault> {
    let fail = |what: String| Err(wrong(thing(index, node), what));
    if let Some(matrix) = node.matrix {
        if node.translation.is_some() || node.rotation.is_some() || node.scale.is_some() {
            return fail(
                "it has a matrix beside a translation, rotation or scale; it may have one or the other".to_owned(),
            );
        }
        return affine(matrix.map(f64::from))
            .map_err(|what| wrong(thing(index, node), format!("its matrix: {what}")));
    }
    let vector = |values: [f32; 3]| DVec3::from(values.map(f64::from));
    let rotation = node.rotation.unwrap_or_default().0.map(f64::from);
    let length = rotation.iter().map(|x| x * x).sum::<f64>().sqrt();
    if !(length.is_finite() && length > 0.0) {
        return fail(format!("its rotation {rotation:?} is no quaternion"));
    }
    Ok(DAffine3::from_scale_rotation_translation(
        node.scale.map_or(DVec3::ONE, vector),
        DQuat::from_array(rotation.map(|x| x / length)),
        node.translation.map_or(DVec3::ZERO, vector),
    ))
}

/// The transform of a matrix, column by column.
pub(super) fn affine(columns: [f64; 16]) -> Result<DAffine3, String> {
    let matrix = DMat4::from_cols_array(&columns);
    let last = matrix.row(3);
    if last != DVec4::W {
        return Err(format!(
            "the last row is {last}, but has to be [0, 0, 0, 1]"
        ));
    }
    Ok(DAffine3::from_mat4(matrix))
}
