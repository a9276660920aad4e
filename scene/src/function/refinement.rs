//! Making a mesh: roots that share edges, and bisections that keep it conforming.
//!
//! # Theory
//! A triangle is bisected at its reference edge. Its neighbour there must be too: if that edge is another one of its own than
//! the reference edge, it is bisected at the latter first, whereby the edge becomes one of its children's reference edges
//! (Mitchell 1989, as in [`crate::bisection`]). Whatever the roots' reference edges are, that ends: only edges are cut that
//! there were before, each once.
//!
//! # Practice
//! Edges are things of their own, which two triangles share or only one has. Where something stands on a wall, the two sides of
//! its foot share neither edges nor vertices, so that light on one side is none of the other's. Vertices are midpoints in
//! f64 of others, back to corners of surfaces.

use std::collections::HashMap;

use glam::{DVec3, Vec3};

use super::mesh::NO_ROOT;
use super::{Node, VertexMesh};
use crate::weld::{Place, place};
use crate::{Scene, SceneError, SurfaceId, bisection};

/// Index of a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct VertexId(pub u32);

/// Index of a triangle of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NodeId(pub u32);

const NONE: u32 = u32::MAX;

/// The deepest leaves that are bisected for their own sake; what conforms to them may be a few bisections deeper.
const MAX_DEPTH: u32 = 24;

/// A mesh that grows.
#[derive(Clone, Debug)]
pub struct Refinement {
    roots: Vec<u32>,
    nodes: Vec<Node>,
    /// One per node.
    facts: Vec<Facts>,
    edges: Vec<Edge>,
    vertices: Vec<Vertex>,
}

/// What a triangle has while it grows.
#[derive(Clone, Copy, Debug)]
struct Facts {
    surface: SurfaceId,
    /// Bisections below its surface, and their code, see [`bisection`].
    depth: u32,
    code: u32,
    /// Area, m^2.
    area: f64,
    /// From vertex k to the next.
    edges: [u32; 3],
}

/// A side of one leaf or two.
#[derive(Clone, Copy, Debug)]
struct Edge {
    ends: [u32; 2],
    leaves: [u32; 2],
    /// Vertex and halves, the first half at the first end, once it is cut.
    cut: Option<(u32, [u32; 2])>,
}

/// A vertex and where it came to be.
#[derive(Clone, Copy, Debug)]
struct Vertex {
    position: DVec3,
    /// A triangle that has it: the root whose corner it is, or the one whose edge was cut.
    node: u32,
    /// What it is the middle of.
    between: Option<[u32; 2]>,
    /// Whether it came to be between two triangles.
    is_inside: bool,
}

impl Refinement {
    /// A mesh of the surfaces that are to have vertices, each whole as yet. Two of them that share a side are one wall there if
    /// `joins` says so of them and the side's ends.
    pub fn new(
        scene: &Scene,
        has_vertices: impl Fn(SurfaceId) -> bool,
        joins: impl Fn([SurfaceId; 2], [Vec3; 2]) -> bool,
    ) -> Self {
        let mut mesh = Self {
            roots: vec![NO_ROOT; scene.surfaces().len()],
            nodes: Vec::new(),
            facts: Vec::new(),
            edges: Vec::new(),
            vertices: Vec::new(),
        };
        let ids = (0..).map(SurfaceId).zip(scene.surfaces());
        for (id, surface) in ids.filter(|&(id, _)| has_vertices(id)) {
            mesh.roots[id.index()] = mesh.nodes.len() as u32;
            mesh.facts.push(Facts {
                surface: id,
                depth: 0,
                code: 0,
                area: surface.area(),
                edges: [NONE; 3],
            });
            mesh.nodes.push(Node {
                vertices: [NONE; 3],
                child: 0,
            });
        }
        let mates = mesh.mates(scene, joins);
        mesh.weld_corners(scene, &mates);
        mesh.lay_edges(&mates);
        mesh
    }

    /// For each side 3 n + k of the roots, from corner k of root n to the next, the side of another root that it is one with.
    fn mates(
        &self,
        scene: &Scene,
        joins: impl Fn([SurfaceId; 2], [Vec3; 2]) -> bool,
    ) -> Vec<Option<u32>> {
        let mut at: HashMap<[Place; 2], Vec<u32>> = HashMap::new();
        for (root, facts) in (0..).zip(&self.facts) {
            let corners = scene.surface(facts.surface).corners;
            for side in 0..3 {
                let ends = [corners[side], corners[(side + 1) % 3]].map(place);
                at.entry(ends).or_default().push(3 * root + side as u32);
            }
        }
        let surface = |side: u32| self.facts[side as usize / 3].surface;
        let mut mates = vec![None; 3 * self.nodes.len()];
        for (&[from, to], sides) in &at {
            let Some(back) = at.get(&[to, from]) else {
                continue;
            };
            let ends = [from, to].map(|place| Vec3::from(place.map(f32::from_bits)));
            // Two sheets may stand on one line: each side has the one that goes on in its own wall.
            for &side in sides {
                let one = |&&other: &&u32| joins([surface(side), surface(other)], ends);
                let mut others = back.iter().filter(one);
                if let (Some(&other), None) = (others.next(), others.next()) {
                    mates[side as usize] = Some(other);
                }
            }
        }
        // Where three meet it is nobody's.
        let is_mutual =
            |side: usize| mates[side].is_some_and(|mate| mates[mate as usize] == Some(side as u32));
        (0..mates.len())
            .map(|side| mates[side].filter(|_| is_mutual(side)))
            .collect()
    }

    /// Gives each corner of the roots its vertex: one for all that meet there by way of common sides.
    fn weld_corners(&mut self, scene: &Scene, mates: &[Option<u32>]) {
        for first in 0..3 * self.nodes.len() {
            if self.nodes[first / 3].vertices[first % 3] != NONE {
                continue;
            }
            let surface = self.facts[first / 3].surface;
            let vertex = self.vertices.len() as u32;
            self.vertices.push(Vertex {
                position: scene.surface(surface).corners[first % 3].as_dvec3(),
                node: first as u32 / 3,
                between: None,
                is_inside: false,
            });
            let mut open = vec![first];
            while let Some(corner) = open.pop() {
                let (root, k) = (corner / 3, corner % 3);
                if std::mem::replace(&mut self.nodes[root].vertices[k], vertex) == vertex {
                    continue;
                }
                // The side that starts here ends there; the one that ends here starts there.
                let (out, into) = (3 * root + k, 3 * root + (k + 2) % 3);
                let next = |side: u32| 3 * (side as usize / 3) + (side as usize % 3 + 1) % 3;
                open.extend(mates[out].map(next));
                open.extend(mates[into].map(|side| side as usize));
            }
        }
    }

    fn lay_edges(&mut self, mates: &[Option<u32>]) {
        for (side, mate) in mates.iter().enumerate() {
            let (root, k) = (side / 3, side % 3);
            if self.facts[root].edges[k] != NONE {
                continue;
            }
            let vertices = self.nodes[root].vertices;
            let edge = self.edges.len() as u32;
            let mut leaves = [root as u32, NONE];
            self.facts[root].edges[k] = edge;
            if let &Some(mate) = mate {
                leaves[1] = mate / 3;
                self.facts[mate as usize / 3].edges[mate as usize % 3] = edge;
            }
            self.edges.push(Edge {
                ends: [vertices[k], vertices[(k + 1) % 3]],
                leaves,
                cut: None,
            });
        }
    }

    /// Whether a surface has vertices.
    pub fn has_vertices(&self, surface: SurfaceId) -> bool {
        self.roots[surface.index()] != NO_ROOT
    }

    /// How many vertices there are; new ones have the highest numbers.
    pub fn vertex_count(&self) -> u32 {
        self.vertices.len() as u32
    }

    /// All leaves.
    pub fn leaves(&self) -> impl Iterator<Item = NodeId> {
        let nodes = (0..).map(NodeId).zip(&self.nodes);
        nodes.filter(|(_, node)| node.child == 0).map(|(id, _)| id)
    }

    /// All triangles there are and were, each before its halves.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = NodeId> + use<> {
        (0..self.nodes.len() as u32).map(NodeId)
    }

    /// The halves of a triangle; `None` where it is a leaf.
    pub fn halves(&self, node: NodeId) -> Option<[NodeId; 2]> {
        let child = self.nodes[node.0 as usize].child;
        (child > 0).then(|| [NodeId(child), NodeId(child + 1)])
    }

    /// Whether a triangle is a leaf.
    pub fn is_leaf(&self, node: NodeId) -> bool {
        self.nodes[node.0 as usize].child == 0
    }

    /// The vertices of a triangle.
    pub fn corners(&self, node: NodeId) -> [VertexId; 3] {
        self.nodes[node.0 as usize].vertices.map(VertexId)
    }

    /// The surface that a triangle is part of.
    pub fn surface(&self, node: NodeId) -> SurfaceId {
        self.facts[node.0 as usize].surface
    }

    /// The area of a triangle, m^2.
    pub fn area(&self, node: NodeId) -> f64 {
        self.facts[node.0 as usize].area
    }

    /// The position of a vertex, metres, relative to the scene's origin.
    pub fn position(&self, vertex: VertexId) -> DVec3 {
        self.vertices[vertex.0 as usize].position
    }

    /// The two vertices that a vertex is the middle of; `None` where it is a surface's corner.
    pub fn between(&self, vertex: VertexId) -> Option<[VertexId; 2]> {
        self.vertices[vertex.0 as usize]
            .between
            .map(|ends| ends.map(VertexId))
    }

    /// How often the surface was bisected that a triangle is part of, and the code of these bisections, see [`bisection`].
    pub fn bisections(&self, node: NodeId) -> (u32, u32) {
        let Facts { depth, code, .. } = self.facts[node.0 as usize];
        (depth, code)
    }

    /// The leaf at barycentric coordinates in a surface, and the coordinates in it, which have the same sum; `None` where the surface
    /// has no vertices. A point outside of the surface is assigned to a leaf on its border.
    pub fn leaf_at(&self, surface: SurfaceId, barycentric: DVec3) -> Option<(NodeId, DVec3)> {
        let root = self.roots[surface.index()];
        let mut node = (root != NO_ROOT).then_some(NodeId(root))?;
        let mut at = barycentric;
        while let Some([first, second]) = self.halves(node) {
            let DVec3 { x: a, y: b, z: c } = at;
            (node, at) = if a >= b {
                (first, DVec3::new(a - b, c, 2.0 * b))
            } else {
                (second, DVec3::new(c, b - a, 2.0 * a))
            };
        }
        Some((node, at))
    }

    /// The corners of a triangle as barycentric coordinates in its surface, in the order of [`Self::corners`]; exact.
    pub fn in_surface(&self, node: NodeId) -> [DVec3; 3] {
        let Facts { depth, code, .. } = self.facts[node.0 as usize];
        let [a, b, c] = bisection::leaf_corners(depth, code);
        // Those have the surface's orientation.
        if depth.is_multiple_of(2) {
            [a, b, c]
        } else {
            [b, a, c]
        }
    }

    /// The surface on which a vertex came to be, and its barycentric coordinates there; the same of a point inside of the
    /// wall beside it: the middle of the triangle that had it then, or the vertex itself where the wall is all around it.
    pub fn place_of(&self, vertex: VertexId) -> (SurfaceId, [DVec3; 2]) {
        let Vertex {
            node,
            between,
            is_inside,
            ..
        } = self.vertices[vertex.0 as usize];
        let corners = self.in_surface(NodeId(node));
        let centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
        let place = if between.is_some() {
            0.5 * (corners[0] + corners[1])
        } else {
            let vertices = self.nodes[node as usize].vertices;
            let corner = vertices.iter().position(|&v| v == vertex.0).unwrap_or(0);
            corners[corner]
        };
        let inside = if is_inside { place } else { centroid };
        (self.facts[node as usize].surface, [place, inside])
    }

    /// Bisects a leaf, and whatever has to be for the mesh to conform; nothing if it is as deep as a tree may be.
    pub fn bisect(&mut self, leaf: NodeId) {
        if !self.is_leaf(leaf) || self.bisections(leaf).0 >= MAX_DEPTH {
            return;
        }
        let mut open = vec![self.cut(leaf.0)];
        while let Some(edge) = open.pop() {
            let [leaf, _] = self.edges[edge as usize].leaves;
            if leaf != NONE {
                // First its own reference edge, if that is another one; then this one is a child's.
                open.push(edge);
                let cut = self.cut(leaf);
                if cut != edge {
                    open.push(cut);
                }
            }
        }
    }

    /// Cuts a leaf at its reference edge, which it returns.
    fn cut(&mut self, leaf: u32) -> u32 {
        let Facts {
            surface,
            depth,
            code,
            area,
            edges: [reference, second, third],
        } = self.facts[leaf as usize];
        let [p0, p1, p2] = self.nodes[leaf as usize].vertices;
        let (middle, halves) = self.middle_of(reference, leaf);
        // The half at p0, then that at p1.
        let is_along = self.edges[reference as usize].ends[0] == p0;
        let [at_p0, at_p1] = if is_along {
            halves
        } else {
            [halves[1], halves[0]]
        };
        let inner = self.edges.len() as u32;
        let child = self.nodes.len() as u32;
        self.edges.push(Edge {
            ends: [p2, middle],
            leaves: [child, child + 1],
            cut: None,
        });
        for (vertices, edges, is_second) in [
            ([p0, p2, middle], [third, inner, at_p0], 0),
            ([p2, p1, middle], [second, at_p1, inner], 1),
        ] {
            self.nodes.push(Node { vertices, child: 0 });
            self.facts.push(Facts {
                surface,
                depth: depth + 1,
                code: code << 1 | is_second,
                area: 0.5 * area,
                edges,
            });
        }
        self.nodes[leaf as usize].child = child;
        self.replace(reference, leaf, NONE);
        self.replace(third, leaf, child);
        self.replace(second, leaf, child + 1);
        self.replace(at_p0, NONE, child);
        self.replace(at_p1, NONE, child + 1);
        reference
    }

    /// The vertex in the middle of an edge of a leaf, and the edge's halves.
    fn middle_of(&mut self, edge: u32, leaf: u32) -> (u32, [u32; 2]) {
        let Edge { ends, cut, leaves } = self.edges[edge as usize];
        if let Some(cut) = cut {
            return cut;
        }
        let vertex = self.vertices.len() as u32;
        let [a, b] = ends.map(|end| self.vertices[end as usize].position);
        self.vertices.push(Vertex {
            position: 0.5 * (a + b),
            node: leaf,
            between: Some(ends),
            is_inside: !leaves.contains(&NONE),
        });
        let first = self.edges.len() as u32;
        for ends in [[ends[0], vertex], [vertex, ends[1]]] {
            self.edges.push(Edge {
                ends,
                leaves: [NONE; 2],
                cut: None,
            });
        }
        let cut = (vertex, [first, first + 1]);
        self.edges[edge as usize].cut = Some(cut);
        cut
    }

    /// Puts one leaf in another's place beside an edge; what is there comes first.
    fn replace(&mut self, edge: u32, leaf: u32, by: u32) {
        let leaves = &mut self.edges[edge as usize].leaves;
        if let Some(place) = leaves.iter_mut().find(|there| **there == leaf) {
            *place = by;
        }
        if leaves[0] == NONE {
            leaves.swap(0, 1);
        }
    }

    /// The mesh as it is, for a scene of the same surfaces.
    ///
    /// # Errors
    /// None but for a scene of other surfaces.
    pub fn mesh(&self) -> Result<VertexMesh, SceneError> {
        let vertices = self.vertices.iter().map(|vertex| vertex.position.as_vec3());
        VertexMesh::new(
            self.roots.len(),
            self.roots.clone(),
            self.nodes.clone(),
            vertices.collect(),
        )
    }
}
