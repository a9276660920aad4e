//! Typed indices. IDs start at 0 and count the elements of one array of a [`crate::Scene`].

use bytemuck::{Pod, Zeroable};

/// The most patches a scene may have, 2^24 - 1, so that an ID fits the 24 bits of R, G and B and
/// [`NO_PATCH`] stays free.
pub const MAX_PATCHES: u32 = (1 << 24) - 1;

/// The ID that stands for "no patch": the only 24-bit value that is never a patch.
pub const NO_PATCH: PatchId = PatchId(MAX_PATCHES);

/// Index of a patch, numbered along the bisection trees in surface order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub struct PatchId(pub u32);

/// Index of a surface (an input triangle).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub struct SurfaceId(pub u32);

/// Index of a material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub struct MaterialId(pub u32);

/// Index of an object: an OBJ `o` or `g`, or one thing of a generated model.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Pod, Zeroable)]
#[repr(transparent)]
pub struct ObjectId(pub u32);

macro_rules! impl_index {
    ($($id:ident),*) => {$(
        impl $id {
            /// The ID as an array index.
            #[inline]
            pub const fn index(self) -> usize {
                self.0 as usize
            }
        }
    )*};
}
impl_index!(PatchId, SurfaceId, MaterialId, ObjectId);
