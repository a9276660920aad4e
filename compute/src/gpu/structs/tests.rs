//! What Rust and the shaders share is the same on both sides.

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
                "forward" = forward: V, "horizon" = horizon: u32
            }),
        ),
        (
            "DrawSettings",
            layout!(DrawSettings {
                "near" = near: f32, "plane_tolerance" = plane_tolerance: f32,
                "pixel" = pixel: f32, "resolution" = resolution: u32,
                "surface_count" = surface_count: u32, "atlas_width" = atlas_width: f32,
                "atlas_height" = atlas_height: f32, "padding" = padding: u32
            }),
        ),
        (
            "Projected",
            layout!(Projected {
                "edge_0" = edge_0: V, "first_patch" = first_patch: u32,
                "edge_1" = edge_1: V, "depth" = depth: u32,
                "edge_2" = edge_2: V, "is_back_face" = is_back_face: u32,
                "margins" = margins: V, "face" = face: u32,
                "inverse_depth" = inverse_depth: V, "padding" = padding: u32,
                "corner_0" = corner_0: V, "padding_0" = padding_0: u32,
                "corner_1" = corner_1: V, "padding_1" = padding_1: u32,
                "corner_2" = corner_2: V, "padding_2" = padding_2: u32
            }),
        ),
        (
            "Span",
            layout!(Span { "start" = start: u32, "end" = end: u32 }),
        ),
        (
            "DrawArguments",
            layout!(DrawArguments {
                "vertex_count" = vertex_count: u32, "instance_count" = instance_count: u32,
                "first_vertex" = first_vertex: u32, "first_instance" = first_instance: u32
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
        let (Some(name), naga::TypeInner::Struct { members, span }) = (&ty.name, &ty.inner) else {
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
    let part = |wgsl| with_constants(&[wgsl]);
    let shaders = [
        (
            "inclusive_sum.wgsl",
            part(include_str!("../inclusive_sum.wgsl")),
        ),
        (
            "item_buffer.wgsl",
            part(include_str!("../item_buffer.wgsl")),
        ),
        ("merger.wgsl", merger_wgsl()),
        ("projection.wgsl", projection_wgsl()),
        ("raster_compute.wgsl", raster_compute_wgsl()),
        ("raster_pipeline.wgsl", raster_pipeline_wgsl()),
    ];
    shaders.map(|(name, wgsl)| (name.into(), wgsl)).into()
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
            naga::valid::Capabilities::CLIP_DISTANCES,
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
    let moved = projection_wgsl().replacen("near: f32,", "near: vec2f,", 1);
    let layouts = layouts_in_wgsl(&moved);
    let (_, layout) = layouts.iter().find(|(n, _)| n == "DrawSettings").unwrap();
    let in_rust = layouts_in_rust();
    let (_, expected) = in_rust.iter().find(|(n, _)| *n == "DrawSettings").unwrap();
    assert_ne!(layout, expected);
}
