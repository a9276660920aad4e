//! The hierarchy of nodes: which of them are in the scene, where, and what they are called.

use std::collections::{HashMap, HashSet};

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

/// The nodes of the scene, each before its children.
pub(super) fn placed<'a>(
    root: &'a Root,
    warnings: &mut Vec<String>,
) -> Result<Vec<Placed<'a>>, GltfFault> {
    let mut waiting: Vec<(usize, DAffine3)> = roots(root, warnings)
        .into_iter()
        .rev()
        .map(|index| (index, DAffine3::IDENTITY))
        .collect();
    let mut is_placed = vec![false; root.nodes.len()];
    let mut placed = Vec::new();
    while let Some((index, model_from_parent)) = waiting.pop() {
        let Some(node) = root.nodes.get(index) else {
            let count = root.nodes.len();
            return Err(wrong(
                format!("nodes[{index}]"),
                format!("it is a child or in a scene, but the file has {count} nodes"),
            ));
        };
        if std::mem::replace(&mut is_placed[index], true) {
            return Err(wrong(
                thing(index, node),
                "it is below itself or has two parents; nodes have to be a tree",
            ));
        }
        let model_from_node = model_from_parent * parent_from_node(index, node)?;
        if !model_from_node.is_finite() {
            return Err(wrong(
                thing(index, node),
                "its transform, with those of its parents, is not finite",
            ));
        }
        let children = node.children.iter().flatten().rev();
        waiting.extend(children.map(|child| (child.value(), model_from_node)));
        placed.push(Placed {
            index,
            node,
            model_from_node,
        });
    }
    Ok(placed)
}

/// The nodes without parents of the default scene, else of the first one, else of the file.
fn roots(root: &Root, warnings: &mut Vec<String>) -> Vec<usize> {
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
    let children = root.nodes.iter().flat_map(|node| &node.children);
    let children: HashSet<usize> = children.flatten().map(Index::value).collect();
    (0..root.nodes.len())
        .filter(|index| !children.contains(index))
        .collect()
}

/// The transform that a node says.
fn parent_from_node(index: usize, node: &Node) -> Result<DAffine3, GltfFault> {
    let fail = |what: String| Err(wrong(thing(index, node), what));
    if let Some(matrix) = node.matrix {
        let matrix = DMat4::from_cols_array(&matrix.map(f64::from));
        if matrix.row(3) != DVec4::W {
            let row = matrix.row(3);
            return fail(format!(
                "the last row of its matrix is {row}, but has to be [0, 0, 0, 1]"
            ));
        }
        return Ok(DAffine3::from_mat4(matrix));
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

/// Names of objects, no two of which are equal.
#[derive(Default)]
pub(super) struct Names {
    /// How many objects asked for a name, and the number that the next one gets.
    asked: HashMap<String, [usize; 2]>,
    taken: HashSet<String>,
    /// Names that more than one object asked for.
    several: Vec<String>,
}

impl Names {
    /// A name for an object that asks for one.
    pub(super) fn name(&mut self, wanted: &str) -> String {
        let [asked, next] = self.asked.entry(wanted.to_owned()).or_insert([0, 2]);
        *asked += 1;
        if *asked == 2 {
            self.several.push(wanted.to_owned());
        }
        let mut name = wanted.to_owned();
        while !self.taken.insert(name.clone()) {
            name = format!("{wanted}.{next}");
            *next += 1;
        }
        name
    }

    /// Tells of names that objects would have shared.
    pub(super) fn warning(&self) -> Option<String> {
        let first = self.several.first()?;
        let more = match self.several.len() - 1 {
            0 => String::new(),
            more => format!(", and so are those of {more} other names"),
        };
        Some(format!(
            "several nodes are named \"{first}\": their objects are told apart by numbers behind the name{more}"
        ))
    }
}

#[cfg(test)]
mod tests {
    use super::Names;

    #[test]
    fn names_of_objects_are_never_equal() {
        let mut names = Names::default();
        let given = ["a", "a.2", "a", "a", "b", "a.2"].map(|name| names.name(name));
        assert_eq!(given, ["a", "a.2", "a.3", "a.4", "b", "a.2.2"]);
        assert!(names.warning().unwrap().contains("\"a\""));
    }
}
