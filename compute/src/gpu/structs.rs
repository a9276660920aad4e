//! All data that Rust and the shaders share: structs, constants, and the shaders themselves.
//!
//! The constants are typed here only, and are put in front of each shader's text. The structs are typed
//! in the shaders too; a test compares every offset and size.

use bytemuck::{Pod, Zeroable};
use scene::NO_PATCH;

use crate::cpu::COORDINATE_ULPS;

/// Alpha of a pixel that sees nothing: the value the atlas is cleared to.
pub const ALPHA_NOTHING: u8 = 0;
/// Alpha of a pixel that sees the back of a surface.
pub const ALPHA_BACK_FACE: u8 = 128;
/// Alpha of a pixel that sees a patch.
pub const ALPHA_PATCH: u8 = 255;

/// What the reversed depth of a back is multiplied by, so that it lies behind the front that it meets at
/// a silhouette. Depths are f32: for a plane that is seen at an angle theta they err by some 2^-22 / theta,
/// which 2^-12 covers down to a thousandth. A back in front of something by less than that share of its
/// distance is not reported.
pub const BACK_FACE_RETREAT: f32 = 1.0 - 1.0 / 4096.0;

/// How far outwards the edges of fronts are moved, relative to the coordinates of a corner and of the eye
/// along the normal of the edge's plane, so that a ray that passes between two fronts by rounding alone meets
/// both: 16 units in the
/// last place (2^-24). A corner's own rounding takes up to 2 of them, that of its difference from the eye 2
/// to 7, and the products make that 10 to 30 if all err the same way from one end of a scene to the
/// other; a quarter of what is taken sufficed wherever measured. More would hide more of what is
/// behind: the sky in an opening is seen smaller by this on all sides.
pub const FRONT_FACE_OUTSET: f32 = 16.0 / 16_777_216.0;

/// The same for the rounding of an edge's plane q_i x q_j, relative to the factors' lengths: a unit in the
/// last place for each product, and one for their difference.
pub const PRODUCT_ULPS: f32 = 2.0 / 16_777_216.0;

/// The most that both together may move an edge, in pixels: what is so far away that its own coordinates
/// are less certain than that is not to grow by it.
pub const MOST_MARGIN: f32 = 1.0 / 256.0;

/// How much farther outwards edges are moved in what is rasterised, pixels: covers two corners that are
/// each rounded to 1/16 of a pixel, the coarsest that Vulkan allows (most have 1/256). What is covered in
/// vain is cut off pixel by pixel.
pub const RASTERISED_OUTSET: f32 = 1.0 / 16.0;

/// The least factor by which moving edges outwards may change the determinant of their vectors. In
/// front of the eye it grows; where it shrinks further, edges cross behind the eye, or nearly. That happens
/// to slivers only, which are then sought in the whole picture.
pub const MIN_GROWTH: f32 = 0.5;

/// Threads of a workgroup: the most that every adapter offers.
pub const WORKGROUP_SIZE: u32 = 256;
/// Consecutive pixels that one thread sums, runs of the same patch by one addition.
pub const PIXELS_PER_THREAD: u32 = 16;

/// A surface.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Surface {
    /// First corner, metres, relative to the scene's origin.
    pub corner_0: [f32; 3],
    /// First leaf of its bisection tree.
    pub first_patch: u32,
    /// Second corner, metres.
    pub corner_1: [f32; 3],
    /// Bisections down to a leaf.
    pub depth: u32,
    /// Third corner, metres.
    pub corner_2: [f32; 3],
    /// Fills the struct up to its alignment.
    pub padding: u32,
}

/// One of the five faces of a hemicube, as a picture. The vectors are in the scene's axes.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Face {
    /// The eye, metres, relative to the scene's origin, rounded.
    pub eye_high: [f32; 3],
    /// Edge of the first row on the plane at distance 1, dimensionless.
    pub bottom: f32,
    /// What `eye_high` lacks.
    pub eye_low: [f32; 3],
    /// Height of the picture on the plane at distance 1, dimensionless.
    pub height: f32,
    /// Unit vector, direction of growing columns.
    pub right: [f32; 3],
    /// Column of the atlas where it starts, pixels.
    pub origin_x: f32,
    /// Unit vector, direction of growing rows.
    pub up: [f32; 3],
    /// Row of the atlas where it starts, pixels.
    pub origin_y: f32,
    /// Unit vector into the picture.
    pub forward: [f32; 3],
    /// Fills the struct up to its alignment.
    pub padding: f32,
}

/// What is the same for all faces.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct DrawSettings {
    /// Distance of the near plane, metres.
    pub near: f32,
    /// Distance of the eye from a surface's plane up to which it is seen edge-on at most, metres.
    pub plane_tolerance: f32,
    /// Side of a pixel on the plane at distance 1, dimensionless.
    pub pixel: f32,
    /// Fills the struct up to its alignment.
    pub padding: f32,
}

/// A third of a hemicube's picture: R x R pixels of the atlas.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Tile {
    /// Column of the atlas where it starts, pixels.
    pub origin_x: u32,
    /// Row of the atlas where it starts, pixels.
    pub origin_y: u32,
    /// Row of sums that it adds to.
    pub row: u32,
    /// Where its delta form factors start.
    pub first_factor: u32,
    /// Pixels after which they repeat.
    pub factor_period: u32,
}

/// What is the same for all tiles and rows of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct MergeSettings {
    /// Pixels along a tile.
    pub resolution: u32,
    /// Patches of the scene; a row has two sums more, for nothing and for back faces.
    pub patch_count: u32,
    /// Words of 32 bits in a row, a bit for each patch.
    pub words_per_row: u32,
    /// Blocks of words in a row, each a workgroup's.
    pub blocks_per_row: u32,
    /// Rows of the batch.
    pub row_count: u32,
}

/// What is read back of a row besides its entries.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct RowSummary {
    /// Where the row's entries end in the batch's.
    pub end: u32,
    /// Share that sees nothing, in units.
    pub open: u32,
    /// Share that sees back faces, in units.
    pub back_face: u32,
}

/// An entry of a row, as the device counts it: [`crate::rows::Entry`] in whole units.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct CountedEntry {
    /// The patch that receives.
    pub patch: u32,
    /// Its form factor in units.
    pub units: u32,
}

/// The text of `item_buffer.wgsl`, ready to compile.
pub fn item_buffer_wgsl() -> String {
    with_constants(include_str!("item_buffer.wgsl"))
}

/// The text of `merger.wgsl`, ready to compile.
pub fn merger_wgsl() -> String {
    with_constants(include_str!("merger.wgsl"))
}

fn with_constants(wgsl: &str) -> String {
    let integers = [
        ("ALPHA_BACK_FACE", ALPHA_BACK_FACE.into()),
        ("ALPHA_PATCH", ALPHA_PATCH.into()),
        ("NO_PATCH", NO_PATCH.0),
        ("WORKGROUP_SIZE", WORKGROUP_SIZE),
        ("PIXELS_PER_THREAD", PIXELS_PER_THREAD),
    ];
    integers
        .iter()
        .map(|(name, value)| format!("const {name}: u32 = {value}u;\n"))
        .chain([
            format!("const BACK_FACE_RETREAT: f32 = {BACK_FACE_RETREAT:?}f;\n"),
            format!("const MIN_GROWTH: f32 = {MIN_GROWTH:?}f;\n"),
            format!("const FRONT_FACE_OUTSET: f32 = {FRONT_FACE_OUTSET:?}f;\n"),
            format!("const PRODUCT_ULPS: f32 = {PRODUCT_ULPS:?}f;\n"),
            format!("const MOST_MARGIN: f32 = {MOST_MARGIN:?}f;\n"),
            format!("const RASTERISED_OUTSET: f32 = {RASTERISED_OUTSET:?}f;\n"),
            format!(
                "const COORDINATE_ULPS: f32 = {:?}f;\n",
                COORDINATE_ULPS as f32
            ),
            wgsl.into(),
        ])
        .collect()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::mem::offset_of;

    use super::*;

    /// Name, offset and size of each member; and the size of the whole.
    type Layout = (Vec<(String, u32, u32)>, u32);

    macro_rules! layout {
        ($type:ty { $($wgsl:literal = $field:ident: $kind:ty),* }) => {{
            let value = <$type>::zeroed();
            // Fails to compile where the type named here is not the field's.
            $(let _: $kind = value.$field;)*
            let members = vec![
                $(($wgsl.into(), offset_of!($type, $field) as u32, size_of::<$kind>() as u32)),*
            ];
            (members, size_of::<$type>() as u32)
        }};
    }

    fn layouts_in_rust() -> Vec<(&'static str, Layout)> {
        type V = [f32; 3];
        vec![
            (
                "Surface",
                layout!(Surface {
                    "corner_0" = corner_0: V, "first_patch" = first_patch: u32,
                    "corner_1" = corner_1: V, "depth" = depth: u32,
                    "corner_2" = corner_2: V, "padding" = padding: u32
                }),
            ),
            (
                "Face",
                layout!(Face {
                    "eye_high" = eye_high: V, "bottom" = bottom: f32,
                    "eye_low" = eye_low: V, "height" = height: f32,
                    "right" = right: V, "origin_x" = origin_x: f32,
                    "up" = up: V, "origin_y" = origin_y: f32,
                    "forward" = forward: V, "padding" = padding: f32
                }),
            ),
            (
                "DrawSettings",
                layout!(DrawSettings {
                    "near" = near: f32, "plane_tolerance" = plane_tolerance: f32,
                    "pixel" = pixel: f32, "padding" = padding: f32
                }),
            ),
            (
                "Tile",
                layout!(Tile {
                    "origin_x" = origin_x: u32, "origin_y" = origin_y: u32, "row" = row: u32,
                    "first_factor" = first_factor: u32, "factor_period" = factor_period: u32
                }),
            ),
            (
                "MergeSettings",
                layout!(MergeSettings {
                    "resolution" = resolution: u32, "patch_count" = patch_count: u32,
                    "words_per_row" = words_per_row: u32, "blocks_per_row" = blocks_per_row: u32,
                    "row_count" = row_count: u32
                }),
            ),
            (
                "RowSummary",
                layout!(RowSummary { "end" = end: u32, "open" = open: u32, "back_face" = back_face: u32 }),
            ),
            // `patch` is a reserved word in WGSL.
            (
                "Entry",
                layout!(CountedEntry { "patch_id" = patch: u32, "units" = units: u32 }),
            ),
        ]
    }

    fn parsed(wgsl: &str) -> naga::Module {
        naga::front::wgsl::parse_str(wgsl)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(wgsl)))
    }

    /// All structs of a shader that lie in buffers.
    fn layouts_in_wgsl(wgsl: &str) -> Vec<(String, Layout)> {
        let module = parsed(wgsl);
        let mut layouter = naga::proc::Layouter::default();
        layouter.update(module.to_ctx()).unwrap();
        let mut layouts = Vec::new();
        for (_, ty) in module.types.iter() {
            let (Some(name), naga::TypeInner::Struct { members, span }) = (&ty.name, &ty.inner)
            else {
                continue;
            };
            if members.iter().any(|member| member.binding.is_some()) {
                continue; // passed between shader stages
            }
            let members = members
                .iter()
                .map(|m| (m.name.clone().unwrap(), m.offset, layouter[m.ty].size))
                .collect();
            layouts.push((name.clone(), (members, *span)));
        }
        layouts
    }

    /// Every shader of this folder, by its file name.
    fn shaders() -> Vec<(String, String)> {
        vec![
            ("item_buffer.wgsl".into(), item_buffer_wgsl()),
            ("merger.wgsl".into(), merger_wgsl()),
        ]
    }

    #[test]
    fn every_shader_of_the_folder_is_valid() {
        let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src/gpu");
        let files: BTreeSet<String> = std::fs::read_dir(folder)
            .unwrap()
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .filter(|name| {
                std::path::Path::new(name)
                    .extension()
                    .is_some_and(|extension| extension == "wgsl")
            })
            .collect();
        assert!(!files.is_empty());
        assert_eq!(files, shaders().into_iter().map(|(name, _)| name).collect());
        for (name, wgsl) in shaders() {
            naga::valid::Validator::new(
                naga::valid::ValidationFlags::all(),
                naga::valid::Capabilities::empty(),
            )
            .validate(&parsed(&wgsl))
            .unwrap_or_else(|error| panic!("{name}: {}", error.emit_to_string(&wgsl)));
        }
    }

    #[test]
    fn structs_lie_in_memory_as_the_shaders_see_them() {
        let in_rust = layouts_in_rust();
        let mut seen = BTreeSet::new();
        for (file, wgsl) in shaders() {
            for (name, layout) in layouts_in_wgsl(&wgsl) {
                let (_, expected) = in_rust
                    .iter()
                    .find(|(known, _)| *known == name)
                    .unwrap_or_else(|| panic!("{file}: {name} is not known in Rust"));
                assert_eq!(layout, *expected, "{file}: {name}");
                seen.insert(name);
            }
        }
        assert_eq!(
            seen,
            in_rust.iter().map(|(name, _)| (*name).into()).collect()
        );
    }

    #[test]
    fn a_moved_member_would_be_noticed() {
        let moved = item_buffer_wgsl().replacen("near: f32,", "near: vec2f,", 1);
        let layouts = layouts_in_wgsl(&moved);
        let (_, layout) = layouts.iter().find(|(n, _)| n == "DrawSettings").unwrap();
        let in_rust = layouts_in_rust();
        let (_, expected) = in_rust.iter().find(|(n, _)| *n == "DrawSettings").unwrap();
        assert_ne!(layout, expected);
    }
}
