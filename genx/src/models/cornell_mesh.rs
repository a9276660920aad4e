//! How the Cornell box's floor and ceiling are cut into triangles around the blocks and the light.
//!
//! The blocks stand askew, 35 mm apart at one place and 65 mm from the floor's edge at another, so
//! no grid fits between them. The free corners were placed once, by simulated annealing of
//! Delaunay triangulations that hold all given sides, so that the longest side of each triangle is
//! at most 1.93 times its shortest, and rounded to millimetres. So were the places where the room's edges are
//! cut, which the walls share.
//!
//! Corners of the floor are numbered: 0 to 3 the room's (right front, left front, left back, right
//! back), 4 to 7 the short block's, 8 to 11 the tall block's, 12 and 13 on the right wall, 14 and 15
//! on the left wall, 16 and 17 on the back wall, 18 to 21 [`FLOOR_FRONT`], then [`FLOOR_CORNERS`].
//! Those of the ceiling likewise: 0 to 3 the room's, 4 to 7 the light's, 8 to 13 on the walls, 14
//! [`CEILING_FRONT`], then [`CEILING_CORNERS`].

/// Where the edges along the depth are cut, mm from the front.
pub const DEPTHS: [f64; 2] = [202.0, 389.0];

/// Where the edges along the back wall are cut, as shares of its width from the right.
pub const WIDTHS: [f64; 2] = [0.39, 0.72];

/// Where the floor's front edge is cut: x, mm.
pub const FLOOR_FRONT: [f64; 4] = [111.0, 234.0, 361.0, 443.0];

/// Free corners of the floor: x and z, mm.
pub const FLOOR_CORNERS: [[f64; 2]; 19] = [
    [333.0, 237.0],
    [470.0, 500.0],
    [286.0, 251.0],
    [152.0, 314.0],
    [214.0, 324.0],
    [223.0, 385.0],
    [112.0, 418.0],
    [466.0, 98.0],
    [47.0, 101.0],
    [467.0, 185.0],
    [348.0, 168.0],
    [390.0, 195.0],
    [373.0, 81.0],
    [307.0, 45.0],
    [500.0, 298.0],
    [75.0, 302.0],
    [410.0, 141.0],
    [305.0, 231.0],
    [298.0, 204.0],
];

/// Triangles of the floor, counter-clockwise from above.
#[rustfmt::skip] // one a line would be three screens
pub const FLOOR_TRIANGLES: [[usize; 3]; 62] = [
    [0, 12, 30], [0, 30, 18], [1, 21, 29], [1, 29, 14], [2, 15, 23], [2, 23, 17], [3, 16, 28],
    [3, 28, 13], [4, 7, 19], [4, 18, 30], [4, 19, 18], [4, 30, 5], [5, 12, 37], [5, 25, 6],
    [5, 30, 12], [5, 37, 25], [6, 9, 24], [6, 24, 40], [6, 25, 26], [6, 26, 9], [6, 40, 7],
    [7, 32, 34], [7, 34, 35], [7, 35, 19], [7, 40, 32], [8, 11, 36], [8, 22, 9], [8, 31, 33],
    [8, 33, 22], [8, 36, 31], [9, 22, 24], [9, 26, 27], [9, 27, 10], [10, 16, 17],
    [10, 17, 23], [10, 23, 11], [10, 27, 16], [11, 15, 36], [11, 23, 15], [12, 13, 37],
    [13, 28, 37], [14, 29, 31], [14, 31, 36], [14, 36, 15], [16, 27, 28], [19, 35, 20],
    [20, 34, 21], [20, 35, 34], [21, 34, 29], [22, 32, 40], [22, 33, 32], [22, 39, 24],
    [22, 40, 39], [24, 39, 40], [25, 27, 26], [25, 28, 27], [25, 37, 28], [29, 34, 38],
    [29, 38, 31], [31, 38, 33], [32, 33, 38], [32, 38, 34],
];

/// Where the ceiling's front edge is cut: x, mm.
pub const CEILING_FRONT: [f64; 1] = [278.0];

/// Free corners of the ceiling: x and z, mm.
pub const CEILING_CORNERS: [[f64; 2]; 4] = [
    [128.0, 111.0],
    [430.0, 356.0],
    [288.0, 424.0],
    [124.0, 373.0],
];

/// Triangles of the ceiling, counter-clockwise from below.
#[rustfmt::skip] // one a line would be a screen
pub const CEILING_TRIANGLES: [[usize; 3]; 23] = [
    [0, 14, 15], [0, 15, 8], [1, 4, 14], [1, 10, 4], [2, 13, 11], [3, 9, 18], [3, 18, 12],
    [4, 7, 14], [4, 10, 16], [4, 16, 5], [5, 16, 17], [5, 17, 6], [6, 17, 18], [6, 18, 7],
    [7, 8, 15], [7, 15, 14], [7, 18, 8], [8, 18, 9], [10, 11, 16], [11, 13, 16], [12, 17, 13],
    [12, 18, 17], [13, 17, 16],
];
