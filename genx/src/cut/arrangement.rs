//! The arrangement of the edges of faces in one plane.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};
use scene::Surface;
use scene::planar::{facing_axes, turn};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::snap::{self, Point};

/// A triangle of the arrangement that some face covers.
pub(super) struct Piece {
    pub corners: [Vec3; 3],
    /// m^2.
    pub area: f64,
    /// The faces that cover it, the one that stays first.
    pub members: Vec<usize>,
}

/// Where the grid of an arrangement lies.
struct Grid {
    /// Axes of the coordinate plane that the faces face most, counter-clockwise seen from their front.
    axes: [usize; 2],
    /// The side of a pixel, metres.
    pixel: f64,
}

impl Grid {
    fn point(&self, p: DVec3) -> Point {
        self.axes.map(|axis| (p[axis] / self.pixel).round() as i64)
    }

    /// The point of a face's plane over a point of the grid.
    fn lift(&self, at: Point, face: &[Vec3; 3]) -> Vec3 {
        let [p, q, r] = face.map(Vec3::as_dvec3);
        let normal = (q - p).cross(r - p);
        let [u, v] = self.axes;
        let w = 3 - u - v;
        let mut point = p;
        point[u] = at[0] as f64 * self.pixel;
        point[v] = at[1] as f64 * self.pixel;
        point[w] -= (point - p).dot(normal) / normal[w];
        point.as_vec3()
    }
}

/// The pieces of faces of one plane, cut along `lines` in it too, on a grid of pixels of that side, metres; `None` where they have none. The faces come in
/// an order that their corners decide; `rank` says which of them stays.
pub(super) fn cut<R: Ord>(
    surfaces: &[Surface],
    group: &[usize],
    lines: &[[DVec3; 2]],
    pixel: f64,
    rank: impl Fn(usize) -> R,
) -> Option<Vec<Piece>> {
    let double_area = |&k: &usize| surfaces[k].area() * surfaces[k].normal();
    let normal = group
        .iter()
        .map(double_area)
        .sum::<DVec3>()
        .try_normalize()?;
    let grid = Grid {
        axes: facing_axes(normal),
        pixel,
    };
    // The corner that a point of the grid is: that of the face that comes first.
    let mut corners: HashMap<Point, Vec3> = HashMap::new();
    let mut segments = Vec::with_capacity(3 * group.len());
    let mut outlines = Vec::with_capacity(group.len());
    for &k in group {
        let face = surfaces[k].corners;
        let points = face.map(|p| grid.point(p.as_dvec3()));
        for (point, corner) in points.into_iter().zip(face) {
            corners.entry(point).or_insert(corner);
        }
        segments.extend([[0, 1], [1, 2], [2, 0]].map(|side| side.map(|n: usize| points[n])));
        outlines.push(points.map(flat));
    }
    segments.extend(lines.iter().map(|ends| ends.map(|p| grid.point(p))));
    let plane = triangulation(&snap::paths(&segments))?;
    let mut ranked: Vec<usize> = (0..group.len()).collect();
    ranked.sort_by_key(|&n| rank(group[n]));
    let mut pieces = Vec::new();
    for face in plane.inner_faces() {
        let points = face.positions().map(|p| [p.x as i64, p.y as i64]);
        let [a, b, c] = points.map(flat);
        let middle = (a + b + c) / 3.0;
        let members: Vec<usize> = ranked
            .iter()
            .map(|&n| (n, group[n]))
            .filter(|&(n, _)| holds(&outlines[n], middle))
            .map(|(_, k)| k)
            .collect();
        let Some(&winner) = members.first() else {
            continue;
        };
        let lift = |point: Point| {
            let corner = corners.get(&point).copied();
            corner.unwrap_or_else(|| grid.lift(point, &surfaces[winner].corners))
        };
        let [u, v] = grid.axes;
        pieces.push(Piece {
            corners: points.map(lift),
            area: 0.5 * turn(a, b, c) * pixel * pixel / normal[3 - u - v].abs(),
            members,
        });
    }
    Some(pieces)
}

/// The Delaunay triangulation of paths that meet at grid points alone; `None` where that is not so.
fn triangulation(paths: &[Vec<Point>]) -> Option<ConstrainedDelaunayTriangulation<Point2<f64>>> {
    let mut plane = ConstrainedDelaunayTriangulation::new();
    for path in paths {
        let mut handles = Vec::with_capacity(path.len());
        for point in path {
            let DVec2 { x, y } = flat(*point);
            handles.push(plane.insert(Point2::new(x, y)).ok()?);
        }
        for pair in handles.windows(2) {
            if pair[0] == pair[1] {
                continue;
            }
            if !plane.can_add_constraint(pair[0], pair[1]) {
                return None;
            }
            plane.add_constraint(pair[0], pair[1]);
        }
    }
    Some(plane)
}

fn flat(point: Point) -> DVec2 {
    // Exact below 2^53.
    DVec2::new(point[0] as f64, point[1] as f64)
}

/// Whether a triangle, counter-clockwise, holds a point.
fn holds(&[a, b, c]: &[DVec2; 3], p: DVec2) -> bool {
    turn(a, b, p) > 0.0 && turn(b, c, p) > 0.0 && turn(c, a, p) > 0.0
}
