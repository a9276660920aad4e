//! Form factors by Lambert's formula and integration, independent of hemicubes and catalogues: what
//! the bank's expected values, its winding and its tessellation are held against.
//!
//! # Theory
//! F from a point with normal n to a polygon p_k: 1/(2 pi) sum_k angle_k (n . unit(r_k x r_k+1)),
//! r_k = p_k - point, angle_k between r_k and r_k+1 (Lambert 1760; Schröder and Hanrahan, SIGGRAPH
//! 1993, give its history). The polygon is first clipped to the point's horizon.

use std::f64::consts::PI;

use glam::DVec3;
use scene::planar::clip;

use super::reference::{Entry, Shape, entries};
use super::shapes::{TESSELLATION, Triangle, area, horizontal};
use super::{bank, case, closed_forms};

/// Fronts count, backs do not.
fn from_point(point: DVec3, normal: DVec3, triangle: Triangle) -> f64 {
    let [a, b, c] = triangle.map(|p| p - point);
    if (b - a).cross(c - a).dot(a) >= 0.0 {
        return 0.0;
    }
    let clipped = clip(&[a, b, c], |p| p.dot(normal));
    let sum: f64 = (0..clipped.len())
        .map(|k| {
            let (p, q) = (clipped[k], clipped[(k + 1) % clipped.len()]);
            let cross = p.cross(q);
            let sine = cross.length();
            if sine < 1e-300 {
                return 0.0;
            }
            sine.atan2(p.dot(q)) * cross.dot(normal) / sine
        })
        .sum();
    -sum / (2.0 * PI)
}

fn from_point_to_all(point: DVec3, normal: DVec3, to: &[Triangle]) -> f64 {
    to.iter().map(|&t| from_point(point, normal, t)).sum()
}

/// Nodes and weights of Gauss and Legendre on [0, 1].
fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    (0..n)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (n as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..50 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
                }
                slope = n as f64 * (x * p1 - p0) / (x * x - 1.0);
                x -= p1 / slope;
            }
            let weight = 1.0 / ((1.0 - x * x) * slope * slope);
            (f64::midpoint(1.0, x), weight)
        })
        .collect()
}

/// Mean over the triangles of a function of point and normal.
fn mean(triangles: &[Triangle], n: usize, f: impl Fn(DVec3, DVec3) -> f64) -> f64 {
    let nodes = gauss_legendre(n);
    let mut sum = 0.0;
    for &[a, b, c] in triangles {
        let double_area = (b - a).cross(c - a);
        let normal = double_area.normalize();
        for &(u, wu) in &nodes {
            for &(v, wv) in &nodes {
                let point = a + u * ((b - a) + v * (c - b));
                sum += wu * wv * u * double_area.length() * f(point, normal);
            }
        }
    }
    sum / area(triangles)
}

/// Form factor of an unoccluded entry, as its triangles have it.
fn integrate(entry: &Entry, n: usize) -> f64 {
    let to = entry.triangles_to();
    match &entry.from {
        Shape::Point { point, normal } => from_point_to_all((*point).into(), (*normal).into(), &to),
        _ => mean(&entry.triangles_from(), n, |point, normal| {
            from_point_to_all(point, normal, &to)
        }),
    }
}

#[track_caller]
fn assert_near(name: &str, value: f64, expected: f64, tolerance: f64) {
    let error = (value / expected - 1.0).abs();
    assert!(
        error <= tolerance,
        "{name}: {value}, not {expected} ({error:.1e})"
    );
}

#[test]
fn closed_forms_agree_with_integration_and_polyhedra_within_the_stated_tessellation() {
    for entry in entries().unwrap() {
        if !entry.occluders.is_empty() {
            continue;
        }
        let curved = entry.from.is_curved() || entry.to.is_curved();
        // Gauss's rule meets an integrand that jumps where shapes touch or nearly do.
        let (n, tolerance) = if curved {
            (4, TESSELLATION)
        } else {
            (48, 1e-3)
        };
        assert_near(
            &entry.name,
            integrate(&entry, n),
            entry.form_factor,
            tolerance,
        );
    }
}

#[test]
fn catalogue_formulas_agree_with_the_reference() {
    let value = |name: &str| {
        let entry = entries().unwrap().into_iter().find(|e| e.name == name);
        entry.unwrap().form_factor
    };
    for (name, formula) in [
        (
            "parallel unit squares, distance 1 (cube opposite faces)",
            closed_forms::opposed_rectangles(1.0, 1.0, 1.0),
        ),
        (
            "near-touching unit plates, gap 1e-2",
            closed_forms::opposed_rectangles(1.0, 1.0, 0.01),
        ),
        (
            "long parallel strips 1x1000, distance 1 (2-D limit sqrt2-1)",
            closed_forms::opposed_rectangles(1.0, 1000.0, 1.0),
        ),
        (
            "perpendicular rectangles common edge 1, widths 2 and 0.5",
            closed_forms::rectangles_at_right_angle(1.0, 2.0, 0.5),
        ),
        (
            "perpendicular rectangles common edge 10, widths 1 and 3",
            closed_forms::rectangles_at_right_angle(10.0, 1.0, 3.0),
        ),
    ] {
        assert_near(name, formula, value(name), 1e-9);
    }
    for (separation, published) in [
        (2.0, 0.06859),
        (1.0, 0.19982),
        (0.5, 0.41525),
        (0.25, 0.63204),
        (0.1, 0.82699),
    ] {
        let formula = closed_forms::opposed_rectangles(1.0, 1.0, separation);
        assert!(
            (formula - published).abs() < 6e-6,
            "{separation}: {formula}"
        );
    }
    let adjacent = closed_forms::rectangles_at_right_angle(1.0, 1.0, 1.0);
    assert_near("adjacent", adjacent, 0.200_043_776_075, 1e-9);
}

/// From a floor to a ceiling at height 1, both of side `size`, past a plate: its shadow on the ceiling
/// is a rectangle.
fn past_plate(size: f64, plate: [f64; 2], height: f64) -> f64 {
    let [floor, ceiling] =
        [(0.0, true), (1.0, false)].map(|(z, up)| horizontal([0.0, size], [0.0, size], z, up));
    mean(&floor, 64, |point, normal| {
        let shadow = |p: f64| plate.map(|q| (p + (q - p) / height).clamp(0.0, size));
        let (x, y) = (shadow(point.x), shadow(point.y));
        let hidden = if x[1] > x[0] && y[1] > y[0] {
            from_point_to_all(point, normal, &horizontal(x, y, 1.0, false))
        } else {
            0.0
        };
        from_point_to_all(point, normal, &ceiling) - hidden
    })
}

#[test]
fn occluded_values_agree_with_integrated_shadows() {
    let value = past_plate(2.0, [0.55, 1.45], 0.75);
    assert_near("past the plate", value, closed_forms::PAST_PLATE, 1e-8);
    let value = past_plate(1.0, [0.0, 0.5], 0.5);
    assert_near("half-blocked", value, 0.149_868_671_773_790_5, 2e-5);
    assert_near("half-blocked, View3D", value, 0.149_870, 3e-5);
    let [square, plate] = [(1.0, 0.0, true), (0.5, 0.5, false)]
        .map(|(s, z, up)| horizontal([0.0, s], [0.0, s], z, up));
    let value = mean(&square, 48, |p, n| from_point_to_all(p, n, &plate));
    assert_near(
        "square to plate",
        value,
        closed_forms::SQUARE_TO_PLATE,
        1e-5,
    );
}

#[test]
fn names_are_unique() {
    let cases = bank().unwrap();
    for (k, case) in cases.iter().enumerate() {
        assert!(
            cases[..k].iter().all(|other| other.name != case.name),
            "{} twice",
            case.name
        );
    }
    assert!(cases.len() > 60, "{}", cases.len());
}

#[test]
fn shapes_are_cut_into_the_patches_they_should_have() {
    for case in bank().unwrap() {
        let scene = case.scene.build().unwrap();
        let patches = scene.patch_count();
        assert!(patches < 6000, "{}: {patches}", case.name);
        if let case::Measure::FormFactor { from, .. } = case.measure {
            let own: u32 = scene
                .surfaces()
                .iter()
                .zip(scene.mesh().trees())
                .filter(|(surface, _)| scene.object(surface.object) == from)
                .map(|(_, tree)| 1 << tree.depth)
                .sum();
            let coarse = case.name.starts_with("cube of 2");
            assert!(coarse || own >= case::PATCHES, "{}: {own}", case.name);
        }
    }
}
