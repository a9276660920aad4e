//! Values interpolated between patches.
//!
//! # Theory
//! A value at a vertex is the mean, weighted by area, of the patches that meet there, and a point
//! in a patch has the value that is linear between those of its corners (Cohen and Wallace,
//! "Radiosity and Realistic Image Synthesis", 1993, section 9.1). It is continuous over shared
//! edges and stays within the least and the greatest value of the patches around. What lies inside of a solid is left out: the
//! floor around a box does not darken because the floor below it is dark.
//!
//! Radiosity itself is not continuous everywhere. Where patches that meet at a point differ in
//! material, or in their normals by more than [`CREASE_DEGREES`], the point is several vertices,
//! one for each group of patches; so nothing bleeds over an edge of the room or out of a lamp.
//!
//! Where a surface is bisected deeper than its neighbour, a vertex of the finer one may lie in the
//! middle of a coarser patch's edge (a T-vertex). Its value is then the mean of that edge's ends,
//! which is what the coarser patch shows there: no seam opens.
//!
//! # Practice
//! Corners are matched by position, bit for bit. Corners of patches are dyadic means of surface
//! corners, computed in f64 (exactly, but for exponents far apart) and rounded once, so both sides
//! of an edge get the same bits whichever way round they run. Everything is sorted, nothing is
//! hashed: n log n, and the same on every run.
//!
//! # Differences
//! T-vertices that are no midpoints, as between surfaces which share only part of an edge, are
//! left as they are, as are those whose groups differ.

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scene::weld::{Place, place};
use scene::{MaterialId, PatchId, Rgb, Scene, bisection};

/// Normals that differ by more are on the two sides of a crease. Tuned: a column of 16 sides (22.5
/// degrees) is meant to be round, one of 8 (45 degrees) is not.
pub const CREASE_DEGREES: f64 = 30.0;

/// The corner of a patch: 3 patch + 0, 1 or 2.
type CornerIndex = u32;

/// Values at the corners of all patches.
#[derive(Clone, Debug)]
pub struct VertexValues {
    /// One per vertex, W/m^2.
    values: Vec<Rgb>,
    /// Index into `values`, three per patch.
    vertex_of_corner: Vec<u32>,
}

/// A vertex: corners of patches at one position that belong together.
struct Vertex {
    place: Place,
    material: MaterialId,
    /// Unit normal of its first patch.
    normal: DVec3,
}

impl VertexValues {
    /// Vertex values from those of the patches (one per patch, W/m^2).
    pub fn new(scene: &Scene, patch_values: &[Rgb]) -> Self {
        let normals: Vec<DVec3> = scene
            .surfaces()
            .iter()
            .map(scene::Surface::normal)
            .collect();
        let patches: Vec<scene::Patch> = (0..scene.patch_count())
            .into_par_iter()
            .map(|p| scene.patch(PatchId(p)))
            .collect();

        let mut corners: Vec<(Place, CornerIndex)> = patches
            .par_iter()
            .enumerate()
            .flat_map_iter(|(p, patch)| {
                (0..3).map(move |k| (place(patch.corners[k]), (3 * p + k) as CornerIndex))
            })
            .collect();
        corners.par_sort_unstable();

        let is_inside = scene.is_inside();
        let mut vertices: Vec<Vertex> = Vec::new();
        let mut sums: Vec<(DVec3, f64)> = Vec::new();
        let mut vertex_of_corner = vec![0; corners.len()];
        for at_one_position in corners.chunk_by(|a, b| a.0 == b.0) {
            let first = vertices.len();
            for &(place, corner) in at_one_position {
                let patch = &patches[corner as usize / 3];
                let material = scene.surface(patch.surface).material;
                let normal = normals[patch.surface.index()];
                let known = vertices[first..]
                    .iter()
                    .position(|v| v.takes(material, normal));
                let vertex = first + known.unwrap_or(vertices.len() - first);
                if vertex == vertices.len() {
                    vertices.push(Vertex {
                        place,
                        material,
                        normal,
                    });
                    sums.push((DVec3::ZERO, 0.0));
                }
                let index = corner as usize / 3;
                if !is_inside[index] {
                    let (sum, area) = &mut sums[vertex];
                    *sum += patch.area * patch_values[index].as_dvec3();
                    *area += patch.area;
                }
                vertex_of_corner[corner as usize] = vertex as u32;
            }
        }
        let mut values: Vec<Rgb> = sums
            .iter()
            .map(|(sum, area)| (sum / area.max(f64::MIN_POSITIVE)).as_vec3())
            .collect();
        close_seams(scene, &vertices, &vertex_of_corner, &mut values);
        Self {
            values,
            vertex_of_corner,
        }
    }

    /// The value at barycentric coordinates in a patch, which sum to 1.
    #[inline]
    pub fn at(&self, patch: PatchId, [a, b, c]: [f32; 3]) -> Rgb {
        let [va, vb, vc] = self.corners(patch);
        a * va + b * vb + c * vc
    }

    /// The values at a patch's corners.
    #[inline]
    pub fn corners(&self, patch: PatchId) -> [Rgb; 3] {
        let first = 3 * patch.index();
        [0, 1, 2].map(|k| self.values[self.vertex_of_corner[first + k] as usize])
    }
}

impl Vertex {
    /// Whether a patch with this material and normal belongs to the vertex.
    fn takes(&self, material: MaterialId, normal: DVec3) -> bool {
        let least = CREASE_DEGREES.to_radians().cos();
        self.material == material && self.normal.dot(normal) >= least
    }
}

/// A T-vertex, and the part of a coarser patch's edge that it is in the middle of.
struct Seam {
    /// Length of that part, squared, m^2.
    length_squared: f64,
    vertex: u32,
    ends: [u32; 2],
}

/// Gives every T-vertex in the middle of a patch's edge the mean of the edge's ends, then those in
/// the middles of the halves, and so on.
fn close_seams(scene: &Scene, vertices: &[Vertex], vertex_of_corner: &[u32], values: &mut [Rgb]) {
    let mut seams: Vec<Seam> = (0..scene.patch_count())
        .into_par_iter()
        .flat_map_iter(|patch| {
            let surface = scene.mesh().surface_of(PatchId(patch));
            let tree = scene.mesh().tree(surface);
            let weights = bisection::leaf_corners(tree.depth, patch - tree.first_patch.0);
            let ends = &vertex_of_corner[3 * patch as usize..][..3];
            let root = scene.surface(surface).corners.map(Vec3::as_dvec3);
            let mut seams = Vec::new();
            let mut edges: Vec<[(DVec3, u32); 2]> = [[0, 1], [1, 2], [2, 0]]
                .map(|edge| edge.map(|k| (weights[k], ends[k])))
                .into();
            // Positions come from the surface's corners, as those of patches do: the middle of two
            // rounded corners would often miss by one rounding.
            let position = |w: DVec3| w.x * root[0] + w.y * root[1] + w.z * root[2];
            while let Some([(p, p_vertex), (q, q_vertex)]) = edges.pop() {
                let middle = 0.5 * (p + q);
                let like = &vertices[ends[0] as usize];
                if let Some(vertex) = find(vertices, place(position(middle).as_vec3()), like) {
                    seams.push(Seam {
                        length_squared: position(p).distance_squared(position(q)),
                        vertex,
                        ends: [p_vertex, q_vertex],
                    });
                    edges.push([(p, p_vertex), (middle, vertex)]);
                    edges.push([(middle, vertex), (q, q_vertex)]);
                }
            }
            seams
        })
        .collect();
    // Longest first: an end may itself lie in the middle of a longer edge. The indices make the
    // order one, should several edges run through a vertex.
    seams.par_sort_unstable_by(|a, b| {
        let by_index = (a.vertex, a.ends).cmp(&(b.vertex, b.ends));
        b.length_squared.total_cmp(&a.length_squared).then(by_index)
    });
    for Seam {
        vertex,
        ends: [a, b],
        ..
    } in seams
    {
        values[vertex as usize] = 0.5 * (values[a as usize] + values[b as usize]);
    }
}

/// The vertex at a position that patches like those of `like` belong to.
fn find(vertices: &[Vertex], at: Place, like: &Vertex) -> Option<u32> {
    let first = vertices.partition_point(|v| v.place < at);
    let there = vertices[first..].iter().take_while(|v| v.place == at);
    let place = there
        .into_iter()
        .position(|v| v.takes(like.material, like.normal))?;
    Some((first + place) as u32)
}
