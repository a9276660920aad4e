//! The bisection mesh: one tree per surface, whose leaves are the patches.
//!
//! Each surface is the root of a binary tree of triangles (see [`crate::bisection`]). Here every
//! tree is uniform, so a depth and a first ID stand for all its nodes; nothing else is stored.
//! Callers ask for a patch by surface and barycentric coordinates and for a node by its range of
//! IDs, and so need not know how a tree keeps its shape.

use std::ops::Range;

use crate::{MAX_PATCHES, PatchId, SceneError, SurfaceId, bisection};

/// The uniform bisection tree of one surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tree {
    /// ID of its first leaf.
    pub first_patch: PatchId,
    /// Bisections from the root to each leaf; the tree has 2^depth leaves.
    pub depth: u32,
}

impl Tree {
    /// IDs of all leaves.
    pub fn patches(self) -> Range<u32> {
        self.first_patch.0..self.first_patch.0 + (1 << self.depth)
    }

    /// IDs of the leaves below the inner node `level` bisections under the root with this code.
    ///
    /// `level` is at most the tree's depth.
    pub fn node(self, level: u32, code: u32) -> Range<u32> {
        let below = self.depth - level;
        let first = self.first_patch.0 + (code << below);
        first..first + (1 << below)
    }
}

/// The trees of all surfaces, in surface order.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Mesh {
    /// One per surface.
    trees: Vec<Tree>,
    patch_count: u32,
}

impl Mesh {
    /// A mesh with `depths[s]` bisections below surface s.
    pub fn new(depths: &[u32]) -> Result<Self, SceneError> {
        let mut patches = 0_u64;
        for (surface, &depth) in depths.iter().enumerate() {
            if depth > bisection::MAX_BISECTIONS {
                return Err(SceneError::Bisections {
                    surface: surface as u32,
                    bisections: depth,
                });
            }
            patches += 1 << depth;
        }
        if patches > u64::from(MAX_PATCHES) {
            return Err(SceneError::TooManyPatches { patches });
        }
        let mut next = 0;
        let trees = depths
            .iter()
            .map(|&depth| {
                let tree = Tree {
                    first_patch: PatchId(next),
                    depth,
                };
                next += 1 << depth;
                tree
            })
            .collect();
        Ok(Self {
            trees,
            patch_count: next,
        })
    }

    /// Number of patches.
    pub fn patch_count(&self) -> u32 {
        self.patch_count
    }

    /// The trees, one per surface.
    pub fn trees(&self) -> &[Tree] {
        &self.trees
    }

    /// The tree of one surface.
    pub fn tree(&self, surface: SurfaceId) -> Tree {
        self.trees[surface.index()]
    }

    /// The surface a patch lies in.
    pub fn surface_of(&self, patch: PatchId) -> SurfaceId {
        let after = self.trees.partition_point(|tree| tree.first_patch <= patch);
        SurfaceId(after as u32 - 1)
    }

    /// The patch that holds a point of a surface, and the point's barycentric coordinates in it.
    #[inline]
    pub fn locate(&self, surface: SurfaceId, barycentric: [f32; 3]) -> (PatchId, [f32; 3]) {
        let tree = self.tree(surface);
        let (code, local) = bisection::locate(tree.depth, barycentric);
        (PatchId(tree.first_patch.0 + code), local)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_patch_belongs_to_the_surface_whose_range_holds_it() {
        let mesh = Mesh::new(&[0, 3, 1, 0, 5]).unwrap();
        assert_eq!(mesh.patch_count(), 1 + 8 + 2 + 1 + 32);
        for (surface, tree) in mesh.trees().iter().enumerate() {
            for patch in tree.patches() {
                assert_eq!(mesh.surface_of(PatchId(patch)), SurfaceId(surface as u32));
            }
        }
    }

    #[test]
    fn children_split_their_parents_range() {
        let tree = Tree {
            first_patch: PatchId(100),
            depth: 6,
        };
        assert_eq!(tree.node(0, 0), tree.patches());
        for level in 0..6 {
            for code in 0..1 << level {
                let parent = tree.node(level, code);
                let (first, second) = (
                    tree.node(level + 1, 2 * code),
                    tree.node(level + 1, 2 * code + 1),
                );
                assert_eq!(
                    (first.start, first.end, second.end),
                    (parent.start, second.start, parent.end)
                );
            }
        }
    }

    #[test]
    fn one_patch_more_than_24_bits_hold_is_an_error() {
        // 2^23 + 2^22 + ... + 1 = 2^24 - 1 is the limit itself.
        let mut depths: Vec<u32> = (0..=23).collect();
        assert_eq!(Mesh::new(&depths).unwrap().patch_count(), MAX_PATCHES);
        depths.push(0);
        assert_eq!(
            Mesh::new(&depths),
            Err(SceneError::TooManyPatches { patches: 1 << 24 })
        );
    }
}
