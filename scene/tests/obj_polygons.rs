//! How polygons become triangles.

mod common;

use std::f64::consts::TAU;
use std::fmt::Write;

use common::{folder, load_text};
use glam::{DMat3, DVec2, DVec3};
use proptest::prelude::*;
use scene::import::ImportedModel;

/// The polygon with these corners, in the file's order.
fn import(corners: &[DVec3]) -> ImportedModel {
    let mut text = String::new();
    for p in corners {
        writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
    }
    let face = (1..=corners.len()).fold("f".to_owned(), |f, k| format!("{f} {k}"));
    load_text(&folder(), text + &face + "\n").unwrap()
}

/// Twice the area of a polygon with these corners, above 0 if counter-clockwise.
fn shoelace(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| a.perp_dot(*b)).sum()
}

/// Twice a triangle's area over its squared longest side, up to which a fan may have it face away: coordinates of
/// six digits are off by half of this.
const SLIVER: f64 = 1e-5;

fn in_plane(corners: &[DVec2], axes: DMat3) -> Vec<DVec3> {
    corners.iter().map(|p| axes * p.extend(0.0)).collect()
}

/// Imports a simple polygon from every first corner, both ways round, and checks that triangles
/// cover it once.
fn covered_once(corners: &[DVec2], axes: DMat3) {
    let mut corners = corners.to_vec();
    for _ in 0..2 {
        for _ in 0..corners.len() {
            corners.rotate_left(1);
            let model = import(&in_plane(&corners, axes));
            let expected = 0.5 * shoelace(&corners);
            let normal = axes.z_axis * expected.signum();
            // Corners are rounded to f32, by 2^-24 of the extent, at most 20 here; that moves the
            // area by as much times the circumference, below 100.
            let tolerance = 20.0 * 100.0 / f64::from(1 << 24);
            let mut area = 0.0;
            for surface in &model.surfaces {
                let facing = surface.normal().dot(normal);
                area += surface.area() * facing.signum();
                let [a, b, c] = surface.corners.map(glam::Vec3::as_dvec3);
                let sides = [a - b, b - c, c - a].map(DVec3::length_squared);
                let longest = sides.into_iter().fold(0.0, f64::max);
                let is_sliver = 2.0 * surface.area() <= SLIVER * longest + tolerance;
                assert!(facing > 0.9 || is_sliver, "{corners:?}");
            }
            assert!(
                (area - expected.abs()).abs() < tolerance,
                "{area} for {expected}: {corners:?}"
            );
            let warnings = &model.report.warnings;
            assert!(
                !warnings.iter().any(|w| w.contains("overlap")),
                "{warnings:?}"
            );
        }
        corners.reverse();
    }
}

fn points(corners: &[[f64; 2]]) -> Vec<DVec2> {
    corners.iter().copied().map(DVec2::from).collect()
}

/// Planes of all kinds, their third axis the normal.
fn planes() -> [DMat3; 4] {
    let tilted = DMat3::from_rotation_x(0.7) * DMat3::from_rotation_y(-1.1);
    [
        DMat3::IDENTITY,
        DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
        DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::NEG_Y),
        tilted,
    ]
}

#[test]
fn concave_polygons_are_covered_once_from_any_corner_in_any_plane() {
    let star: Vec<DVec2> = (0..10)
        .map(|k| DVec2::from_angle(TAU * f64::from(k) / 10.0) * [5.0, 2.0][k as usize % 2])
        .collect();
    let spiral = |turns: i32| {
        let arm = |offset: f64| {
            (0..=8 * turns).map(move |k| {
                DVec2::from_angle(TAU * f64::from(k) / 8.0) * (1.0 + offset + f64::from(k) / 8.0)
            })
        };
        arm(0.5).chain(arm(0.0).rev()).collect::<Vec<_>>()
    };
    for corners in [
        // L, T, U, a comb, an arrow head, a floor with a small notch.
        points(&[[0., 0.], [2., 0.], [2., 1.], [1., 1.], [1., 2.], [0., 2.]]),
        points(&[
            [0., 2.],
            [0., 1.],
            [1., 1.],
            [1., -2.],
            [2., -2.],
            [2., 1.],
            [3., 1.],
            [3., 2.],
        ]),
        points(&[
            [0., 0.],
            [3., 0.],
            [3., 3.],
            [2., 3.],
            [2., 1.],
            [1., 1.],
            [1., 3.],
            [0., 3.],
        ]),
        points(&[
            [0., 0.],
            [7., 0.],
            [7., 4.],
            [6., 1.],
            [5., 4.],
            [4., 1.],
            [3., 4.],
            [2., 1.],
            [1., 4.],
        ]),
        points(&[[0., 0.], [2., 2.], [0., 1.], [-2., 2.]]),
        points(&[
            [0., 0.],
            [5., 0.],
            [5., 0.05],
            [5.05, 0.05],
            [5.05, 0.],
            [10., 0.],
            [10., 10.],
            [0., 10.],
        ]),
        star,
        spiral(3),
    ] {
        for axes in planes() {
            covered_once(&corners, axes);
        }
    }
}

#[test]
fn straight_corners_and_doubled_corners_and_spikes_change_no_area() {
    for corners in [
        // A T with corners in the middles of its sides, two doubled, and one with a spike.
        points(&[
            [0., 2.],
            [0., 1.5],
            [0., 1.],
            [0.5, 1.],
            [1., 1.],
            [1., -2.],
            [1.5, -2.],
            [2., -2.],
            [2., 1.],
            [2.5, 1.],
            [3., 1.],
            [3., 2.],
            [2., 2.],
            [1., 2.],
        ]),
        points(&[
            [0., 0.],
            [2., 0.],
            [2., 0.],
            [2., 1.],
            [1., 1.],
            [1., 1.],
            [1., 1.],
            [1., 2.],
            [0., 2.],
        ]),
        points(&[
            [0., 0.],
            [2., 0.],
            [2., 1.],
            [1., 1.],
            [1., 2.],
            [1., 3.],
            [1., 2.],
            [0., 2.],
        ]),
    ] {
        covered_once(&corners, DMat3::IDENTITY);
    }
}

#[test]
fn hole_that_a_bridge_joins_to_the_rim_stays_open() {
    let corners = points(&[
        [0., 0.],
        [4., 0.],
        [4., 4.],
        [0., 4.],
        [0., 0.],
        [1., 1.],
        [1., 3.],
        [3., 3.],
        [3., 1.],
        [1., 1.],
    ]);
    for axes in planes() {
        covered_once(&corners, axes);
    }
    let model = import(&in_plane(&corners, DMat3::IDENTITY));
    for surface in &model.surfaces {
        let centroid = surface.corners.iter().sum::<glam::Vec3>() / 3.0 + model.origin.as_vec3();
        assert!((centroid.truncate() - 2.0).abs().max_element() > 1.0);
    }
}

#[test]
fn fan_that_covers_a_polygon_once_is_kept() {
    // Convex, with straight corners, and an arrow head from its tip and from its notch.
    let straight = [[0., 0.], [1., 0.], [2., 0.], [2., 1.], [2., 2.], [0., 2.]];
    let arrow = [[0., 0.], [2., 2.], [0., 1.], [-2., 2.]];
    let notch = [arrow[2], arrow[3], arrow[0], arrow[1]];
    for corners in [&straight[..], &arrow[..], &notch[..]] {
        let corners = in_plane(&points(corners), DMat3::IDENTITY);
        let model = import(&corners);
        let fan = corners[1..].windows(2).map(|p| [corners[0], p[0], p[1]]);
        let expected: Vec<[DVec3; 3]> = fan
            .filter(|[a, b, c]| (b - a).cross(c - a) != DVec3::ZERO)
            .collect();
        let found: Vec<[DVec3; 3]> = model
            .surfaces
            .iter()
            .map(|s| s.corners.map(|p| p.as_dvec3() + model.origin))
            .collect();
        assert_eq!(found, expected);
    }
}

#[test]
fn convex_polygons_in_six_digits_are_fanned() {
    // Corners in the middles of sides, off by the rounding of the sixth digit.
    let model = import(&in_plane(
        &points(&[
            [0., 0.],
            [1., 1e-6],
            [2., 0.],
            [1.999_999, 1.],
            [2., 2.],
            [1., 1.999_999],
            [0., 2.],
        ]),
        DMat3::IDENTITY,
    ));
    let first = model.surfaces[0].corners[0];
    assert!(model.surfaces.iter().all(|s| s.corners[0] == first));
}

#[test]
fn polygons_that_cross_themselves_or_are_not_planar_are_fanned_and_warned_of() {
    let pentagram: Vec<DVec3> = (0..5)
        .map(|k| DVec2::from_angle(TAU * f64::from(2 * k) / 5.0).extend(0.0))
        .collect();
    let bow_tie = [[0., 0.], [2., 2.], [2., 0.], [0., 2.]];
    let uneven = [[0., 0.], [3., 3.], [3., 0.], [0., 1.]];
    let mut twisted = in_plane(
        &points(&[[2., 2.], [0., 1.], [-2., 2.], [0., 0.]]),
        DMat3::IDENTITY,
    );
    twisted[1].z = 0.1;
    for corners in [
        pentagram,
        in_plane(&points(&bow_tie), DMat3::IDENTITY),
        in_plane(&points(&uneven), DMat3::IDENTITY),
        twisted,
    ] {
        let model = import(&corners);
        let warnings = model.report.warnings.join("\n");
        assert!(
            warnings.contains("1 of 1 polygons cross themselves") && warnings.contains("overlap"),
            "{corners:?}: {warnings}"
        );
        for surface in &model.surfaces {
            let first = surface.corners[0].as_dvec3() + model.origin;
            assert!(first.distance(corners[0]) < 1e-6, "a fan");
        }
    }
}

/// Two corners are as good as in line with the first: its fan has a sliver that faces away, and is kept.
#[test]
fn regression_a_fan_with_a_sliver_is_covered_once_but_for_that() {
    let radii = [
        6.106_079_925,
        0.248_140_924,
        4.774_456_609,
        1.434_993_105,
        5.679_000_203,
        0.267_030_495,
        6.082_709_759,
        4.772_628_946,
        7.539_879_933,
        7.507_948_203,
        0.1,
        0.1,
    ];
    covered_once(&around(&radii), DMat3::IDENTITY);
}

/// Corners at these distances from a middle, at equal angles.
fn around(radii: &[f64]) -> Vec<DVec2> {
    let step = TAU / radii.len() as f64;
    let corners = radii.iter().enumerate();
    corners
        .map(|(k, r)| DVec2::from_angle(k as f64 * step) * *r)
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Any radii around a middle make a simple polygon, which has the middle in sight, but a fan
    /// from one of its corners overlaps as a rule.
    #[test]
    fn polygons_around_a_point_are_covered_once(
        radii in prop::collection::vec(0.1_f64..9.0, 4..14), about in prop::array::uniform3(-3.0_f64..3.0)
    ) {
        let [x, y, z] = about;
        covered_once(
            &around(&radii),
            DMat3::from_rotation_x(x) * DMat3::from_rotation_y(y) * DMat3::from_rotation_z(z),
        );
    }

    /// Whatever the corners on a small grid: no panic, and no triangle faces away without a word.
    #[test]
    fn triangles_face_as_their_polygon_or_a_warning_says_so(
        grid in prop::collection::vec((0_u8..5, 0_u8..5), 4..12)
    ) {
        let corners: Vec<DVec2> = grid
            .iter()
            .map(|&(x, y)| DVec2::new(f64::from(x), f64::from(y)))
            .collect();
        let area = shoelace(&corners);
        prop_assume!(area != 0.0);
        let model = import(&in_plane(&corners, DMat3::IDENTITY));
        let warned = model.report.warnings.iter().any(|w| w.contains("overlap"));
        let faces_away = model.surfaces.iter().any(|s| s.normal().z * area < 0.0);
        prop_assert_eq!(faces_away, warned);
    }
}
