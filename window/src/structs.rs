//! All data that Rust and the shader share: structs, constants, and the shader itself.
//!
//! The constants are typed here only, and are put in front of the shader's text. The structs are typed there too; a test compares
//! every offset and size.

use bytemuck::{Pod, Zeroable};
use display::luminance::luminance;
use display::{Channel, Mode};
use scene::{NO_PATCH, Rgb};

/// No root: the surface has no vertices, and shows what its patches have.
pub const NO_ROOT: u32 = u32::MAX;

/// Numbers of [`Mode`]s.
const MODES: [(&str, Mode); 5] = [
    ("MODE_LOG", Mode::Log),
    ("MODE_FILMIC", Mode::Filmic),
    ("MODE_LINEAR", Mode::Linear),
    ("MODE_FALSE_COLOR", Mode::FalseColor),
    ("MODE_IDS", Mode::Ids),
];

/// Numbers of [`Channel`]s.
const CHANNELS: [(&str, Channel); 5] = [
    ("CHANNEL_ALL", Channel::All),
    ("CHANNEL_LUMINANCE", Channel::Luminance),
    ("CHANNEL_RED", Channel::Red),
    ("CHANNEL_GREEN", Channel::Green),
    ("CHANNEL_BLUE", Channel::Blue),
];

/// Entries of the table of false colours: as many as the table of [`display::tone`] has.
pub const COLORS: u32 = 1024;

/// The outline of the patch that is picked, sRGB codes over 255: a magenta that no false colour and few walls have.
const OUTLINE: [f32; 3] = [1.0, 0.15, 0.75];
/// Half the width of its sides, pixels of the screen.
const OUTLINE_WIDTH: f32 = 2.0;
/// The least height of a patch in the picture, pixels of the screen, below which the outline covers all of it.
const OUTLINED_HEIGHT: f32 = 6.0;
/// Half the width of the wires, pixels of the screen.
const WIRE_WIDTH: f32 = 0.5;
/// Share of a wire's colour that is its own.
const WIRE_OPACITY: f32 = 0.6;
/// Patches of such heights in the picture, pixels of the screen, lose their wires and have them whole: where all would be wires
/// one would see nothing.
const WIRED_HEIGHTS: [f32; 2] = [2.0, 5.0];

/// What of a surface the shader knows.
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
    /// Index of its node of the function's mesh, or [`NO_ROOT`].
    pub root: u32,
    /// Index of its material.
    pub material: u32,
    /// Fills the struct up to its alignment.
    pub padding: [u32; 3],
}

/// What is shown of a material's function: `more + factor * value`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub struct Material {
    /// What is added, in the unit of what is shown.
    pub more: [f32; 3],
    /// Fills the struct up to its alignment.
    pub padding_0: u32,
    /// What values at vertices are multiplied by.
    pub factor: [f32; 3],
    /// Fills the struct up to its alignment.
    pub padding_1: u32,
}

/// What is the same for all pixels.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct View {
    /// The eye, metres, relative to the scene's origin.
    pub eye: [f32; 3],
    /// Half the picture's width on the plane at distance 1, dimensionless.
    pub half_width: f32,
    /// Unit vector to the picture's right.
    pub right: [f32; 3],
    /// Half the picture's height on the plane at distance 1, dimensionless.
    pub half_height: f32,
    /// Unit vector to the picture's top.
    pub up: [f32; 3],
    /// Distance of the near plane, metres.
    pub near: f32,
    /// Unit vector into the picture.
    pub forward: [f32; 3],
    /// Samples along a pixel's side.
    pub samples: f32,
    /// A value's place on the scale is `(f(value) - start) * factor`, f the identity or the logarithm.
    pub start: f32,
    /// See [`Self::start`].
    pub factor: f32,
    /// Whether f is the logarithm, 0 or 1.
    pub is_logarithmic: u32,
    /// Number of the [`Mode`].
    pub mode: u32,
    /// Number of the [`Channel`], which values between vertices are shown of.
    pub channel: u32,
    /// Whether surfaces with a root show their function, 0 or 1.
    pub has_function: u32,
    /// Whether patches have wires, 0 or 1.
    pub has_wires: u32,
    /// The patch that is outlined, or [`NO_PATCH`].
    pub picked: u32,
}

/// A mode's number.
pub fn number_of_mode(mode: Mode) -> u32 {
    number(&MODES, mode)
}

/// A channel's number.
pub fn number_of_channel(channel: Channel) -> u32 {
    number(&CHANNELS, channel)
}

fn number<T: Copy + PartialEq>(table: &[(&str, T)], value: T) -> u32 {
    (0..)
        .zip(table)
        .find(|(_, (_, there))| *there == value)
        .map_or(0, |(number, _)| number)
}

/// The text of `surfaces.wgsl`, ready to compile.
pub fn surfaces_wgsl() -> String {
    let names = MODES.map(|(name, _)| name);
    let numbers = (0..).zip(names.into_iter().chain(CHANNELS.map(|(name, _)| name)));
    let integers = numbers
        .map(|(number, name)| (name, number % MODES.len() as u32))
        .chain([
            ("NO_PATCH", NO_PATCH.0),
            ("NO_ROOT", NO_ROOT),
            ("COLORS", COLORS),
        ])
        .map(|(name, value)| format!("const {name}: u32 = {value}u;\n"));
    let floats = [
        ("OUTLINE_WIDTH", OUTLINE_WIDTH),
        ("OUTLINED_HEIGHT", OUTLINED_HEIGHT),
        ("WIRE_WIDTH", WIRE_WIDTH),
        ("WIRE_OPACITY", WIRE_OPACITY),
        ("WIRED_FROM", WIRED_HEIGHTS[0]),
        ("WIRED_WHOLE", WIRED_HEIGHTS[1]),
    ]
    .map(|(name, value)| format!("const {name}: f32 = {value:?}f;\n"));
    let vectors = [
        ("OUTLINE", OUTLINE),
        ("LUMINANCE_WEIGHTS", [Rgb::X, Rgb::Y, Rgb::Z].map(luminance)),
    ]
    .map(|(name, [x, y, z])| format!("const {name}: vec3f = vec3f({x:?}f, {y:?}f, {z:?}f);\n"));
    integers
        .chain(floats)
        .chain(vectors)
        .chain([include_str!("surfaces.wgsl").to_owned()])
        .collect()
}

#[cfg(test)]
mod tests {
    use std::mem::offset_of;

    use super::*;

    type Layout = Vec<(String, u32)>;

    macro_rules! layout {
        ($type:ident: $($field:ident),*) => {
            (stringify!($type), vec![$((stringify!($field).to_owned(), offset_of!($type, $field) as u32)),*], size_of::<$type>() as u32)
        };
    }

    fn in_rust() -> [(&'static str, Layout, u32); 3] {
        [
            layout!(Surface: corner_0, first_patch, corner_1, depth, corner_2, root, material),
            layout!(Material: more, factor),
            layout!(View: eye, half_width, right, half_height, up, near, forward, samples, start, factor, is_logarithmic, mode,
                channel, has_function, has_wires, picked),
        ]
    }

    fn in_wgsl(wgsl: &str) -> Vec<(String, Layout, u32)> {
        let module = naga::front::wgsl::parse_str(wgsl)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(wgsl)));
        let structs = module.types.iter().filter_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { members, span } => {
                Some((ty.name.clone().unwrap(), members, *span))
            }
            _ => None,
        });
        structs
            .map(|(name, members, span)| {
                let members = members.iter().map(|m| (m.name.clone().unwrap(), m.offset));
                (name, members.collect(), span)
            })
            .collect()
    }

    #[test]
    fn the_shader_is_valid() {
        let wgsl = surfaces_wgsl();
        let module = naga::front::wgsl::parse_str(&wgsl)
            .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&wgsl)));
        naga::valid::Validator::new(
            naga::valid::ValidationFlags::all(),
            naga::valid::Capabilities::empty(),
        )
        .validate(&module)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(&wgsl)));
    }

    #[test]
    fn structs_lie_in_memory_as_the_shader_sees_them() {
        let there = in_wgsl(&surfaces_wgsl());
        for (name, members, size) in in_rust() {
            let (_, seen, span) = there.iter().find(|(n, _, _)| n == name).unwrap();
            assert_eq!((seen, *span), (&members, size), "{name}");
        }
    }

    #[test]
    fn a_moved_member_would_be_noticed() {
        let moved = surfaces_wgsl().replacen("near: f32,", "near: vec2f,", 1);
        let there = in_wgsl(&moved);
        let (_, seen, _) = there.iter().find(|(n, _, _)| n == "View").unwrap();
        assert_ne!(*seen, in_rust()[2].1);
    }

    #[test]
    fn every_mode_and_channel_has_a_number_of_its_own_in_the_shader() {
        let wgsl = surfaces_wgsl();
        for (name, mode) in MODES {
            let line = format!("const {name}: u32 = {}u;", number_of_mode(mode));
            assert!(wgsl.contains(&line), "{line}");
        }
        for (name, channel) in CHANNELS {
            let line = format!("const {name}: u32 = {}u;", number_of_channel(channel));
            assert!(wgsl.contains(&line), "{line}");
        }
    }
}
