//! A region's triangles, their neighbours, and what bounds them.

use glam::{DVec2, DVec3};
use scene::planar::{facing_axes, turn};

use super::ULP;
use super::flood::Group;
use super::weld::{Welded, sorted_edges};

/// No half-edge on the other side.
pub(super) const NONE: u32 = u32::MAX;

/// The half-edge after this one in its triangle.
pub(super) fn next(half: u32) -> u32 {
    if half % 3 == 2 { half - 2 } else { half + 1 }
}

/// The half-edge before this one in its triangle.
pub(super) fn previous(half: u32) -> u32 {
    if half.is_multiple_of(3) {
        half + 2
    } else {
        half - 1
    }
}

/// The triangles of a region. Half-edge 3 t + k leads from corner k of triangle t to the next.
pub(super) struct RegionMesh {
    pub normal: DVec3,
    /// Of each vertex, its index in the scene; ascending.
    pub vertices: Vec<u32>,
    /// Of each vertex, metres.
    pub points: Vec<DVec3>,
    /// Of each vertex, in the coordinate plane that the region faces most, counter-clockwise seen from the front:
    /// f32 coordinates as they are, so that orientations are exact but for one f64 rounding.
    pub flat: Vec<DVec2>,
    /// Of each triangle, its vertices.
    pub corners: Vec<[u32; 3]>,
    /// Of each half-edge, the opposite one, or [`NONE`].
    pub mates: Vec<u32>,
}

impl RegionMesh {
    /// `None` where three triangles or two of one side share an edge.
    pub(super) fn new(welded: &Welded, group: &Group) -> Option<Self> {
        let of = |&surface: &u32| welded.corners[surface as usize];
        let mut vertices: Vec<u32> = group.surfaces.iter().flat_map(of).collect();
        vertices.sort_unstable();
        vertices.dedup();
        let local = |vertex: u32| vertices.partition_point(|&v| v < vertex) as u32;
        let corners: Vec<[u32; 3]> = group.surfaces.iter().map(|s| of(s).map(local)).collect();
        let mut mates = vec![NONE; 3 * corners.len()];
        for edge in sorted_edges(&corners).chunk_by(|a, b| a.0 == b.0) {
            match *edge {
                [_] => {}
                [(_, a), (_, b)] => {
                    let origin = |half: u32| corners[half as usize / 3][half as usize % 3];
                    if origin(a) == origin(b) {
                        return None;
                    }
                    mates[a as usize] = b;
                    mates[b as usize] = a;
                }
                _ => return None,
            }
        }
        let points: Vec<DVec3> = vertices
            .iter()
            .map(|&vertex| welded.vertices[vertex as usize].as_dvec3())
            .collect();
        let [u, v] = facing_axes(group.normal);
        Some(Self {
            normal: group.normal,
            flat: points.iter().map(|p| DVec2::new(p[u], p[v])).collect(),
            vertices,
            points,
            corners,
            mates,
        })
    }

    /// The vertex that a half-edge starts from.
    pub(super) fn origin(&self, half: u32) -> u32 {
        self.corners[half as usize / 3][half as usize % 3]
    }

    /// The sum of the triangles' areas as seen along the coordinate axis, m^2.
    pub(super) fn flat_area(&self) -> f64 {
        self.corners
            .iter()
            .map(|corners| {
                let [a, b, c] = corners.map(|vertex| self.flat[vertex as usize]);
                0.5 * turn(a, b, c)
            })
            .sum()
    }

    /// Whether three vertices turn left at the middle one.
    pub(super) fn turn(&self, [a, v, b]: [u32; 3]) -> Turn {
        let [a, v, b] = [a, v, b].map(|vertex| self.points[vertex as usize]);
        let Some(side) = Side::new(a, b, self.normal) else {
            return Turn::Right;
        };
        let (along, left, limit) = side.place(v);
        if left < -limit {
            Turn::Left
        } else if left <= limit && along > 0.0 && along < 1.0 {
            Turn::Straight
        } else {
            Turn::Right
        }
    }

    /// The places in a loop of vertices that are corners. All others are in a line with the corners before and
    /// after them but for rounding, of two units in the last place. Vertices that `is_fixed` are
    /// corners in any case.
    pub(super) fn simplified(
        &self,
        vertices: &[u32],
        is_fixed: impl Fn(u32) -> bool,
    ) -> Vec<usize> {
        let count = vertices.len();
        let point = |place: usize| self.points[vertices[place % count] as usize];
        let middle = (0..count).map(point).sum::<DVec3>() / count as f64;
        // What is farthest from any point is a corner.
        let mut start = (0, -1.0);
        for place in 0..count {
            let distance = point(place).distance_squared(middle);
            if distance > start.1 {
                start = (place, distance);
            }
        }
        let is_straight = |from: usize, to: usize| {
            let Some(side) = Side::new(point(from), point(to), self.normal) else {
                return false;
            };
            let mut before = 0.0;
            (from + 1..to).all(|place| {
                let (along, left, limit) = side.place(point(place));
                let is_in_order = along > before && along < 1.0;
                before = along;
                is_in_order && left.abs() <= limit && !is_fixed(vertices[place % count])
            })
        };
        let (mut place, end) = (start.0, start.0 + count);
        let mut kept = Vec::new();
        while place < end {
            kept.push(place % count);
            // Doubled as long as it is straight, then halved: each vertex is looked at log n times.
            let mut step = 1;
            while place + 2 * step <= end && is_straight(place, place + 2 * step) {
                step *= 2;
            }
            let mut more = step;
            while more > 0 {
                let to = place + step + more;
                if to <= end && is_straight(place, to) {
                    step += more;
                }
                more /= 2;
            }
            place += step;
        }
        kept
    }
}

/// How a path turns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Turn {
    Left,
    /// Not beyond rounding.
    Straight,
    /// Or back.
    Right,
}

/// A segment from which points are measured.
struct Side {
    ends: [DVec3; 2],
    /// Unit vector to its left.
    left: DVec3,
}

impl Side {
    fn new(a: DVec3, b: DVec3, normal: DVec3) -> Option<Self> {
        let left = normal.cross(b - a).try_normalize()?;
        Some(Self { ends: [a, b], left })
    }

    /// Where a point is along the segment, 0 at its start and 1 at its end; how far to its left, metres; and
    /// by how much that may come from rounding.
    fn place(&self, p: DVec3) -> (f64, f64, f64) {
        let [a, b] = self.ends;
        let along = (p - a).dot(b - a) / a.distance_squared(b);
        let reach = a.abs().lerp(b.abs(), along.clamp(0.0, 1.0)) + p.abs();
        (
            along,
            (p - a).dot(self.left),
            ULP * self.left.abs().dot(reach),
        )
    }
}

/// What bounds a region.
pub(super) struct Outline {
    /// Of each vertex: not needed for the outline.
    pub is_dropped: Vec<bool>,
    /// Unit direction of the longest side.
    pub direction: DVec3,
}

impl Outline {
    pub(super) fn new(mesh: &RegionMesh) -> Option<Self> {
        // How many sides of the outline start from each vertex.
        let mut starts = vec![0_u32; mesh.points.len()];
        let bounds = |half: u32| mesh.mates[half as usize] == NONE;
        let halves = || (0..mesh.mates.len() as u32).filter(|&half| bounds(half));
        for half in halves() {
            starts[mesh.origin(half) as usize] += 1;
        }
        let mut is_dropped: Vec<bool> = starts.iter().map(|&count| count == 0).collect();
        let mut is_done = vec![false; mesh.mates.len()];
        let mut longest = DVec3::ZERO;
        for first in halves() {
            if is_done[first as usize] {
                continue;
            }
            let mut vertices = Vec::new();
            let mut half = first;
            while !is_done[half as usize] {
                is_done[half as usize] = true;
                vertices.push(mesh.origin(half));
                // Round the end, from triangle to triangle.
                half = next(half);
                while !bounds(half) {
                    half = next(mesh.mates[half as usize]);
                }
            }
            let kept = mesh.simplified(&vertices, |vertex| starts[vertex as usize] > 1);
            for &vertex in &vertices {
                is_dropped[vertex as usize] = true;
            }
            for (k, &place) in kept.iter().enumerate() {
                is_dropped[vertices[place] as usize] = false;
                let to = vertices[kept[(k + 1) % kept.len()]];
                let side = mesh.points[to as usize] - mesh.points[vertices[place] as usize];
                if side.length_squared() > longest.length_squared() {
                    longest = side;
                }
            }
        }
        Some(Self {
            is_dropped,
            direction: longest.try_normalize()?,
        })
    }
}
