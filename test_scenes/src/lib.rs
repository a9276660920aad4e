//! Small scenes for tests and benchmarks, and what must be seen in them.

// They are for tests: a scene that cannot be made is a defect of the test.
#![allow(clippy::missing_panics_doc)]

mod bank;
mod dense;
mod objects;
mod rooms;
mod views;

pub use bank::{bank, moved_corner};
pub use dense::{Triangle, bumpy_sphere, furnished_sphere, stone};
pub use objects::{WALLS, grid, named, walls};
pub use rooms::{
    block, colourful_room, furnace, furnished_room, furnished_room_surfaces, material, quad, scene,
    shaken,
};
pub use views::{Difference, VIEW_RESOLUTION, Views};
