//! The few convex polygons that a region's triangles form.
//!
//! # Method
//! Vertices that the outline does not need are taken out of the triangulation one after the other, and what
//! they leave is cut into triangles by its ears: as there are always triangles of positive
//! area with the same boundary, holes and vertices that touch need no care, and where a vertex
//! cannot be taken out it stays. Then edges are removed, longest first, wherever both ends stay convex
//! (Hertel and Mehlhorn, "Fast triangulation of simple polygons", 1983: at most four times the fewest
//! pieces).

use glam::DVec2;
use scene::planar::turn;

use super::outline::{NONE, Outline, RegionMesh, Turn, next, previous};

/// The most triangles around a vertex that is taken out, at first and in the end. Cutting ears takes
/// time with the cube of it. Tuned: triangulations have 6 on average.
const MOST_AROUND: [usize; 2] = [16, 100];

/// How many rounds over all vertices there are for each of these.
const ROUNDS: usize = 24;

/// Difference of areas, relative, that may come from corners that were dropped as rounding.
pub(super) const AREA_TOLERANCE: f64 = 1e-6;

/// Corners of convex polygons, counter-clockwise, as vertices of the mesh; `None` where they do not
/// have the region's area.
pub(super) fn pieces(mesh: &RegionMesh, outline: &Outline) -> Option<Vec<Vec<u32>>> {
    let area = mesh.flat_area();
    let triangulation = Triangulation::new(mesh, outline);
    [true, false].into_iter().find_map(|straight| {
        let pieces = triangulation.merged(straight)?;
        let sum: f64 = pieces.iter().map(|piece| flat_area(mesh, piece)).sum();
        ((sum - area).abs() <= AREA_TOLERANCE * area).then_some(pieces)
    })
}

/// Triangles without the vertices that the outline does not need, as vertices of the mesh, and of each half-edge the opposite one, as
/// in the mesh; `None` where they do not have the region's area.
pub(super) fn triangles(mesh: &RegionMesh, outline: &Outline) -> Option<(Vec<[u32; 3]>, Vec<u32>)> {
    let all = Triangulation::new(mesh, outline);
    let is_there = |triangle: &usize| all.corners[*triangle][0] != NONE;
    let mut number = vec![NONE; all.corners.len()];
    let kept: Vec<usize> = (0..all.corners.len()).filter(is_there).collect();
    for (k, &triangle) in (0..).zip(&kept) {
        number[triangle] = k;
    }
    let renamed = |half: u32| match half {
        NONE => NONE,
        half => 3 * number[half as usize / 3] + half % 3,
    };
    let corners: Vec<[u32; 3]> = kept.iter().map(|&triangle| all.corners[triangle]).collect();
    let mates = kept
        .iter()
        .flat_map(|&triangle| &all.mates[3 * triangle..3 * triangle + 3]);
    let mates = mates.map(|&half| renamed(half)).collect();
    let area = mesh.flat_area();
    let sum: f64 = corners.iter().map(|corners| flat_area(mesh, corners)).sum();
    ((sum - area).abs() <= AREA_TOLERANCE * area).then_some((corners, mates))
}

fn flat_area(mesh: &RegionMesh, piece: &[u32]) -> f64 {
    let point = |k: usize| mesh.flat[piece[k] as usize];
    (2..piece.len())
        .map(|k| 0.5 * turn(point(0), point(k - 1), point(k)))
        .sum()
}

/// Triangles that change. One that is gone has corners [`NONE`].
struct Triangulation<'a> {
    mesh: &'a RegionMesh,
    corners: Vec<[u32; 3]>,
    mates: Vec<u32>,
    /// Of each vertex, a half-edge that starts there, on the boundary the first counter-clockwise.
    starts: Vec<u32>,
}

/// A side of a polygon that is cut: the vertex it starts from, and the half-edge outside.
type Side = (u32, u32);

impl<'a> Triangulation<'a> {
    /// That of a region, without the vertices that its outline does not need.
    fn new(mesh: &'a RegionMesh, outline: &Outline) -> Self {
        let mut triangulation = Self {
            mesh,
            corners: mesh.corners.clone(),
            mates: mesh.mates.clone(),
            starts: vec![NONE; mesh.points.len()],
        };
        triangulation.drop_vertices(&outline.is_dropped);
        triangulation
    }

    fn origin(&self, half: u32) -> u32 {
        self.corners[half as usize / 3][half as usize % 3]
    }

    fn drop_vertices(&mut self, is_dropped: &[bool]) {
        for half in 0..self.mates.len() as u32 {
            let vertex = self.origin(half) as usize;
            if self.starts[vertex] == NONE || self.mates[half as usize] == NONE {
                self.starts[vertex] = half;
            }
        }
        let mut rest: Vec<u32> = (0..is_dropped.len() as u32)
            .filter(|&vertex| is_dropped[vertex as usize])
            .collect();
        for most in MOST_AROUND {
            for _ in 0..ROUNDS {
                let before = rest.len();
                rest.retain(|&vertex| !self.drop_vertex(vertex, most));
                if rest.len() == before {
                    break;
                }
            }
        }
    }

    /// Takes a vertex out, where that can be done.
    fn drop_vertex(&mut self, vertex: u32, most: usize) -> bool {
        let first = self.starts[vertex as usize];
        let (mut around, mut sides) = (Vec::new(), Vec::new());
        let mut half = first;
        let is_inside = loop {
            around.push(half / 3);
            let opposite = next(half);
            sides.push((self.origin(opposite), self.mates[opposite as usize]));
            half = self.mates[previous(half) as usize];
            if half == first || half == NONE {
                break half == first;
            }
            if around.len() == most {
                return false;
            }
        };
        if !is_inside {
            let last = previous(around_last(&around, &self.corners, vertex));
            sides.push((self.origin(last), NONE));
        }
        if sides.len() == 2 && sides[0].1 == NONE {
            return false;
        }
        let Some(ears) = ears(&self.mesh.flat, sides.iter().map(|side| side.0).collect()) else {
            return false;
        };
        for &triangle in &around {
            self.corners[triangle as usize] = [NONE; 3];
        }
        self.cut(sides, &ears, &around);
        true
    }

    /// Replaces a polygon by triangles: `ears` are the places in what is left of it, `free` where the
    /// triangles go.
    fn cut(&mut self, mut sides: Vec<Side>, ears: &[usize], free: &[u32]) {
        if let [(_, mate), _] = sides[..] {
            self.mates[mate as usize] = NONE;
            let vertex = self.origin(mate);
            self.starts[vertex as usize] = mate;
            return;
        }
        for (&ear, &triangle) in ears.iter().zip(free) {
            let count = sides.len();
            let (before, after) = ((ear + count - 1) % count, (ear + 1) % count);
            let corners = [before, ear, after];
            self.corners[triangle as usize] = corners.map(|place| sides[place].0);
            self.join(3 * triangle, sides[before].1);
            self.join(3 * triangle + 1, sides[ear].1);
            if count == 3 {
                self.join(3 * triangle + 2, sides[after].1);
            } else {
                sides[before].1 = 3 * triangle + 2;
                sides.remove(ear);
            }
        }
    }

    fn join(&mut self, half: u32, mate: u32) {
        self.mates[half as usize] = mate;
        let vertex = self.origin(half) as usize;
        let start = self.starts[vertex];
        // Half-edges on the boundary stay first.
        let is_stale = self.origin(start) as usize != vertex || self.mates[start as usize] != NONE;
        if mate == NONE || is_stale {
            self.starts[vertex] = half;
        }
        if mate != NONE {
            self.mates[mate as usize] = half;
        }
    }

    /// The triangles merged to convex polygons. Corners may become straight if `straight`; they are then
    /// removed. `None` where a polygon is not convex after that.
    fn merged(&self, straight: bool) -> Option<Vec<Vec<u32>>> {
        let is_there = |half: u32| self.corners[half as usize / 3][0] != NONE;
        let halves = 0..self.mates.len() as u32;
        let (mut after, mut before): (Vec<u32>, Vec<u32>) = halves
            .clone()
            .map(|half| (next(half), previous(half)))
            .unzip();
        let mut is_gone = vec![false; self.mates.len()];
        let mut edges: Vec<(f64, u32)> = halves
            .clone()
            .filter(|&half| is_there(half))
            .filter(|&half| {
                let mate = self.mates[half as usize];
                mate != NONE && half < mate
            })
            .map(|half| {
                let point = |half: u32| self.mesh.points[self.origin(half) as usize];
                (point(half).distance_squared(point(next(half))), half)
            })
            .collect();
        edges.sort_unstable_by(|(a, i), (b, j)| b.total_cmp(a).then(i.cmp(j)));
        for (_, half) in edges {
            let (half, mate) = (half as usize, self.mates[half as usize] as usize);
            let ends = [(before[half], after[mate]), (before[mate], after[half])];
            let is_convex = ends.iter().all(|&(to, from)| {
                let path = [to, from, after[from as usize]].map(|half| self.origin(half));
                match self.mesh.turn(path) {
                    Turn::Left => true,
                    Turn::Straight => straight,
                    Turn::Right => false,
                }
            });
            if is_convex {
                for (to, from) in ends {
                    after[to as usize] = from;
                    before[from as usize] = to;
                }
                is_gone[half] = true;
                is_gone[mate] = true;
            }
        }
        let mut pieces = Vec::new();
        for first in halves {
            if is_gone[first as usize] || !is_there(first) {
                continue;
            }
            let mut vertices = Vec::new();
            let mut half = first;
            while !is_gone[half as usize] {
                is_gone[half as usize] = true;
                vertices.push(self.origin(half));
                half = after[half as usize];
            }
            pieces.push(self.convex(&vertices)?);
        }
        Some(pieces)
    }

    /// The corners of a polygon that is convex but for rounding.
    fn convex(&self, vertices: &[u32]) -> Option<Vec<u32>> {
        if vertices.len() == 3 {
            return Some(vertices.to_vec());
        }
        let kept = self.mesh.simplified(vertices, |_| false);
        let corners: Vec<u32> = kept.iter().map(|&place| vertices[place]).collect();
        let point = |k: usize| self.mesh.flat[corners[k % corners.len()] as usize];
        let is_convex =
            (0..corners.len()).all(|k| turn(point(k), point(k + 1), point(k + 2)) > 0.0);
        (corners.len() >= 3 && is_convex).then_some(corners)
    }
}

/// The half-edge that starts from a vertex in the last triangle around it.
fn around_last(around: &[u32], corners: &[[u32; 3]], vertex: u32) -> u32 {
    let triangle = around[around.len() - 1];
    let place = corners[triangle as usize].iter().position(|&c| c == vertex);
    3 * triangle + place.unwrap_or(0) as u32
}

/// Which corners of a polygon can be cut off one after the other, as their places in what is left; the last
/// triangle comes as one too. `None` where that fails. The best shaped ear goes first, which takes the cube of their number
/// but keeps what is left easy to take apart; an import, whose polygons may be long and must all be cut, takes
/// the next ear instead ([`scene::obj`]).
fn ears(points: &[DVec2], mut rest: Vec<u32>) -> Option<Vec<usize>> {
    let mut ears = Vec::with_capacity(rest.len());
    while rest.len() > 2 {
        let count = rest.len();
        let (ear, _) = (0..count)
            .filter_map(|ear| {
                let corners = [(ear + count - 1) % count, ear, (ear + 1) % count];
                let vertices = corners.map(|place| rest[place]);
                let [a, b, c] = vertices.map(|vertex| points[vertex as usize]);
                let area = turn(a, b, c);
                let holds =
                    |p| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
                let is_ear = area > 0.0
                    && rest.iter().enumerate().all(|(place, &vertex)| {
                        corners.contains(&place) || !holds(points[vertex as usize])
                    });
                let sides = [a - b, b - c, c - a].map(DVec2::length_squared);
                is_ear.then(|| (ear, area / (sides[0] + sides[1] + sides[2])))
            })
            .max_by(|a, b| a.1.total_cmp(&b.1).then(b.0.cmp(&a.0)))?;
        ears.push(ear);
        if count == 3 {
            break;
        }
        rest.remove(ear);
    }
    Some(ears)
}
