//! What an item buffer has to draw: a wall's triangles as the few convex polygons they form.
//!
//! # Theory
//! Triangles that share edges, lie in one plane and face the same way look, from anywhere, like the polygon
//! they form. Drawn as that, a wall of a thousand triangles costs no more than one of two; which of them a
//! pixel sees is then asked of a [`Locator`], for those pixels only that see the wall in the end.
//!
//! # Practice
//! Vertices are the same where all their bits are; vertices are in a plane, and corners in a line, where they
//! are within about two units in the last place of it, half of what the fronts of surfaces are drawn
//! larger by ([`crate::COORDINATE_ULPS`]), so that no gaps open where a corner was dropped.
//! Surfaces that overlap, or three at an edge, are drawn one by one, as are those of any wall that is odd.

mod flood;
mod locator;
mod outline;
mod partition;
mod pieces;
#[cfg(test)]
mod tests;
mod walls;
mod weld;

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scene::{Scene, SurfaceId};

pub(crate) use locator::{LEAF, Node, STEEP, Tree};
pub use locator::{Locator, Member, NO_MEMBER};
pub use walls::{Coarse, Wall, walls};

use flood::Group;
use outline::{Outline, RegionMesh};
use partition::Frame;
use weld::Welded;

/// How far off an f32 coordinate may be, relative.
const ULP: f64 = 1.0 / (1 << 24) as f64;

/// Everything a scene's item buffers draw; geometry only, made once per scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    all: Vec<Region>,
    pieces: Vec<Piece>,
    /// Of all pieces, one after the other: indices into `vertices`.
    corners: Vec<u32>,
    vertices: Vec<Vec3>,
    /// One per surface.
    region_of: Vec<u32>,
}

/// Connected coplanar surfaces of one material that face the same way.
#[derive(Clone, Debug, PartialEq)]
pub struct Region {
    /// Ascending.
    pub surfaces: Vec<SurfaceId>,
    /// Indices into [`Regions::pieces`].
    pub pieces: Range<u32>,
    /// A triangle in the region's plane, counter-clockwise seen from the front, metres: the region's coordinates
    /// are the barycentric ones with respect to it. A single surface's corners in their order; else a
    /// triangle that covers the region.
    pub reference: [DVec3; 3],
    /// Unit normal, on the front side.
    pub normal: DVec3,
    /// `None` for a region of a single surface.
    pub locator: Option<Locator>,
}

/// A convex polygon, part of a region.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Piece {
    /// Index into [`Regions::regions`].
    pub region: u32,
    /// Indices into the corners of all pieces.
    corners: Range<u32>,
}

/// Surfaces that are drawn as one.
struct Merged {
    surfaces: Vec<SurfaceId>,
    normal: DVec3,
    reference: [DVec3; 3],
    locator: Locator,
    /// Indices of vertices, counter-clockwise.
    pieces: Vec<Vec<u32>>,
}

impl Regions {
    /// The regions of a scene, in the order of their first surfaces.
    pub fn new(scene: &Scene) -> Self {
        let welded = Welded::new(scene.surfaces());
        let merged: Vec<Merged> = flood::groups(scene, &welded)
            .into_par_iter()
            .filter_map(|group| merge(scene, &welded, &group))
            .collect();
        let none = u32::MAX;
        let mut merged_of = vec![none; scene.surfaces().len()];
        for (index, merged) in (0..).zip(&merged) {
            for surface in &merged.surfaces {
                merged_of[surface.index()] = index;
            }
        }
        let mut merged: Vec<Option<Merged>> = merged.into_iter().map(Some).collect();
        let mut regions = Self {
            all: Vec::new(),
            pieces: Vec::new(),
            corners: Vec::new(),
            vertices: Vec::new(),
            region_of: vec![none; scene.surfaces().len()],
        };
        for (id, &index) in (0..).map(SurfaceId).zip(&merged_of) {
            if index == none {
                let surface = scene.surface(id);
                let reference = surface.corners.map(Vec3::as_dvec3);
                let pieces = [welded.corners[id.index()]];
                regions.push(vec![id], &pieces, reference, surface.normal(), None);
            } else if let Some(merged) = merged[index as usize].take() {
                let (pieces, locator) = (&merged.pieces, Some(merged.locator));
                let (reference, normal) = (merged.reference, merged.normal);
                regions.push(merged.surfaces, pieces, reference, normal, locator);
            }
        }
        regions.vertices = welded.vertices;
        regions
    }

    fn push(
        &mut self,
        surfaces: Vec<SurfaceId>,
        pieces: &[impl AsRef<[u32]>],
        reference: [DVec3; 3],
        normal: DVec3,
        locator: Option<Locator>,
    ) {
        let region = self.all.len() as u32;
        for surface in &surfaces {
            self.region_of[surface.index()] = region;
        }
        let first = self.pieces.len() as u32;
        for piece in pieces {
            let start = self.corners.len() as u32;
            self.corners.extend(piece.as_ref());
            let corners = start..self.corners.len() as u32;
            self.pieces.push(Piece { region, corners });
        }
        self.all.push(Region {
            surfaces,
            pieces: first..self.pieces.len() as u32,
            reference,
            normal,
            locator,
        });
    }

    /// All regions.
    pub fn regions(&self) -> &[Region] {
        &self.all
    }

    /// The pieces of all regions, region by region; never more than surfaces.
    pub fn pieces(&self) -> &[Piece] {
        &self.pieces
    }

    /// Unique positions, metres; no coordinate is -0.
    pub fn vertices(&self) -> &[Vec3] {
        &self.vertices
    }

    /// A piece's corners as indices into [`Self::vertices`], counter-clockwise from the front.
    pub fn corners(&self, piece: usize) -> &[u32] {
        let Range { start, end } = self.pieces[piece].corners;
        &self.corners[start as usize..end as usize]
    }

    /// The index of the region that a surface is part of.
    pub fn region_of(&self, surface: SurfaceId) -> u32 {
        self.region_of[surface.index()]
    }
}

/// What surfaces form, or `None` where something is odd.
fn merge(scene: &Scene, welded: &Welded, group: &Group) -> Option<Merged> {
    let mesh = RegionMesh::new(welded, group)?;
    let outline = Outline::new(&mesh)?;
    let frame = Frame::new(&mesh, &outline, group.point)?;
    let surfaces: Vec<SurfaceId> = group.surfaces.iter().copied().map(SurfaceId).collect();
    let locator = Locator::new(scene, &surfaces, &mesh, &frame)?;
    let pieces = pieces::pieces(&mesh, &outline)?;
    let in_scene = |&vertex: &u32| mesh.vertices[vertex as usize];
    Some(Merged {
        surfaces,
        normal: group.normal,
        reference: frame.reference,
        locator,
        pieces: pieces
            .iter()
            .map(|piece| piece.iter().map(in_scene).collect())
            .collect(),
    })
}
