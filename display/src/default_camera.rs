//! A camera for a scene that nobody has placed one in.
//!
//! What kind of scene it is ([`crate::kind`]) decides where the camera is: an object is looked at
//! from outside, a stage through its open side, which fills the picture, a room from inside; from
//! outside if backs are not drawn, since then its walls let one look in.
//!
//! # Where to stand
//! Candidates get a score from a small picture each, and the first of the best is taken:
//! - inside, points of a grid at eye height, in level directions (so that verticals stay parallel)
//!   and two angles of view: the shares of the scene's area, of its objects and of its lamps' area
//!   that are in the picture, less those of the picture that are close before the eye or open. One
//!   that sees backs is none.
//! - outside, three-quarter views from above that hold the whole scene and are filled by it: the share of fronts among
//!   the surfaces seen. Where that is small, they stand behind walls, and one inside is taken if there is any.

use std::collections::BTreeSet;
use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;
use scene::{Scene, Surface};
use visibility::{Cull, Drawable, Sample, Window};

use crate::camera::Camera;
use crate::kind::{self, Kind, MAX_BACK_FACES, bounding_box};
use crate::probe::{Lookout, Probe, Ray};
use crate::settings::Size;

/// Angle of view inside, degrees: as wide as looks natural, 75 degrees across at 4:3.
pub const INSIDE_FOV: f64 = 60.0;
/// A second one for rooms that are high for their length, 96 degrees across, which bends what is
/// near the edges; what it has to gain in score to be taken.
const WIDE_FOV: f64 = 80.0;
const WIDE_PENALTY: f64 = 0.15;
/// Angle of view outside, degrees: that of the published Cornell box.
const OUTSIDE_FOV: f64 = 39.0;

/// Width over height of a picture, where the scene does not ask for another.
pub const ASPECT: f64 = 4.0 / 3.0;
/// Margin around what fills a picture, as a share of it.
const MARGIN: f64 = 0.02;

/// Height of an eye in a room, as a share of the room's.
const EYE_HEIGHT: f64 = 0.45;
/// Distance of the outermost eyes from the walls, as a share of the room's length.
const WALL_DISTANCE: f64 = 0.06;
/// Directions tried outside, each way round, and elevations in degrees.
const OUTSIDE_AZIMUTHS: u32 = 12;
const OUTSIDE_ELEVATIONS: [f64; 2] = [30.0, 50.0];

/// What counts as close before the eye, as a share of half the room's diagonal.
const CLOSE: f64 = 0.25;
/// Cosine to the normal, below which rays are too grazing to show all the area they stand for.
const GRAZING: f64 = 0.25;
/// Weights of the shares of objects and lamps in the score. Tuned by eye on rooms with columns.
const OBJECTS_WEIGHT: f64 = 0.3;
const LAMPS_WEIGHT: f64 = 0.15;

/// Share of fronts among what a view from outside shows, below which it is one from behind a wall.
const MOSTLY_FRONTS: f64 = 0.5;

/// Rows of a candidate's picture, pixels.
const CANDIDATE_ROWS: u32 = 48;

/// Points along each side of the floor, and level directions tried at each of them.
fn candidates_of(scene: &Scene) -> (usize, u32) {
    // A candidate costs some 20 ns a surface.
    match scene.surfaces().len() {
        0..=20_000 => (7, 16),
        20_001..=100_000 => (5, 16),
        _ => (3, 8),
    }
}

/// A camera, and the width over height of the picture it suits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Framing {
    /// The camera.
    pub camera: Camera,
    /// Width over height.
    pub aspect: f64,
}

/// What a camera can be like, whatever the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wishes {
    /// Up in the picture, a unit vector along an axis.
    pub up: DVec3,
    /// Vertical angle of view, degrees.
    pub fov_degrees: Option<f64>,
    /// Width over height.
    pub aspect: Option<f64>,
    /// Whether backs of surfaces are drawn.
    pub cull: Cull,
}

/// Chooses a camera.
pub fn choose(scene: &Scene, wishes: &Wishes) -> Framing {
    match kind::of(scene) {
        Kind::Stage(side) => through(scene, side, wishes),
        Kind::Room if wishes.cull == Cull::Nothing => inside(scene, wishes, MAX_BACK_FACES)
            .unwrap_or_else(|| not_behind_a_wall(scene, wishes)),
        Kind::Object if wishes.cull == Cull::Nothing => not_behind_a_wall(scene, wishes),
        Kind::Room | Kind::Object => outside(scene, wishes).0,
    }
}

/// The best view from outside, unless it shows backs mostly and one from inside shows fewer.
fn not_behind_a_wall(scene: &Scene, wishes: &Wishes) -> Framing {
    let (framing, fronts) = outside(scene, wishes);
    if fronts >= MOSTLY_FRONTS {
        return framing;
    }
    let few = [MAX_BACK_FACES, 0.25 * (1.0 - fronts)];
    let inside = few.into_iter().find_map(|most| inside(scene, wishes, most));
    inside.unwrap_or(framing)
}

/// The view through the open side of a stage, which fills the picture.
fn through(scene: &Scene, side: DVec3, wishes: &Wishes) -> Framing {
    let [middle, half] = bounding_box(scene);
    let fov = wishes.fov_degrees.unwrap_or(OUTSIDE_FOV);
    let camera = Camera::new(middle, -side, wishes.up, fov);
    let [width, height] = [camera.right, camera.up].map(|axis| half.dot(axis.abs()));
    let aspect = wishes
        .aspect
        .unwrap_or_else(|| (width / height).clamp(0.5, 2.0));
    let reach = (1.0 + MARGIN) * height.max(width / aspect) / camera.half_height();
    let eye = middle + (half.dot(side.abs()) + reach) * side;
    Framing {
        camera: Camera { eye, ..camera },
        aspect,
    }
}

/// The best three-quarter view from outside, and the share of fronts in it.
fn outside(scene: &Scene, wishes: &Wishes) -> (Framing, f64) {
    let aspect = wishes.aspect.unwrap_or(ASPECT);
    let fov = wishes.fov_degrees.unwrap_or(OUTSIDE_FOV);
    let (east, south) = floor_axes(wishes.up);
    let mut candidates = Vec::new();
    for elevation in OUTSIDE_ELEVATIONS {
        for k in 0..OUTSIDE_AZIMUTHS {
            // From the front and a little to the right, as one looks at a thing on a table.
            let azimuth = f64::from(k) * std::f64::consts::TAU / f64::from(OUTSIDE_AZIMUTHS) + 1.05;
            let level = azimuth.cos() * east + azimuth.sin() * south;
            let (sin, cos) = elevation.to_radians().sin_cos();
            let forward = -(cos * level + sin * wishes.up);
            let camera = Camera::new(DVec3::ZERO, forward, wishes.up, fov);
            candidates.push(filled_by(scene, camera, aspect));
        }
    }
    let drawable = Arc::new(Drawable::new(scene));
    let scores: Vec<f64> = candidates
        .par_iter()
        .map_init(
            || Probe::new(&drawable),
            |probe, camera| {
                let window = candidate_window(camera, aspect);
                let mut probe = probe.at(camera.eye, wishes.cull, window.pixel_count());
                let (mut fronts, mut backs) = (0.0, 0.0);
                probe.look(&window, |ray| match ray.sample {
                    Sample::Front { .. } => fronts += ray.solid_angle,
                    Sample::BackFace(_) => backs += ray.solid_angle,
                    Sample::Nothing => {}
                });
                // Hundredths, so that among equals the first wins and not chance.
                (fronts / (fronts + backs).max(f64::MIN_POSITIVE) * 100.0).round()
            },
        )
        .collect();
    let best = first_best(&scores).unwrap_or(0);
    let framing = Framing {
        camera: candidates[best],
        aspect,
    };
    (framing, scores[best] / 100.0)
}

/// The camera with the same directions whose picture is filled by the scene, but for a margin. Where something reflects, that is
/// the scene: a sky may be many times as large.
///
/// A point p is within the left and the right side of a picture seen from e if |(p - e) . right| <= w (p - e) . forward, w the half
/// width at distance 1. So e . right - w e . forward is at least the largest p . right - w p . forward, and -e . right -
/// w e . forward at least the largest of the other side: of both, the nearest e lies in the middle. So above and below, and of the
/// two distances the larger one counts.
fn filled_by(scene: &Scene, camera: Camera, aspect: f64) -> Camera {
    let high = camera.half_height() / (1.0 + MARGIN);
    let sides = [(camera.right, high * aspect), (camera.up, high)];
    let mut reach = [[f64::NEG_INFINITY; 2]; 2];
    let reflects = |surface: &&Surface| !scene.material(surface.material).is_emitter();
    let all_emit = !scene.surfaces().iter().any(|surface| reflects(&surface));
    let surfaces = scene
        .surfaces()
        .iter()
        .filter(|surface| all_emit || reflects(surface));
    for corner in surfaces.flat_map(|surface| surface.corners) {
        let corner = corner.as_dvec3();
        let depth = corner.dot(camera.forward);
        for ([plus, minus], (axis, half)) in reach.iter_mut().zip(sides) {
            let across = corner.dot(axis);
            *plus = plus.max(across - half * depth);
            *minus = minus.max(-across - half * depth);
        }
    }
    let middle = |k: usize| 0.5 * (reach[k][0] - reach[k][1]);
    let depth = |k: usize| -0.5 * (reach[k][0] + reach[k][1]) / sides[k].1;
    Camera {
        eye: middle(0) * camera.right
            + middle(1) * camera.up
            + depth(0).min(depth(1)) * camera.forward,
        ..camera
    }
}

/// The best view from inside, of those of which at most so much are backs, or `None` where there is none.
fn inside(scene: &Scene, wishes: &Wishes, most_backs: f64) -> Option<Framing> {
    let aspect = wishes.aspect.unwrap_or(ASPECT);
    let fovs = match wishes.fov_degrees {
        Some(fov) => vec![(fov, 0.0)],
        None => vec![(INSIDE_FOV, 0.0), (WIDE_FOV, WIDE_PENALTY)],
    };
    let [middle, half] = bounding_box(scene);
    let (east, south) = floor_axes(wishes.up);
    let (n, azimuths) = candidates_of(scene);
    let eyes: Vec<DVec3> = (0..n * n)
        .map(|k| {
            let across =
                |k: usize| (1.0 - 2.0 * WALL_DISTANCE) * (2.0 * k as f64 / (n - 1) as f64 - 1.0);
            let place = across(k % n) * east + across(k / n) * south;
            middle + half * (place + (2.0 * EYE_HEIGHT - 1.0) * wishes.up)
        })
        .collect();
    let critic = Critic::new(scene, most_backs);
    let drawable = Arc::new(Drawable::new(scene));
    let candidates: Vec<(Camera, f64)> = eyes
        .into_par_iter()
        .map_init(
            || Probe::new(&drawable),
            |probe, eye| {
                let window = candidate_window(&Camera::new(eye, east, wishes.up, WIDE_FOV), aspect);
                let pixels = azimuths as usize * fovs.len() * window.pixel_count();
                let mut probe = probe.at(eye, Cull::Nothing, pixels);
                let mut candidates = Vec::new();
                for k in 0..azimuths {
                    let azimuth = f64::from(k) * std::f64::consts::TAU / f64::from(azimuths);
                    let level = azimuth.cos() * east + azimuth.sin() * south;
                    for &(fov, penalty) in &fovs {
                        let camera = Camera::new(eye, level, wishes.up, fov);
                        let score = critic.score(&mut probe, &camera, aspect) - penalty;
                        candidates.push((camera, score));
                    }
                }
                candidates
            },
        )
        .flatten()
        .collect();
    let scores: Vec<f64> = candidates.iter().map(|(_, score)| *score).collect();
    let best = first_best(&scores)?;
    Some(Framing {
        camera: candidates[best].0,
        aspect,
    })
}

/// Two axes across `up`, which is an axis, such that (east, up, south) is right-handed.
fn floor_axes(up: DVec3) -> (DVec3, DVec3) {
    let east = if up.x.abs() > 0.5 { DVec3::Y } else { DVec3::X };
    (east, east.cross(up))
}

/// A candidate's small picture.
fn candidate_window(camera: &Camera, aspect: f64) -> Window {
    let width = (f64::from(CANDIDATE_ROWS) * aspect)
        .round()
        .clamp(1.0, 512.0) as u32;
    camera.window(
        Size {
            width,
            height: CANDIDATE_ROWS,
        },
        1,
    )
}

/// The index of the first of the highest scores that are numbers above minus infinity.
fn first_best(scores: &[f64]) -> Option<usize> {
    let mut best = None;
    let mut highest = f64::NEG_INFINITY;
    for (index, &score) in scores.iter().enumerate() {
        if score > highest {
            (best, highest) = (Some(index), score);
        }
    }
    best
}

/// Judges views from inside.
struct Critic<'a> {
    scene: &'a Scene,
    /// Area of all surfaces, m^2.
    area: f64,
    /// Area of all that emit, m^2.
    lamp_area: f64,
    /// What is nearer than this stands close before the eye, metres.
    close: f64,
    /// Share of a view that may be backs.
    most_backs: f64,
}

impl<'a> Critic<'a> {
    fn new(scene: &'a Scene, most_backs: f64) -> Self {
        let [_, half] = bounding_box(scene);
        let lamps = scene
            .surfaces()
            .iter()
            .filter(|s| scene.material(s.material).is_emitter());
        Self {
            scene,
            area: scene.area(),
            lamp_area: lamps.map(Surface::area).sum(),
            close: CLOSE * half.length(),
            most_backs,
        }
    }

    /// The score of a view, minus infinity if it sees too many backs; `probe` is at its eye.
    fn score(&self, probe: &mut Lookout, camera: &Camera, aspect: f64) -> f64 {
        let (mut visible_area, mut visible_lamps) = (0.0, 0.0);
        let (mut close, mut open, mut backs, mut total) = (0.0, 0.0, 0.0, 0.0);
        let mut objects = BTreeSet::new();
        probe.look(
            &candidate_window(camera, aspect),
            |Ray {
                 direction,
                 sample,
                 solid_angle,
             }| {
                total += solid_angle;
                match sample {
                    Sample::Nothing => open += solid_angle,
                    Sample::BackFace(_) => backs += solid_angle,
                    Sample::Front { surface, depth, .. } => {
                        let surface = self.scene.surface(surface);
                        let distance = f64::from(depth) * direction.length();
                        let cosine = surface
                            .normal()
                            .dot(direction.normalize())
                            .abs()
                            .max(GRAZING);
                        let area = solid_angle * distance * distance / cosine;
                        visible_area += area;
                        objects.insert(surface.object);
                        if f64::from(depth) < self.close {
                            close += solid_angle;
                        }
                        if self.scene.material(surface.material).is_emitter() {
                            visible_lamps += area;
                        }
                    }
                }
            },
        );
        if backs > self.most_backs * total {
            return f64::NEG_INFINITY;
        }
        let object_share = objects.len() as f64 / self.scene.objects().len().max(1) as f64;
        let lamp_share = if self.lamp_area > 0.0 {
            visible_lamps / self.lamp_area
        } else {
            0.0
        };
        (visible_area / self.area).min(1.0)
            + OBJECTS_WEIGHT * object_share
            + LAMPS_WEIGHT * lamp_share.min(1.0)
            - (close + open) / total
    }
}
