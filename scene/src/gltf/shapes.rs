//! The shapes of bodies that stand in for lights.

use std::f64::consts::PI;

use glam::DVec3;

/// Corners of a disc.
const DISC: u32 = 16;

/// A polyhedron of 80 triangles, of the area of a sphere of this radius.
pub(super) fn sphere(centre: DVec3, radius: f64) -> Vec<[DVec3; 3]> {
    let unit: Vec<[DVec3; 3]> = icosahedron()
        .into_iter()
        .flat_map(|[a, b, c]| {
            let [ab, bc, ca] = [a + b, b + c, c + a].map(DVec3::normalize);
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        })
        .collect();
    let area = |[a, b, c]: &[DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
    let area: f64 = unit.iter().map(area).sum();
    let scale = radius * (4.0 * PI / area).sqrt();
    let place = |corners: [DVec3; 3]| corners.map(|corner| centre + scale * corner);
    unit.into_iter().map(place).collect()
}

/// The faces of an icosahedron with corners on the unit sphere: a corner at each pole, and two rings of five between them.
fn icosahedron() -> Vec<[DVec3; 3]> {
    // The rings' latitude: atan(1/2).
    let (height, radius) = (1.0 / 5f64.sqrt(), 2.0 / 5f64.sqrt());
    let ring = |k: u32, half: f64, height: f64| {
        let (sin, cos) = (2.0 * PI * (f64::from(k % 5) + half) / 5.0).sin_cos();
        DVec3::new(radius * cos, radius * sin, height)
    };
    let (top, bottom) = (DVec3::Z, DVec3::NEG_Z);
    let faces = |k: u32| {
        let [a, b] = [k, k + 1].map(|k| ring(k, 0.0, height));
        let [c, d] = [k, k + 1].map(|k| ring(k, 0.5, -height));
        [[top, a, b], [a, c, b], [b, c, d], [bottom, d, c]]
    };
    (0..5).flat_map(faces).collect()
}

/// A regular polygon across an axis, of the area of a disc of this radius.
pub(super) fn disc(centre: DVec3, axis: DVec3, radius: f64) -> Vec<[DVec3; 3]> {
    let step = 2.0 * PI / f64::from(DISC);
    let scale = radius * (2.0 * PI / (f64::from(DISC) * step.sin())).sqrt();
    let (x, y) = axis.any_orthonormal_pair();
    let corner = |k: u32| {
        let (sin, cos) = (step * f64::from(k % DISC)).sin_cos();
        centre + scale * (cos * x + sin * y)
    };
    (0..DISC)
        .map(|k| [centre, corner(k), corner(k + 1)])
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area_vector([a, b, c]: &[DVec3; 3]) -> DVec3 {
        0.5 * (b - a).cross(c - a)
    }

    #[test]
    fn spheres_are_closed_face_outwards_and_have_the_area_of_a_sphere() {
        let centre = DVec3::new(1.0, 2.0, 3.0);
        let triangles = sphere(centre, 0.5);
        assert_eq!(triangles.len(), 80);
        let sum: DVec3 = triangles.iter().map(area_vector).sum();
        assert!(sum.length() < 1e-12, "{sum}");
        for triangle in &triangles {
            assert!(area_vector(triangle).dot(triangle[0] - centre) > 0.0);
        }
        let area: f64 = triangles.iter().map(|t| area_vector(t).length()).sum();
        assert!((area - PI).abs() < 1e-12, "{area}");
    }

    #[test]
    fn discs_face_along_their_axis_and_have_the_area_of_a_disc() {
        let axis = DVec3::new(1.0, -2.0, 0.5).normalize();
        let sum: DVec3 = disc(DVec3::ONE, axis, 2.0).iter().map(area_vector).sum();
        assert!((sum - 4.0 * PI * axis).length() < 1e-12, "{sum}");
    }
}
