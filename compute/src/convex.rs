//! Convex enclosures: where nothing can hide anything, form factors are formulas.
//!
//! # Theory
//! Where every surface lies in front of, or in, the plane of every other one, all of them are parts of the
//! boundary of a convex body, seen from inside: a straight line between two of them meets no third one. A
//! form factor from a point is then Lambert's sum over the other patch's edges
//! ([`polygon_form_factor`](crate::polygon_form_factor)), and since nothing lies below anybody's horizon,
//! nothing need be clipped there. An edge between two patches counts for both, with opposite signs: its
//! term is computed once.
//!
//! # Practice
//! The points are those on which hemicubes would stand: a row has the errors of its points, and none of pixels. A row
//! costs as much as there are patches to see, a hemicube as much as it has pixels; so formulas are for
//! scenes of few patches (`PIXELS_PER_SOURCE`). There are no formulas for what pixels count in the
//! thesis.

use std::collections::HashMap;
use std::f64::consts::TAU;
use std::ops::Range;
use std::sync::Arc;

use glam::{DVec3, Vec3};
use rayon::prelude::*;
use scene::weld::Vertices;
use scene::{PatchId, Scene};
use visibility::facets::{Facet, facets};
use visibility::hemicube::pixel_count;
use visibility::{COORDINATE_ULPS, Drawable, Frame};

use crate::hemicubes::Hemicubes;
use crate::polygon_form_factor::edge_term;
use crate::receivers::ReceiverId;
use crate::rows::{BackendError, Entry, Row, RowBatch, RowSource, UNITS_PER_ONE, Unseen};
use crate::settings::Maps;

/// Pixels of a hemicube that are drawn and merged in the time that the formula takes for one patch.
const PIXELS_PER_SOURCE: usize = 12;

/// The most comparisons of a corner with a plane, a fraction of a second's work; a scene that needs more counts as
/// one where something hides something.
const MOST_PRODUCTS: usize = 1 << 26;

/// Patches that a thread takes at a time, and tasks for each thread in a batch.
const ROWS_PER_TASK: usize = 8;
const TASKS_PER_THREAD: usize = 8;

/// Form factor rows without hemicubes.
pub struct ConvexRows<'a> {
    hemicubes: Arc<Hemicubes<'a>>,
    /// One per region.
    facets: Vec<Facet>,
    boundaries: Boundaries,
}

impl<'a> ConvexRows<'a> {
    /// Rows of a scene's patches, in which nothing hides anything; `None` where something may, where drawing hemicubes costs
    /// less, and for the thesis's maps.
    pub fn new(hemicubes: &Arc<Hemicubes<'a>>) -> Option<Self> {
        let sources = hemicubes.sources();
        let most = pixel_count(hemicubes.resolution()) / PIXELS_PER_SOURCE;
        if hemicubes.maps() == Maps::Thesis || sources.count() as usize > most {
            return None;
        }
        let facets = facets(hemicubes.drawable());
        is_unobstructed(hemicubes.drawable(), &facets).then(|| Self {
            hemicubes: Arc::clone(hemicubes),
            facets,
            boundaries: Boundaries::new(sources.scene()),
        })
    }

    /// The row of one receiver.
    fn row(&self, receiver: ReceiverId) -> Row {
        let receivers = self.hemicubes.receivers();
        let own = receivers.surface(receiver);
        let facet = own.map(|own| &self.facets[self.hemicubes.drawable().region_of(own) as usize]);
        let frames = receivers.frames(receiver);
        let mut factors = vec![0.0; self.boundaries.patches.len()];
        for frame in &frames {
            self.boundaries.add_factors(frame, facet, &mut factors);
        }
        let one = f64::from(UNITS_PER_ONE);
        let units_each = one / frames.len() as f64;
        let row = (0..).zip(&factors).map(|(source, factor)| Entry {
            source,
            units: (factor * units_each) as f32,
        });
        let entries = row.filter(|entry| entry.units > 0.0).collect();
        let seen = factors.iter().sum::<f64>() * units_each;
        let unseen = Unseen {
            open: (one - seen).round() as u32,
            back_face: 0,
        };
        Row { entries, unseen }
    }
}

impl RowSource for ConvexRows<'_> {
    fn draw_rows(&mut self, receivers: Range<u32>) -> Result<RowBatch, BackendError> {
        let first = receivers.start;
        let rows = receivers
            .into_par_iter()
            .with_min_len(ROWS_PER_TASK)
            .map(|receiver| self.row(ReceiverId(receiver)))
            .collect();
        Ok(RowBatch::of(first, rows))
    }

    fn preferred_batch(&self) -> u32 {
        (rayon::current_num_threads() * TASKS_PER_THREAD * ROWS_PER_TASK) as u32
    }

    fn describe(&self) -> String {
        let threads = rayon::current_num_threads();
        let plural = if threads == 1 { "" } else { "s" };
        format!("closed forms, {threads} thread{plural}")
    }

    fn draws_hemicubes(&self) -> bool {
        false
    }
}

/// True where nothing can hide anything.
fn is_unobstructed(drawable: &Drawable, facets: &[Facet]) -> bool {
    let corner_count: usize = facets.iter().map(|facet| facet.corners.len()).sum();
    if corner_count.saturating_mul(facets.len()) > MOST_PRODUCTS {
        return false;
    }
    facets.iter().enumerate().all(|(k, facet)| {
        let is_in_front = facets.iter().all(|other| !facet.has_behind(other));
        let mut others = (k + 1..facets.len()).filter(|&other| facet.is_in_plane(&facets[other]));
        is_in_front && others.all(|other| !overlap(drawable, facet.normal, [k, other]))
    })
}

/// True where pieces of two regions in one plane have more than an edge in common.
fn overlap(drawable: &Drawable, normal: DVec3, regions: [usize; 2]) -> bool {
    let all = drawable.regions();
    let pieces = |k: usize| {
        let pieces = all.regions()[k].pieces.clone();
        pieces.map(|piece| -> Vec<DVec3> {
            let corners = all.corners(piece as usize).iter();
            corners
                .map(|&vertex| all.vertices()[vertex as usize].as_dvec3())
                .collect()
        })
    };
    let [one, other] = regions;
    pieces(one)
        .any(|p| pieces(other).any(|q| !is_beside(&p, &q, normal) && !is_beside(&q, &p, normal)))
}

/// True where an edge of one convex polygon has all of the other one, in the same plane, on its outside or within
/// rounding of it.
fn is_beside(polygon: &[DVec3], other: &[DVec3], normal: DVec3) -> bool {
    (0..polygon.len()).any(|k| {
        let (from, to) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        let inwards = normal.cross(to - from).normalize_or_zero();
        other.iter().all(|&p| {
            let reach = from.abs().max(to.abs()).max(p.abs());
            (p - from).dot(inwards) <= COORDINATE_ULPS * inwards.abs().dot(reach)
        })
    })
}

/// The patches of a scene with their edges and corners, each once.
struct Boundaries {
    /// Metres.
    vertices: Vec<DVec3>,
    /// The corners of each patch.
    patches: Vec<[u32; 3]>,
    edges: Vec<Edge>,
}

/// An edge of one patch or of two.
struct Edge {
    from: u32,
    to: u32,
    /// The patch that has the edge in this direction.
    patch: u32,
    /// The one that has it in the other, or [`NO_PATCH`].
    opposite: u32,
}

const NO_PATCH: u32 = u32::MAX;

impl Boundaries {
    fn new(scene: &Scene) -> Self {
        let mut boundaries = Self {
            vertices: Vec::new(),
            patches: Vec::new(),
            edges: Vec::new(),
        };
        let mut vertices = Vertices::default();
        let mut edge_between = HashMap::new();
        for patch in 0..scene.patch_count() {
            let corners = scene.patch(PatchId(patch)).corners;
            let corners = corners.map(|p| vertices.index(p));
            boundaries.patches.push(corners);
            for k in 0..3 {
                let (from, to) = (corners[k], corners[(k + 1) % 3]);
                // Taken out, so that a third patch begins an edge of its own.
                if let Some(index) = edge_between.remove(&(to, from)) {
                    let edge: &mut Edge = &mut boundaries.edges[index];
                    edge.opposite = patch;
                } else {
                    edge_between.insert((from, to), boundaries.edges.len());
                    boundaries.edges.push(Edge {
                        from,
                        to,
                        patch,
                        opposite: NO_PATCH,
                    });
                }
            }
        }
        let positions = vertices.into_positions().into_iter();
        boundaries.vertices = positions.map(Vec3::as_dvec3).collect();
        boundaries
    }

    /// Adds the form factors from a point to all patches but those in its own facet, where it lies on one.
    fn add_factors(&self, frame: &Frame, facet: Option<&Facet>, factors: &mut [f64]) {
        let mut sums = vec![0.0; factors.len()];
        for edge in &self.edges {
            let [p, q] = [edge.from, edge.to].map(|k| self.vertices[k as usize] - frame.position);
            let term = edge_term(p, q, frame.normal);
            sums[edge.patch as usize] += term;
            if edge.opposite != NO_PATCH {
                sums[edge.opposite as usize] -= term;
            }
        }
        let is_above: Vec<bool> = self
            .vertices
            .iter()
            .map(|&p| facet.is_none_or(|facet| facet.height(p) > facet.tolerance))
            .collect();
        for ((corners, sum), factor) in self.patches.iter().zip(&sums).zip(factors) {
            // Corners go counter-clockwise as the point sees them, and so clockwise about its normal: the sum is
            // negative, but for rounding where a patch is seen edge-on.
            if corners.iter().any(|&k| is_above[k as usize]) {
                *factor += (-sum / TAU).max(0.0);
            }
        }
    }
}
