//! Which faces overlap in one plane, and which are connected in it.

use std::collections::HashMap;

use glam::Vec3;
use rstar::primitives::{GeomWithData, Rectangle};
use rstar::{AABB, RTree};
use scene::Surface;
use scene::weld::{Place, places};

/// Cosine of the angle between normals up to which small faces in one plane face the same way; its negative, for opposite ways.
const SAME_WAY: f64 = 0.9;

/// The most pairs of faces whose boxes touch: 512 MiB. Each of a closed body's faces touches a dozen others.
pub(super) const MOST_PAIRS: usize = 1 << 26;

/// Areas are told apart to this power of two, relative: sums in another order are the same.
const AREA_STEPS: f64 = (1 << 20) as f64;

/// Faces that are cut together: those that overlap in one plane, on either side of it, directly or by way of others, and each
/// that `is_cut` for another reason. The two sides of a sheet, triangle by triangle the same, are no reason to cut them.
/// Their indices come by their corners' places, so that the order of the file decides nothing.
pub(super) fn groups(
    surfaces: &[Surface],
    pairs: &[[u32; 2]],
    tolerance: f64,
    is_cut: impl Fn(usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut sets = Sets::new(surfaces.len());
    let mut is_cut: Vec<bool> = (0..surfaces.len()).map(is_cut).collect();
    for pair in pairs {
        let [a, b] = pair.map(|k| k as usize);
        if overlap(&surfaces[a], &surfaces[b], tolerance) {
            sets.join(a, b);
            let [p, q, r] = surfaces[b].corners;
            is_cut[a] |= places(surfaces[a].corners) != places([p, r, q]);
        }
    }
    let mut groups: HashMap<usize, Vec<usize>> = HashMap::new();
    for k in 0..surfaces.len() {
        groups.entry(sets.root(k)).or_default().push(k);
    }
    let mut groups: Vec<Vec<usize>> = groups
        .into_values()
        .filter(|group| group.iter().any(|&k| is_cut[k]))
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
                if in_plane(&surfaces[a], &surfaces[b], tolerance) == 1 {
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

/// Pairs of faces whose boxes touch, the one that comes first in the file first; an error of one of them where there are more
/// than [`MOST_PAIRS`].
pub(super) fn near_pairs(surfaces: &[Surface], tolerance: f64) -> Result<Vec<[u32; 2]>, [u32; 2]> {
    let by = Vec3::splat(tolerance as f32);
    let boxes = surfaces.iter().enumerate().map(|(k, surface)| {
        let [a, b, c] = surface.corners;
        let low = a.min(b).min(c) - by;
        let high = a.max(b).max(c) + by;
        GeomWithData::new(Rectangle::from_corners(low.into(), high.into()), k as u32)
    });
    let boxes: Vec<GeomWithData<Rectangle<[f32; 3]>, u32>> = boxes.collect();
    let tree = RTree::bulk_load(boxes.clone());
    let mut pairs = Vec::new();
    for one in &boxes {
        let envelope = AABB::from_corners(one.geom().lower(), one.geom().upper());
        let near = tree.locate_in_envelope_intersecting(envelope);
        let later = near
            .map(|other| other.data)
            .filter(|&other| other > one.data);
        pairs.extend(later.map(|other| [one.data, other]));
        if pairs.len() > MOST_PAIRS {
            return Err(pairs[MOST_PAIRS]);
        }
    }
    Ok(pairs)
}

/// How two faces face each other if they are in one plane, that is if the corners of the smaller one, whose own plane is less
/// certain, lie in the plane of the larger: 1 the same way, -1 opposite ways; 0 if they are not.
fn in_plane(a: &Surface, b: &Surface, tolerance: f64) -> i32 {
    let (large, small) = if a.area() >= b.area() { (a, b) } else { (b, a) };
    let (origin, normal) = (large.corners[0].as_dvec3(), large.normal());
    let height = |p: &Vec3| (p.as_dvec3() - origin).dot(normal).abs();
    let cosine = normal.dot(small.normal());
    let is_in_plane =
        cosine.abs() > SAME_WAY && small.corners.iter().all(|p| height(p) <= tolerance);
    if is_in_plane {
        cosine.signum() as i32
    } else {
        0
    }
}

/// True where two faces are in one plane and no line along a side parts them, but for twice the tolerance.
fn overlap(a: &Surface, b: &Surface, tolerance: f64) -> bool {
    if in_plane(a, b, tolerance) == 0 {
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
