//! What a run can certify about its own form factors, without knowing the exact ones.
//!
//! # Theory
//! Exact form factors obey two laws. A row sums to 1 less what its patch sees of openings (closure).
//! And what all patches send to patch j, by reciprocity A_i F_ij = A_j F_ji, is what j sees of them:
//!
//! sum_i A_i F_ij = A_j sum_i F_ji
//!
//! (Cohen and Wallace, "Radiosity and realistic image synthesis", 1993). The left side is
//! sampled by everybody else's hemicubes, the right side by j's own, so their relative difference,
//! over the larger of the two, is an error of the form factors that normalising rows cannot hide. Its
//! root mean square over the patches, by area, is the aggregated reciprocity error. Errors that both
//! sides share, as in a symmetric scene, do not show.
//!
//! The backs of surfaces are black. A patch that sees one loses power to a leak or to wrong winding.
//! Patches that no other patch sees, but by chance (the floor below a box, the bottom of the box) have no part in
//! the exchange, whatever they see; they are left out of the shares of openings and of back faces.
//!
//! # Practice
//! Sums over rows are integers, which do not depend on the order in which rows are drawn, nor on
//! threads; each row counts once. Who is to blame is found by drawing a few hemicubes again.

mod culprit;
mod exchange;
mod inside;
mod openings;

use std::ops::Range;

use scene::{PatchId, Scene};
use serde::Serialize;

use crate::row_cache::RowCache;
use crate::rows::UNITS_PER_ONE;
use crate::sources::{SourceId, Sources};
use culprit::{Loss, culprit};
use exchange::Exchange;

pub use inside::inside;

/// A scene looks closed when its patches see less than this of openings, dimensionless: a convex room's
/// do when holes take less than this share of its walls, and what is left open on purpose is larger.
pub const LOOKS_CLOSED: f64 = 0.02;

/// The most that the patches of a scene that looks closed may see of openings, dimensionless, and of backs before it is told. Walls
/// that share corners leak nothing at all; this leaves room for a few pixels between walls that meet
/// within rounding only.
pub const OPEN_SHARE_TOLERANCE: f64 = 1e-6;

/// The most that patches may see of back faces, dimensionless. Back faces are black, so this is also
/// the relative error that they may bring to an irradiance: as much as unoccluded form factors may
/// have.
pub const BACK_FACE_SHARE_TOLERANCE: f64 = 1e-3;

/// The most by which power emitted and power absorbed and lost may differ, relative to that emitted. Both
/// what is not converged and what is not reciprocal shows here, and neither may move the scene's mean
/// radiosity by more than a percent.
pub const IMBALANCE_TOLERANCE: f64 = 0.01;

/// A patch of which others see less than this share of what it sees itself is seen by chance: by rays that
/// meet a common edge of what hides it, which belongs to all that share it.
const SEEN_BY_CHANCE: f64 = 1e-3;

/// The most by which a patch's form factors and what it sees of openings and backs may miss 1, together,
/// dimensionless. They are integers that do not miss it at all; this leaves room for rounding them a
/// few thousand times.
pub const CLOSURE_TOLERANCE: f64 = 1e-6;

/// The most for the aggregated reciprocity error, dimensionless. Tuned: a box, a columned room and fine
/// meshes of the Cornell box, whose power balances are right to half a percent, have 0.6 to 2.8 percent; a
/// coarser Cornell box, off by 2.7 percent, has 6.5; one of a few large patches, off by 25, has 19.
pub const RECIPROCITY_TOLERANCE: f64 = 0.05;

/// What a run knows of the quality of its form factors and of its solution.
#[derive(Clone, Debug, Serialize)]
pub struct Certificate {
    /// Rows drawn or read in this run. Unless all rows of lit patches are drawn, the figures that need all of them are null.
    /// Patches that no light can reach have no part in the exchange.
    pub rows_drawn: u32,
    /// Patches that no other patch sees, of those that light can reach; null unless all rows of these were drawn.
    pub hidden_patches: Option<u32>,
    /// Which these are, ascending; empty where they are not known.
    #[serde(skip)]
    pub hidden: Vec<PatchId>,
    /// Patches that lie inside of solids or behind walls: most of what they see is backs and openings, and they neither emit
    /// nor are lit; null as above, and before the solution is near its end.
    pub inside_patches: Option<u32>,
    /// Mean share of a hemisphere that sees nothing, by area, of the patches that are neither hidden nor inside of solids; null
    /// where no row was drawn.
    pub open_share: Option<f64>,
    /// As much of it as openings that are meant may account for; null where none is.
    pub meant_open_share: Option<f64>,
    /// The same as `open_share` of back faces.
    pub back_face_share: Option<f64>,
    /// Whether `open_share`, without what is meant, is below [`LOOKS_CLOSED`].
    pub looks_closed: Option<bool>,
    /// Largest |row sum + openings + back faces - 1| of a patch whose row was drawn, dimensionless.
    pub closure_error: f64,
    /// Null unless all rows were drawn, but for those of unlit patches.
    pub reciprocity: Option<Reciprocity>,
    /// Openings of a scene that looks closed, without those that are meant; null where there are none.
    pub opening: Option<Finding>,
    /// Back faces that patches see; null where there are none.
    pub back_faces: Option<Finding>,
    /// Share of the emitted power that is neither absorbed nor lost; null as in the power balance.
    pub imbalance: Option<f64>,
    /// What is beyond the tolerances of `--strict`.
    pub violations: Vec<String>,
}

/// How well A_j sum_i F_ji and sum_i A_i F_ij agree. Relative differences are over the larger one.
#[derive(Clone, Debug, Serialize)]
pub struct Reciprocity {
    /// Root mean square of the relative difference, by area, dimensionless.
    pub rms: f64,
    /// The patch with the largest relative difference; where sources are coarser, the first one of the source that has
    /// it.
    pub worst_patch: u32,
    /// What it is part of.
    pub worst_object: String,
    /// (received - sent) over the larger, dimensionless, -1 to 1: positive where the others see more of
    /// the patch than it sees of them.
    pub worst: f64,
}

/// Where power is lost, and the likely cause.
#[derive(Clone, Debug, Serialize)]
pub struct Finding {
    /// Mean share of a hemisphere, by area, dimensionless.
    pub share: f64,
    /// The object whose backs are seen most, or whose fronts border most on the opening; null where
    /// drawing again has not met any.
    pub culprit: Option<String>,
    /// The patch that loses most.
    pub worst_patch: u32,
    /// What it is part of.
    pub worst_object: String,
    /// Share of its hemisphere, dimensionless.
    pub worst_share: f64,
}

/// What is known of a solution, beside its rows.
#[derive(Clone, Copy, Debug, Default)]
pub struct Known<'k> {
    /// What [`inside`] tells.
    pub inside: Option<&'k [PatchId]>,
    /// See [`Energy::imbalance`](crate::energy::Energy::imbalance).
    pub imbalance: Option<f64>,
    /// The last one of its iteration, relative.
    pub residual: Option<f64>,
    /// Whether the error of its function was estimated: that then stands for what is not reciprocal and not balanced.
    pub has_estimate: bool,
    /// What receivers are made of, where patches are finer than those that the rows are of.
    pub patches: Option<&'k Sources<'k>>,
}

impl Known<'_> {
    /// The patches that a receiver is made of.
    pub fn patches_in(&self, receiver: usize) -> Range<u32> {
        let receiver = receiver as u32;
        match self.patches {
            Some(patches) => patches.patches_in(SourceId(receiver)),
            None => receiver..receiver + 1,
        }
    }
}

/// What the rows drawn so far certify.
pub fn certify(rows: &RowCache, known: Known) -> Certificate {
    let Known {
        inside, imbalance, ..
    } = known;
    let scene = rows.sources().patches();
    let areas = scene.patch_areas();
    let exchange = Exchange::new(rows, &areas);
    let rows_drawn = rows.unseen().iter().flatten().count() as u32;
    let lit = rows.lit_count();
    let all_drawn = rows_drawn == lit;
    let is_seen = |j: usize| exchange.is_seen[j];
    let hidden = (0..areas.len())
        .filter(|&j| !rows.unlit()[j] && !is_seen(j))
        .collect::<Vec<usize>>();
    // Where nobody sees anybody, as around a solid, there is no exchange to be left out of.
    let leave_out_hidden = all_drawn && (hidden.len() as u32) < lit;
    let hidden: Vec<PatchId> = hidden
        .into_iter()
        .filter(|_| all_drawn)
        .flat_map(|j| known.patches_in(j).map(PatchId))
        .collect();
    let is_inside = |j: usize| {
        let patch = PatchId(j as u32);
        inside.is_some_and(|inside| inside.binary_search(&patch).is_ok())
    };
    let counts = |j: usize| (!leave_out_hidden || is_seen(j)) && !is_inside(j);

    let of_all = |loss| -> Shares { shares(rows, loss).filter(|&(j, _)| counts(j)).collect() };
    let (open, back_faces) = (of_all(Loss::Opening), of_all(Loss::BackFaces));
    let meant = openings::meant(rows);
    let beyond = |&(j, share): &(usize, f64)| {
        let meant = meant.as_ref().map_or(0.0, |meant| meant[j]);
        (j, f64::max(share - meant, 0.0))
    };
    let unmeant: Shares = open.iter().map(beyond).collect();
    let mean = |shares: &Shares| {
        let (mut lost, mut whole) = (0.0, 0.0);
        for &(j, share) in shares {
            lost += areas[j] * share;
            whole += areas[j];
        }
        (whole > 0.0).then(|| lost / whole)
    };
    let [open_share, unmeant_share, back_face_share] = [&open, &unmeant, &back_faces].map(mean);
    let looks_closed = unmeant_share.map(|share| share < LOOKS_CLOSED);

    let find = |loss, mut worst: Shares, share: Option<f64>| {
        let share = share.filter(|&share| share > 0.0)?;
        worst.retain(|&(_, share)| share > 0.0);
        worst.sort_by(|(a, x), (b, y)| y.total_cmp(x).then(a.cmp(b)));
        let &(patch, worst_share) = worst.first()?;
        Some(Finding {
            share,
            culprit: culprit(rows, loss, &worst),
            worst_patch: known.patches_in(patch).start,
            worst_object: object_name(scene, patch),
            worst_share,
        })
    };
    let mut certificate = Certificate {
        rows_drawn,
        hidden_patches: all_drawn.then_some(hidden.len() as u32),
        hidden,
        inside_patches: inside.map(|inside| {
            let patches = inside.iter().map(|j| known.patches_in(j.index()).len());
            patches.sum::<usize>() as u32
        }),
        open_share,
        meant_open_share: meant.and(open_share.zip(unmeant_share).map(|(all, un)| all - un)),
        back_face_share,
        looks_closed,
        closure_error: closure_error(rows),
        reciprocity: (all_drawn && lit > 0).then(|| exchange.reciprocity(rows, &known)),
        opening: if looks_closed == Some(true) {
            find(Loss::Opening, unmeant, unmeant_share)
        } else {
            None
        },
        back_faces: find(Loss::BackFaces, back_faces, back_face_share),
        imbalance,
        violations: Vec::new(),
    };
    certificate.violations = certificate.violations(lit, &known);
    certificate
}

/// Patches and the shares of their hemispheres that they lose.
type Shares = Vec<(usize, f64)>;

/// The share of its hemisphere that each patch loses, of those whose row was drawn.
fn shares(rows: &RowCache, loss: Loss) -> impl Iterator<Item = (usize, f64)> {
    rows.unseen()
        .iter()
        .enumerate()
        .filter_map(move |(j, unseen)| {
            let unseen = (*unseen)?;
            let units = match loss {
                Loss::Opening => unseen.open,
                Loss::BackFaces => unseen.back_face,
            };
            Some((j, f64::from(units) / f64::from(UNITS_PER_ONE)))
        })
}

/// How far any patch's hemisphere is from being accounted for.
fn closure_error(rows: &RowCache) -> f64 {
    shares(rows, Loss::Opening)
        .zip(shares(rows, Loss::BackFaces))
        .map(|((j, open), (_, back_face))| {
            (rows.received().row_sum(j) + open + back_face - 1.0).abs()
        })
        .fold(0.0, f64::max)
}

fn object_name(scene: &Scene, patch: usize) -> String {
    let surface = scene.mesh().surface_of(PatchId(patch as u32));
    scene.object(scene.surface(surface).object).to_owned()
}

impl Certificate {
    fn violations(&self, patches: u32, known: &Known) -> Vec<String> {
        let mut violations = Vec::new();
        if self.rows_drawn < patches {
            violations.push(format!(
                "only {} of {patches} rows of form factors were drawn or read in this run",
                self.rows_drawn
            ));
        }
        if self.closure_error > CLOSURE_TOLERANCE {
            violations.push(format!(
                "a patch's form factors, with openings and back faces, sum to 1 only to {} (at most {})",
                percent(self.closure_error),
                percent(CLOSURE_TOLERANCE)
            ));
        }
        if let Some(finding) = &self.opening
            && finding.share > OPEN_SHARE_TOLERANCE
        {
            violations.push(format!(
                "{} (at most {})",
                finding.opening(),
                percent(OPEN_SHARE_TOLERANCE)
            ));
        }
        if let Some(finding) = &self.back_faces
            && finding.share > BACK_FACE_SHARE_TOLERANCE
        {
            violations.push(format!(
                "{} (at most {})",
                finding.back_faces(),
                percent(BACK_FACE_SHARE_TOLERANCE)
            ));
        }
        if known.has_estimate {
            return violations;
        }
        // Where no iteration is done, form factors are all that is asked for.
        if let Some(imbalance) = self.imbalance
            && let Some(residual) = known.residual
            && imbalance.abs() > IMBALANCE_TOLERANCE
        {
            violations.push(format!(
                "{} of the emitted power is neither absorbed nor lost (at most {}); the residual is {residual:.1e}: \
                 iterate longer, or use more --points or smaller patches",
                percent(imbalance),
                percent(IMBALANCE_TOLERANCE)
            ));
        }
        if let Some(reciprocity) = &self.reciprocity
            && reciprocity.rms > RECIPROCITY_TOLERANCE
        {
            violations.push(format!(
                "the form factors miss reciprocity by {} rms (at most {}), patch {} of \"{}\" by {}: \
                 use a higher resolution, more --points or smaller patches",
                percent(reciprocity.rms),
                percent(RECIPROCITY_TOLERANCE),
                reciprocity.worst_patch,
                reciprocity.worst_object,
                percent(reciprocity.worst),
            ));
        }
        violations
    }

    /// Openings and back faces that are more than rounding, with the likely culprits.
    pub fn warnings(&self) -> Vec<String> {
        let told = |finding: &&Finding| finding.share > OPEN_SHARE_TOLERANCE;
        let opening = self.opening.as_ref().filter(told).map(Finding::opening);
        let back_faces = self.back_faces.as_ref().filter(told);
        let back_faces = back_faces.map(Finding::back_faces);
        opening.into_iter().chain(back_faces).collect()
    }

    /// One line for people.
    pub fn summary(&self) -> String {
        let mut parts = Vec::new();
        if let Some(share) = self.open_share {
            let meant = self
                .meant_open_share
                .map_or_else(String::new, |meant| format!(" ({} meant)", percent(meant)));
            parts.push(format!("openings {}{meant}", percent(share)));
        }
        if let Some(share) = self.back_face_share {
            parts.push(format!("back faces {}", percent(share)));
        }
        if let Some(reciprocity) = &self.reciprocity {
            parts.push(format!(
                "reciprocity error {} rms, {} at worst",
                percent(reciprocity.rms),
                percent(reciprocity.worst.abs())
            ));
        }
        if let Some(imbalance) = self.imbalance {
            parts.push(format!("imbalance {}", percent(imbalance)));
        }
        parts.push(
            match self.violations.len() {
                0 => "within tolerances",
                _ if self.reciprocity.is_none() => "not all rows drawn",
                _ => "beyond tolerances",
            }
            .to_owned(),
        );
        parts.join(", ")
    }
}

impl Finding {
    fn opening(&self) -> String {
        let culprit = self.culprit.as_ref().map_or_else(String::new, |object| {
            format!(", beside the surfaces of \"{object}\"")
        });
        format!(
            "{} of what patches see is an opening{culprit}, in a scene that looks closed; patch {} of \
             \"{}\" loses most, {}",
            percent(self.share),
            self.worst_patch,
            self.worst_object,
            percent(self.worst_share),
        )
    }

    fn back_faces(&self) -> String {
        let culprit = self
            .culprit
            .as_ref()
            .map_or_else(String::new, |object| format!(", mostly of \"{object}\""));
        format!(
            "{} of what patches see are backs of surfaces{culprit}; patch {} of \"{}\" sees most, {}",
            percent(self.share),
            self.worst_patch,
            self.worst_object,
            percent(self.worst_share),
        )
    }
}

/// A share in percent, to three digits.
fn percent(share: f64) -> String {
    let percent = 100.0 * share;
    match percent.abs() {
        0.0 => "0 %".to_owned(),
        x if x < 1e-3 => format!("{percent:.1e} %"),
        x => {
            let digits = (2.0 - x.log10().floor()).clamp(0.0, 5.0) as usize;
            format!("{percent:.digits$} %")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_show_three_digits() {
        for (share, text) in [
            (0.0, "0 %"),
            (1.0, "100 %"),
            (-0.027_34, "-2.73 %"),
            (0.000_123_4, "0.0123 %"),
            (1e-6, "1.0e-4 %"),
        ] {
            assert_eq!(percent(share), text);
        }
    }
}
