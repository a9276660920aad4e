//! View factors as near as is asked for.
//!
//! They are drawn coarsely at first, and then once more, until they are near enough: with twice the resolution, or at about four times as
//! many points, whichever brings most of the error. Either takes four times the work, so that the last time takes three quarters of all.
//!
//! # Error
//! Some patches that are looked at more closely tell what all rows have in common only where that is more than their scatter. What view
//! factors changed by tells it, too: an error e that falls to e/2 has changed by e/2, independent ones by 1.1 e, and one that falls to
//! e/4 by 3/4 e, so that half of the change is 0.4 to 1.5 of what is left. The larger one of both counts.

use std::io;
use std::time::{Duration, Instant};

use scene::Scene;
use serde::Serialize;
use visibility::hemicube::MAX_RESOLUTION;

use super::{ViewFactors, view_factors};
use crate::form_factors::{Closely, FormFactors, Needed};
use crate::row_cache::RowCache;
use crate::settings::{FormFactorSettings, Points};

/// How many times as much work it is to draw all once more.
const MORE: u32 = 4;

/// Pixels that may be drawn at a time: about a minute's work of a core, whatever it may be.
const MOST_PIXELS: u64 = 1 << 37;

/// What is left of an error, as a share of what it has changed by.
const LEFT: f64 = 0.5;

/// The share of the squared error that pixels bring from which on they are what is to be finer.
const MOSTLY: f64 = 0.5;

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Asked {
    /// The largest error of all view factors together, relative, see [`super`].
    pub error: f64,
    /// By what they are drawn first.
    pub first: FormFactorSettings,
    /// Whether resolution and points are given, and stay as they are.
    pub is_resolution_given: bool,
    /// As above.
    pub are_points_given: bool,
}

/// View factors, and what they were made by.
pub struct AsNear<'a> {
    /// With their errors.
    pub view_factors: ViewFactors,
    /// Of these settings.
    pub form_factors: FormFactors<'a>,
    /// The rows of all patches.
    pub rows: RowCache<'a>,
    /// What is said of them.
    pub report: ViewFactorsReport,
}

/// How near view factors are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ViewFactorsReport {
    /// The error that was asked for, relative.
    pub asked: f64,
    /// What it is estimated to be.
    pub error: f64,
    /// Whether that is as small as was asked for.
    pub is_reached: bool,
    /// Why they are not nearer.
    pub stopped_by: ViewFactorsEnd,
    /// Pixels along a hemicube's face.
    pub resolution: u32,
    /// Where a patch's hemicubes stand.
    pub points: Points,
}

/// Why view factors are not nearer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum ViewFactorsEnd {
    /// They are as near as was asked for.
    Error,
    /// Resolution and points are given, or as many as there may be.
    Given,
    /// It would take too much work.
    Work,
    /// It would take too long.
    TimeLimit,
}

impl ViewFactorsReport {
    /// A line for people.
    pub fn describe(&self) -> String {
        let why = match self.stopped_by {
            ViewFactorsEnd::Error => "",
            ViewFactorsEnd::Given => "; more than was asked for, with pixels and points as given",
            ViewFactorsEnd::Work => "; more than was asked for, which takes too many pixels",
            ViewFactorsEnd::TimeLimit => "; more than was asked for, stopped by --time-limit",
        };
        let percent = 100.0 * self.error;
        // Two digits that tell something.
        let digits = (1.0 - percent.max(1e-6).log10().floor()).clamp(2.0, 6.0) as usize;
        format!(
            "{percent:.digits$} % of view factors, rms by area; {} pixels, points {}{why}",
            self.resolution, self.points
        )
    }
}

/// The view factors between a scene's objects with at most the error that is asked for, or as near as they get before it is
/// late. `form_factors` are those of the scene, by whatever settings.
///
/// # Errors
/// What a back end says; [`io::ErrorKind::Interrupted`] where it is cancelled.
pub fn as_near_as<'a>(
    asked: Asked,
    scene: &'a Scene,
    form_factors: FormFactors<'a>,
    is_late: &dyn Fn(Duration) -> bool,
) -> io::Result<AsNear<'a>> {
    let mut form_factors = form_factors.with_settings(asked.first);
    let mut before: Option<ViewFactors> = None;
    loop {
        let start = Instant::now();
        let mut rows = form_factors.rows(Needed::All).map_err(io::Error::other)?;
        form_factors = form_factors.after(&rows);
        let view_factors = view_factors(scene, &form_factors, &mut rows)?;
        let sampled = view_factors.mean_error(&view_factors.errors);
        let changed = before.map(|before| view_factors.mean_error(&view_factors.changes(&before)));
        let error = sampled.max(LEFT * changed.unwrap_or(0.0));
        let settings = form_factors.settings();
        let hemicubes = rows.statistics().hemicubes;
        let is_near = error <= asked.error;
        let finer = if is_near && changed.is_some() {
            None
        } else {
            let by_pixels = view_factors.errors_by(&form_factors, Closely::Pixels);
            let by_pixels = view_factors.mean_error(&by_pixels.map_err(io::Error::other)?);
            let are_pixels = by_pixels.powi(2) > MOSTLY * sampled.powi(2);
            let points = hemicubes as f64 / f64::from(scene.patch_count());
            finer(settings, are_pixels, points, asked)
        };
        let pixels = hemicubes * 3 * u64::from(settings.resolution).pow(2);
        let stopped_by = match finer {
            None if is_near => ViewFactorsEnd::Error,
            None => ViewFactorsEnd::Given,
            Some(_) if u64::from(MORE) * pixels > MOST_PIXELS => ViewFactorsEnd::Work,
            Some(_) if is_late(MORE * start.elapsed()) => ViewFactorsEnd::TimeLimit,
            Some(finer) => {
                form_factors = form_factors.with_settings(finer);
                before = Some(view_factors);
                continue;
            }
        };
        let report = ViewFactorsReport {
            asked: asked.error,
            error,
            is_reached: is_near,
            stopped_by,
            resolution: settings.resolution,
            points: settings.points,
        };
        return Ok(AsNear {
            view_factors,
            form_factors,
            rows,
            report,
        });
    }
}

/// The next finer settings: with more pixels if these are most of the error, else with more points than these on the mean.
fn finer(
    settings: FormFactorSettings,
    are_pixels: bool,
    points: f64,
    asked: Asked,
) -> Option<FormFactorSettings> {
    let can_pixels = !asked.is_resolution_given && 2 * settings.resolution <= MAX_RESOLUTION;
    let more_points = match settings.points {
        _ if asked.are_points_given => None,
        Points::CENTROID => Some(Points::Auto),
        _ => three_point(f64::from(MORE) * points),
    };
    match more_points {
        Some(points) if !are_pixels || !can_pixels => {
            Some(FormFactorSettings { points, ..settings })
        }
        _ if can_pixels => Some(FormFactorSettings {
            resolution: 2 * settings.resolution,
            ..settings
        }),
        _ => None,
    }
}

/// The least three-point rule of so many points; `None` where there may not be as many.
fn three_point(count: f64) -> Option<Points> {
    let bisections = (count / 3.0).log2().ceil().max(0.0) as u32;
    (bisections <= Points::MAX_BISECTIONS).then_some(Points::ThreePoint { bisections })
}
