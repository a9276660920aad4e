//! Looking at lamps from the points of a patch.

use std::ops::Range;

use glam::DVec3;
use scene::{PatchId, Scene, SurfaceId};

use super::cone::{Cone, Sphere};
use super::find::Lamp;
use super::merge::{is_in, merge};
use crate::cpu::{Cull, Projection, Raster, is_in_plane, plane_tolerance, reach};
use crate::hemicube::{self, Frame, Window};
use crate::polygon_form_factor::{above_horizon, point_to_triangle};
use crate::rows::{Entry, Unseen};
use crate::settings::FormFactorSettings;

/// Share of the unhidden light of all lamps from which on one has its own view.
const LEAST_SHARE: f64 = 0.01;

/// Views a point at most.
const MOST_VIEWS: usize = 8;

/// Pixels along the longer side of a view: a shadow's edge across a lamp is right to half of one.
const VIEW_PIXELS: usize = 64;

/// Pixels along the shorter side at least, as long as the longer one has at most [`MOST_PIXELS`].
const LEAST_PIXELS: usize = 8;
const MOST_PIXELS: usize = 2048;

/// Edges of a lamp along which its view may lie; the one with the smallest rectangle is taken.
const MOST_DIRECTIONS: usize = 16;

/// The widest view, as the tangent of half its angle; a lamp that is closer or larger covers so much of
/// the hemicube that it needs no view of its own.
const WIDEST: f64 = 2.0;

/// Views lamps for one thread.
pub(super) struct LampViewer<'a> {
    scene: &'a Scene,
    settings: FormFactorSettings,
    lamps: &'a [Lamp],
    /// Around the surfaces, one each.
    spheres: &'a [Sphere],
    all: bool,
    plane_tolerance: f64,
    /// What may be seen of a lamp, and what may hide it.
    hiders_and_lamp: Projection,
    lamp_alone: Projection,
    raster: Raster,
}

/// What one patch sees of the lamps that matter to it.
#[derive(Default)]
pub(super) struct Seen {
    /// Patches of the lamps with views, ascending ranges.
    pub replaced: Vec<Range<u32>>,
    /// Patch and form factor, dimensionless.
    pub factors: Vec<(u32, f64)>,
}

impl<'a> LampViewer<'a> {
    /// A viewer of these lamps; of all of them, if `all`, whether they matter or not.
    pub fn new(
        scene: &'a Scene,
        settings: FormFactorSettings,
        lamps: &'a [Lamp],
        spheres: &'a [Sphere],
        all: bool,
    ) -> Self {
        Self {
            scene,
            settings,
            lamps,
            spheres,
            all,
            plane_tolerance: plane_tolerance(scene),
            hiders_and_lamp: Projection::default(),
            lamp_alone: Projection::default(),
            raster: Raster::default(),
        }
    }

    /// The row in which the lamps that matter have their own factors.
    pub fn refine(
        &mut self,
        patch: PatchId,
        row: &[Entry],
        unseen: Unseen,
    ) -> (Vec<Entry>, Unseen) {
        let frames = hemicube::frames(self.scene, patch, self.settings.points);
        let own = self.scene.mesh().surface_of(patch);
        let mut chosen = self.choose(own, &frames);
        let seen = loop {
            match self.look(own, &frames, &chosen) {
                Ok(seen) => break seen,
                // Too thin for a view's pixels: the hemicube's may find it.
                Err(missed) => chosen.retain(|&index| index != missed),
            }
        };
        merge(row, unseen, &seen, self.settings.units_per_one())
            .unwrap_or_else(|| (row.to_vec(), unseen))
    }

    /// The lamps that matter to a patch.
    fn choose(&self, own: SurfaceId, frames: &[Frame]) -> Vec<usize> {
        let mut possible: Vec<(f64, usize)> = Vec::new();
        let mut total = 0.0;
        for (index, lamp) in self.lamps.iter().enumerate() {
            let form_factor: f64 = if lamp.surfaces.contains(&own) {
                0.0
            } else {
                frames.iter().map(|frame| self.unhidden(frame, lamp)).sum()
            };
            let light = lamp.emission * form_factor;
            total += light;
            if light > 0.0 {
                possible.push((light, index));
            }
        }
        // The brightest first; of equals the one with the lower number.
        possible.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        if !self.all {
            possible.retain(|(light, _)| *light >= LEAST_SHARE * total);
            possible.truncate(MOST_VIEWS);
        }
        // A lamp that some point sees too wide is left to the hemicube for all of them.
        let fits = |&index: &usize| {
            frames.iter().all(|frame| {
                !self.faces(frame, &self.lamps[index])
                    || self.window(frame, &self.lamps[index]).is_some()
            })
        };
        possible
            .into_iter()
            .map(|(_, index)| index)
            .filter(fits)
            .collect()
    }

    /// True where the point is in front of the lamp's plane.
    fn faces(&self, frame: &Frame, lamp: &Lamp) -> bool {
        let surface = self.scene.surface(lamp.surfaces[0]);
        let height = (frame.position - surface.corners[0].as_dvec3()).dot(surface.normal());
        let reach = reach(surface).max(frame.position.abs());
        height > 0.0 && !is_in_plane(height, self.plane_tolerance, surface.normal(), reach)
    }

    /// Form factor of a lamp if nothing hides it, dimensionless.
    fn unhidden(&self, frame: &Frame, lamp: &Lamp) -> f64 {
        if !self.faces(frame, lamp) {
            return 0.0;
        }
        lamp.surfaces
            .iter()
            .map(|&id| point_to_triangle(self.corners(frame, id)))
            .sum()
    }

    fn corners(&self, frame: &Frame, surface: SurfaceId) -> [DVec3; 3] {
        self.scene
            .surface(surface)
            .corners
            .map(|p| frame.to_local(p.as_dvec3()))
    }

    /// The window that just encloses a lamp's part above the horizon; `None` where that is too wide, or
    /// nothing.
    fn window(&self, frame: &Frame, lamp: &Lamp) -> Option<Window> {
        let corners: Vec<DVec3> = lamp
            .surfaces
            .iter()
            .flat_map(|&id| above_horizon(self.corners(frame, id)))
            .map(DVec3::normalize_or_zero)
            .collect();
        let forward = corners.iter().sum::<DVec3>().normalize_or_zero();
        if forward == DVec3::ZERO || corners.iter().any(|q| q.dot(forward) <= 0.0) {
            return None;
        }
        let directions = corners
            .iter()
            .zip(corners.iter().skip(1))
            .take(MOST_DIRECTIONS);
        let (_, right, [left, bottom, width, height]) = directions
            .filter_map(|(p, q)| {
                let right = (q - p).reject_from_normalized(forward).try_normalize()?;
                let rectangle = rectangle(&corners, forward, right);
                Some((rectangle[2] * rectangle[3], right, rectangle))
            })
            .min_by(|a, b| a.0.total_cmp(&b.0))?;
        let ends = [left, left + width, bottom, bottom + height];
        if ends.iter().any(|end| end.abs() > WIDEST) {
            return None;
        }
        let (longer, shorter) = (width.max(height), width.min(height));
        let pixel = (longer / VIEW_PIXELS as f64)
            .min(shorter / LEAST_PIXELS as f64)
            .max(longer / MOST_PIXELS as f64);
        if !(pixel.is_finite() && pixel > 0.0) {
            return None;
        }
        let pixels = |side: f64| ((side / pixel).ceil() as usize).clamp(1, MOST_PIXELS);
        Some(Window {
            right,
            up: forward.cross(right),
            forward,
            left,
            bottom,
            pixel,
            width: pixels(width),
            height: pixels(height),
        })
    }

    /// How far away the lamp's farthest corner is, metres.
    fn reach(&self, frame: &Frame, lamp: &Lamp) -> f64 {
        lamp.surfaces
            .iter()
            .flat_map(|&id| self.scene.surface(id).corners)
            .map(|p| p.as_dvec3().distance(frame.position))
            .fold(0.0, f64::max)
    }

    /// The mean over the points of what is seen of the chosen lamps; as an error a lamp that no pixel of
    /// its view meets from some point, hidden or not.
    fn look(&mut self, own: SurfaceId, frames: &[Frame], chosen: &[usize]) -> Result<Seen, usize> {
        let mut seen = Seen::default();
        for &index in chosen {
            let trees = self.lamps[index]
                .surfaces
                .iter()
                .map(|&id| self.scene.mesh().tree(id));
            seen.replaced.extend(trees.map(scene::Tree::patches));
        }
        seen.replaced.sort_unstable_by_key(|range| range.start);
        if chosen.is_empty() {
            return Ok(seen);
        }
        for frame in frames {
            for &index in chosen {
                let share = 1.0 / frames.len() as f64;
                if !self.view(own, frame, index, share, &mut seen) {
                    return Err(index);
                }
            }
        }
        seen.factors.sort_by_key(|(patch, _)| *patch);
        seen.factors.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1 += next.1;
            }
            same
        });
        Ok(seen)
    }

    /// Looks at one lamp from one point and adds what is seen, times `share`. False where no pixel meets
    /// the lamp.
    fn view(
        &mut self,
        own: SurfaceId,
        frame: &Frame,
        index: usize,
        share: f64,
        seen: &mut Seen,
    ) -> bool {
        let lamp = &self.lamps[index];
        let form_factor = self.unhidden(frame, lamp);
        let Some(window) = self.window(frame, lamp).filter(|_| form_factor > 0.0) else {
            return true;
        };
        self.lamp_alone.set_some(
            self.scene,
            frame,
            Some(own),
            lamp.surfaces.iter().copied(),
            true,
            Cull::BackFaces,
            self.plane_tolerance,
        );
        let nothing = u32::MAX;
        let mut whole = 0.0;
        self.raster.draw(&self.lamp_alone, &window);
        self.raster
            .for_each_row(&self.lamp_alone, nothing, nothing, |j, ids| {
                whole += (0..ids.len())
                    .filter(|&i| ids[i] != nothing)
                    .map(|i| weight(&window, i, j))
                    .sum::<f64>();
            });
        if whole <= 0.0 {
            return false;
        }
        let first = seen.factors.len();
        let replaced = &seen.replaced;
        let factors = &mut seen.factors;
        let cone = Cone::around(frame, &window, self.reach(frame, lamp));
        let hiders = (0..).map(SurfaceId).zip(self.spheres);
        self.hiders_and_lamp.set_some(
            self.scene,
            frame,
            Some(own),
            hiders
                .filter(|&(id, sphere)| id != own && cone.meets(sphere))
                .map(|(id, _)| id),
            true,
            Cull::Nothing,
            self.plane_tolerance,
        );
        self.raster.draw(&self.hiders_and_lamp, &window);
        let trees: Vec<Range<u32>> = lamp
            .surfaces
            .iter()
            .map(|&id| self.scene.mesh().tree(id).patches())
            .collect();
        self.raster
            .for_each_row(&self.hiders_and_lamp, nothing, nothing, |j, ids| {
                for (i, &id) in ids.iter().enumerate() {
                    if id == nothing
                        || !is_in(replaced, id)
                        || !trees.iter().any(|t| t.contains(&id))
                    {
                        continue;
                    }
                    let weight = share * form_factor * weight(&window, i, j) / whole;
                    match factors[first..].last_mut() {
                        Some((patch, sum)) if *patch == id => *sum += weight,
                        _ => factors.push((id, weight)),
                    }
                }
            });
        true
    }
}

/// The rectangle around some directions on the plane at distance 1 before an eye: left, bottom, width,
/// height, with the sides along `right`.
fn rectangle(directions: &[DVec3], forward: DVec3, right: DVec3) -> [f64; 4] {
    let up = forward.cross(right);
    let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
    for q in directions {
        let w = q.dot(forward);
        for (k, v) in [q.dot(right) / w, q.dot(up) / w].into_iter().enumerate() {
            low[k] = low[k].min(v);
            high[k] = high[k].max(v);
        }
    }
    [low[0], low[1], high[0] - low[0], high[1] - low[1]]
}

/// A pixel's delta form factor, up to a factor that all pixels share.
fn weight(window: &Window, i: usize, j: usize) -> f64 {
    let direction = window.forward
        + (window.left + (i as f64 + 0.5) * window.pixel) * window.right
        + (window.bottom + (j as f64 + 0.5) * window.pixel) * window.up;
    direction.z.max(0.0) / direction.length_squared().powi(2)
}
