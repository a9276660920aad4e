//! The mesh whose vertices have values.
//!
//! Each surface that has one is the root of a tree of newest-vertex bisections ([`crate::bisection`]), as deep as the values ask
//! for in each place. The leaves of a wall's surfaces conform: no vertex lies inside of another leaf's side.

use glam::{DVec3, Vec3};

use crate::{Rgb, SceneError, SurfaceId};

/// A triangle of the mesh. Its reference edge runs from vertex 0 to vertex 1, and vertex 2 is the newest.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Node {
    /// Indices of vertices.
    pub vertices: [u32; 3],
    /// Index of its first child, which the second one follows; 0 where it is a leaf.
    pub child: u32,
}

/// No root: the surface has no vertices.
pub(super) const NO_ROOT: u32 = u32::MAX;

/// A conforming mesh over surfaces.
#[derive(Clone, Debug, PartialEq)]
pub struct VertexMesh {
    /// One per surface: the index of its node, or [`NO_ROOT`].
    roots: Vec<u32>,
    /// Children follow their parents.
    nodes: Vec<Node>,
    /// Positions of the vertices, metres, relative to the scene's origin.
    vertices: Vec<Vec3>,
}

impl VertexMesh {
    /// A mesh of these parts, for a scene of so many surfaces. A root is the index of a surface's node, or `u32::MAX`.
    ///
    /// # Errors
    /// Parts that are no forest over these vertices.
    pub fn new(
        surfaces: usize,
        roots: Vec<u32>,
        nodes: Vec<Node>,
        vertices: Vec<Vec3>,
    ) -> Result<Self, SceneError> {
        let fault = |what: &'static str, index: usize| {
            Err(SceneError::VertexMesh {
                what,
                index: index as u32,
            })
        };
        if roots.len() != surfaces {
            return fault(
                "the number of roots, which is not that of surfaces,",
                roots.len(),
            );
        }
        let mut is_taken = vec![false; nodes.len()];
        let mut take = |node: u32| {
            let taken = is_taken.get_mut(node as usize);
            taken.is_some_and(|taken| !std::mem::replace(taken, true))
        };
        for (surface, &root) in roots.iter().enumerate() {
            if root != NO_ROOT && !take(root) {
                return fault("the root of surface", surface);
            }
        }
        for (index, node) in nodes.iter().enumerate() {
            if node.vertices.iter().any(|&v| v as usize >= vertices.len()) {
                return fault("a vertex of node", index);
            }
            let child = node.child;
            let is_good = child == 0 || child as usize > index && take(child) && take(child + 1);
            if !is_good {
                return fault("a child of node", index);
            }
        }
        if let Some(index) = is_taken.iter().position(|&taken| !taken) {
            return fault("the place in a tree of node", index);
        }
        if let Some(index) = vertices.iter().position(|v| !v.is_finite()) {
            return fault("the position of vertex", index);
        }
        Ok(Self {
            roots,
            nodes,
            vertices,
        })
    }

    /// The index of each surface's node, or `u32::MAX`, one per surface.
    pub fn roots(&self) -> &[u32] {
        &self.roots
    }

    /// Whether a surface has vertices.
    pub fn has_vertices(&self, surface: SurfaceId) -> bool {
        self.root(surface).is_some()
    }

    /// All nodes, children after their parents.
    pub fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// The positions of the vertices, metres, relative to the scene's origin.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// How many vertices there are.
    pub fn vertex_count(&self) -> u32 {
        self.vertices.len() as u32
    }

    /// How many leaves there are.
    pub fn leaf_count(&self) -> u32 {
        let leaves = self.nodes.iter().filter(|node| node.child == 0);
        leaves.count() as u32
    }

    /// The node of a surface, if it has one.
    fn root(&self, surface: SurfaceId) -> Option<&Node> {
        let root = self.roots[surface.index()];
        (root != NO_ROOT).then(|| &self.nodes[root as usize])
    }

    /// The children of a node; `None` where it is a leaf.
    fn children(&self, node: &Node) -> Option<[&Node; 2]> {
        let child = node.child as usize;
        (child > 0).then(|| [&self.nodes[child], &self.nodes[child + 1]])
    }

    /// The vertices of the leaf at barycentric coordinates in a surface, and the coordinates in it; both sum to the same.
    /// `None` where the surface has no vertices. A point outside of the surface is assigned to a leaf on its border.
    #[inline]
    pub fn locate(
        &self,
        surface: SurfaceId,
        [mut a, mut b, mut c]: [f32; 3],
    ) -> Option<([u32; 3], [f32; 3])> {
        let mut node = self.root(surface)?;
        while let Some([first, second]) = self.children(node) {
            if a >= b {
                (a, b, c) = (a - b, c, 2.0 * b);
                node = first;
            } else {
                (a, b, c) = (c, b - a, 2.0 * a);
                node = second;
            }
        }
        Some((node.vertices, [a, b, c]))
    }

    /// The leaves of a surface, each as its vertices, and their number of bisections; none where it has no vertices.
    pub fn leaves(&self, surface: SurfaceId) -> Vec<([u32; 3], u32)> {
        let mut leaves = Vec::new();
        let mut open: Vec<(&Node, u32)> = self
            .root(surface)
            .map(|root| (root, 0))
            .into_iter()
            .collect();
        while let Some((node, depth)) = open.pop() {
            match self.children(node) {
                Some([first, second]) => open.extend([(second, depth + 1), (first, depth + 1)]),
                // Each bisection turns the orientation round.
                None if depth.is_multiple_of(2) => leaves.push((node.vertices, depth)),
                None => {
                    let [a, b, c] = node.vertices;
                    leaves.push(([b, a, c], depth));
                }
            }
        }
        leaves
    }

    /// The mean of what is linear between some values at the vertices over the part of a surface that its uniform tree of
    /// `depth` bisections has under this code; `None` where the surface has no vertices.
    pub(super) fn mean_over(
        &self,
        values: &[Rgb],
        surface: SurfaceId,
        depth: u32,
        code: u32,
    ) -> Option<Rgb> {
        let mut node = self.root(surface)?;
        let value = |vertex: u32| values[vertex as usize].as_dvec3();
        for level in (0..depth).rev() {
            let Some(children) = self.children(node) else {
                // The patch is a part of a leaf: what is linear has its mean in the middle.
                let part = crate::bisection::leaf_corners(depth, code);
                let middle = (part[0] + part[1] + part[2]) / 3.0;
                let (vertices, weights) = self.locate(surface, middle.as_vec3().to_array())?;
                let mean: DVec3 = (0..3)
                    .map(|k| f64::from(weights[k]) * value(vertices[k]))
                    .sum();
                return Some(mean.as_vec3());
            };
            node = children[(code >> level & 1) as usize];
        }
        let (mut sum, mut open) = (DVec3::ZERO, vec![(node, 1.0)]);
        while let Some((node, share)) = open.pop() {
            match self.children(node) {
                Some([first, second]) => open.extend([(first, 0.5 * share), (second, 0.5 * share)]),
                None => sum += share / 3.0 * node.vertices.map(value).into_iter().sum::<DVec3>(),
            }
        }
        Some(sum.as_vec3())
    }
}
