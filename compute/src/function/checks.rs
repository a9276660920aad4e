//! Points at which a function is compared with what is gathered there, drawn by chance.

use glam::DVec3;
use scene::SurfaceId;
use scene::function::NodeId;

use super::vertices::Place;
use crate::receivers::mixed;

/// A part of the scene whose values are of one kind.
#[derive(Clone, Copy, Debug)]
pub(super) enum Part {
    /// Linear between the vertices of a leaf.
    Leaf(NodeId),
    /// One value: this reflected radiosity, W/m^2.
    Patch(DVec3),
}

/// A triangle in which points may be drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Candidate {
    pub part: Part,
    pub surface: SurfaceId,
    /// As barycentric coordinates in the surface.
    pub corners: [DVec3; 3],
    /// m^2.
    pub area: f64,
    /// Of all points, those that are to be here: above 0; all candidates' shares sum to 1 at most.
    pub share: f64,
}

/// A point at which the function is compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Check {
    pub place: Place,
    pub part: Part,
    /// Barycentric coordinates in the triangle that it was drawn in.
    pub within: [f64; 3],
    /// The area that it stands for, m^2: that of its triangle, over the number of points that are expected there.
    pub area: f64,
}

/// So many points, as many in each candidate as its share; other rounds have other points.
pub(super) fn draw(
    candidates: impl Iterator<Item = Candidate>,
    count: usize,
    round: u32,
) -> Vec<Check> {
    let mut checks = Vec::with_capacity(count);
    let all = count as f64;
    let mut sum = 0.0;
    for candidate in candidates {
        sum += candidate.share;
        loop {
            let next = checks.len();
            // One in each of as many equal steps.
            if next == count || next as f64 + chance(next, round, 0) >= sum * all {
                break;
            }
            let [u, v] = [1, 2].map(|k| chance(next, round, k));
            let root = u.sqrt();
            let within = [1.0 - root, root * (1.0 - v), root * v];
            checks.push(Check {
                place: Place {
                    surface: candidate.surface,
                    barycentric: (0..3).map(|k| within[k] * candidate.corners[k]).sum(),
                },
                part: candidate.part,
                within,
                area: candidate.area / (candidate.share * all),
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
        let candidates = parts.iter().map(|&(share, area)| Candidate {
            part: Part::Patch(DVec3::splat(area)),
            surface: SurfaceId(0),
            corners: [DVec3::X, DVec3::Y, DVec3::Z],
            area,
            share,
        });
        let checks = draw(candidates, 1000, 7);
        assert_eq!(checks.len(), 1000);
        for (share, area) in parts {
            let is_here =
                |check: &&Check| matches!(check.part, Part::Patch(of) if of == DVec3::splat(area));
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
