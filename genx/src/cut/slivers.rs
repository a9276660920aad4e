//! How deep surfaces are bisected that a cut has made.
//!
//! Between a lamp and the wall beside it a cut may leave a strip of the ceiling as thin as the gap and as long as the room, whose
//! area asks for no bisection: one patch, lit at one end. So what a cut has made is bisected until it is short as well.

use std::collections::HashSet;

use glam::{DVec3, Vec3};
use scene::Surface;
use scene::bisection::{MAX_BISECTIONS, bisections_for};
use scene::weld::{Place, places};

/// The longest side of a patch of what a cut has made, in square roots of the area threshold; that of half a square is 2.
const LONGEST: f64 = 4.0;

/// Surfaces before a cut, to tell later which it has made.
#[derive(Clone, Debug)]
pub struct Uncut(HashSet<[Place; 3]>);

impl Uncut {
    /// These.
    pub fn new(surfaces: &[Surface]) -> Self {
        Self(
            surfaces
                .iter()
                .map(|surface| places(surface.corners))
                .collect(),
        )
    }

    /// Bisections of each surface for patches of at most `max_area`, m^2, and, where it is another one, short as well; `None`
    /// where they are more than a tree may have.
    pub fn bisections(&self, surfaces: &[Surface], max_area: f64) -> Option<Vec<u32>> {
        let of_surface = |surface: &Surface| {
            let by_area = bisections_for(surface.area(), max_area)?;
            if self.0.contains(&places(surface.corners)) {
                return Some(by_area);
            }
            let by_length = bisections_to(surface, LONGEST * max_area.sqrt());
            Some(by_length.max(by_area).min(MAX_BISECTIONS))
        };
        surfaces.iter().map(of_surface).collect()
    }
}

/// Bisections until no side is longer than this, metres.
fn bisections_to(surface: &Surface, longest: f64) -> u32 {
    let root = surface.with_longest_side_first();
    let mut shapes = vec![root.corners.map(Vec3::as_dvec3)];
    let mut bisections = 0;
    let sides = |[a, b, c]: [DVec3; 3]| [a.distance(b), b.distance(c), c.distance(a)];
    let is_long = |shape: &[DVec3; 3]| sides(*shape).into_iter().any(|side| side > longest);
    while bisections < MAX_BISECTIONS && shapes.iter().any(is_long) {
        let children = shapes.iter().flat_map(|&[a, b, c]| {
            let middle = 0.5 * (a + b);
            [[a, c, middle], [c, b, middle]]
        });
        let mut children: Vec<[DVec3; 3]> = children.collect();
        // Of two alike one will do; there are four at most (see scene::bisection).
        let key =
            |shape: &[DVec3; 3]| sides(*shape).map(|side| (1e6 * side / longest).round() as i64);
        children.sort_by_key(key);
        children.dedup_by_key(|shape| key(shape));
        shapes = children;
        bisections += 1;
    }
    bisections
}

#[cfg(test)]
mod tests {
    use super::*;
    use scene::{MaterialId, ObjectId};

    fn surface(corners: [[f32; 2]; 3]) -> Surface {
        Surface {
            corners: corners.map(|[x, y]| Vec3::new(x, y, 0.0)),
            material: MaterialId(0),
            object: ObjectId(0),
        }
    }

    /// A strip of 4 m x 1 cm with an area of 0.02 m^2: whole by its area, and in pieces of at most 0.57 m once it is cut.
    /// A well-shaped triangle is bisected by its area alone.
    #[test]
    fn what_is_cut_is_short_as_well() {
        let strip = surface([[0.0, 0.0], [4.0, 0.0], [2.5, 0.01]]);
        let half = surface([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
        let surfaces = [strip, half];
        let all = Uncut::new(&surfaces).bisections(&surfaces, 0.02).unwrap();
        assert_eq!(all, [0, 5]);
        let none = Uncut::new(&[]).bisections(&surfaces, 0.02).unwrap();
        assert_eq!(none[1], 5);
        let limit = LONGEST * 0.02_f64.sqrt();
        let root = strip.with_longest_side_first().corners.map(Vec3::as_dvec3);
        let longest = |depth: u32| {
            let leaves = (0..1 << depth).map(|code| {
                let corners = scene::bisection::leaf_corners(depth, code)
                    .map(|w| w.x * root[0] + w.y * root[1] + w.z * root[2]);
                (0..3)
                    .map(|k| corners[k].distance(corners[(k + 1) % 3]))
                    .fold(0.0, f64::max)
            });
            leaves.fold(0.0, f64::max)
        };
        assert!(
            longest(none[0]) <= limit && longest(none[0] - 1) > limit,
            "{none:?}"
        );
        // Each triangle a patch stays what it is.
        let inf = Uncut::new(&[])
            .bisections(&surfaces, f64::INFINITY)
            .unwrap();
        assert_eq!(inf, [0, 0]);
    }
}
