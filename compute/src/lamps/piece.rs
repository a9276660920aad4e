//! The parts of a lamp that are viewed one by one.
//!
//! A view is a plane picture, so it cannot look far to both sides. A lamp that is too long for it, a tube close to
//! the wall it lights, is halved by planes through the eye until its parts fit.

use fearless_simd::{Level, Simd, dispatch};
use fearless_simd_macros::simd;
use glam::DVec3;
use visibility::Window;

use crate::polygon_form_factor::{in_front, point_to_polygon};

/// Pixels along the longer side of a view: a shadow's edge across a lamp is right to half of one.
const VIEW_PIXELS: usize = 64;

/// Pixels along the shorter side at least, as long as the longer one has at most [`MOST_PIXELS`].
const LEAST_PIXELS: usize = 8;
const MOST_PIXELS: usize = 2048;

/// Edges of a lamp along which its view may lie; the one with the smallest rectangle is taken.
const MOST_DIRECTIONS: usize = 16;

/// The widest view, as the tangent of half its angle.
const WIDEST: f64 = 2.0;

/// How often a lamp is halved at most. What is wider still covers so much of the hemicube that it needs no
/// view of its own.
const MOST_HALVINGS: u32 = 2;

/// A part of a lamp, as a point sees it, and the window that just encloses it.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub window: Window,
    /// The piece is where directions have no negative product with any.
    planes: Vec<DVec3>,
    /// Of the piece if nothing hides it, dimensionless.
    pub form_factor: f64,
}

impl Piece {
    /// The pixels' delta form factors, row by row, up to a factor that all share; 0 where a pixel looks past the
    /// piece.
    pub fn weights(&self, weights: &mut Vec<f64>) {
        weights.clear();
        weights.resize(self.window.width * self.window.height, 0.0);
        dispatch!(Level::new(), simd => self.weigh(simd, weights));
    }

    #[simd]
    fn weigh<S: Simd>(&self, simd: S, weights: &mut [f64]) {
        let window = &self.window;
        let across = window.pixel * window.right;
        for (j, row) in weights.chunks_exact_mut(window.width).enumerate() {
            let first = window.forward
                + (window.left + 0.5 * window.pixel) * window.right
                + (window.bottom + (j as f64 + 0.5) * window.pixel) * window.up;
            for (i, weight) in row.iter_mut().enumerate() {
                let direction = first + i as f64 * across;
                let squared = direction.length_squared();
                *weight = direction.z.max(0.0) / (squared * squared);
            }
            for plane in &self.planes {
                let (base, step) = (plane.dot(first), plane.dot(across));
                for (i, weight) in row.iter_mut().enumerate() {
                    if base + i as f64 * step < 0.0 {
                        *weight = 0.0;
                    }
                }
            }
        }
    }
}

/// The pieces of polygons that lie above the horizon, relative to the eye; `None` where they are too wide,
/// or nothing.
pub(super) fn pieces(polygons: &[Vec<DVec3>]) -> Option<Vec<Piece>> {
    let mut pieces = Vec::new();
    halve(polygons, &[], &mut pieces).then_some(pieces)
}

fn halve(polygons: &[Vec<DVec3>], planes: &[DVec3], pieces: &mut Vec<Piece>) -> bool {
    let across = match window(polygons) {
        View::Fits(window) => {
            pieces.push(Piece {
                window,
                planes: planes.to_vec(),
                form_factor: polygons.iter().map(|p| point_to_polygon(p)).sum(),
            });
            return true;
        }
        View::TooWide { across } => across,
        View::Nothing => return false,
    };
    planes.len() < MOST_HALVINGS as usize
        && [across, -across].into_iter().all(|plane| {
            let half: Vec<Vec<DVec3>> = polygons
                .iter()
                .map(|polygon| in_front(polygon, plane))
                .filter(|polygon| polygon.len() > 2)
                .collect();
            half.is_empty() || halve(&half, &[planes, &[plane]].concat(), pieces)
        })
}

enum View {
    Fits(Window),
    /// Too long in the direction of a unit vector.
    TooWide {
        across: DVec3,
    },
    Nothing,
}

/// The window that just encloses some polygons.
fn window(polygons: &[Vec<DVec3>]) -> View {
    let corners: Vec<DVec3> = polygons
        .iter()
        .flatten()
        .map(|corner| corner.normalize_or_zero())
        .collect();
    let forward = corners.iter().sum::<DVec3>().normalize_or_zero();
    let farthest = corners
        .iter()
        .min_by(|p, q| p.dot(forward).total_cmp(&q.dot(forward)));
    let across = farthest.and_then(|p| p.reject_from_normalized(forward).try_normalize());
    let (Some(farthest), Some(across)) = (farthest, across) else {
        return View::Nothing;
    };
    if farthest.dot(forward) * WIDEST.hypot(WIDEST) < farthest.dot(across) {
        return View::TooWide { across };
    }
    let directions = corners
        .iter()
        .zip(corners.iter().skip(1))
        .take(MOST_DIRECTIONS);
    let smallest = directions
        .filter_map(|(p, q)| {
            let right = (q - p).reject_from_normalized(forward).try_normalize()?;
            let rectangle = rectangle(&corners, forward, right);
            Some((rectangle[2] * rectangle[3], right, rectangle))
        })
        .min_by(|a, b| a.0.total_cmp(&b.0));
    let Some((_, right, [left, bottom, width, height])) = smallest else {
        return View::Nothing;
    };
    let ends = [left, left + width, bottom, bottom + height];
    if ends.iter().any(|end| end.abs() > WIDEST) {
        return View::TooWide { across };
    }
    let (longer, shorter) = (width.max(height), width.min(height));
    let pixel = (longer / VIEW_PIXELS as f64)
        .min(shorter / LEAST_PIXELS as f64)
        .max(longer / MOST_PIXELS as f64);
    if !(pixel.is_finite() && pixel > 0.0) {
        return View::Nothing;
    }
    let pixels = |side: f64| ((side / pixel).ceil() as usize).clamp(1, MOST_PIXELS);
    View::Fits(Window {
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
