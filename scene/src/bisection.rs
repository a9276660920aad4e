//! Newest-vertex bisection of a triangle, in barycentric coordinates.
//!
//! # Theory
//! A triangle (p0, p1, p2) with reference edge p0 p1 is cut at that edge's midpoint m into
//! (p0, p2, m) and (p2, p1, m): each child's reference edge is the side opposite the new corner m
//! (Mitchell, "A comparison of adaptive refinement techniques for elliptic problems", ACM TOMS
//! 1989, section 2). Every child has exactly half its parent's area, and only four shapes, up to
//! scale, occur below a root. The curve that enters the parent at p0 and leaves it at p1 passes
//! p2, from the first child to the second: leaves in their order follow a Sierpinski curve, and
//! each shares an edge with the next.
//!
//! A point with barycentric coordinates (a, b, c) lies in the first child if a >= b, where its
//! coordinates are (a - b, c, 2b), and else in the second, where they are (c, b - a, 2a). No
//! geometry is needed on the way down.
//!
//! # Practice
//! The leaf after `depth` bisections is named by a code of `depth` bits, the first decision in the
//! highest bit, 0 for the first child; an inner node's leaves are a contiguous range of codes.
//! Each bisection turns the orientation round, so after an odd number of them the first two corners
//! of a leaf are exchanged: what callers see always has the root's orientation.

use glam::DVec3;

/// The most bisections below a root: 2^23 leaves stay under [`crate::MAX_PATCHES`].
pub const MAX_BISECTIONS: u32 = 23;

/// Code of the leaf that holds the point, `depth` bisections down.
///
/// The point's barycentric coordinates need not sum to 1; points outside the root are assigned to
/// a leaf on its border.
#[inline]
pub fn leaf_code(depth: u32, barycentric: [f32; 3]) -> u32 {
    locate(depth, barycentric).0
}

/// Code of the leaf that holds the point, and the point's barycentric coordinates in that leaf
/// (they sum to what the given ones sum to).
#[inline]
pub fn locate(depth: u32, [mut a, mut b, mut c]: [f32; 3]) -> (u32, [f32; 3]) {
    let mut code = 0;
    for _ in 0..depth {
        let second = a < b;
        let difference = (a - b).abs();
        let newest = 2.0 * a.min(b);
        (a, b) = if second {
            (c, difference)
        } else {
            (difference, c)
        };
        c = newest;
        code = code << 1 | u32::from(second);
    }
    if depth.is_multiple_of(2) {
        (code, [a, b, c])
    } else {
        (code, [b, a, c])
    }
}

/// Corners of a leaf, as barycentric coordinates in the root.
///
/// They are dyadic fractions, hence exact.
pub fn leaf_corners(depth: u32, code: u32) -> [DVec3; 3] {
    let [mut p0, mut p1, mut p2] = [DVec3::X, DVec3::Y, DVec3::Z];
    for level in (0..depth).rev() {
        let middle = 0.5 * (p0 + p1);
        if code >> level & 1 == 0 {
            p1 = p2;
        } else {
            p0 = p2;
        }
        p2 = middle;
    }
    if depth.is_multiple_of(2) {
        [p0, p1, p2]
    } else {
        [p1, p0, p2]
    }
}

/// The fewest bisections after which a triangle of `area` has leaves of at most `max_area`, both
/// in m^2; `None` where that is more than [`MAX_BISECTIONS`].
pub fn bisections_for(area: f64, max_area: f64) -> Option<u32> {
    (0..=MAX_BISECTIONS).find(|&depth| area / f64::from(1_u32 << depth) <= max_area)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Exact containment: the inputs are multiples of 2^-12 and depth is at most 10, so every
    /// product below is exact in f64.
    fn contains(corners: [DVec3; 3], point: DVec3) -> bool {
        let side = |p: DVec3, q: DVec3| {
            let (e, d) = (q - p, point - p);
            e.x * d.y - e.y * d.x
        };
        let [p0, p1, p2] = corners;
        // In the (a, b) plane the root X, Y, Z is counter-clockwise.
        side(p0, p1) >= 0.0 && side(p1, p2) >= 0.0 && side(p2, p0) >= 0.0
    }

    proptest! {
        #[test]
        fn located_leaf_is_the_one_found_by_brute_force(
            depth in 0_u32..=10, i in 1_u32..4096, j in 1_u32..4096
        ) {
            prop_assume!(i + j < 4096);
            let unit = 1.0 / 4096.0;
            let (a, b) = (f64::from(i) * unit, f64::from(j) * unit);
            let point = DVec3::new(a, b, 1.0 - a - b);
            let code = leaf_code(depth, point.as_vec3().to_array());
            let holders: Vec<u32> =
                (0..1 << depth).filter(|&c| contains(leaf_corners(depth, c), point)).collect();
            prop_assert!(holders.contains(&code), "{code} not in {holders:?}");
        }

        #[test]
        fn local_coordinates_lead_back_to_the_point(
            depth in 0_u32..=10, i in 1_u32..4096, j in 1_u32..4096
        ) {
            prop_assume!(i + j < 4096);
            let unit = 1.0 / 4096.0;
            let (a, b) = (f64::from(i) * unit, f64::from(j) * unit);
            let point = DVec3::new(a, b, 1.0 - a - b);
            let (code, [u, v, w]) = locate(depth, point.as_vec3().to_array());
            let [p0, p1, p2] = leaf_corners(depth, code);
            let again = f64::from(u) * p0 + f64::from(v) * p1 + f64::from(w) * p2;
            prop_assert_eq!(again, point); // all numbers are dyadic: no rounding
        }
    }

    #[test]
    fn children_halve_their_parent_exactly() {
        for depth in 0..=12 {
            for code in 0..1 << depth {
                let [p0, p1, p2] = leaf_corners(depth, code);
                let (e, f) = (p1 - p0, p2 - p0);
                // Positive: counter-clockwise in the (a, b) plane, as the root is.
                let double_area = e.x * f.y - e.y * f.x;
                assert!(double_area.to_bits() == 0.5_f64.powi(depth as i32).to_bits());
            }
        }
    }

    #[test]
    fn consecutive_leaves_share_an_edge() {
        let depth = 9;
        for code in 1..1 << depth {
            let before = leaf_corners(depth, code - 1);
            let shared = leaf_corners(depth, code)
                .iter()
                .filter(|p| before.contains(p))
                .count();
            assert!(
                shared == 2,
                "leaves {} and {code} share {shared} corners",
                code - 1
            );
        }
    }

    #[test]
    fn shapes_stay_within_the_four_similarity_classes() {
        let root = [
            DVec3::new(0.0, 0.0, 0.0),
            DVec3::new(2.0, 0.0, 0.0),
            DVec3::new(0.7, 0.9, 0.0),
        ];
        let mut shapes: Vec<[i64; 3]> = (0..1 << 9)
            .map(|code| {
                let corners =
                    leaf_corners(9, code).map(|w| w.x * root[0] + w.y * root[1] + w.z * root[2]);
                let mut sides = [0, 1, 2].map(|k| corners[k].distance(corners[(k + 1) % 3]));
                sides.sort_by(f64::total_cmp);
                sides.map(|s| (s / sides[2] * 1e6).round() as i64)
            })
            .collect();
        shapes.sort_unstable();
        shapes.dedup();
        assert!(shapes.len() <= 4, "{shapes:?}");
    }
}
