//! Points at which a function is compared with what is gathered there, drawn by chance.

use glam::DVec3;
use scene::function::NodeId;
use scene::{PatchId, SurfaceId};

use super::gatherer::{Light, Look};
use super::vertices::Place;
use crate::receivers::mixed;

/// A part of the scene whose values are of one kind.
#[derive(Clone, Copy, Debug)]
pub(super) enum Part {
    /// Linear between the vertices of a leaf.
    Leaf(NodeId),
    /// One value: this reflected radiosity, W/m^2.
    Patch(PatchId, DVec3),
}

/// A triangle in which points may be drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub part: Part,
    pub surface: SurfaceId,
    /// Those of the leaf or patch, as barycentric coordinates in the surface.
    pub corners: [DVec3; 3],
    /// Its own, as barycentric coordinates in the leaf or patch.
    pub in_part: [DVec3; 3],
    /// Its own, m^2.
    pub area: f64,
}

/// A point at which the function is compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Check {
    pub place: Place,
    pub part: Part,
    /// Barycentric coordinates in the leaf or patch.
    pub within: [f64; 3],
    /// The area that it stands for, m^2: that of the triangle it was drawn in, over the number of points expected there.
    pub area: f64,
}

/// Points, and what was found there.
#[derive(Clone, Debug, Default)]
pub(super) struct Sample {
    pub checks: Vec<Check>,
    /// What they receive.
    pub lights: Vec<Light>,
    /// What some of them see when they look a second time, by their index.
    pub looks: Vec<(usize, Look)>,
}

impl Sample {
    /// One sample of both, in which points stand for the less the more there are.
    #[must_use]
    pub fn and(mut self, mut other: Self) -> Self {
        let counts = [&self, &other].map(|sample| sample.checks.len() as f64);
        let all = counts[0] + counts[1];
        for (sample, count) in [&mut self, &mut other].into_iter().zip(counts) {
            for check in &mut sample.checks {
                check.area *= count / all;
            }
        }
        let before = self.checks.len();
        self.checks.append(&mut other.checks);
        self.lights.append(&mut other.lights);
        let looks = other.looks.iter();
        self.looks
            .extend(looks.map(|&(k, look)| (before + k, look)));
        self
    }
}

/// So many points; other rounds have other ones. Each measure, of which candidates have some, draws as many, and each candidate as
/// many of them as it has of the measure.
pub(super) fn draw<const N: usize>(
    candidates: &[(Candidate, [f64; N])],
    count: usize,
    round: u32,
) -> Vec<Check> {
    let mut sums = [0.0; N];
    for (_, measures) in candidates {
        for (sum, measure) in sums.iter_mut().zip(measures) {
            *sum += measure;
        }
    }
    let measured = sums.iter().filter(|sum| **sum > 0.0).count() as f64;
    let mut checks = Vec::with_capacity(count);
    let all = count as f64;
    let mut drawn = 0.0;
    for (candidate, measures) in candidates {
        let of_sums = measures.iter().zip(sums).filter(|(_, sum)| *sum > 0.0);
        let share = of_sums.map(|(measure, sum)| measure / sum).sum::<f64>() / measured;
        drawn += share;
        loop {
            let next = checks.len();
            // One in each of as many equal steps.
            if next == count || next as f64 + chance(next, round, 0) >= drawn * all {
                break;
            }
            let [u, v] = [1, 2].map(|k| chance(next, round, k));
            let root = u.sqrt();
            let of_corners = |corners: [DVec3; 3], weights: DVec3| -> DVec3 {
                (0..3).map(|k| weights[k] * corners[k]).sum()
            };
            let within = DVec3::new(1.0 - root, root * (1.0 - v), root * v);
            let within = of_corners(candidate.in_part, within);
            checks.push(Check {
                place: Place {
                    surface: candidate.surface,
                    barycentric: of_corners(candidate.corners, within),
                },
                part: candidate.part,
                within: within.to_array(),
                area: candidate.area / (share * all),
            });
        }
    }
    checks
}

/// A number from 0 to 1 that is as good as chance, the same each time.
fn chance(check: usize, round: u32, which: u64) -> f64 {
    let state = (check as u64) << 34 ^ u64::from(round) << 2 ^ which;
    (mixed(mixed(state)) >> 11) as f64 / (1_u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Points have a candidate's share, and stand for its area, whatever share that is: 1,000 points by steps are
    /// within one of their number, and areas of as many within a thousandth of what a candidate's one is.
    #[test]
    fn points_stand_for_the_area_they_are_drawn_in() {
        let parts = [(0.7, 1.0), (0.05, 5.0), (0.25, 0.1)];
        let candidates = parts.map(|(share, area)| {
            let candidate = Candidate {
                part: Part::Patch(PatchId(0), DVec3::splat(area)),
                surface: SurfaceId(0),
                corners: [DVec3::X, DVec3::Y, DVec3::Z],
                in_part: [DVec3::X, DVec3::Y, DVec3::Z],
                area,
            };
            (candidate, [7.0 * share, 0.0])
        });
        let checks = draw(&candidates, 1000, 7);
        assert_eq!(checks.len(), 1000);
        for (share, area) in parts {
            let is_here = |check: &&Check| matches!(check.part, Part::Patch(_, of) if of == DVec3::splat(area));
            let here: Vec<&Check> = checks.iter().filter(is_here).collect();
            assert!(
                (here.len() as f64 - 1000.0 * share).abs() <= 1.0,
                "{}",
                here.len()
            );
            let sum: f64 = here.iter().map(|check| check.area).sum();
            assert!((sum / area - 1.0).abs() <= 1.0 / (1000.0 * share), "{sum}");
            for check in here {
                let place = check.place.barycentric;
                assert!(place.min_element() >= 0.0 && (place.element_sum() - 1.0).abs() < 1e-12);
            }
        }
    }
}
