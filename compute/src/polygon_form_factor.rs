//! The exact form factor from a point to a polygon: Lambert's formula.
//!
//! F = sum_k G_k . n / (2 pi), over the edges of the polygon, with G_k the vector along q_k x q_{k+1} as
//! long as the angle between q_k and q_{k+1} (radians); q_k are the corners relative to the point, n is the
//! receiver's normal (Lambert, Photometria, 1760; as in Baum, Rushmeier, Winget, "Improving radiosity
//! solutions through the use of analytically determined form-factors", SIGGRAPH 1989, section 3). It holds
//! for what lies above the receiver's horizon, so the polygon is clipped there first.

use std::f64::consts::TAU;

use glam::DVec3;
use scene::planar::clip;

/// Form factor, dimensionless, from a point to a triangle that nothing hides, seen from its front or its
/// back alike. `corners` are in the receiver's frame, relative to the point, with z along its normal.
pub fn point_to_triangle(corners: [DVec3; 3]) -> f64 {
    point_to_polygon(&in_front(&corners, DVec3::Z))
}

/// The same to a plane convex polygon of which nothing lies below the horizon.
pub fn point_to_polygon(corners: &[DVec3]) -> f64 {
    let count = corners.len();
    let sum: f64 = (0..count)
        .map(|k| edge_term(corners[k], corners[(k + 1) % count], DVec3::Z))
        .sum();
    sum.abs() / TAU
}

/// G . n of one edge, its ends relative to the point.
pub fn edge_term(p: DVec3, q: DVec3, normal: DVec3) -> f64 {
    let cross = p.cross(q);
    let sin = cross.length();
    // An edge whose line passes the point: it turns about nothing.
    if sin == 0.0 {
        return 0.0;
    }
    sin.atan2(p.dot(q)) * cross.dot(normal) / sin
}

/// The part of a convex polygon on the side of a plane through the point to which `normal` points.
pub fn in_front(corners: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    clip(corners, |p| p.dot(normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn rectangle(low: DVec3, u: DVec3, v: DVec3) -> f64 {
        let corners = [low, low + u, low + u + v, low + v];
        point_to_triangle([corners[0], corners[1], corners[2]])
            + point_to_triangle([corners[0], corners[2], corners[3]])
    }

    /// Howell, catalogue of radiation configuration factors, B-3 (element to parallel rectangle with a
    /// corner above it), a = b = c: 2 X/sqrt(1+X^2) atan(X/sqrt(1+X^2)) / (2 pi), X = 1. The formula is
    /// exact; f64 leaves 1e-14.
    #[test]
    fn parallel_square_over_its_corner_is_the_catalogues() {
        let s = 2.0_f64.sqrt();
        let expected = 2.0 / s * (1.0 / s).atan() / TAU;
        assert!((rectangle(DVec3::Z, DVec3::X, DVec3::Y) - expected).abs() < 1e-14);
    }

    /// A disk of radius r at distance h, seen from below its centre: r^2 / (r^2 + h^2). A regular n-gon
    /// inscribed in it has sin(t)/t of its area, t = 2 pi/n, and so at least that share of the factor.
    #[test]
    fn many_triangles_make_a_disk() {
        let n = 2000;
        let at = |k: usize| {
            let angle = TAU * k as f64 / n as f64;
            DVec3::new(angle.cos(), angle.sin(), 1.0)
        };
        let sum: f64 = (0..n)
            .map(|k| point_to_triangle([DVec3::Z, at(k), at(k + 1)]))
            .sum();
        let t = TAU / n as f64;
        assert!(sum < 0.5 && sum > 0.5 * t.sin() / t, "{sum}");
    }

    #[test]
    fn what_is_below_the_horizon_counts_nothing() {
        // An upright square, half of it below the horizon, and its upper half alone.
        let whole = rectangle(DVec3::new(1.0, -1.0, -1.0), DVec3::Y * 2.0, DVec3::Z * 2.0);
        let upper = rectangle(DVec3::new(1.0, -1.0, 0.0), DVec3::Y * 2.0, DVec3::Z);
        assert!(
            (whole - upper).abs() < 1e-14 && upper > 0.1,
            "{whole} {upper}"
        );
        let below = rectangle(DVec3::new(1.0, -1.0, -2.0), DVec3::Y, DVec3::Z);
        assert!(below.abs() < 1e-15);
    }

    /// An infinite half plane's worth of wall covers half of the hemisphere by cosine: 1/2.
    #[test]
    fn endless_wall_covers_half() {
        let far = 1e6;
        let wall = rectangle(
            DVec3::new(1.0, -far, -far),
            DVec3::Y * 2.0 * far,
            DVec3::Z * 2.0 * far,
        );
        assert!((wall - 0.5).abs() < 4.0 / (PI * far), "{wall}");
    }
}
