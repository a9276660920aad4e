//! A bounding volume hierarchy over the pieces of a scene, for rays through pixels.
//!
//! # Theory
//! A binary tree of boxes, each round all triangles below it, into which pieces are fanned. Boxes are cut where the surface area heuristic expects
//! the least work, n_left A_left + n_right A_right over places between bins of centroids (Wald, "On fast
//! construction of SAH-based bounding volume hierarchies", IEEE Symposium on Interactive Ray Tracing 2007).
//!
//! # Practice
//! The two parts of a box lie in one line of a processor's cache. The tree of n triangles has n - 1 places for such
//! pairs: that of its root, then all of its left part, then its right part; a leaf of several triangles leaves those that it
//! does not need unused. So parts are built by several threads in one list, and are the same for any number of
//! threads.

use crate::regions::Regions;

/// Triangles in a leaf at most.
const LEAF: usize = 4;

/// Where a box may be cut, along its longest side.
const BINS: usize = 16;

/// Parts of fewer triangles are built by one thread.
const TRIANGLES_PER_TASK: usize = 1 << 12;

/// A box, and what is in it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Node {
    /// Smallest coordinates, metres.
    pub low: [f32; 3],
    /// Largest coordinates, metres.
    pub high: [f32; 3],
    /// Place of its two parts in [`Bvh::pairs`]; or of a leaf's first triangle in
    /// [`Bvh::triangles`].
    pub first: u32,
    /// Triangles of a leaf; 0 for an inner node.
    pub count: u32,
}

/// The two parts of a box.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(align(64))]
pub(crate) struct Pair(pub [Node; 2]);

/// The tree.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Bvh {
    pub root: Node,
    pub pairs: Vec<Pair>,
    /// Leaf after leaf.
    pub triangles: Vec<Triangle>,
}

/// A part of a piece, or all of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Triangle {
    /// Metres.
    pub corners: [[f32; 3]; 3],
    /// Index into [`Regions::pieces`].
    pub piece: u32,
    /// Index into [`Regions::regions`].
    pub region: u32,
}

/// A box from its smallest to its largest coordinates, metres.
#[derive(Clone, Copy, Debug)]
struct Bounds {
    low: [f32; 3],
    high: [f32; 3],
}

impl Bounds {
    const NONE: Self = Self {
        low: [f32::INFINITY; 3],
        high: [f32::NEG_INFINITY; 3],
    };

    fn with(self, other: &Self) -> Self {
        Self {
            low: std::array::from_fn(|k| self.low[k].min(other.low[k])),
            high: std::array::from_fn(|k| self.high[k].max(other.high[k])),
        }
    }

    /// Half of its surface, m^2; 0 of none.
    fn half_area(&self) -> f32 {
        let [x, y, z] = std::array::from_fn(|k| (self.high[k] - self.low[k]).max(0.0));
        x * y + y * z + z * x
    }

    /// Twice the middle along an axis, metres.
    fn middle(&self, axis: usize) -> f32 {
        self.low[axis] + self.high[axis]
    }
}

/// A triangle to be put in its place.
#[derive(Clone, Copy, Debug)]
struct Item {
    triangle: Triangle,
    bounds: Bounds,
}

impl Bvh {
    /// The hierarchy of all pieces, of which there is one at least, in boxes that are larger by `margin` metres.
    pub fn new(regions: &Regions, margin: f32) -> Self {
        let vertices = regions.vertices();
        let mut items = Vec::with_capacity(regions.pieces().len());
        for (index, piece) in regions.pieces().iter().enumerate() {
            let corner = |k: &u32| vertices[*k as usize].to_array();
            let Some((first, others)) = regions.corners(index).split_first() else {
                continue;
            };
            items.extend(others.windows(2).map(|pair| {
                let corners = [corner(first), corner(&pair[0]), corner(&pair[1])];
                let bounds = corners.iter().fold(Bounds::NONE, |bounds, p| {
                    let [low, high] = [-margin, margin].map(|m| p.map(|x| x + m));
                    bounds.with(&Bounds { low, high })
                });
                Item {
                    triangle: Triangle {
                        corners,
                        piece: index as u32,
                        region: piece.region,
                    },
                    bounds,
                }
            }));
        }
        let mut pairs = vec![Pair::default(); items.len() - 1];
        let root = build(&mut pairs, 0, &mut items, 0);
        Self {
            root,
            pairs,
            triangles: items.iter().map(|item| item.triangle).collect(),
        }
    }
}

/// Builds the tree of `items`, the first of which is number `first` of all, in the places `pairs`, one fewer than items,
/// the first of which is number `place` of all.
fn build(pairs: &mut [Pair], place: u32, items: &mut [Item], first: u32) -> Node {
    let bounds = items.iter().map(|item| &item.bounds);
    let Bounds { low, high } = bounds.fold(Bounds::NONE, Bounds::with);
    let count = items.len() as u32;
    let Some((pair, below)) = pairs.split_first_mut().filter(|_| items.len() > LEAF) else {
        return Node {
            low,
            high,
            first,
            count,
        };
    };
    let left_count = split(items);
    let (left, right) = items.split_at_mut(left_count);
    let (left_pairs, right_pairs) = below.split_at_mut(left_count - 1);
    let middle = left_count as u32;
    let mut build_left = || build(left_pairs, place + 1, left, first);
    let mut build_right = || build(right_pairs, place + middle, right, first + middle);
    let (left, right) = if left_count >= TRIANGLES_PER_TASK {
        rayon::join(build_left, build_right)
    } else {
        (build_left(), build_right())
    };
    *pair = Pair([left, right]);
    Node {
        low,
        high,
        first: place,
        count: 0,
    }
}

/// Brings those that are to be the left part to the front, and says how many they are: one at least, and not
/// all.
fn split(items: &mut [Item]) -> usize {
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for item in &*items {
        for k in 0..3 {
            low[k] = low[k].min(item.bounds.middle(k));
            high[k] = high[k].max(item.bounds.middle(k));
        }
    }
    let length = |k: usize| high[k] - low[k];
    let axis = (0..3).fold(0, |most, k| if length(k) > length(most) { k } else { most });
    let scale = BINS as f32 / length(axis);
    // Middles that do not differ, or by less than an f32 tells.
    if !scale.is_finite() {
        return items.len() / 2;
    }
    let bin = |item: &Item| {
        let bin = (item.bounds.middle(axis) - low[axis]) * scale;
        (bin as usize).min(BINS - 1)
    };
    let mut bins = [(0_usize, Bounds::NONE); BINS];
    for item in &*items {
        let (count, bounds) = &mut bins[bin(item)];
        *count += 1;
        *bounds = bounds.with(&item.bounds);
    }
    // What the bins from each one on cost.
    let mut right = [0.0_f32; BINS];
    let (mut count, mut bounds) = (0, Bounds::NONE);
    for k in (1..BINS).rev() {
        count += bins[k].0;
        bounds = bounds.with(&bins[k].1);
        right[k] = count as f32 * bounds.half_area();
    }
    let (mut best, mut least) = (1, f32::INFINITY);
    let (mut count, mut bounds) = (0, Bounds::NONE);
    for k in 1..BINS {
        count += bins[k - 1].0;
        bounds = bounds.with(&bins[k - 1].1);
        let cost = count as f32 * bounds.half_area() + right[k];
        if cost < least {
            (best, least) = (k, cost);
        }
    }
    let mut left_count = 0;
    for k in 0..items.len() {
        if bin(&items[k]) < best {
            items.swap(left_count, k);
            left_count += 1;
        }
    }
    if left_count == 0 || left_count == items.len() {
        return items.len() / 2;
    }
    left_count
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(tree: &Bvh, node: &Node, next: &mut u32) {
        if node.count > 0 {
            assert!(node.first == *next && node.count as usize <= LEAF);
            *next += node.count;
            let of_leaf = &tree.triangles[node.first as usize..*next as usize];
            let mut corners = of_leaf.iter().flat_map(|triangle| triangle.corners);
            let is_in = |p: [f32; 3]| (0..3).all(|k| node.low[k] < p[k] && p[k] < node.high[k]);
            assert!(corners.all(is_in));
            return;
        }
        for part in &tree.pairs[node.first as usize].0 {
            for k in 0..3 {
                assert!(node.low[k] <= part.low[k] && part.high[k] <= node.high[k]);
            }
            check(tree, part, next);
        }
    }

    /// Every triangle is in one leaf and in its box, every box in the one it is a part of; more than one thread builds,
    /// and some triangles cannot be told apart.
    #[test]
    fn boxes_hold_what_is_in_them() {
        let count = 3 * TRIANGLES_PER_TASK as u32;
        let mut items: Vec<Item> = (0..count)
            .map(|k| {
                let place = k.min(count - 50) as f32;
                let p = [(0.1 * place).sin(), (0.7 * place).cos(), 1e-4 * place];
                let bounds = Bounds {
                    low: p.map(|x| x - 1e-3),
                    high: p.map(|x| x + 1e-3),
                };
                let triangle = Triangle {
                    corners: [p; 3],
                    piece: k,
                    region: k,
                };
                Item { triangle, bounds }
            })
            .collect();
        let mut pairs = vec![Pair::default(); items.len() - 1];
        let root = build(&mut pairs, 0, &mut items, 0);
        let triangles: Vec<Triangle> = items.iter().map(|item| item.triangle).collect();
        let mut pieces: Vec<u32> = triangles.iter().map(|triangle| triangle.piece).collect();
        pieces.sort_unstable();
        assert!(pieces.iter().copied().eq(0..count));
        let tree = Bvh {
            root,
            pairs,
            triangles,
        };
        let mut next = 0;
        check(&tree, &tree.root, &mut next);
        assert_eq!(next, count);
    }
}
