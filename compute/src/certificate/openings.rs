//! Openings that are meant: what was taken out of a model on purpose, as a window.
//!
//! A patch may see as much of nothing as its points see of the openings where nothing stands between, which Lambert's formula
//! tells exactly. What it sees beyond that is lost elsewhere. Where something does stand between, as a column before the
//! window, as much may be lost unnoticed.

use rayon::prelude::*;
use scene::Opening;
use visibility::Frame;

use crate::polygon_form_factor::point_to_triangle;
use crate::receivers::ReceiverId;
use crate::row_cache::RowCache;
use crate::rows::Unseen;

/// The most by which pixels may see more of an opening than there is, relative to it. Tuned with [`PIXELS`]: in a room with a
/// window, single hemicubes of 24 to 128 pixels see up to 5 percent and 4.5 pixels more.
const RELATIVE_TOLERANCE: f64 = 0.1;

/// The same for openings of a few pixels, in the largest delta form factors.
const PIXELS: f64 = 3.0;

/// How much of a hemisphere each patch may see of openings that are meant, dimensionless; `None` where none is.
pub(super) fn meant(rows: &RowCache) -> Option<Vec<f64>> {
    let openings = rows.sources().patches().openings();
    if openings.is_empty() {
        return None;
    }
    let receivers = rows.hemicubes().receivers();
    // A pixel in the middle of the front: its area over pi, of a face of 2 x 2.
    let pixel = 4.0 / (std::f64::consts::PI * f64::from(rows.hemicubes().resolution()).powi(2));
    let of_patch = |(patch, unseen): (usize, &Option<Unseen>)| {
        if unseen.is_none_or(|unseen| unseen.open == 0) {
            return 0.0;
        }
        let frames = receivers.frames(ReceiverId(patch as u32));
        let sum: f64 = frames.iter().map(|frame| seen_from(frame, openings)).sum();
        let mean = sum / frames.len() as f64;
        if mean > 0.0 {
            mean * (1.0 + RELATIVE_TOLERANCE) + PIXELS * pixel
        } else {
            0.0
        }
    };
    let patches = rows.unseen().par_iter().enumerate();
    Some(patches.map(of_patch).collect())
}

/// What a point sees of the fronts of openings, dimensionless, if nothing hides them.
fn seen_from(frame: &Frame, openings: &[Opening]) -> f64 {
    let fronts = openings.iter().filter_map(|opening| {
        let corners = opening
            .corners
            .map(|corner| frame.to_local(corner.as_dvec3()));
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        (normal.dot(corners[0]) < 0.0).then(|| point_to_triangle(corners))
    });
    fronts.sum()
}
