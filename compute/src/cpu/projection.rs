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
//! regions, and the ones that are outside of a face of a hemicube are told by bits ([`outside`]).

// Functions that a vectorised caller needs must be inlined into it: compiled on their own they would
// be for the baseline instruction set.
#![allow(clippy::inline_always)]

use std::sync::Arc;

use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;
use scene::SurfaceId;

use super::drawable::{Drawable, RegionFacts};
use super::horizon::Horizon;
use super::outside;
use super::rounding::{is_in_plane, margin};
use super::specks::{self, Specks};
use crate::hemicube::{Frame, pixel_count};

/// Back faces are drawn this much too deep, so that a pixel on the silhouette of a solid, where a
/// front and a back face meet at equal depth, sees the front: well above the rounding of an f32
/// depth (2^-24) and of its steps along a row, well below any wall's thickness.
const BACK_FACE_RETREAT: f64 = 1.0 - 1.0 / (1 << 19) as f64;

/// What is nearer by this factor is so when depths are f32, but where a surface is seen almost along it.
const CLEARLY_NEARER: f64 = 1.0 + 1e-5;

/// What is done about the backs of surfaces, which are one-sided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cull {
    /// They occlude, and are seen as [`super::Sample::BackFace`].
    Nothing,
    /// They are not there.
    BackFaces,
}

/// A convex piece of a region as seen from one eye, in the eye's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Projected {
    /// Its corners and edges in [`Projection`]'s lists.
    pub first: u32,
    pub end: u32,
    /// 1/w = inverse_depth . d, 1/m.
    pub inverse_depth: DVec3,
    /// The region it is part of.
    pub region: u32,
    /// True where the eye is behind it.
    pub is_back_face: bool,
    /// Bits that all its corners have in common, see [`outside`].
    pub outside: u32,
}

/// The edge from one corner of a piece to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Edge {
    /// e(d) = across . d is at least 0 inside.
    pub across: DVec3,
    /// How far below 0 it may be inside, for directions d no longer than sqrt(3).
    pub margin: f64,
}

/// All that an eye can see, set up for drawing into any window of its frame.
#[derive(Clone, Debug)]
pub struct Projection<'a> {
    pub(super) drawable: Arc<Drawable<'a>>,
    level: Level,
    frame: Frame,
    pub(super) pieces: Vec<Projected>,
    /// Of all pieces, relative to the eye, metres.
    pub(super) corners: Vec<DVec3>,
    /// The k-th one ends at the k-th corner.
    pub(super) edges: Vec<Edge>,
    /// All vertices of the scene, axis after axis, relative to the eye, metres.
    vertices: [Vec<f64>; 3],
    /// See [`outside`]; one per vertex.
    outside: Vec<u32>,
    /// What may be seen.
    pub(super) horizon: Horizon,
    /// Where rays are to be cast instead of drawing what is set up.
    pub(super) casting: Option<Casting>,
    /// What is drawn besides the pieces, and the region that the eye is on.
    pub(super) specks: Specks,
    pub(super) own: Option<u32>,
}

/// A plane as seen from an eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plane {
    /// True where the eye is behind it.
    pub is_back_face: bool,
    /// 1/w = inverse_depth . d, 1/m.
    pub inverse_depth: DVec3,
}

/// What rays need to know of the eye.
#[derive(Clone, Copy, Debug)]
pub(super) struct Casting {
    /// The region that the eye lies on, if any.
    pub own: Option<u32>,
    pub horizon: bool,
    pub cull: Cull,
}

/// What the inverse depth of a front or a back is multiplied by.
#[inline(always)]
pub(super) fn retreat(is_back_face: bool) -> f64 {
    if is_back_face { BACK_FACE_RETREAT } else { 1.0 }
}

impl<'a> Projection<'a> {
    /// A projection that nothing is in.
    pub fn new(drawable: &Arc<Drawable<'a>>) -> Self {
        let count = drawable.vertices[0].len();
        Self {
            drawable: Arc::clone(drawable),
            level: Level::new(),
            frame: Frame {
                position: DVec3::ZERO,
                tangent: DVec3::X,
                bitangent: DVec3::Y,
                normal: DVec3::Z,
            },
            pieces: Vec::new(),
            corners: Vec::new(),
            edges: Vec::new(),
            vertices: [(); 3].map(|()| vec![0.0; count]),
            outside: vec![0; count],
            horizon: Horizon::default(),
            casting: None,
            specks: Specks::default(),
            own: None,
        }
    }

    /// The same as [`Self::set`] for drawing into a few windows: where pieces are many and small compared to
    /// `pixels`, those of all these windows, nothing is set up, and rays are cast when a window is drawn.
    pub fn set_for(
        &mut self,
        pixels: usize,
        frame: &Frame,
        own: Option<SurfaceId>,
        horizon: bool,
        cull: Cull,
    ) {
        if !self.drawable.casts(pixels, false) {
            return self.set(frame, own, horizon, cull);
        }
        self.start(frame);
        self.casting = Some(Casting {
            own: own.map(|own| self.drawable.region_of(own)),
            horizon,
            cull,
        });
    }

    /// The same for a hemicube of a resolution, which sees what is above its horizon, fronts and backs.
    pub fn set_for_hemicube(&mut self, resolution: u32, frame: &Frame, own: SurfaceId) {
        let drawable = Arc::clone(&self.drawable);
        let pixels = pixel_count(resolution);
        let specks = drawable.clusters.as_ref();
        let Some(clusters) = specks.filter(|_| !drawable.casts(pixels, true)) else {
            return self.set_for(pixels, frame, Some(own), true, Cull::Nothing);
        };
        self.start(frame);
        let own = drawable.region_of(own);
        self.own = Some(own);
        let mut specks = std::mem::take(&mut self.specks);
        dispatch!(self.level, simd => specks::set(
            simd, self, &mut specks, clusters, own, resolution
        ));
        self.specks = specks;
    }

    /// True for a region that is edge-on or at the horizon within rounding, with its largest height given, metres.
    #[cold]
    pub(super) fn leaves_out(&self, region: u32, height: f64) -> bool {
        let facts = &self.drawable.facts[region as usize];
        let eye_reach = self.eye_reach(self.own);
        plane(&self.drawable, &self.frame, facts, eye_reach).is_none()
            || is_at_horizon(&self.drawable, &self.frame, height, facts, eye_reach)
    }

    /// Turns a region into the frame and sets up its pieces as a hemicube sees them.
    #[inline(always)]
    pub(super) fn set_one(&mut self, region: u32, eye_reach: DVec3) {
        self.turn_region(region);
        self.set_region(region, eye_reach, true, Cull::Nothing);
    }

    /// Turns a region's vertices into the frame.
    #[inline(always)]
    fn turn_region(&mut self, region: u32) {
        let Self {
            drawable,
            frame,
            vertices,
            outside,
            ..
        } = self;
        let regions = drawable.regions();
        for piece in regions.regions()[region as usize].pieces.clone() {
            for &vertex in regions.corners(piece as usize) {
                let vertex = vertex as usize;
                let [x, y, z] = &drawable.vertices;
                let q = frame.to_local(DVec3::new(x[vertex], y[vertex], z[vertex]));
                for (axis, value) in vertices.iter_mut().zip(q.to_array()) {
                    axis[vertex] = value;
                }
                outside[vertex] = outside::bits(q.x, q.y, q.z);
            }
        }
    }

    /// Where the eye stands.
    pub(super) fn frame(&self) -> &Frame {
        &self.frame
    }

    /// The index in `pieces` of what a ray has met, of which nothing but the region is known.
    pub(super) fn met(&mut self, region: u32, is_back_face: bool) -> u32 {
        self.pieces.push(Projected {
            first: 0,
            end: 0,
            inverse_depth: DVec3::ZERO,
            region,
            is_back_face,
            outside: 0,
        });
        self.pieces.len() as u32 - 1
    }

    /// Sets up all that can be seen; `own` is the surface that the eye lies on, if any. What is at or below
    /// the horizon (z = 0 in the frame, if `horizon`) or edge-on within rounding ([`is_in_plane`]) is left
    /// out.
    pub fn set(&mut self, frame: &Frame, own: Option<SurfaceId>, horizon: bool, cull: Cull) {
        let drawable = Arc::clone(&self.drawable);
        self.start(frame);
        self.turn_all();
        let own = own.map(|own| drawable.region_of(own));
        let mut seen = std::mem::take(&mut self.horizon);
        if horizon {
            seen.find(&drawable, frame, self.eye_reach(own));
        } else {
            seen.open(&drawable);
        }
        dispatch!(self.level, simd => set_regions(
            simd, self, own, seen.regions(), horizon, cull
        ));
        self.horizon = seen;
    }

    /// The same for some regions only, which `own`, the eye's, is not among.
    pub fn set_some(
        &mut self,
        frame: &Frame,
        own: Option<SurfaceId>,
        regions: impl Iterator<Item = u32>,
        horizon: bool,
        cull: Cull,
    ) {
        self.start(frame);
        let own = own.map(|own| self.drawable.region_of(own));
        for region in regions {
            self.turn_region(region);
            dispatch!(self.level, simd => set_regions(
                simd, self, own, &[region], horizon, cull
            ));
        }
    }

    /// Turns all vertices into the frame.
    fn turn_all(&mut self) {
        let Self {
            drawable,
            level,
            frame,
            vertices: [x, y, z],
            outside,
            ..
        } = self;
        let from = drawable.vertices.each_ref().map(Vec::as_slice);
        dispatch!(*level, simd => to_local(simd, frame, from, [x, y, z], outside));
    }

    fn start(&mut self, frame: &Frame) {
        self.frame = *frame;
        self.casting = None;
        self.own = None;
        self.specks.clear();
        self.pieces.clear();
        self.corners.clear();
        self.edges.clear();
    }

    /// Largest magnitude of the coordinates by which the eye's plane is known, metres.
    pub(super) fn eye_reach(&self, own: Option<u32>) -> DVec3 {
        own.map_or(self.frame.position.abs(), |own| {
            self.drawable.facts[own as usize].reach
        })
    }

    /// Sets up the pieces of a region, whose vertices are in the frame.
    #[inline(always)]
    fn set_region(&mut self, region: u32, eye_reach: DVec3, horizon: bool, cull: Cull) {
        let Self {
            drawable,
            frame,
            pieces,
            corners,
            edges,
            vertices: [x, y, z],
            outside,
            ..
        } = self;
        let facts = &drawable.facts[region as usize];
        let Some(plane) = plane(drawable, frame, facts, eye_reach) else {
            return;
        };
        let is_back_face = plane.is_back_face;
        if is_back_face && cull == Cull::BackFaces {
            return;
        }
        let sign = if is_back_face { 1.0 } else { -1.0 };
        let regions = drawable.regions();
        for piece in regions.regions()[region as usize].pieces.clone() {
            let ids = regions.corners(piece as usize);
            let common = ids
                .iter()
                .fold(u32::MAX, |bits, &id| bits & outside[id as usize]);
            if horizon {
                if common & outside::NOT_ABOVE_HORIZON != 0 {
                    continue;
                }
                let height = ids
                    .iter()
                    .fold(f64::MIN, |height, &id| height.max(z[id as usize]));
                if is_at_horizon(drawable, frame, height, facts, eye_reach) {
                    continue;
                }
            }
            let first = corners.len();
            corners.extend(ids.iter().map(|&id| {
                let id = id as usize;
                DVec3::new(x[id], y[id], z[id])
            }));
            let [scene_x, scene_y, scene_z] = &drawable.vertices;
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
                    margin(across, frame.to_scene(across), from, to)
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
                outside: common,
            });
        }
    }

    /// True where one piece that is set up hides all of some polygons, of which there is one at least; their corners
    /// are relative to the eye, in its frame, metres. Rays set up nothing that hides.
    pub fn hides(&self, polygons: &[Vec<DVec3>]) -> bool {
        let is_before = |piece: &Projected, p: &DVec3| {
            let edges = &self.edges[piece.first as usize..piece.end as usize];
            piece.inverse_depth.dot(*p) >= CLEARLY_NEARER
                && edges.iter().all(|edge| edge.across.dot(*p) >= 0.0)
        };
        let hides_all = |piece| polygons.iter().flatten().all(|p| is_before(piece, p));
        self.pieces.iter().any(hides_all)
    }

    /// The three e_k of the proportion e_0 : e_1 : e_2 of a region's coordinates along a ray, see
    /// [`Region::reference`](super::regions::Region::reference).
    pub(super) fn coordinates(&self, region: u32) -> [DVec3; 3] {
        let drawable = &self.drawable;
        let facts = &drawable.facts[region as usize];
        let [q0, q1, q2] = drawable.regions().regions()[region as usize]
            .reference
            .map(|p| self.frame.to_local(p));
        let sign = if facts.offset > facts.normal.dot(self.frame.position) {
            1.0
        } else {
            -1.0
        };
        [q1.cross(q2), q2.cross(q0), q0.cross(q1)].map(|e| sign * e)
    }
}

/// A region's plane; `None` where it is edge-on within rounding.
#[inline(always)]
fn plane(
    drawable: &Drawable,
    frame: &Frame,
    facts: &RegionFacts,
    eye_reach: DVec3,
) -> Option<Plane> {
    // Distance of the eye from the plane, negative in front.
    let distance = facts.offset - facts.normal.dot(frame.position);
    let tolerance = drawable.plane_tolerance;
    let reach = facts.reach.max(eye_reach);
    if is_in_plane(distance.abs(), tolerance, facts.normal, reach) {
        return None;
    }
    let is_back_face = distance > 0.0;
    Some(Plane {
        is_back_face,
        inverse_depth: frame.vector_to_local(facts.normal) * (retreat(is_back_face) / distance),
    })
}

/// True where the highest point of a piece is at the horizon within rounding, or below it.
#[inline(always)]
fn is_at_horizon(
    drawable: &Drawable,
    frame: &Frame,
    height: f64,
    facts: &RegionFacts,
    eye_reach: DVec3,
) -> bool {
    let reach = facts.reach.max(eye_reach);
    is_in_plane(height, drawable.plane_tolerance, frame.normal, reach)
}

/// Sets up the pieces of some regions, whose vertices are in the frame, `own` excepted.
#[simd]
fn set_regions<S: Simd>(
    simd: S,
    projection: &mut Projection,
    own: Option<u32>,
    regions: &[u32],
    horizon: bool,
    cull: Cull,
) {
    let eye_reach = projection.eye_reach(own);
    for &region in regions {
        if own != Some(region) {
            projection.set_region(region, eye_reach, horizon, cull);
        }
    }
}

/// All vertices in a frame, and their bits of [`outside`].
#[simd]
fn to_local<S: Simd>(
    simd: S,
    frame: &Frame,
    [from_x, from_y, from_z]: [&[f64]; 3],
    [to_x, to_y, to_z]: [&mut [f64]; 3],
    outside: &mut [u32],
) {
    let count = outside.len();
    let (from_x, from_y, from_z) = (&from_x[..count], &from_y[..count], &from_z[..count]);
    let (to_x, to_y, to_z) = (&mut to_x[..count], &mut to_y[..count], &mut to_z[..count]);
    for k in 0..count {
        let q = frame.to_local(DVec3::new(from_x[k], from_y[k], from_z[k]));
        to_x[k] = q.x;
        to_y[k] = q.y;
        to_z[k] = q.z;
    }
    for k in 0..count {
        outside[k] = outside::bits(to_x[k], to_y[k], to_z[k]);
    }
}
