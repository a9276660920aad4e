//! Polygons with four or more corners, cut into triangles.
//!
//! # Method
//! A polygon is fanned from its first corner. Where some triangle of the fan would face away, as in
//! most concave polygons, a planar polygon is cut by its ears instead (Meisters, "Polygons have
//! ears", 1975): an ear is a corner whose triangle with its neighbours holds no other corner. As
//! every triangle has the polygon's orientation and the triangles' boundaries add up to the
//! polygon's, each point is covered as often as the polygon winds around it: once, also where
//! edges coincide, as in polygons whose holes are joined to their rim by a bridge.
//!
//! Ears are found in the coordinate plane that the polygon faces most, where f32 coordinates keep
//! all their bits: orientations are exact but for one f64 rounding.

use std::collections::VecDeque;

use glam::{DVec2, DVec3, Vec3};

use crate::planar::{facing_axes, turn};

/// Farthest a corner of a planar polygon may lie from its mean plane, as a share of the diagonal
/// of its bounding box. Tuned: coordinates written with six digits stay well below it, and the
/// left wall of the published Cornell box, twisted by 1e-3, lies above.
const PLANARITY_TOLERANCE: f64 = 1e-4;

/// Twice a triangle's area over its squared longest side, up to which its facing may come from
/// rounding: coordinates written with six digits are off by half of this.
const SLIVER: f64 = 1e-5;

/// The same ratio for triangles that [`crate::Surface::is_degenerate`] certainly drops: half of its
/// limit, since a coordinate plane shows at least 1/sqrt 3 of an area.
const DROPPED: f64 = 0.5 / (1 << 23) as f64;

/// A polygon in triangles.
pub(super) struct Triangles {
    /// Indices of the polygon's corners, two triangles fewer than corners.
    pub corners: Vec<[usize; 3]>,
    /// Twice the vector area, m^2.
    pub normal: DVec3,
    pub is_planar: bool,
    /// Some triangle faces away from the polygon, so that triangles overlap.
    pub overlap: bool,
}

/// Cuts a polygon into triangles: a fan, or where that overlaps and ears can be found, ears.
pub(super) fn triangles(polygon: &[Vec3]) -> Triangles {
    let corners: Vec<DVec3> = polygon.iter().map(|p| p.as_dvec3()).collect();
    let fan: Vec<[usize; 3]> = (2..corners.len()).map(|k| [0, k - 1, k]).collect();
    let cross = |[a, b, c]: [usize; 3]| {
        let [a, b, c] = [corners[a], corners[b], corners[c]];
        (b - a).cross(c - a)
    };
    // Twice the vector area, whatever the corner the fan starts from.
    let normal = fan.iter().map(|&t| cross(t)).sum::<DVec3>();
    let unit_normal = normal.normalize_or_zero();
    let is_planar = is_planar(&corners, unit_normal);
    let overlap = fan.iter().any(|&triangle| {
        let [a, b, c] = triangle.map(|k| corners[k]);
        let longest = a
            .distance_squared(b)
            .max(b.distance_squared(c))
            .max(c.distance_squared(a));
        let cross = cross(triangle);
        // A polygon without a normal, an even figure of eight, has triangles of both sides.
        let facing = if unit_normal == DVec3::ZERO {
            -cross.length()
        } else {
            cross.dot(unit_normal)
        };
        facing < -SLIVER * longest
    });
    let ears = (overlap && is_planar && normal != DVec3::ZERO)
        .then(|| ears(&projected(&corners, normal)))
        .flatten();
    Triangles {
        overlap: overlap && ears.is_none(),
        corners: ears.unwrap_or(fan),
        normal,
        is_planar,
    }
}

fn is_planar(corners: &[DVec3], unit_normal: DVec3) -> bool {
    let middle = corners.iter().sum::<DVec3>() / corners.len() as f64;
    let (low, high) = corners
        .iter()
        .fold((corners[0], corners[0]), |(low, high), &p| {
            (low.min(p), high.max(p))
        });
    let tolerance = PLANARITY_TOLERANCE * low.distance(high);
    corners
        .iter()
        .all(|&p| (p - middle).dot(unit_normal).abs() <= tolerance)
}

/// The corners in the coordinate plane that the polygon faces most, counter-clockwise.
fn projected(corners: &[DVec3], normal: DVec3) -> Vec<DVec2> {
    let [u, v] = facing_axes(normal);
    corners.iter().map(|p| DVec2::new(p[u], p[v])).collect()
}

/// The triangles of a counter-clockwise polygon; `None` where it crosses itself.
fn ears(points: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    if crosses_itself(points) {
        return None;
    }
    // Ears that are more than slivers first, then any, then those that touch a corner.
    let kinds = [(SLIVER, true), (0.0, true), (0.0, false)];
    let mut rest: VecDeque<usize> = (0..points.len()).collect();
    let mut ears = Vec::with_capacity(points.len() - 2);
    while rest.len() > 3 {
        let first = |is_wanted: &dyn Fn([usize; 3]) -> bool| {
            (0..rest.len()).find(|&place| is_wanted(corner(&rest, place)))
        };
        let found = first(&|corner| is_spike(corner.map(|k| points[k])))
            .or_else(|| {
                kinds.iter().find_map(|&(least, closed)| {
                    first(&|corner| is_ear(points, &rest, corner, least, closed))
                })
            })
            .or_else(|| first(&|corner| is_flat(corner.map(|k| points[k]))))?;
        // The search goes on behind what was found, so that ears do not become a fan again.
        rest.rotate_left(found);
        ears.push(corner(&rest, 0));
        rest.pop_front();
        rest.rotate_left(1);
    }
    let last = corner(&rest, 1);
    (shape(last.map(|k| points[k])) >= -DROPPED).then_some(())?;
    ears.push(last);
    Some(ears)
}

/// A corner with its neighbours.
fn corner(rest: &VecDeque<usize>, place: usize) -> [usize; 3] {
    let count = rest.len();
    [
        rest[(place + count - 1) % count],
        rest[place],
        rest[(place + 1) % count],
    ]
}

/// Whether a corner's triangle has a [`shape`] above `least` and no other corner in it or, if
/// `closed`, on its sides.
fn is_ear(
    points: &[DVec2],
    rest: &VecDeque<usize>,
    corner: [usize; 3],
    least: f64,
    closed: bool,
) -> bool {
    let triangle @ [a, b, c] = corner.map(|k| points[k]);
    let holds = |p: DVec2| {
        let sides = [turn(a, b, p), turn(b, c, p), turn(c, a, p)];
        sides
            .iter()
            .all(|&side| side > 0.0 || (closed && side == 0.0))
    };
    shape(triangle) > least
        && rest
            .iter()
            .map(|&k| points[k])
            .all(|p| triangle.contains(&p) || !holds(p))
}

/// Whether a corner's triangle has no area.
fn is_flat(triangle: [DVec2; 3]) -> bool {
    shape(triangle).abs() <= DROPPED
}

/// Whether a corner turns back on itself, or lies on one of its neighbours.
fn is_spike([a, b, c]: [DVec2; 3]) -> bool {
    is_flat([a, b, c]) && (a - b).dot(c - b) >= 0.0
}

/// Twice the area of a triangle over its squared longest side, 0 for a point.
fn shape([a, b, c]: [DVec2; 3]) -> f64 {
    let sides = [a - b, b - c, c - a].map(DVec2::length_squared);
    let longest = sides.into_iter().fold(f64::MIN_POSITIVE, f64::max);
    turn(a, b, c) / longest
}

/// Whether two edges cross in their insides. Edges that touch or coincide do not.
fn crosses_itself(points: &[DVec2]) -> bool {
    let mut edges: Vec<[DVec2; 2]> = points
        .iter()
        .zip(points.iter().cycle().skip(1))
        .map(|(&a, &b)| if a.x <= b.x { [a, b] } else { [b, a] })
        .collect();
    edges.sort_unstable_by(|a, b| a[0].x.total_cmp(&b[0].x));
    edges.iter().enumerate().any(|(index, &[a, b])| {
        edges[index + 1..]
            .iter()
            .take_while(|[c, _]| c.x < b.x)
            .any(|&[c, d]| {
                turn(a, b, c) * turn(a, b, d) < 0.0 && turn(c, d, a) * turn(c, d, b) < 0.0
            })
    })
}
