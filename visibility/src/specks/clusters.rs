//! A scene's regions in clusters of neighbours, for scenes of many.
//!
//! What holds of a cluster's box need not be asked of each region in it: whether it rises above an eye's horizon,
//! which faces of a hemicube see it, how large its triangles are in pixels at most, whether it is hidden. Corners are
//! numbered within a cluster, so that what is found of them stays in the nearest cache.

#[cfg(test)]
mod tests;

use std::ops::Range;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scene::SurfaceId;

use crate::Frame;
use crate::regions::{Region, Regions};

/// Regions in a cluster at most: as many as have corners that a byte can number. Of 32, 64 and 128 tuned on
/// `benches/dense.rs`.
pub(crate) const REGIONS: usize = 64;

/// Vertices that are dealt with together.
pub(crate) const LANES: usize = 8;

/// Clusters in a group: enough for what lies in a row in memory to be fetched in a row. Tuned likewise.
const CLUSTERS: usize = 8;

/// Lists of fewer regions are sorted by one thread.
const REGIONS_PER_TASK: usize = 1 << 12;

/// What all regions of a cluster are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Single triangles, each of one surface.
    Triangles,
    /// Other convex polygons of up to four corners.
    Polygons,
    /// Anything else.
    Others,
}

/// A box that holds regions, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    pub middle: DVec3,
    /// From there to its sides.
    pub half: DVec3,
    /// From there to its corners.
    pub radius: f64,
}

/// Regions that are near each other.
#[derive(Clone, Debug)]
pub(crate) struct Cluster {
    pub bounds: Bounds,
    /// Longest side of its triangles, metres; 0 for other kinds.
    pub longest: f32,
    pub kind: Kind,
    /// Of [`Clusters::regions`].
    pub regions: Range<u32>,
    /// Of [`Clusters::vertices`]; none in a cluster of others. The last one is there as often as [`LANES`] ask for.
    pub vertices: Range<u32>,
}

impl Bounds {
    fn new(low: DVec3, high: DVec3) -> Self {
        let half = 0.5 * (high - low);
        Self {
            middle: 0.5 * (low + high),
            half,
            radius: half.length(),
        }
    }

    /// True where none of it is above an eye's horizon.
    #[inline(always)]
    pub fn is_below(&self, frame: &Frame) -> bool {
        let height = frame.normal.dot(self.middle - frame.position);
        height + frame.normal.abs().dot(self.half) <= 0.0
    }
}

impl Cluster {
    /// Places of its regions in the lists of all.
    pub fn places(&self) -> Range<usize> {
        self.regions.start as usize..self.regions.end as usize
    }
}

/// All regions of a scene.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clusters {
    pub all: Vec<Cluster>,
    /// Of every [`CLUSTERS`] of them.
    groups: Vec<Bounds>,
    /// Cluster after cluster.
    pub regions: Vec<u32>,
    /// The first one of each of these.
    pub surfaces: Vec<SurfaceId>,
    /// Of each of these, numbers of its cluster's vertices; a triangle's last one is there twice.
    pub corners: Vec<[u8; 4]>,
    /// Cluster after cluster, axis after axis, metres.
    pub vertices: [Vec<f32>; 3],
}

impl Clusters {
    /// Clusters of all regions.
    pub fn new(regions: &Regions) -> Self {
        let items: Vec<Item> = (0..regions.regions().len() as u32)
            .into_par_iter()
            .map(|region| Item::new(regions, region))
            .collect();
        let mut clusters = Self::default();
        for kind in [Kind::Triangles, Kind::Polygons, Kind::Others] {
            let of_kind = items.iter().filter(|item| item.kind == kind);
            let mut items: Vec<Item> = of_kind.copied().collect();
            sort(&mut items);
            let parts: Vec<Part> = items
                .par_chunks(REGIONS)
                .map(|items| Part::new(regions, kind, items))
                .collect();
            for part in parts {
                clusters.push(part);
            }
        }
        clusters.groups = clusters.all.chunks(CLUSTERS).map(bounds_of).collect();
        clusters
    }

    /// Groups of neighbours, with the numbers of their first clusters and the boxes of all.
    pub fn groups(&self) -> impl Iterator<Item = (u32, &Bounds, &[Cluster])> {
        let firsts = (0..).step_by(CLUSTERS);
        let groups = self.groups.iter().zip(self.all.chunks(CLUSTERS));
        firsts
            .zip(groups)
            .map(|(first, (bounds, clusters))| (first, bounds, clusters))
    }

    /// A cluster's regions.
    pub fn regions_of(&self, cluster: &Cluster) -> &[u32] {
        &self.regions[cluster.places()]
    }

    /// A cluster's vertices, axis after axis, metres; none of a cluster of others.
    pub fn vertices_of(&self, cluster: &Cluster) -> [&[f32]; 3] {
        let Range { start, end } = cluster.vertices;
        let part = start as usize..end as usize;
        self.vertices.each_ref().map(|axis| &axis[part.clone()])
    }

    fn push(&mut self, mut part: Part) {
        let of_clusters = |range: &mut Range<u32>, before: usize| {
            *range = range.start + before as u32..range.end + before as u32;
        };
        of_clusters(&mut part.cluster.regions, self.regions.len());
        of_clusters(&mut part.cluster.vertices, self.vertices[0].len());
        self.all.push(part.cluster);
        self.regions.extend(part.regions);
        self.surfaces.extend(part.surfaces);
        self.corners.extend(part.corners);
        for (all, axis) in self.vertices.iter_mut().zip(part.vertices) {
            all.extend(axis);
        }
    }
}

/// One cluster, whose places count from 0, and what the lists of all hold of it.
struct Part {
    cluster: Cluster,
    regions: Vec<u32>,
    surfaces: Vec<SurfaceId>,
    corners: Vec<[u8; 4]>,
    vertices: [Vec<f32>; 3],
}

impl Part {
    fn new(regions: &Regions, kind: Kind, items: &[Item]) -> Self {
        let low = items.iter().fold(Vec3::MAX, |low, item| low.min(item.low));
        let high = items
            .iter()
            .fold(Vec3::MIN, |high, item| high.max(item.high));
        let mut longest: f32 = 0.0;
        let mut corners = vec![[0; 4]; items.len()];
        // Of all vertices.
        let mut known: Vec<u32> = Vec::new();
        if kind != Kind::Others {
            for (item, numbers) in items.iter().zip(&mut corners) {
                let region = &regions.regions()[item.region as usize];
                let polygon = regions.corners(region.pieces.start as usize);
                for (k, number) in numbers.iter_mut().enumerate() {
                    let vertex = polygon[k.min(polygon.len() - 1)];
                    let place = known.iter().position(|&other| other == vertex);
                    *number = place.unwrap_or(known.len()) as u8;
                    if place.is_none() {
                        known.push(vertex);
                    }
                }
                if kind == Kind::Triangles {
                    let [a, b, c] = [0, 1, 2].map(|k| regions.vertices()[polygon[k] as usize]);
                    longest = longest
                        .max(a.distance(b))
                        .max(b.distance(c))
                        .max(c.distance(a));
                }
            }
        }
        let count = known.len().next_multiple_of(LANES);
        let vertex = |k: usize| regions.vertices()[known[k.min(known.len() - 1)] as usize];
        let axis = |axis: usize| (0..count).map(|k| vertex(k)[axis]).collect();
        Self {
            cluster: Cluster {
                bounds: Bounds::new(low.as_dvec3(), high.as_dvec3()),
                longest,
                kind,
                regions: 0..items.len() as u32,
                vertices: 0..count as u32,
            },
            regions: items.iter().map(|item| item.region).collect(),
            surfaces: items
                .iter()
                .map(|item| regions.regions()[item.region as usize].surfaces[0])
                .collect(),
            corners,
            vertices: [axis(0), axis(1), axis(2)],
        }
    }
}

/// The box of some clusters.
fn bounds_of(clusters: &[Cluster]) -> Bounds {
    let (mut low, mut high) = (DVec3::MAX, DVec3::MIN);
    for Cluster { bounds, .. } in clusters {
        low = low.min(bounds.middle - bounds.half);
        high = high.max(bounds.middle + bounds.half);
    }
    Bounds::new(low, high)
}

fn kind_of(regions: &Regions, region: &Region) -> Kind {
    let corners = regions.corners(region.pieces.start as usize);
    match (region.pieces.len(), corners.len(), region.surfaces.len()) {
        (1, 3, 1) => Kind::Triangles,
        (1, 3 | 4, _) => Kind::Polygons,
        _ => Kind::Others,
    }
}

/// A region and its box, metres.
#[derive(Clone, Copy, Debug)]
struct Item {
    region: u32,
    kind: Kind,
    low: Vec3,
    high: Vec3,
}

impl Item {
    fn new(regions: &Regions, id: u32) -> Self {
        let region = &regions.regions()[id as usize];
        let mut item = Self {
            region: id,
            kind: kind_of(regions, region),
            low: Vec3::MAX,
            high: Vec3::MIN,
        };
        let pieces = region.pieces.clone();
        for &vertex in pieces.flat_map(|piece| regions.corners(piece as usize)) {
            let vertex = regions.vertices()[vertex as usize];
            item.low = item.low.min(vertex);
            item.high = item.high.max(vertex);
        }
        item
    }

    /// Twice the middle of its box.
    fn middle(&self) -> Vec3 {
        self.low + self.high
    }
}

/// Sorts such that every [`REGIONS`] of them are near each other: halves them along their longest extent, and again.
fn sort(items: &mut [Item]) {
    if items.len() <= REGIONS {
        return;
    }
    let middles = || items.iter().map(Item::middle);
    let extent = middles().fold(Vec3::MIN, Vec3::max) - middles().fold(Vec3::MAX, Vec3::min);
    let axis = extent.max_position();
    let half = (items.len() / 2).next_multiple_of(REGIONS);
    // Regions that are at the same place are told apart by their numbers.
    items.select_nth_unstable_by(half - 1, |a, b| {
        let by_place = a.middle()[axis].total_cmp(&b.middle()[axis]);
        by_place.then(a.region.cmp(&b.region))
    });
    let is_small = items.len() < REGIONS_PER_TASK;
    let (low, high) = items.split_at_mut(half);
    if is_small {
        sort(low);
        sort(high);
    } else {
        rayon::join(|| sort(low), || sort(high));
    }
}
