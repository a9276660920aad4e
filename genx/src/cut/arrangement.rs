//! The arrangement of the edges of faces in one plane.

use std::collections::HashMap;

use glam::{DVec2, DVec3, Vec3};
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};
use scene::Surface;
use scene::planar::{facing_axes, turn};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation};

use super::snap::{self, Point};

/// A triangle of the arrangement that some face covers, seen from one side.
pub(super) struct Piece {
    pub corners: [Vec3; 3],
    /// m^2.
    pub area: f64,
    /// The faces of this side that cover it, the one that stays first.
    pub members: Vec<usize>,
}

/// More segments of one plane cross than can be put in order.
pub(super) struct TooManyCrossings;

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

/// The pieces of faces of one plane, of both its sides, cut along `lines` in it too, on a grid of pixels of that side, metres;
/// `None` where they have none. The faces come in an order that their corners decide; `rank` says which of those that face the
/// same way stays.
pub(super) fn cut<R: Ord>(
    surfaces: &[Surface],
    group: &[usize],
    lines: &[[DVec3; 2]],
    pixel: f64,
    rank: impl Fn(usize) -> R,
) -> Result<Option<Vec<Piece>>, TooManyCrossings> {
    let front = surfaces[group[0]].normal();
    let is_front = |k: usize| surfaces[k].normal().dot(front) > 0.0;
    let double_area = |&k: &usize| {
        let normal = surfaces[k].normal();
        surfaces[k].area() * if is_front(k) { normal } else { -normal }
    };
    let Some(normal) = group.iter().map(double_area).sum::<DVec3>().try_normalize() else {
        return Ok(None);
    };
    let grid = Grid {
        axes: facing_axes(normal),
        pixel,
    };
    // The corner that a point of the grid is, the same for both sides: that of the face that comes first.
    let mut corners: HashMap<Point, Vec3> = HashMap::new();
    let mut segments = Vec::with_capacity(3 * group.len() + lines.len());
    let mut outlines = Vec::with_capacity(group.len());
    for &k in group {
        let face = surfaces[k].corners;
        let mut points = face.map(|p| grid.point(p.as_dvec3()));
        for (point, corner) in points.into_iter().zip(face) {
            corners.entry(point).or_insert(corner);
        }
        segments.extend([[0, 1], [1, 2], [2, 0]].map(|side| side.map(|n: usize| points[n])));
        if !is_front(k) {
            points.reverse();
        }
        outlines.push(points.map(flat));
    }
    segments.extend(lines.iter().map(|ends| ends.map(|p| grid.point(p))));
    for segment in &mut segments {
        segment.sort_unstable();
    }
    segments.sort_unstable();
    segments.dedup();
    let paths = snap::paths(&segments).ok_or(TooManyCrossings)?;
    let Some(plane) = triangulation(&paths) else {
        return Ok(None);
    };
    let boxes = outlines.iter().enumerate().map(|(n, outline)| {
        let low = outline[0].min(outline[1]).min(outline[2]);
        let high = outline[0].max(outline[1]).max(outline[2]);
        GeomWithData::new(Rectangle::from_corners(low.into(), high.into()), n)
    });
    let boxes: RTree<GeomWithData<Rectangle<[f64; 2]>, usize>> = RTree::bulk_load(boxes.collect());
    let mut ranked: Vec<usize> = (0..group.len()).collect();
    ranked.sort_by_key(|&n| rank(group[n]));
    let mut places = vec![0; group.len()];
    for (place, &n) in ranked.iter().enumerate() {
        places[n] = place;
    }
    let mut pieces = Vec::new();
    for face in plane.inner_faces() {
        let points = face.positions().map(|p| [p.x as i64, p.y as i64]);
        let [a, b, c] = points.map(flat);
        let middle = (a + b + c) / 3.0;
        let there = boxes.locate_all_at_point(middle.into()).map(|of| of.data);
        let mut members: Vec<usize> = there.filter(|&n| holds(&outlines[n], middle)).collect();
        members.sort_by_key(|&n| places[n]);
        let Some(&first) = members.first() else {
            continue;
        };
        let face = &surfaces[group[first]].corners;
        let corners = points.map(|point| {
            let corner = corners.entry(point);
            *corner.or_insert_with(|| grid.lift(point, face))
        });
        let [u, v] = grid.axes;
        let area = 0.5 * turn(a, b, c) * pixel * pixel / normal[3 - u - v].abs();
        let members = members.into_iter().map(|n| group[n]);
        let (fronts, backs): (Vec<usize>, Vec<usize>) = members.partition(|&k| is_front(k));
        let [a, b, c] = corners;
        for (corners, members) in [([a, b, c], fronts), ([a, c, b], backs)] {
            if !members.is_empty() {
                pieces.push(Piece {
                    corners,
                    area,
                    members,
                });
            }
        }
    }
    Ok(Some(pieces))
}

/// The Delaunay triangulation of paths that meet at grid points alone; `None` where that is not so.
fn triangulation(paths: &[Vec<Point>]) -> Option<ConstrainedDelaunayTriangulation<Point2<f64>>> {
    let mut points: Vec<Point> = paths.iter().flatten().copied().collect();
    points.sort_unstable();
    points.dedup();
    let index = |point: &Point| points.binary_search(point).unwrap_or(0);
    let steps = paths.iter().flat_map(|path| path.windows(2));
    let mut edges: Vec<[usize; 2]> = steps
        .map(|ends| [index(&ends[0]), index(&ends[1])])
        .collect();
    for edge in &mut edges {
        edge.sort_unstable();
    }
    edges.sort_unstable();
    edges.dedup();
    let position = |&point: &Point| {
        let DVec2 { x, y } = flat(point);
        Point2::new(x, y)
    };
    let positions = points.iter().map(position).collect();
    let mut is_crossed = false;
    let plane = ConstrainedDelaunayTriangulation::try_bulk_load_cdt(positions, edges, |_| {
        is_crossed = true;
    });
    plane.ok().filter(|_| !is_crossed)
}

fn flat(point: Point) -> DVec2 {
    // Exact below 2^53.
    DVec2::new(point[0] as f64, point[1] as f64)
}

/// Whether a triangle, counter-clockwise, holds a point.
fn holds(&[a, b, c]: &[DVec2; 3], p: DVec2) -> bool {
    turn(a, b, p) > 0.0 && turn(b, c, p) > 0.0 && turn(c, a, p) > 0.0
}
