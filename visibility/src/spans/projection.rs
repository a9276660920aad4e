//! The pieces of regions as seen from one eye, set up once for all windows.
//!
//! # Theory
//! Let q0, q1, q2 be a triangle's corners relative to the eye. The ray along d meets the
//! triangle's plane where its barycentric coordinates are in the proportion of
//! e_k(d) = (q_{k+1} x q_{k+2}) . d, k = 0, 1, 2 (homogeneous rasterisation: Olano and Greer,
//! "Triangle scan conversion using 2D homogeneous coordinates", Graphics Hardware 1997). It hits
//! the triangle where all three have the sign of the determinant det(q0, q1, q2), at the depth w
//! with 1/w = (e_0 + e_1 + e_2) / det. All of these are linear in d, hence in the pixel: there is no
//! division in a pixel, no clipping and no near plane, and a triangle that passes beside or
//! behind the eye needs no care. The patch follows from the proportion of the e_k alone,
//! see [`scene::bisection`]. What holds of a triangle's edges holds of those of any convex polygon.
//!
//! # Practice
//! The vectors are f64. Two pieces that share an edge have the same vector for it, with opposite signs, so that no
//! pixel between them is missed. Vertices are turned into the frame once for all pieces, or for those of some
//! regions, and the ones that are outside of a face of a hemicube are told by their outcodes ([`outcode`]).

use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;

use crate::buffer::Seen;
use crate::eye::{Cull, Standpoint};
use crate::geometry::Geometry;
use crate::rounding::margin;
use crate::{Frame, outcode};

/// Ratio of depths from which on one is nearer than the other in f32 too, unless a surface is seen almost edge-on.
const CLEARLY_NEARER: f64 = 1.0 + 1e-5;

/// A convex piece of a region as seen from one eye, in the eye's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Projected {
    /// Its corners and edges in [`Projection`]'s lists.
    pub first: u32,
    pub end: u32,
    /// 1/w = inverse_depth . d, 1/m.
    pub inverse_depth: DVec3,
    /// The region it is part of.
    pub region: u32,
    /// True where the eye is behind it.
    pub is_back_face: bool,
    /// Bits that the outcodes of all its corners have in common.
    pub outcode: u32,
}

/// The edge from one corner of a piece to the next.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Edge {
    /// The edge function: e(d) = across . d is at least 0 inside.
    pub across: DVec3,
    /// How far below 0 it may be inside, for directions d no longer than sqrt(3).
    pub margin: f64,
}

/// The pieces that an eye can see, set up for drawing into any window of its frame.
#[derive(Clone, Debug)]
pub(crate) struct Projection {
    level: Level,
    pub pieces: Vec<Projected>,
    /// Of all pieces, relative to the eye, metres.
    pub corners: Vec<DVec3>,
    /// The k-th one ends at the k-th corner.
    pub edges: Vec<Edge>,
    /// All vertices of the scene, axis after axis, relative to the eye, metres.
    vertices: [Vec<f64>; 3],
    /// One per vertex.
    outcodes: Vec<u32>,
}

impl Projection {
    /// Room for the pieces of a scene, of which none is set up.
    pub fn new(geometry: &Geometry) -> Self {
        let count = geometry.vertices[0].len();
        Self {
            level: Level::new(),
            pieces: Vec::new(),
            corners: Vec::new(),
            edges: Vec::new(),
            vertices: [(); 3].map(|()| vec![0.0; count]),
            outcodes: vec![0; count],
        }
    }

    /// Forgets all pieces.
    pub fn clear(&mut self) {
        self.pieces.clear();
        self.corners.clear();
        self.edges.clear();
    }

    /// Sets up all that can be seen. What is at or below the horizon or edge-on within rounding
    /// ([`is_in_plane`](crate::is_in_plane)) is left out.
    pub fn set(&mut self, at: &Standpoint) {
        self.clear();
        self.turn_all(at);
        dispatch!(self.level, simd => set_all(simd, self, at));
    }

    /// The same for some regions only.
    pub fn set_some(&mut self, at: &Standpoint, regions: impl Iterator<Item = u32>) {
        self.clear();
        for region in regions.filter(|&region| at.own != Some(region)) {
            dispatch!(self.level, simd => set_one(simd, self, at, region));
        }
    }

    /// Adds the pieces of a region, which is not the eye's.
    #[inline(always)]
    pub fn add(&mut self, at: &Standpoint, region: u32) {
        self.turn_region(at, region);
        self.set_region(at, region);
    }

    /// Turns all vertices into the frame.
    fn turn_all(&mut self, at: &Standpoint) {
        let Self {
            level,
            vertices: [x, y, z],
            outcodes,
            ..
        } = self;
        let from = at.geometry.vertices.each_ref().map(Vec::as_slice);
        dispatch!(*level, simd => to_local(simd, &at.frame, from, [x, y, z], outcodes));
    }

    /// Turns a region's vertices into the frame.
    #[inline(always)]
    fn turn_region(&mut self, at: &Standpoint, region: u32) {
        let regions = &at.geometry.regions;
        let [x, y, z] = &at.geometry.vertices;
        for piece in regions.regions()[region as usize].pieces.clone() {
            for &vertex in regions.corners(piece as usize) {
                let vertex = vertex as usize;
                let q = at
                    .frame
                    .to_local(DVec3::new(x[vertex], y[vertex], z[vertex]));
                for (axis, value) in self.vertices.iter_mut().zip(q.to_array()) {
                    axis[vertex] = value;
                }
                self.outcodes[vertex] = outcode::of_point(q.x, q.y, q.z);
            }
        }
    }

    /// Sets up the pieces of a region, whose vertices are in the frame.
    #[inline(always)]
    fn set_region(&mut self, at: &Standpoint, region: u32) {
        let Self {
            pieces,
            corners,
            edges,
            vertices: [x, y, z],
            outcodes,
            ..
        } = self;
        let geometry = at.geometry;
        let facts = &geometry.facts[region as usize];
        let Some(plane) = at.plane(facts) else {
            return;
        };
        let is_back_face = plane.is_back_face;
        if is_back_face && at.cull == Cull::BackFaces {
            return;
        }
        let sign = if is_back_face { 1.0 } else { -1.0 };
        let regions = &geometry.regions;
        for piece in regions.regions()[region as usize].pieces.clone() {
            let ids = regions.corners(piece as usize);
            let common = ids
                .iter()
                .fold(u32::MAX, |bits, &id| bits & outcodes[id as usize]);
            if at.has_horizon {
                if common & outcode::NOT_ABOVE_HORIZON != 0 {
                    continue;
                }
                let height = ids
                    .iter()
                    .fold(f64::MIN, |height, &id| height.max(z[id as usize]));
                if at.is_at_horizon(facts, height) {
                    continue;
                }
            }
            let first = corners.len();
            corners.extend(ids.iter().map(|&id| {
                let id = id as usize;
                DVec3::new(x[id], y[id], z[id])
            }));
            let [scene_x, scene_y, scene_z] = &geometry.vertices;
            let of = |k: usize| {
                let id = ids[k] as usize;
                let in_scene = DVec3::new(scene_x[id], scene_y[id], scene_z[id]);
                (corners[first + k], in_scene.abs())
            };
            let mut from = of(ids.len() - 1);
            for k in 0..ids.len() {
                let to = of(k);
                let across = sign * from.0.cross(to.0);
                let margin = if is_back_face {
                    0.0
                } else {
                    margin(across, at.frame.to_scene(across), from, to)
                };
                edges.push(Edge { across, margin });
                from = to;
            }
            pieces.push(Projected {
                first: first as u32,
                end: corners.len() as u32,
                inverse_depth: plane.inverse_depth,
                region,
                is_back_face,
                outcode: common,
            });
        }
    }

    /// True where one piece that is set up hides all of some polygons, of which there is one at least; their corners
    /// are relative to the eye, in its frame, metres.
    pub fn hides(&self, polygons: &[Vec<DVec3>]) -> bool {
        let is_before = |piece: &Projected, p: &DVec3| {
            let edges = &self.edges[piece.first as usize..piece.end as usize];
            piece.inverse_depth.dot(*p) >= CLEARLY_NEARER
                && edges.iter().all(|edge| edge.across.dot(*p) >= 0.0)
        };
        let hides_all = |piece| polygons.iter().flatten().all(|p| is_before(piece, p));
        self.pieces.iter().any(hides_all)
    }
}

impl Projected {
    /// What is seen of it.
    pub fn seen(&self) -> Seen {
        Seen {
            region: self.region,
            is_back_face: self.is_back_face,
        }
    }
}

/// Sets up the pieces of all regions, whose vertices are in the frame, the eye's own excepted.
#[simd]
fn set_all<S: Simd>(simd: S, projection: &mut Projection, at: &Standpoint) {
    for region in 0..at.geometry.facts.len() as u32 {
        if at.own != Some(region) {
            projection.set_region(at, region);
        }
    }
}

/// Adds the pieces of a region.
#[simd]
fn set_one<S: Simd>(simd: S, projection: &mut Projection, at: &Standpoint, region: u32) {
    projection.add(at, region);
}

/// All vertices in a frame, and their outcodes.
#[simd]
fn to_local<S: Simd>(
    simd: S,
    frame: &Frame,
    [from_x, from_y, from_z]: [&[f64]; 3],
    [to_x, to_y, to_z]: [&mut [f64]; 3],
    outcodes: &mut [u32],
) {
    let count = outcodes.len();
    let (from_x, from_y, from_z) = (&from_x[..count], &from_y[..count], &from_z[..count]);
    let (to_x, to_y, to_z) = (&mut to_x[..count], &mut to_y[..count], &mut to_z[..count]);
    for k in 0..count {
        let q = frame.to_local(DVec3::new(from_x[k], from_y[k], from_z[k]));
        to_x[k] = q.x;
        to_y[k] = q.y;
        to_z[k] = q.z;
    }
    for k in 0..count {
        outcodes[k] = outcode::of_point(to_x[k], to_y[k], to_z[k]);
    }
}
