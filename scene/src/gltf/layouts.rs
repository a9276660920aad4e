//! What the elements of accessors may be, by what they are for.
//!
//! # Sources
//! glTF 2.0, section 3.7.2.1 (attributes, indices, morph targets), 3.7.3.1 (inverse bind matrices); `KHR_mesh_quantization`
//! adds integers, which are taken whether or not a file names that extension.

use gltf::json::accessor::{ComponentType, Type};

use ComponentType::{F32, I8, I16, U8, U16, U32};

/// What elements may be.
#[derive(Debug)]
pub(super) struct Layout {
    pub kinds: &'static [Type],
    /// Components, and whether they may be fractions of the largest integer (`normalized`), integers themselves, or both.
    components: &'static [(ComponentType, Numbers)],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Numbers {
    Plain,
    Fractions,
    Both,
}

use Numbers::{Both, Fractions, Plain};

impl Layout {
    pub(super) fn takes(&self, component: ComponentType, is_normalized: bool) -> bool {
        let fits = |numbers| match numbers {
            Plain => !is_normalized,
            Fractions => is_normalized,
            Both => true,
        };
        let mut components = self.components.iter();
        components.any(|&(known, numbers)| known == component && fits(numbers))
    }
}

pub(super) const POSITIONS: Layout = Layout {
    kinds: &[Type::Vec3],
    components: &[
        (F32, Plain),
        (I8, Both),
        (U8, Both),
        (I16, Both),
        (U16, Both),
    ],
};

pub(super) const NORMALS: Layout = Layout {
    kinds: &[Type::Vec3],
    components: &[(F32, Plain), (I8, Fractions), (I16, Fractions)],
};

pub(super) const TEXTURE_COORDINATES: Layout = Layout {
    kinds: &[Type::Vec2],
    components: POSITIONS.components,
};

pub(super) const COLOURS: Layout = Layout {
    kinds: &[Type::Vec3, Type::Vec4],
    components: WEIGHTS.components,
};

/// Of positions and of normals in morph targets.
pub(super) const DISPLACEMENTS: Layout = Layout {
    kinds: &[Type::Vec3],
    components: &[(F32, Plain), (I8, Both), (I16, Both)],
};

pub(super) const JOINTS: Layout = Layout {
    kinds: &[Type::Vec4],
    components: &[(U8, Plain), (U16, Plain)],
};

pub(super) const WEIGHTS: Layout = Layout {
    kinds: &[Type::Vec4],
    components: &[(F32, Plain), (U8, Fractions), (U16, Fractions)],
};

pub(super) const INDICES: Layout = Layout {
    kinds: &[Type::Scalar],
    components: &[(U8, Plain), (U16, Plain), (U32, Plain)],
};

pub(super) const INVERSE_BIND_MATRICES: Layout = Layout {
    kinds: &[Type::Mat4],
    components: &[(F32, Plain)],
};
