//! Pictures: what the pixels of a window see of a view.

use std::ops::Range;

use fearless_simd::{Level, dispatch};
use scene::SurfaceId;

use crate::Window;
use crate::buffer::{Buffer, NONE, SPECK, Seen};
use crate::look_up::{Blanks, LookUp, Pieces, Source};
use crate::outcode;
use crate::rays;
use crate::runs::for_each_run;
use crate::spans::{self, Spans};
use crate::specks::{self, HierarchicalDepth, Target};
use crate::view::{HemicubeView, View};

/// What a pixel sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// No surface.
    Nothing,
    /// The back of a surface.
    BackFace(SurfaceId),
    /// The front of a surface.
    Front {
        /// Which.
        surface: SurfaceId,
        /// Where on it; they sum to 1.
        barycentric: [f32; 3],
        /// Distance along the window's forward direction, metres.
        depth: f32,
    },
}

/// The memory for one picture after the other, of any view, for one thread.
#[derive(Clone, Debug)]
pub struct Canvas {
    level: Level,
    buffer: Buffer,
    spans: Spans,
    depth: HierarchicalDepth,
    /// What rays have met, run of pixels by run.
    met: Vec<Seen>,
    look_up: LookUp,
}

/// What the pixels of a window see.
#[derive(Debug)]
pub struct Picture<'p> {
    canvas: &'p mut Canvas,
    view: View<'p>,
    window: Window,
}

impl Default for Canvas {
    fn default() -> Self {
        Self {
            level: Level::new(),
            buffer: Buffer::default(),
            spans: Spans::default(),
            depth: HierarchicalDepth::default(),
            met: Vec::new(),
            look_up: LookUp::default(),
        }
    }
}

impl Canvas {
    /// Draws what a view sees through a window.
    pub fn draw<'p>(&'p mut self, view: &View<'p>, window: &Window) -> Picture<'p> {
        self.draw_or_cast(view, window, 0);
        Picture {
            canvas: self,
            view: *view,
            window: *window,
        }
    }

    /// Draws what a hemicube sees through one of its faces, in the order of [`crate::hemicube::windows`].
    pub fn draw_face<'p>(&'p mut self, hemicube: &HemicubeView<'p>, face: usize) -> Picture<'p> {
        let HemicubeView {
            view,
            specks,
            windows,
        } = hemicube;
        let window = &windows[face];
        self.draw_or_cast(view, window, outcode::OF_FACES[face]);
        if let Some((specks, clusters)) = specks {
            let mut target = Target {
                at: &view.at,
                drawn: &view.projection.pieces,
                buffer: &mut self.buffer,
                depth: &mut self.depth,
            };
            dispatch!(self.level, simd => specks::draw(
                simd, clusters, specks, face, window, &mut target
            ));
        }
        Picture {
            canvas: self,
            view: *view,
            window: *window,
        }
    }

    /// Draws all pieces but those beyond a window, whose corners' outcodes have one of the bits `beyond` in common; or
    /// casts rays.
    fn draw_or_cast(&mut self, view: &View, window: &Window, beyond: u32) {
        let Self {
            level,
            buffer,
            spans,
            met,
            ..
        } = self;
        let Some(bvh) = view.bvh else {
            buffer.clear(window);
            dispatch!(*level, simd => spans::draw(
                simd, view.projection, beyond, window, spans, buffer
            ));
            return;
        };
        buffer.clear_codes(window);
        dispatch!(*level, simd => rays::cast(simd, &view.at, bvh, window, &mut buffer.codes));
        met.clear();
        for run in buffer.codes.chunk_by_mut(|a, b| a == b) {
            if run[0] != NONE {
                met.push(rays::seen(bvh, run[0]));
                run.fill(met.len() as u32 - 1);
            }
        }
    }
}

impl Picture<'_> {
    /// Hands out the patch IDs row by row, with `nothing` and `back_face` for pixels that see no patch.
    pub fn for_each_row(&mut self, nothing: u32, back_face: u32, take: impl FnMut(usize, &[u32])) {
        self.look_up(None, Blanks { nothing, back_face }, take);
    }

    /// Hands out the runs of pixels that see the same patch of some regions, ascending: patch, row, pixels. What else
    /// is seen costs no look-up.
    pub fn for_each_run_of(
        &mut self,
        regions: &[u32],
        mut take: impl FnMut(u32, usize, Range<usize>),
    ) {
        let level = self.canvas.level;
        let blanks = Blanks {
            nothing: NONE,
            back_face: NONE,
        };
        self.look_up(Some(regions), blanks, |j, ids| {
            dispatch!(level, simd => for_each_run(simd, ids, #[inline(always)] |id, start, end| {
                if id != NONE {
                    take(id, j, start..end);
                }
            }));
        });
    }

    fn look_up(
        &mut self,
        regions: Option<&[u32]>,
        blanks: Blanks,
        mut take: impl FnMut(usize, &[u32]),
    ) {
        let Canvas {
            level,
            buffer,
            met,
            look_up,
            ..
        } = &mut *self.canvas;
        let source = Source {
            at: &self.view.at,
            locators: self.view.locators,
            pieces: pieces(&self.view, met),
            window: &self.window,
        };
        look_up.start(&source, regions, blanks);
        for j in 0..self.window.height {
            take(
                j,
                look_up.row(*level, &source, j, buffer.row(&self.window, j)),
            );
        }
    }

    /// Hands out the runs of pixels that see a surface, from the front or from behind: row, pixels.
    pub fn for_each_covered_run(&self, mut take: impl FnMut(usize, Range<usize>)) {
        let Canvas { level, buffer, .. } = &*self.canvas;
        for j in 0..self.window.height {
            let row = buffer.row(&self.window, j);
            dispatch!(*level, simd => for_each_run(simd, row, #[inline(always)] |code, start, end| {
                if code != NONE {
                    take(j, start..end);
                }
            }));
        }
    }

    /// What pixel (i, j) sees.
    pub fn sample(&self, i: usize, j: usize) -> Sample {
        let mut sample = Sample::Nothing;
        self.for_each_sample(j, i..i + 1, |_, seen| sample = seen);
        sample
    }

    /// Hands out what some pixels i of row j see.
    pub fn for_each_sample(
        &self,
        j: usize,
        pixels: Range<usize>,
        mut take: impl FnMut(usize, Sample),
    ) {
        let Self {
            canvas,
            view,
            window,
        } = self;
        let pieces = pieces(view, &canvas.met);
        let mut i = pixels.start;
        let row = &canvas.buffer.row(window, j)[pixels];
        for run in row.chunk_by(|a, b| a == b) {
            if run[0] == NONE {
                for _ in run {
                    take(i, Sample::Nothing);
                    i += 1;
                }
                continue;
            }
            let seen = if run[0] & SPECK != 0 {
                Seen::of_speck(run[0])
            } else {
                pieces.seen(run[0])
            };
            let geometry = view.at.geometry;
            let coordinates = view.at.coordinates(seen.region);
            let plane = view.at.any_plane(&geometry.facts[seen.region as usize]);
            let mut last = 0;
            for _ in run {
                let direction = window.direction(i, j);
                let at = |k: usize| coordinates[k].dot(direction);
                let (surface, [a, b, c]) =
                    geometry.surface_at(seen.region, [at(0), at(1), at(2)], &mut last);
                let sample = if seen.is_back_face {
                    Sample::BackFace(surface)
                } else {
                    let (a, b, c) = (a.max(0.0), b.max(0.0), c.max(0.0));
                    let sum = a + b + c;
                    Sample::Front {
                        surface,
                        barycentric: [(a / sum) as f32, (b / sum) as f32, (c / sum) as f32],
                        depth: (1.0 / plane.inverse_depth.dot(direction)) as f32,
                    }
                };
                take(i, sample);
                i += 1;
            }
        }
    }
}

/// What the codes of a view's picture stand for.
fn pieces<'p>(view: &View<'p>, met: &'p [Seen]) -> Pieces<'p> {
    match view.bvh {
        Some(_) => Pieces::Met(met),
        None => Pieces::Drawn(&view.projection.pieces),
    }
}
