//! What meets at an edge of surfaces whose corners are welded.

use glam::Vec3;
use scene::Surface;
use scene::weld::Vertices;

/// The most surfaces at one edge that are asked whether they are neighbours. More, as in a book's spine,
/// are no wall, and asking each of them for each other would be quadratic.
const MOST_AT_EDGE: usize = 16;

/// A scene's surfaces by their vertices.
pub(super) struct Welded {
    /// Unique positions by first use, metres; no coordinate is -0.
    pub vertices: Vec<Vec3>,
    /// One per surface: indices into `vertices`.
    pub corners: Vec<[u32; 3]>,
    /// All surfaces' edges as (vertices in ascending order, 3 surface + side), sorted.
    edges: Vec<(u64, u32)>,
    /// One per surface's side: where in `edges` its edge's first entry is.
    first: Vec<u32>,
}

impl Welded {
    pub(super) fn new(surfaces: &[Surface]) -> Self {
        let mut vertices = Vertices::with_capacity(surfaces.len());
        let corners: Vec<[u32; 3]> = surfaces
            .iter()
            .map(|surface| surface.corners.map(|p| vertices.index(p)))
            .collect();
        let edges = sorted_edges(&corners);
        let mut first = vec![0; 3 * corners.len()];
        let mut start = 0;
        for (place, &(key, side)) in edges.iter().enumerate() {
            if edges[start].0 != key {
                start = place;
            }
            first[side as usize] = start as u32;
        }
        Self {
            vertices: vertices.into_positions(),
            corners,
            edges,
            first,
        }
    }

    /// The surfaces that have the same edge in the opposite direction.
    pub(super) fn across(&self, surface: u32, side: usize) -> impl Iterator<Item = u32> {
        let own = 3 * surface as usize + side;
        let edges = &self.edges[self.first[own] as usize..];
        let count = edges
            .iter()
            .take(MOST_AT_EDGE + 1)
            .take_while(|(key, _)| *key == edges[0].0)
            .count();
        let asked = if count > MOST_AT_EDGE { 0 } else { count };
        let from = self.corners[surface as usize][side];
        edges[..asked].iter().filter_map(move |&(_, other)| {
            let other = other as usize;
            (self.corners[other / 3][other % 3] != from).then_some(other as u32 / 3)
        })
    }
}

/// The edges of triangles as (vertices in ascending order, 3 triangle + side), sorted.
pub(super) fn sorted_edges(triangles: &[[u32; 3]]) -> Vec<(u64, u32)> {
    let mut edges: Vec<(u64, u32)> = triangles
        .iter()
        .flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
        .zip(0..)
        .map(|((a, b), side)| (u64::from(a.min(b)) << 32 | u64::from(a.max(b)), side))
        .collect();
    edges.sort_unstable();
    edges
}
