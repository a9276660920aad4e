//! The Cornell box: Cornell University Program of Graphics, "The Cornell Box", data page
//! (<https://www.graphics.cornell.edu/online/box/data.html>), measured in millimetres, here metres.
//!
//! Its front, at z = 0, is open. The blocks have no bottoms: they stand on cut-outs of the floor. The
//! published left (red) wall is not planar; it is two triangles that meet in the diagonal from
//! its lower front corner. Reflectances and emission are linear RGB, integrated from the published spectra.
//!
//! # Differences
//! The published quadrilaterals are cut finer, so that no triangle's longest side is over twice
//! its shortest: see [`super::cornell_mesh`].

use glam::DVec3;
use scene::Rgb;

use super::cornell_mesh::{
    CEILING_CORNERS, CEILING_FRONT, CEILING_TRIANGLES, DEPTHS, FLOOR_CORNERS, FLOOR_FRONT,
    FLOOR_TRIANGLES, WIDTHS,
};
use super::override_materials;
use crate::Settings;
use crate::builder::{Builder, Look};

/// Default area threshold, m^2.
pub const MAX_AREA: f64 = 0.001;

const WHITE: Rgb = Rgb::new(0.885_809, 0.698_859, 0.666_422);
const GREEN: Rgb = Rgb::new(0.105_421, 0.377_98, 0.076_425);
const RED: Rgb = Rgb::new(0.570_068, 0.043_013_5, 0.044_370_6);
/// Exitance of the light, W/m^2.
const LIGHT: Rgb = Rgb::new(57.764_5, 43.942_4, 21.217);

/// Depth and height of the room, mm.
const DEPTH: f64 = 559.2;
const HEIGHT: f64 = 548.8;
/// Width of the floor at the front and at the back, and of the ceiling, mm.
const FRONT_WIDTH: f64 = 552.8;
const BACK_WIDTH: f64 = 549.6;
const CEILING_WIDTH: f64 = 556.0;

/// Corners of a quadrilateral as x and z, mm.
type Outline = [[f64; 2]; 4];

/// Outlines of the blocks, counter-clockwise from above, and their heights, mm.
const SHORT_BLOCK: (Outline, f64) = (
    [[130.0, 65.0], [82.0, 225.0], [240.0, 272.0], [290.0, 114.0]],
    165.0,
);
const TALL_BLOCK: (Outline, f64) = (
    [
        [423.0, 247.0],
        [265.0, 296.0],
        [314.0, 456.0],
        [472.0, 406.0],
    ],
    330.0,
);
/// Outline of the light, counter-clockwise from below, mm.
const LIGHT_OUTLINE: Outline = [
    [343.0, 227.0],
    [343.0, 332.0],
    [213.0, 332.0],
    [213.0, 227.0],
];

pub fn build(settings: &Settings) -> Builder {
    let mut builder = Builder::default();
    let white = builder.material("white", WHITE, Rgb::ZERO);
    let green = builder.material("green", GREEN, Rgb::ZERO);
    let red = builder.material("red", RED, Rgb::ZERO);
    let light = builder.material("light", WHITE, LIGHT);
    override_materials(builder.materials_mut(), settings);
    let mut look = |name, material| Look {
        material,
        object: builder.object(name),
    };
    let floor = look("floor", white);
    let ceiling = look("ceiling", white);
    let lamp = look("light", light);
    let back_wall = look("back wall", white);
    let right_wall = look("right wall", green);
    let left_wall = look("left wall", red);
    let short_block = look("short block", white);
    let tall_block = look("tall block", white);

    level(&mut builder, &floor_corners(), &FLOOR_TRIANGLES, floor);
    level(
        &mut builder,
        &ceiling_corners(),
        &CEILING_TRIANGLES,
        ceiling,
    );
    quad(
        &mut builder,
        LIGHT_OUTLINE.map(|[x, z]| DVec3::new(x, HEIGHT, z)),
        lamp,
    );
    walls(&mut builder, back_wall, right_wall, left_wall);
    block(&mut builder, SHORT_BLOCK, 1, short_block);
    block(&mut builder, TALL_BLOCK, 2, tall_block);
    builder
}

/// A quadrilateral, mm, counter-clockwise from its front, cut from its first corner to its third.
fn quad(builder: &mut Builder, corners: [DVec3; 4], look: Look) {
    builder.quad(corners.map(metres), look);
}

fn metres(millimetres: DVec3) -> DVec3 {
    millimetres / 1000.0
}

/// `a` and `b` themselves at 0 and 1.
fn between(a: DVec3, b: DVec3, share: f64) -> DVec3 {
    a * (1.0 - share) + b * share
}

/// Triangles over numbered corners, mm.
fn level(builder: &mut Builder, corners: &[DVec3], triangles: &[[usize; 3]], look: Look) {
    for triangle in triangles {
        builder.triangle(triangle.map(|corner| metres(corners[corner])), look);
    }
}

/// Ends of the walls' cells along the depth and also the height, as shares: the same for both, so
/// that the left wall's fold passes through corners of cells.
fn shares() -> [f64; 4] {
    [0.0, DEPTHS[0] / DEPTH, DEPTHS[1] / DEPTH, 1.0]
}

/// The back wall at shares of its width, from the right, and of its height, mm.
fn back_wall_at(width: f64, height: f64) -> DVec3 {
    let right = DVec3::new(0.0, 0.0, DEPTH);
    let bottom = between(right, DVec3::new(BACK_WIDTH, 0.0, DEPTH), width);
    let right = DVec3::new(0.0, HEIGHT, DEPTH);
    let top = between(right, DVec3::new(CEILING_WIDTH, HEIGHT, DEPTH), width);
    between(bottom, top, height)
}

/// The right wall at shares of its depth and of its height, mm.
fn right_wall_at(depth: f64, height: f64) -> DVec3 {
    let bottom = between(DVec3::ZERO, DVec3::new(0.0, 0.0, DEPTH), depth);
    let front = DVec3::new(0.0, HEIGHT, 0.0);
    let top = between(front, DVec3::new(0.0, HEIGHT, DEPTH), depth);
    between(bottom, top, height)
}

/// The left wall, folded along the diagonal, at shares of its depth and of its height, mm.
fn left_wall_at(depth: f64, height: f64) -> DVec3 {
    let lower_front = DVec3::new(FRONT_WIDTH, 0.0, 0.0);
    let lower_back = DVec3::new(BACK_WIDTH, 0.0, DEPTH);
    let upper_front = DVec3::new(CEILING_WIDTH, HEIGHT, 0.0);
    let upper_back = DVec3::new(CEILING_WIDTH, HEIGHT, DEPTH);
    if depth >= height {
        lower_front * (1.0 - depth) + lower_back * (depth - height) + upper_back * height
    } else {
        lower_front * (1.0 - height) + upper_front * (height - depth) + upper_back * depth
    }
}

fn walls(builder: &mut Builder, back: Look, right: Look, left: Look) {
    let shares = shares();
    let widths = [0.0, WIDTHS[0], WIDTHS[1], 1.0];
    for i in 0..3 {
        for j in 0..3 {
            let (low, high) = (shares[j], shares[j + 1]);
            let (near, far) = (shares[i], shares[i + 1]);
            let cell = [(near, low), (far, low), (far, high), (near, high)];
            quad(builder, cell.map(|(d, h)| left_wall_at(d, h)), left);
            let cell = [(near, low), (near, high), (far, high), (far, low)];
            quad(builder, cell.map(|(d, h)| right_wall_at(d, h)), right);
            let (near, far) = (widths[i], widths[i + 1]);
            let cell = [(near, low), (near, high), (far, high), (far, low)];
            quad(builder, cell.map(|(w, h)| back_wall_at(w, h)), back);
        }
    }
}

/// Corners of the floor, mm, in the order the triangles number them.
fn floor_corners() -> Vec<DVec3> {
    let [_, near, far, _] = shares();
    let mut corners = vec![
        right_wall_at(0.0, 0.0),
        left_wall_at(0.0, 0.0),
        left_wall_at(1.0, 0.0),
        right_wall_at(1.0, 0.0),
    ];
    let on_floor = |[x, z]: [f64; 2]| DVec3::new(x, 0.0, z);
    corners.extend(SHORT_BLOCK.0.map(on_floor));
    corners.extend(TALL_BLOCK.0.map(on_floor));
    corners.extend([near, far].map(|depth| right_wall_at(depth, 0.0)));
    corners.extend([near, far].map(|depth| left_wall_at(depth, 0.0)));
    corners.extend(WIDTHS.map(|width| back_wall_at(width, 0.0)));
    corners.extend(FLOOR_FRONT.map(|x| DVec3::new(x, 0.0, 0.0)));
    corners.extend(FLOOR_CORNERS.map(on_floor));
    corners
}

/// Corners of the ceiling, mm, in the order the triangles number them.
fn ceiling_corners() -> Vec<DVec3> {
    let [_, near, far, _] = shares();
    let in_ceiling = |[x, z]: [f64; 2]| DVec3::new(x, HEIGHT, z);
    let mut corners = vec![
        right_wall_at(0.0, 1.0),
        left_wall_at(0.0, 1.0),
        left_wall_at(1.0, 1.0),
        right_wall_at(1.0, 1.0),
    ];
    corners.extend(LIGHT_OUTLINE.map(in_ceiling));
    corners.extend([near, far].map(|depth| right_wall_at(depth, 1.0)));
    corners.extend([near, far].map(|depth| left_wall_at(depth, 1.0)));
    corners.extend(WIDTHS.map(|width| back_wall_at(width, 1.0)));
    corners.extend(CEILING_FRONT.map(|x| DVec3::new(x, HEIGHT, 0.0)));
    corners.extend(CEILING_CORNERS.map(in_ceiling));
    corners
}

/// Sides, in so many storeys, and top of a block.
fn block(builder: &mut Builder, (outline, height): (Outline, f64), storeys: u32, look: Look) {
    let at = |level: u32| {
        let y = height * f64::from(level) / f64::from(storeys);
        outline.map(|[x, z]| DVec3::new(x, y, z))
    };
    for storey in 0..storeys {
        let (lower, upper) = (at(storey), at(storey + 1));
        for side in 0..4 {
            let next = (side + 1) % 4;
            let corners = [lower[side], lower[next], upper[next], upper[side]];
            quad(builder, corners, look);
        }
    }
    quad(builder, at(storeys), look);
}
