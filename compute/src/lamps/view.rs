//! Looking at lamps from the points of a patch.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use scene::{Scene, SurfaceId};
use visibility::{Canvas, Cull, Eye, Frame, View, Viewer, is_in_plane, reach};

use super::find::Lamp;
use super::merge::merge;
use super::piece::{Piece, pieces};
use crate::hemicubes::Hemicubes;
use crate::polygon_form_factor::{in_front, point_to_polygon};
use crate::receivers::ReceiverId;
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
    /// Of the lamp and what may hide it, and of the lamp alone.
    of_all: Viewer<'a>,
    of_lamp: Viewer<'a>,
    canvas: Canvas,
    /// Of a view's pixels.
    weights: Vec<f64>,
    sums: Sums,
}

/// What one receiver sees of the lamps that matter to it.
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
            scene: hemicubes.sources().scene(),
            hemicubes: Arc::clone(hemicubes),
            lamps: Arc::clone(lamps),
            all,
            plane_tolerance: hemicubes.drawable().plane_tolerance(),
            of_all: Viewer::new(hemicubes.drawable()),
            of_lamp: Viewer::new(hemicubes.drawable()),
            canvas: Canvas::default(),
            weights: Vec::new(),
            sums: Sums::new(lamps),
        }
    }

    /// Gives the lamps that matter to a receiver their own factors in its row.
    pub fn refine(&mut self, receiver: ReceiverId, row: &mut Row) {
        let frames = self.hemicubes.receivers().frames(receiver);
        let own = self.hemicubes.receivers().surface(receiver);
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

    /// The lamps that matter to a receiver.
    fn choose(&self, own: Option<SurfaceId>, frames: &[Frame]) -> Vec<Choice> {
        // Unhidden light, number, and for each point the lamp's polygons.
        let mut possible: Vec<(f64, usize, Vec<Polygons>)> = Vec::new();
        let mut total = 0.0;
        for (index, lamp) in self.lamps.iter().enumerate() {
            if own.is_some_and(|own| lamp.surfaces.binary_search(&own).is_ok()) {
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
    fn look(
        &mut self,
        own: Option<SurfaceId>,
        frames: &[Frame],
        chosen: &[Choice],
    ) -> Result<Seen, usize> {
        let Self {
            lamps,
            of_all,
            of_lamp,
            canvas,
            weights,
            sums,
            ..
        } = self;
        let patches = chosen.iter().map(|choice| &lamps[choice.lamp].patches);
        let mut replaced: Vec<Range<u32>> = patches.flatten().cloned().collect();
        replaced.sort_unstable_by_key(|range| range.start);
        let share = 1.0 / frames.len() as f64;
        for (k, frame) in frames.iter().enumerate() {
            if chosen.iter().all(|choice| choice.pieces[k].is_empty()) {
                continue;
            }
            let views = chosen.iter().flat_map(|choice| &choice.pieces[k]);
            let pixels = views.map(|piece| piece.window.width * piece.window.height);
            let eye = Eye::with_horizon(frame, own);
            let all = of_all.view(&eye, pixels.sum());
            for choice in chosen.iter().filter(|choice| !choice.pieces[k].is_empty()) {
                if all.hides(&choice.polygons[k]) {
                    continue;
                }
                let regions = &lamps[choice.lamp].regions;
                let fronts = Eye {
                    cull: Cull::BackFaces,
                    ..eye
                };
                let alone = of_lamp.view_of(&fronts, regions.iter().copied());
                for piece in &choice.pieces[k] {
                    piece.weights(weights);
                    let whole = covered(canvas, &alone, piece, weights);
                    if whole <= 0.0 {
                        sums.take();
                        return Err(choice.lamp);
                    }
                    let scale = share * piece.form_factor / whole;
                    let row = |j: usize| j * piece.window.width;
                    let mut picture = canvas.draw(&all, &piece.window);
                    picture.for_each_run_of(regions, |patch, j, run| {
                        let seen = sum(&weights[row(j) + run.start..row(j) + run.end]);
                        sums.add(patch, scale * seen);
                    });
                }
            }
        }
        Ok(Seen {
            replaced,
            factors: sums.take(),
        })
    }
}

/// The sum of the weights of the pixels of a piece's window that meet the lamp.
fn covered(canvas: &mut Canvas, lamp: &View, piece: &Piece, weights: &[f64]) -> f64 {
    let row = |j: usize| j * piece.window.width;
    let mut whole = 0.0;
    let picture = canvas.draw(lamp, &piece.window);
    picture.for_each_covered_run(|j, run| {
        whole += sum(&weights[row(j) + run.start..row(j) + run.end]);
    });
    whole
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
