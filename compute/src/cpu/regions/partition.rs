//! Making a [`Locator`].
//!
//! Surfaces are clipped to the cells, and in a cell to both sides of its lines, so that nothing is asked that is
//! decided already. What no side of a surface parts any more, overlaps: there is no locator then.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};
use scene::{Scene, SurfaceId};

use super::ULP;
use super::locator::{LEAF, Locator, Member, NO_MEMBER, Node};
use super::outline::{self, Mesh, Outline};

/// Widths up to this share of the box's diagonal do not count as parts of a surface: f64 rounding, far
/// below what [`Locator`] can tell apart.
const NOTHING: f64 = 1e-10;

/// The most surfaces of a cell whose sides are tried as its next line. Tuned: fans need some choice.
const TRIED: usize = 4;

/// The most nodes a surface.
const MOST_NODES: usize = 16;

/// A region's plane with the box around it.
pub(super) struct Frame {
    /// A triangle twice as wide and twice as high as the box, from its lowest corner.
    pub reference: [DVec3; 3],
    /// Width and height of the box, metres.
    size: DVec2,
    /// Of each triangle, in the box, metres.
    triangles: Vec<[DVec2; 3]>,
    /// Size of what may come from rounding of the scene's coordinates, metres.
    rounding: f64,
}

impl Frame {
    pub(super) fn new(mesh: &Mesh, outline: &Outline, point: DVec3) -> Option<Self> {
        let up = mesh.normal.cross(outline.direction).try_normalize()?;
        let right = up.cross(mesh.normal).try_normalize()?;
        let mut places: Vec<DVec2> = mesh
            .points
            .iter()
            .map(|&p| DVec2::new((p - point).dot(right), (p - point).dot(up)))
            .collect();
        let low = places.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let high = places.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        for place in &mut places {
            *place -= low;
        }
        let corner = point + low.x * right + low.y * up;
        let size = high - low;
        let reach = mesh.points.iter().map(|p| p.abs().max_element());
        (size.min_element() > 0.0).then(|| Self {
            reference: [
                corner,
                corner + 2.0 * size.x * right,
                corner + 2.0 * size.y * up,
            ],
            size,
            triangles: mesh
                .corners
                .iter()
                .map(|corners| corners.map(|vertex| places[vertex as usize]))
                .collect(),
            rounding: 8.0 * ULP * reach.fold(0.0, f64::max),
        })
    }

    /// The corners of the reference in the box's plane.
    fn corners(&self) -> [DVec2; 3] {
        let twice = 2.0 * self.size;
        [DVec2::ZERO, twice.with_y(0.0), twice.with_x(0.0)]
    }

    fn member(&self, scene: &Scene, mesh: &Mesh, surface: SurfaceId, triangle: usize) -> Member {
        let tree = scene.mesh().tree(surface);
        let [a, b, c] = self.triangles[triangle];
        let double_area = (b - a).perp_dot(c - a);
        Member {
            surface,
            first_patch: tree.first_patch.0,
            depth: tree.depth,
            barycentric: [(b, c), (c, a), (a, b)].map(|(from, to)| {
                self.corners()
                    .map(|p| (to - from).perp_dot(p - from) / double_area)
            }),
            // The side beyond which the k-th coordinate is below 0 starts at the next corner.
            neighbours: [1, 2, 0].map(|side| match mesh.mates[3 * triangle + side] {
                outline::NONE => NO_MEMBER,
                mate => mate / 3,
            }),
        }
    }

    fn node(&self, line: Line) -> Node {
        Node {
            line: self.corners().map(|p| line.left(p) as f32),
            sides: [LEAF; 2],
        }
    }

    fn sides(&self, triangle: usize) -> [Line; 3] {
        let [a, b, c] = self.triangles[triangle];
        [(a, b), (b, c), (c, a)].map(|(from, to)| Line {
            from,
            across: (to - from).perp().normalize_or_zero(),
        })
    }

    /// Columns and rows: cells of half the surfaces' mean extents, two a surface at most.
    fn grid(&self) -> [u32; 2] {
        let count = self.triangles.len() as f64;
        let sum: DVec2 = self
            .triangles
            .iter()
            .map(|[a, b, c]| a.max(*b).max(*c) - a.min(*b).min(*c))
            .sum();
        let most = 2.0 * count;
        let wanted = (most * self.size / sum).clamp(DVec2::ONE, DVec2::splat(most));
        let excess = (wanted.x * wanted.y / most).max(1.0);
        // What one axis does not take the other one must.
        let fewer = (wanted / excess.sqrt()).max(DVec2::ONE);
        let limit = DVec2::new(most / fewer.y, most / fewer.x).max(DVec2::ONE);
        // Rounded, as regular meshes want a whole number of cells to each of their own.
        let cells = fewer.min(limit).round();
        [cells.x as u32, cells.y as u32]
    }
}

#[derive(Clone, Copy)]
struct Line {
    from: DVec2,
    /// Unit vector to the left.
    across: DVec2,
}

impl Line {
    /// Distance, metres, above 0 to the left.
    fn left(self, p: DVec2) -> f64 {
        (p - self.from).dot(self.across)
    }
}

/// A part of a surface.
#[derive(Clone)]
struct Part {
    triangle: usize,
    polygon: Vec<DVec2>,
}

impl Part {
    fn double_area(&self) -> f64 {
        let p = &self.polygon;
        (2..p.len())
            .map(|k| (p[k - 1] - p[0]).perp_dot(p[k] - p[0]))
            .sum()
    }

    /// Farthest points to the right of a line (below 0) and to its left, metres.
    fn extent(&self, line: Line) -> [f64; 2] {
        self.polygon
            .iter()
            .map(|&p| line.left(p))
            .fold([0.0, 0.0], |[low, high], left: f64| {
                [left.min(low), left.max(high)]
            })
    }

    /// What is left of a line.
    fn left_of(&self, line: Line) -> Self {
        let points = &self.polygon;
        let mut polygon = Vec::with_capacity(points.len() + 1);
        for (k, &p) in points.iter().enumerate() {
            let q = points[(k + 1) % points.len()];
            let (here, there) = (line.left(p), line.left(q));
            if here >= 0.0 {
                polygon.push(p);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                polygon.push(p.lerp(q, here / (here - there)));
            }
        }
        Self { polygon, ..*self }
    }

    /// The part in each of `count` equal strips along an axis, over the length `size`.
    fn strips(&self, axis: DVec2, size: f64, count: u32) -> Vec<(u32, Self)> {
        let along = self.polygon.iter().map(|p| p.dot(axis));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let scale = f64::from(count) / size;
        let first = ((low + NOTHING * size) * scale) as u32;
        let last = ((high - NOTHING * size) * scale) as u32;
        let (first, last) = (first.min(count - 1), last.min(count - 1));
        let border = |strip: u32, sign: f64| Line {
            from: axis * (f64::from(strip) / scale),
            across: axis * sign,
        };
        (first..=last)
            .map(|strip| {
                let mut part = self.clone();
                if strip > first {
                    part = part.left_of(border(strip, 1.0));
                }
                if strip < last {
                    part = part.left_of(border(strip + 1, -1.0));
                }
                (strip, part)
            })
            .filter(|(_, part)| part.polygon.len() > 2)
            .collect()
    }
}

impl Locator {
    /// `None` where surfaces overlap, or need too many lines.
    pub(super) fn new(
        scene: &Scene,
        surfaces: &[SurfaceId],
        mesh: &Mesh,
        frame: &Frame,
    ) -> Option<Self> {
        let members = surfaces
            .iter()
            .enumerate()
            .map(|(triangle, &surface)| frame.member(scene, mesh, surface, triangle))
            .collect();
        let mut locator = Self {
            members,
            nodes: Vec::new(),
            cells: vec![0],
            size: [1, 1],
        };
        if surfaces.len() == 2 {
            let shared = mesh.mates.iter().take(3).position(|&mate| mate < 6)?;
            locator.nodes.push(Node {
                sides: [LEAF, LEAF | 1],
                ..frame.node(frame.sides(0)[shared])
            });
            return Some(locator);
        }
        locator.size = frame.grid();
        let [columns, rows] = locator.size;
        let mut cells: Vec<Vec<Part>> = vec![Vec::new(); columns as usize * rows as usize];
        for (triangle, corners) in frame.triangles.iter().enumerate() {
            let part = Part {
                triangle,
                polygon: corners.to_vec(),
            };
            for (row, strip) in part.strips(DVec2::Y, frame.size.y, rows) {
                for (column, part) in strip.strips(DVec2::X, frame.size.x, columns) {
                    cells[(row * columns + column) as usize].push(part);
                }
            }
        }
        let near = nearest(&cells, locator.size);
        locator.cells.clear();
        for (parts, near) in cells.into_iter().zip(near) {
            let code = if parts.is_empty() {
                LEAF | near
            } else {
                locator.part(frame, parts)?
            };
            locator.cells.push(code);
        }
        Some(locator)
    }

    /// The code of the partition of one cell.
    fn part(&mut self, frame: &Frame, parts: Vec<Part>) -> Option<u32> {
        let nothing = NOTHING * frame.size.length();
        let mut root = LEAF;
        let mut stack = vec![(parts, None)];
        while let Some((parts, place)) = stack.pop() {
            let code = if let Some(line) = best_line(frame, &parts, nothing) {
                if self.nodes.len() >= MOST_NODES * self.members.len() {
                    return None;
                }
                let node = self.nodes.len();
                self.nodes.push(frame.node(line));
                let right_line = Line {
                    across: -line.across,
                    ..line
                };
                let (mut left, mut right) = (Vec::new(), Vec::new());
                for part in parts {
                    let [low, high] = part.extent(line);
                    if low < -nothing && high > nothing {
                        left.push(part.left_of(line));
                        right.push(part.left_of(right_line));
                    } else if high > -low {
                        left.push(part);
                    } else {
                        right.push(part);
                    }
                }
                stack.push((left, Some((node, 0))));
                stack.push((right, Some((node, 1))));
                node as u32
            } else {
                LEAF | only(&parts, frame.rounding)?
            };
            match place {
                None => root = code,
                Some((node, side)) => self.nodes[node].sides[side] = code,
            }
        }
        Some(root)
    }
}

/// The one of the parts that is more than rounding.
fn only(parts: &[Part], rounding: f64) -> Option<u32> {
    let wide = |part: &Part| {
        let from = part.polygon[0];
        let length = part
            .polygon
            .iter()
            .map(|p| p.distance(from))
            .fold(0.0, f64::max);
        part.double_area() > 2.0 * rounding * length
    };
    if parts.iter().filter(|part| wide(part)).count() > 1 {
        return None;
    }
    let largest = parts
        .iter()
        .max_by(|a, b| a.double_area().total_cmp(&b.double_area()))?;
    Some(largest.triangle as u32)
}

/// The side of a surface that parts the others best: cuts few, and leaves few on either side.
fn best_line(frame: &Frame, parts: &[Part], nothing: f64) -> Option<Line> {
    if parts.len() < 2 {
        return None;
    }
    let cost = |line: &Line| {
        let mut counts = [0, 0];
        for part in parts {
            let [low, high] = part.extent(*line);
            let is_cut = low < -nothing && high > nothing;
            counts[0] += usize::from(is_cut || high > -low);
            counts[1] += usize::from(is_cut || high <= -low);
        }
        let [left, right] = counts;
        (left > 0 && right > 0).then_some(left + right + left.max(right))
    };
    let best = |step: usize| {
        parts
            .iter()
            .step_by(step)
            .flat_map(|part| frame.sides(part.triangle))
            .filter_map(|line| cost(&line).map(|cost| (cost, line)))
            .min_by_key(|(cost, _)| *cost)
            .map(|(_, line)| line)
    };
    let step = parts.len().div_ceil(TRIED);
    best(step).or_else(|| (step > 1).then(|| best(1)).flatten())
}

/// For each cell a surface in it or near by.
fn nearest(cells: &[Vec<Part>], [columns, rows]: [u32; 2]) -> Vec<u32> {
    let mut near: Vec<Option<u32>> = cells
        .iter()
        .map(|parts| parts.first().map(|part| part.triangle as u32))
        .collect();
    let mut queue: VecDeque<u32> = (0..cells.len() as u32)
        .filter(|&cell| near[cell as usize].is_some())
        .collect();
    while let Some(cell) = queue.pop_front() {
        let (column, row) = (cell % columns, cell / columns);
        let beside = [
            (column > 0).then(|| cell - 1),
            (column + 1 < columns).then(|| cell + 1),
            (row > 0).then(|| cell - columns),
            (row + 1 < rows).then(|| cell + columns),
        ];
        for other in beside.into_iter().flatten() {
            if near[other as usize].is_none() {
                near[other as usize] = near[cell as usize];
                queue.push_back(other);
            }
        }
    }
    near.into_iter().map(Option::unwrap_or_default).collect()
}
