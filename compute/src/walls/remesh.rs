//! A wall anew, in triangles of about one size.
//!
//! As few triangles as an outline asks for are no mesh: from one corner of a hall to the other they are needles, and light that is
//! linear on them is no light. So the outline is parted into pieces of the size of triangles, points of a square grid are put between
//! where they are not too close to it, and all are joined by the constrained Delaunay triangulation (Chew, "Constrained Delaunay
//! triangulations", Algorithmica 4, 1989).

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};
use scene::planar::turn;
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};
use visibility::regions::Coarse;

/// How near to the outline a point may be, in steps of the grid.
const NEAREST: f64 = 0.5;

/// The height of a triangle, over its longest side, that comes from rounding: beside a side whose points are in a line but for that.
const NEEDLE: f64 = 1e-5;

/// The difference of areas, relative, that may come from rounding.
const AREA_TOLERANCE: f64 = 1e-5;

/// The wall in triangles of about half the square of a step, metres; `None` where rounding makes something odd of it.
pub(super) fn remeshed(wall: &Coarse, step: f64) -> Option<Vec<[Vec3; 3]>> {
    let plane = Plane::new(wall)?;
    let mut points: HashMap<[u64; 2], Vec3> = HashMap::new();
    let mut add = |at: Vec3| {
        let flat = plane.flat(at);
        points.entry(bits(flat)).or_insert(at);
        flat
    };
    let mut sides: Vec<[DVec2; 2]> = Vec::new();
    for &ends in &wall.outline {
        // Both walls on a foot, and both sides of a slit, have the same points.
        let [from, to] = if ends[0].to_array() < ends[1].to_array() {
            ends
        } else {
            [ends[1], ends[0]]
        };
        let parts = (f64::from(from.distance(to)) / step).ceil() as usize;
        let between = |k: usize| {
            let along = k as f64 / parts as f64;
            from.as_dvec3().lerp(to.as_dvec3(), along).as_vec3()
        };
        let mut before = add(from);
        for next in (1..parts).map(between).chain([to]) {
            let next = add(next);
            sides.push([before, next]);
            before = next;
        }
    }
    for point in plane.grid(wall, step, &sides) {
        points
            .entry(bits(point))
            .or_insert_with(|| plane.lift(point));
    }
    triangulated(wall, &plane, &points, &sides)
}

/// The triangles between points that are in the wall, with these sides.
fn triangulated(
    wall: &Coarse,
    plane: &Plane,
    points: &HashMap<[u64; 2], Vec3>,
    sides: &[[DVec2; 2]],
) -> Option<Vec<[Vec3; 3]>> {
    let mut all: Vec<[u64; 2]> = points.keys().copied().collect();
    all.sort_unstable();
    let index = |point: DVec2| all.binary_search(&bits(point)).unwrap_or(0);
    let edges = sides.iter().map(|side| side.map(index));
    let mut edges: Vec<[usize; 2]> = edges
        .map(|[a, b]| [a.min(b), a.max(b)])
        .filter(|[a, b]| a != b)
        .collect();
    edges.sort_unstable();
    edges.dedup();
    let position = |&[x, y]: &[u64; 2]| Point2::new(f64::from_bits(x), f64::from_bits(y));
    let positions = all.iter().map(position).collect();
    let mut is_crossed = false;
    let mesh = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(
        positions,
        edges,
        |_| is_crossed = true,
    );
    let mesh = mesh.ok().filter(|_| !is_crossed)?;
    let mut triangles = Vec::new();
    let mut area = 0.0;
    for face in mesh.inner_faces() {
        let corners = face.positions().map(|p| DVec2::new(p.x, p.y));
        let [a, b, c] = corners;
        let sides = [b - a, c - b, a - c].map(DVec2::length_squared);
        let longest = sides.into_iter().fold(0.0, f64::max);
        if turn(a, b, c) <= NEEDLE * longest || !plane.holds((a + b + c) / 3.0) {
            continue;
        }
        area += turn(a, b, c);
        let corners = corners.map(|corner| points.get(&bits(corner)).copied());
        let [Some(a), Some(b), Some(c)] = corners else {
            return None;
        };
        triangles.push([a, b, c]);
    }
    let twice = |[a, b, c]: &[Vec3; 3]| {
        let [a, b, c] = [a, b, c].map(|p| plane.flat(*p));
        turn(a, b, c)
    };
    let expected: f64 = wall.triangles.iter().map(twice).sum();
    ((area - expected).abs() <= AREA_TOLERANCE * expected).then_some(triangles)
}

fn bits(point: DVec2) -> [u64; 2] {
    point.to_array().map(f64::to_bits)
}

/// A wall's plane, with the wall in it.
struct Plane {
    origin: DVec3,
    axes: [DVec3; 2],
    triangles: Vec<[DVec2; 3]>,
}

impl Plane {
    /// The first axis is along the longest side.
    fn new(wall: &Coarse) -> Option<Self> {
        let along = |[from, to]: &[Vec3; 2]| to.as_dvec3() - from.as_dvec3();
        let sides = wall.outline.iter().map(along);
        let longest = sides.max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()))?;
        let across = wall.normal.cross(longest).try_normalize()?;
        let mut plane = Self {
            origin: wall.outline[0][0].as_dvec3(),
            axes: [across.cross(wall.normal), across],
            triangles: Vec::new(),
        };
        let flat = |corners: &[Vec3; 3]| corners.map(|corner| plane.flat(corner));
        plane.triangles = wall.triangles.iter().map(flat).collect();
        Some(plane)
    }

    fn flat(&self, point: Vec3) -> DVec2 {
        let from = point.as_dvec3() - self.origin;
        // Adding 0 turns -0 into 0.
        DVec2::from(self.axes.map(|axis| axis.dot(from))) + DVec2::ZERO
    }

    fn lift(&self, point: DVec2) -> Vec3 {
        (self.origin + point.x * self.axes[0] + point.y * self.axes[1]).as_vec3()
    }

    /// Whether the wall has a point.
    fn holds(&self, p: DVec2) -> bool {
        self.triangles
            .iter()
            .any(|&[a, b, c]| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0)
    }

    /// Points of a square grid in the wall that are not too close to its sides.
    fn grid(&self, wall: &Coarse, step: f64, sides: &[[DVec2; 2]]) -> Vec<DVec2> {
        let corners = wall.outline.iter().map(|side| self.flat(side[0]));
        let [low, high] = corners.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
            [low.min(p), high.max(p)]
        });
        // Whole steps along both axes, so that rectangles get squares.
        let counts = ((high - low) / step).ceil();
        let step = (high - low) / counts.max(DVec2::ONE);
        let near = NEAREST * step.max_element();
        let mut points = Vec::new();
        for row in 1..counts.y as usize {
            for column in 1..counts.x as usize {
                let point = low + DVec2::new(column as f64, row as f64) * step;
                let is_near = |&[a, b]: &[DVec2; 2]| {
                    let side = b - a;
                    let along = (point - a).dot(side) / side.length_squared();
                    point.distance(a + along.clamp(0.0, 1.0) * side) < near
                };
                if self.holds(point) && !sides.iter().any(is_near) {
                    points.push(point);
                }
            }
        }
        points
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A square of 10 m with a hole of 2 m, slit from the hole to its side.
    fn wall() -> Coarse {
        let at = |[x, y]: [f32; 2]| Vec3::new(x, y, 1.0);
        let outer = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]].map(at);
        let inner = [[4.0, 4.0], [6.0, 4.0], [6.0, 6.0], [4.0, 6.0]].map(at);
        let mut triangles = Vec::new();
        let mut outline = Vec::new();
        for k in 0..4 {
            let next = (k + 1) % 4;
            triangles.push([outer[k], outer[next], inner[next]]);
            triangles.push([outer[k], inner[next], inner[k]]);
            outline.push([outer[k], outer[next]]);
            outline.push([inner[next], inner[k]]);
        }
        outline.push([inner[0], outer[0]]);
        outline.push([outer[0], inner[0]]);
        let normal = DVec3::Z;
        Coarse {
            triangles,
            outline,
            normal,
        }
    }

    /// It has the area it had, none of its triangles is a needle, and none crosses a side.
    #[test]
    fn triangles_fill_the_wall_and_are_of_one_size() {
        let wall = wall();
        let step = 0.5;
        let triangles = remeshed(&wall, step).unwrap();
        let area = |[a, b, c]: [Vec3; 3]| 0.5 * f64::from((b - a).cross(c - a).z);
        let sum: f64 = triangles.iter().map(|&t| area(t)).sum();
        assert!((sum - 96.0).abs() < 1e-3, "{sum}");
        let expected = sum / (0.5 * step * step);
        let count = triangles.len() as f64;
        assert!(
            count < 1.5 * expected && count > 0.7 * expected,
            "{count} {expected}"
        );
        for &[a, b, c] in &triangles {
            let sides = [b - a, c - b, a - c].map(|side| f64::from(side.length()));
            let longest = sides.into_iter().fold(0.0, f64::max);
            assert!(longest < 2.0 * step, "{longest}");
            // Half of the least height that a grid with a side beside it makes.
            assert!(area([a, b, c]) > 0.1 * step * step, "{a} {b} {c}");
            let middle = (a + b + c) / 3.0;
            let is_left = |p: Vec3| p.y > p.x;
            let below = middle.x < 4.0 && middle.y < 4.0;
            let on_one_side = |p: Vec3| (p.y - p.x).abs() < 1e-5 || is_left(p) == is_left(middle);
            assert!(
                !below || [a, b, c].into_iter().all(on_one_side),
                "{a} {b} {c}"
            );
        }
    }
}
