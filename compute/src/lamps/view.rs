//! Looking at lamps from the points of a patch.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use scene::{PatchId, Scene, SurfaceId};

use super::find::Lamp;
use super::merge::merge;
use super::piece::{Piece, pieces};
use crate::cpu::{Cull, Projection, Raster, is_in_plane, reach};
use crate::hemicube::Frame;
use crate::hemicubes::Hemicubes;
use crate::polygon_form_factor::{in_front, point_to_polygon};
use crate::rows::Row;

/// Share of the unhidden light of all lamps from which on one has its own view.
const LEAST_SHARE: f64 = 0.01;

/// Views a point at most.
const MOST_VIEWS: usize = 8;

/// Views lamps for one thread.
pub(super) struct LampViewer<'a> {
    scene: &'a Scene,
    hemicubes: Arc<Hemicubes<'a>>,
    lamps: Arc<[Lamp]>,
    all: bool,
    plane_tolerance: f64,
    /// The lamp, and what may hide it.
    all_surfaces: Projection<'a>,
    lamp_alone: Projection<'a>,
    raster: Raster,
    /// Of a view's pixels.
    weights: Vec<f64>,
    sums: Sums,
}

/// What one patch sees of the lamps that matter to it.
pub(super) struct Seen {
    /// Patches of the lamps with views, ascending ranges.
    pub replaced: Vec<Range<u32>>,
    /// Patch and form factor, dimensionless, by patch.
    pub factors: Vec<(u32, f64)>,
}

/// Form factors of lamps' patches, summed by patch.
struct Sums {
    /// The first patch of a lamp.
    first: u32,
    /// One per patch up to the last one of a lamp; 0 between two looks.
    factors: Vec<f64>,
    /// The patches that have one.
    patches: Vec<u32>,
}

impl Sums {
    fn new(lamps: &[Lamp]) -> Self {
        let patches = || lamps.iter().flat_map(|lamp| &lamp.patches);
        let first = patches().map(|range| range.start).min().unwrap_or(0);
        let end = patches().map(|range| range.end).max().unwrap_or(0);
        Self {
            first,
            factors: vec![0.0; (end - first) as usize],
            patches: Vec::new(),
        }
    }

    fn add(&mut self, patch: u32, factor: f64) {
        let sum = &mut self.factors[(patch - self.first) as usize];
        if factor == 0.0 {
            return;
        }
        if *sum == 0.0 {
            self.patches.push(patch);
        }
        *sum += factor;
    }

    /// Hands out the sums by patch and starts anew.
    fn take(&mut self) -> Vec<(u32, f64)> {
        self.patches.sort_unstable();
        let (first, factors) = (self.first, &mut self.factors);
        let patches = self.patches.drain(..);
        patches
            .map(|patch| {
                (
                    patch,
                    std::mem::take(&mut factors[(patch - first) as usize]),
                )
            })
            .collect()
    }
}

impl<'a> LampViewer<'a> {
    /// A viewer of these lamps; of all of them, if `all`, whether they matter or not.
    pub fn new(hemicubes: &Arc<Hemicubes<'a>>, lamps: &Arc<[Lamp]>, all: bool) -> Self {
        Self {
            scene: hemicubes.sources(),
            hemicubes: Arc::clone(hemicubes),
            lamps: Arc::clone(lamps),
            all,
            plane_tolerance: hemicubes.drawable().plane_tolerance(),
            all_surfaces: Projection::new(hemicubes.drawable()),
            lamp_alone: Projection::new(hemicubes.drawable()),
            raster: Raster::default(),
            weights: Vec::new(),
            sums: Sums::new(lamps),
        }
    }

    /// Gives the lamps that matter to a patch their own factors in its row.
    pub fn refine(&mut self, patch: PatchId, row: &mut Row) {
        let frames = self.hemicubes.frames(patch);
        let own = self.hemicubes.surface_of(patch);
        let mut chosen = self.choose(own, &frames);
        let seen = loop {
            match self.look(own, &frames, &chosen) {
                Ok(seen) => break seen,
                // Too thin for a view's pixels: the hemicube's may find it.
                Err(missed) => chosen.retain(|choice| choice.lamp != missed),
            }
        };
        if let Some(merged) = merge(row, &seen) {
            *row = merged;
        }
    }

    /// The lamps that matter to a patch.
    fn choose(&self, own: SurfaceId, frames: &[Frame]) -> Vec<Choice> {
        // Unhidden light, number, and for each point the lamp's polygons.
        let mut possible: Vec<(f64, usize, Vec<Polygons>)> = Vec::new();
        let mut total = 0.0;
        for (index, lamp) in self.lamps.iter().enumerate() {
            if lamp.surfaces.binary_search(&own).is_ok() {
                continue;
            }
            let polygons: Vec<_> = frames.iter().map(|f| self.polygons(f, lamp)).collect();
            let form_factors = polygons.iter().flatten().map(|p| point_to_polygon(p));
            let light = lamp.emission * form_factors.sum::<f64>();
            total += light;
            if light > 0.0 {
                possible.push((light, index, polygons));
            }
        }
        // The brightest first; of equals the one with the lower number.
        possible.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        if !self.all {
            possible.retain(|(light, ..)| *light >= LEAST_SHARE * total);
            possible.truncate(MOST_VIEWS);
        }
        possible
            .into_iter()
            .filter_map(|(_, lamp, polygons)| {
                // A lamp that some point sees too wide is left to the hemicube for all of them.
                let pieces = polygons.iter().map(|polygons| {
                    if polygons.is_empty() {
                        Some(Vec::new())
                    } else {
                        pieces(polygons)
                    }
                });
                let pieces = pieces.collect::<Option<Vec<_>>>()?;
                Some(Choice {
                    lamp,
                    polygons,
                    pieces,
                })
            })
            .collect()
    }

    /// What a point can see of a lamp if nothing hides it: the parts above the horizon of the surfaces whose
    /// fronts it sees, in the frame and relative to its eye.
    fn polygons(&self, frame: &Frame, lamp: &Lamp) -> Polygons {
        lamp.surfaces
            .iter()
            .map(|&id| self.scene.surface(id))
            .filter(|surface| {
                let normal = surface.normal();
                let height = (frame.position - surface.corners[0].as_dvec3()).dot(normal);
                let reach = reach(surface).max(frame.position.abs());
                height > 0.0 && !is_in_plane(height, self.plane_tolerance, normal, reach)
            })
            .map(|surface| surface.corners.map(|p| frame.to_local(p.as_dvec3())))
            .map(|corners| in_front(&corners, DVec3::Z))
            .filter(|polygon| polygon.len() > 2)
            .collect()
    }

    /// The mean over the points of what is seen of the chosen lamps; as an error a lamp of which no pixel of
    /// a view meets anything from some point from which no single piece hides it.
    fn look(&mut self, own: SurfaceId, frames: &[Frame], chosen: &[Choice]) -> Result<Seen, usize> {
        let patches = chosen.iter().map(|choice| &self.lamps[choice.lamp].patches);
        let mut replaced: Vec<Range<u32>> = patches.flatten().cloned().collect();
        replaced.sort_unstable_by_key(|range| range.start);
        let share = 1.0 / frames.len() as f64;
        for (k, frame) in frames.iter().enumerate() {
            if chosen.iter().all(|choice| choice.pieces[k].is_empty()) {
                continue;
            }
            let views = chosen.iter().flat_map(|choice| &choice.pieces[k]);
            let pixels = views.map(|piece| piece.window.width * piece.window.height);
            self.all_surfaces
                .set_for(pixels.sum(), frame, Some(own), true, Cull::Nothing);
            for choice in chosen.iter().filter(|choice| !choice.pieces[k].is_empty()) {
                if self.all_surfaces.hides(&choice.polygons[k]) {
                    continue;
                }
                let regions = self.lamps[choice.lamp].regions.iter().copied();
                self.lamp_alone
                    .set_some(frame, Some(own), regions, true, Cull::BackFaces);
                for piece in &choice.pieces[k] {
                    if !self.view(choice.lamp, piece, share) {
                        self.sums.take();
                        return Err(choice.lamp);
                    }
                }
            }
        }
        Ok(Seen {
            replaced,
            factors: self.sums.take(),
        })
    }

    /// Looks at a piece of one lamp from the point that the projections are set to and adds what is seen, times
    /// `share`. False where no pixel meets the piece.
    fn view(&mut self, lamp: usize, piece: &Piece, share: f64) -> bool {
        let lamp = &self.lamps[lamp];
        piece.weights(&mut self.weights);
        let row = |j: usize| j * piece.window.width;
        let mut whole = 0.0;
        self.raster.draw(&self.lamp_alone, &piece.window);
        self.raster.for_each_covered_run(|j, run| {
            whole += sum(&self.weights[row(j) + run.start..row(j) + run.end]);
        });
        if whole <= 0.0 {
            return false;
        }
        self.raster
            .draw_or_cast(&mut self.all_surfaces, None, &piece.window);
        let scale = share * piece.form_factor / whole;
        let Self { weights, sums, .. } = self;
        self.raster
            .for_each_run_of(&self.all_surfaces, &lamp.regions, |patch, j, run| {
                let weights = &weights[row(j) + run.start..row(j) + run.end];
                sums.add(patch, scale * sum(weights));
            });
        true
    }
}

/// Every fourth number is added up by itself, since one sum would wait for itself.
fn sum(weights: &[f64]) -> f64 {
    let fours = weights.chunks_exact(4);
    let rest: f64 = fours.remainder().iter().sum();
    let sums = fours.fold([0.0; 4], |sums: [f64; 4], four| {
        std::array::from_fn(|k| sums[k] + four[k])
    });
    sums.iter().sum::<f64>() + rest
}

/// Plane polygons in a frame, relative to its eye, metres.
type Polygons = Vec<Vec<DVec3>>;

/// A lamp that matters, and its pieces as each point of the patch sees them.
struct Choice {
    /// Number of the lamp.
    lamp: usize,
    /// Of the whole lamp, one list per point.
    polygons: Vec<Polygons>,
    /// One list per point.
    pieces: Vec<Vec<Piece>>,
}
