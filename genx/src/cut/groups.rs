//! Which faces overlap in one plane, and which are connected in it.

use std::collections::HashMap;

use glam::Vec3;
use scene::Surface;
use scene::weld::{Place, places};

/// Cosine of the angle between normals up to which small faces in one plane face the same way.
const SAME_WAY: f64 = 0.9;

/// Areas are told apart to this power of two, relative: sums in another order are the same.
const AREA_STEPS: f64 = (1 << 20) as f64;

/// Faces that are cut together: those that overlap in one plane, directly or by way of others, and each that `is_cut` for
/// another reason. Their indices come by their corners' places, so that the order of the file decides nothing.
pub(super) fn groups(
    surfaces: &[Surface],
    pairs: &[[usize; 2]],
    tolerance: f64,
    is_cut: impl Fn(usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut sets = Sets::new(surfaces.len());
    for &[a, b] in pairs {
        if overlap(&surfaces[a], &surfaces[b], tolerance) {
            sets.join(a, b);
        }
    }
    let mut groups: HashMap<usize, Vec<usize>> = HashMap::new();
    for k in 0..surfaces.len() {
        groups.entry(sets.root(k)).or_default().push(k);
    }
    let mut groups: Vec<Vec<usize>> = groups
        .into_values()
        .filter(|group| group.len() > 1 || is_cut(group[0]))
        .collect();
    let key = |k: &usize| places(surfaces[*k].corners);
    for group in &mut groups {
        group.sort_by_key(key);
    }
    groups.sort_by_key(|group| key(&group[0]));
    groups
}

/// Of each face, the area of the faces that it is connected with by edges in its plane, in steps of its logarithm, and the
/// first of their places.
pub(super) fn connected_areas(surfaces: &[Surface], tolerance: f64) -> Vec<(i64, [Place; 3])> {
    let mut sets = Sets::new(surfaces.len());
    let mut at_edge: HashMap<[Place; 2], Vec<usize>> = HashMap::new();
    for (k, surface) in surfaces.iter().enumerate() {
        let corners = places(surface.corners);
        for side in 0..3 {
            let mut edge = [corners[side], corners[(side + 1) % 3]];
            edge.sort_unstable();
            at_edge.entry(edge).or_default().push(k);
        }
    }
    for at_edge in at_edge.values() {
        for (n, &a) in at_edge.iter().enumerate() {
            for &b in &at_edge[n + 1..] {
                if is_in_plane(&surfaces[a], &surfaces[b], tolerance) {
                    sets.join(a, b);
                }
            }
        }
    }
    let mut order: Vec<usize> = (0..surfaces.len()).collect();
    order.sort_by_key(|&k| places(surfaces[k].corners));
    let mut sums: HashMap<usize, (f64, [Place; 3])> = HashMap::new();
    for k in order {
        let first = places(surfaces[k].corners);
        let sum = sums.entry(sets.root(k)).or_insert((0.0, first));
        sum.0 += surfaces[k].area();
    }
    let mut of = |k: usize| {
        let (area, first) = sums[&sets.root(k)];
        ((area.log2() * AREA_STEPS).round() as i64, first)
    };
    (0..surfaces.len()).map(&mut of).collect()
}

/// Pairs of faces whose boxes touch. Boxes are swept along the axis along which the model is longest.
pub(super) fn near_pairs(surfaces: &[Surface], tolerance: f64) -> Vec<[usize; 2]> {
    let boxes: Vec<[Vec3; 2]> = surfaces
        .iter()
        .map(|surface| {
            let [a, b, c] = surface.corners;
            let by = Vec3::splat(tolerance as f32);
            [a.min(b).min(c) - by, a.max(b).max(c) + by]
        })
        .collect();
    let low = boxes.iter().fold(Vec3::INFINITY, |low, b| low.min(b[0]));
    let high = boxes
        .iter()
        .fold(Vec3::NEG_INFINITY, |high, b| high.max(b[1]));
    let axis = (high - low).max_position();
    let mut order: Vec<usize> = (0..surfaces.len()).collect();
    order.sort_by(|&a, &b| boxes[a][0][axis].total_cmp(&boxes[b][0][axis]));
    let mut active: Vec<usize> = Vec::new();
    let mut pairs = Vec::new();
    for k in order {
        let [low, high] = boxes[k];
        active.retain(|&other| boxes[other][1][axis] >= low[axis]);
        for &other in &active {
            let [other_low, other_high] = boxes[other];
            if low.cmple(other_high).all() && other_low.cmple(high).all() {
                pairs.push([other, k]);
            }
        }
        active.push(k);
    }
    pairs
}

/// True where both face the same way, and the corners of the smaller one, whose own plane is less certain, lie in the
/// plane of the larger.
fn is_in_plane(a: &Surface, b: &Surface, tolerance: f64) -> bool {
    let (large, small) = if a.area() >= b.area() { (a, b) } else { (b, a) };
    let (origin, normal) = (large.corners[0].as_dvec3(), large.normal());
    let height = |p: &Vec3| (p.as_dvec3() - origin).dot(normal).abs();
    normal.dot(small.normal()) > SAME_WAY && small.corners.iter().all(|p| height(p) <= tolerance)
}

/// True where two faces are in one plane and no line along a side parts them, but for twice the tolerance.
fn overlap(a: &Surface, b: &Surface, tolerance: f64) -> bool {
    if !is_in_plane(a, b, tolerance) {
        return false;
    }
    let parts = |of: &Surface, other: &Surface| {
        let [p, q, r] = of.corners.map(Vec3::as_dvec3);
        let normal = of.normal();
        [(p, q), (q, r), (r, p)].into_iter().any(|(from, to)| {
            let inwards = normal.cross(to - from).normalize_or_zero();
            let height = |p: &Vec3| (p.as_dvec3() - from).dot(inwards);
            other.corners.iter().all(|p| height(p) <= 2.0 * tolerance)
        })
    };
    !parts(a, b) && !parts(b, a)
}

/// Disjoint sets of indices.
struct Sets(Vec<usize>);

impl Sets {
    fn new(count: usize) -> Self {
        Self((0..count).collect())
    }

    /// The least of the set.
    fn root(&mut self, mut k: usize) -> usize {
        while self.0[k] != k {
            // Each step halves the path for those that come after.
            self.0[k] = self.0[self.0[k]];
            k = self.0[k];
        }
        k
    }

    fn join(&mut self, a: usize, b: usize) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b)] = a.min(b);
    }
}
