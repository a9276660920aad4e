//! Making a [`Locator`].
//!
//! Surfaces are clipped to the cells, and in a cell to both sides of its lines, so that no line decides what another one
//! has decided. Surfaces that no line along a side parts overlap; then there is no locator.

use std::collections::VecDeque;

use glam::{DVec2, DVec3};
use scene::planar::{clip, turn};
use scene::{Scene, SurfaceId};

use super::ULP;
use super::locator::{LEAF, Locator, Member, NO_MEMBER, Node, STEEP, Tree};
use super::outline::{self, Outline, RegionMesh};

/// Least width of a clipped surface, as a share of the box's diagonal; [`Locator`] cannot tell narrower ones apart.
/// In a regular mesh rounding leaves slivers beyond the borders of cells; without this limit each would cost a line.
const NOTHING: f64 = 1e-6;

/// The most surfaces of a cell whose sides may become its next line. Tuned: fans need some choice.
const MOST_SURFACES_ASKED: usize = 4;

/// The most nodes a surface, beside those of the cells.
const MOST_NODES: usize = 16;

/// Cells a surface. Tuned: with fewer, more points need more than one line, with more the table is farther away. Regular
/// meshes, whose rectangles are two surfaces each, want squares of whole numbers of half their cells.
const CELLS: [f64; 3] = [32.0, 8.0, 2.0];

/// The most cells of a scene, except that a surface has as many as the last of [`CELLS`] says.
const MOST_OF_SCENE: f64 = (1 << 15) as f64;

/// The most cells of a region, about: their numbers have to be exact as f32.
const MOST_CELLS: f64 = (1 << 23) as f64;

/// By how much the number of cells along an axis may be off what is wanted, relative.
const OFF: f64 = 0.3;

/// A vertex lies between two cells that is nearer than this share of a cell.
const BETWEEN: f64 = 1e-3;

/// Triangles and numbers of cells that are looked at, at most.
const MOST_SAMPLED_TRIANGLES: usize = 1 << 10;
const MOST_SAMPLED_CELLS: usize = 1 << 6;

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
    /// Widths that do not count as parts of a surface, metres.
    nothing: f64,
}

impl Frame {
    pub(super) fn new(mesh: &RegionMesh, outline: &Outline, point: DVec3) -> Option<Self> {
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
        let rounding = 8.0 * ULP * reach.fold(0.0, f64::max);
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
            rounding,
            nothing: (0.5 * rounding).max(NOTHING * size.length()),
        })
    }

    /// The corners of the reference in the box's plane.
    fn corners(&self) -> [DVec2; 3] {
        let twice = 2.0 * self.size;
        [DVec2::ZERO, twice.with_y(0.0), twice.with_x(0.0)]
    }

    fn member(
        &self,
        scene: &Scene,
        mesh: &RegionMesh,
        surface: SurfaceId,
        triangle: usize,
    ) -> Member {
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

    /// What has certain values at the reference's corners, over a grid: its coefficients of 1, of the columns and of
    /// the rows.
    fn over_grid([at_corner, along, up]: [f64; 3], [columns, rows]: [u32; 2]) -> [f32; 3] {
        // The reference's sides are twice the grid's.
        [
            at_corner,
            (along - at_corner) / (2.0 * f64::from(columns)),
            (up - at_corner) / (2.0 * f64::from(rows)),
        ]
        .map(|coefficient| coefficient as f32)
    }

    /// A line over a grid, both of its codes 0 as yet, and which of them is for its left.
    fn node(&self, line: Line, [columns, rows]: [u32; 2]) -> (Node, usize) {
        let Line { from, across } = line;
        let cell = self.size / DVec2::new(columns.into(), rows.into());
        let is_steep = across.x.abs() >= across.y.abs();
        // With the coordinate that is to be compared as the second one.
        let swap = |v: DVec2| if is_steep { DVec2::new(v.y, v.x) } else { v };
        let (from, across, cell) = (swap(from), swap(across), swap(cell));
        let slope = -across.x / across.y;
        let a = (from.y - slope * from.x) / cell.y;
        let b = slope * cell.x / cell.y;
        let node = Node {
            line: [a as f32, b as f32],
            sides: [if is_steep { STEEP } else { 0 }, 0],
        };
        (node, usize::from(across.y > 0.0))
    }

    fn sides(&self, triangle: usize) -> [Line; 3] {
        let [a, b, c] = self.triangles[triangle];
        [(a, b), (b, c), (c, a)].map(|(from, to)| Line {
            from,
            across: (to - from).perp().normalize_or_zero(),
        })
    }

    /// Columns and rows of cells, in the proportions of the surfaces' mean extents.
    fn grid(&self, scene: &Scene) -> [u32; 2] {
        let count = self.triangles.len() as f64;
        let surfaces = scene.surfaces().len() as f64;
        let [.., fewest] = CELLS;
        let fits = |cells: &f64| cells * surfaces <= MOST_OF_SCENE;
        let a_surface = CELLS.into_iter().find(fits).unwrap_or(fewest);
        let sum: DVec2 = self
            .triangles
            .iter()
            .map(|[a, b, c]| a.max(*b).max(*c) - a.min(*b).min(*c))
            .sum();
        let most = (a_surface * count).min(MOST_CELLS);
        // As many in each mean extent as gives that number where a rectangle is cut into pairs of triangles.
        let in_extent = (2.0 * a_surface).sqrt();
        let wanted = (in_extent * count * self.size / sum).clamp(DVec2::ONE, DVec2::splat(most));
        let excess = (wanted.x * wanted.y / most).max(1.0);
        // What one axis does not take the other one must.
        let fewer = (wanted / excess.sqrt()).max(DVec2::ONE);
        let limit = DVec2::new(most / fewer.y, most / fewer.x).max(DVec2::ONE);
        let cells = fewer.min(limit);
        [DVec2::X, DVec2::Y].map(|axis| self.aligned(cells.dot(axis), axis))
    }

    /// How many cells an axis is cut into, near a wanted number, for most vertices to lie between two: then regular
    /// meshes have few lines in a cell.
    fn aligned(&self, wanted: f64, axis: DVec2) -> u32 {
        let size = self.size.dot(axis);
        let step = (self.triangles.len() / MOST_SAMPLED_TRIANGLES).max(1);
        let places: Vec<f64> = self
            .triangles
            .iter()
            .step_by(step)
            .flatten()
            .map(|corner| corner.dot(axis) / size)
            .collect();
        let between = |cells: u32| {
            let is_between = |place: &&f64| {
                let at = **place * f64::from(cells);
                (at - at.round()).abs() < BETWEEN
            };
            places.iter().filter(is_between).count()
        };
        let first = ((1.0 - OFF) * wanted).ceil().max(1.0) as u32;
        let last = ((1.0 + OFF) * wanted).max(1.0) as u32;
        let step = (last.saturating_sub(first) as usize / MOST_SAMPLED_CELLS).max(1);
        let nearest = wanted.round() as u32;
        (first..=last)
            .step_by(step)
            .chain([nearest])
            .max_by_key(|&cells| (between(cells), std::cmp::Reverse(cells.abs_diff(nearest))))
            .unwrap_or(nearest)
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
        (2..p.len()).map(|k| turn(p[0], p[k - 1], p[k])).sum()
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
        let polygon = clip(&self.polygon, |p| line.left(p));
        Self { polygon, ..*self }
    }

    /// The part in each of `count` equal strips along an axis, over the length `size`.
    fn strips(&self, axis: DVec2, frame: &Frame, count: u32) -> Vec<(u32, Self)> {
        let size = frame.size.dot(axis);
        let along = self.polygon.iter().map(|p| p.dot(axis));
        let (low, high) = along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| {
            (low.min(x), high.max(x))
        });
        let scale = f64::from(count) / size;
        let first = ((low + frame.nothing) * scale) as u32;
        let last = ((high - frame.nothing) * scale) as u32;
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
        mesh: &RegionMesh,
        frame: &Frame,
    ) -> Option<Self> {
        let members: Vec<Member> = surfaces
            .iter()
            .enumerate()
            .map(|(triangle, &surface)| frame.member(scene, mesh, surface, triangle))
            .collect();
        let size = if members.len() == 2 {
            [1, 1]
        } else {
            frame.grid(scene)
        };
        let mut locator = Self {
            trees: members.iter().map(|member| tree(member, size)).collect(),
            members,
            nodes: Vec::new(),
            size,
        };
        if surfaces.len() == 2 {
            let shared = mesh.mates.iter().take(3).position(|&mate| mate < 6)?;
            let line = frame.sides(0)[shared];
            let (mut node, left) = frame.node(line, size);
            node.sides[left] |= LEAF;
            node.sides[1 - left] |= LEAF | 1;
            locator.nodes.push(node);
            return Some(locator);
        }
        let [columns, rows] = size;
        let mut cells: Vec<Vec<Part>> = vec![Vec::new(); columns as usize * rows as usize];
        for (triangle, corners) in frame.triangles.iter().enumerate() {
            let part = Part {
                triangle,
                polygon: corners.to_vec(),
            };
            for (row, strip) in part.strips(DVec2::Y, frame, rows) {
                for (column, part) in strip.strips(DVec2::X, frame, columns) {
                    cells[(row * columns + column) as usize].push(part);
                }
            }
        }
        let near = nearest(&cells, size);
        locator.nodes.resize(cells.len(), Node::default());
        for (cell, (parts, near)) in cells.into_iter().zip(near).enumerate() {
            if parts.is_empty() {
                locator.nodes[cell] = Node::all(LEAF | near);
            } else {
                locator.part(frame, cell, parts)?;
            }
        }
        Some(locator)
    }

    /// Makes the partition of one cell.
    fn part(&mut self, frame: &Frame, cell: usize, parts: Vec<Part>) -> Option<()> {
        let nothing = frame.nothing;
        let cells = self.size[0] as usize * self.size[1] as usize;
        let most_nodes = cells + MOST_NODES * self.members.len();
        let mut stack = vec![(parts, None)];
        while let Some((parts, place)) = stack.pop() {
            let code = if let Some(line) = best_line(frame, &parts, nothing) {
                if self.nodes.len() >= most_nodes {
                    return None;
                }
                let (new, left_side) = frame.node(line, self.size);
                let node = if place.is_none() {
                    self.nodes[cell] = new;
                    cell
                } else {
                    self.nodes.push(new);
                    self.nodes.len() - 1
                };
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
                stack.push((left, Some((node, left_side))));
                stack.push((right, Some((node, 1 - left_side))));
                node as u32
            } else {
                LEAF | only(&parts, frame.rounding)?
            };
            match place {
                Some((node, side)) => self.nodes[node].sides[side] |= code,
                None if code & LEAF != 0 => self.nodes[cell] = Node::all(code),
                None => {}
            }
        }
        Some(())
    }
}

/// The bisection tree of a member over a grid.
fn tree(member: &Member, size: [u32; 2]) -> Tree {
    let [a, b, c] = member.barycentric;
    let difference = [0, 1, 2].map(|k| a[k] - b[k]);
    Tree {
        difference: Frame::over_grid(difference, size),
        third: Frame::over_grid(c, size),
        first_patch: member.first_patch,
        depth: member.depth,
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
    let step = parts.len().div_ceil(MOST_SURFACES_ASKED);
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
