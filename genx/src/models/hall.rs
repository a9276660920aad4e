//! Model 2: a hall with columns and many kinds of shadow.
//!
//! Two rows of columns along an aisle, a partition with a portal and a passage beside its free end,
//! and behind it a second room. Two ceiling panels cast soft shadows of the columns, a glowing cube
//! on the floor long ones over the walls, a third panel shines through portal and passage, and
//! podium and bench shade the floor beside them.
//!
//! ```text
//!   z
//!   8 +-------bench-----------------+------------+
//!     |                                          |
//!   6 |     []      []      []      +--+         |
//!     |                             |  |         |
//!   5 |#                            +--+         |     plan in cells; [] columns,
//!   4 |# (o)     (o)     *         portal        |     (o) ceiling panels, * glowing cube,
//!   3 |#                            +--+         |     # podium
//!     |                             |  |         |
//!   2 |     []      []      []      |  |   (o)   |
//!     |                             |  |         |
//!   0 +-----------------------------+--+---------+
//!     0     2       4       6       7  8         11  x
//! ```
//!
//! # Size
//! The thesis's thresholds of 5, 1 and 0.25 m^2 and its 26,360, 136,512 and 546,048 triangles ask for
//! an area of some 100,000 m^2: a hall ten times the size that its proportions suggest. Radiosity
//! does not depend on scale.

use scene::Rgb;

use super::{emission_or, reflectance_or};
use crate::Settings;
use crate::builder::{Builder, Look, Plane};
use crate::grid::{Cell, Face, Grid};

/// Default area threshold, m^2: the coarsest of the thesis's table.
pub const MAX_AREA: f64 = 5.0;

/// What the lengths below are multiplied by. Tuned so that the numbers of patches at thresholds of
/// 5, 1 and 0.25 m^2 come close to the thesis's.
const SCALE: f64 = 0.93;

/// Where the cells end, in metres before scaling. No cell is longer than sqrt(3) times its width.
const X: [f64; 12] = [
    0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0, 152.0, 168.0, 184.0, 200.0,
];
const Y: [f64; 4] = [0.0, 12.0, 26.0, 40.0];
const Z: [f64; 9] = [0.0, 20.0, 40.0, 60.0, 80.0, 100.0, 120.0, 140.0, 160.0];

/// The cells along x that the partition fills.
const PARTITION_X: usize = 7;

/// A square hole in the floor or the ceiling, where two by two cells meet.
struct Spot {
    /// First of its two cells along x, and along z.
    cells: [usize; 2],
    /// Length of its edges, metres before scaling.
    width: f64,
}

impl Spot {
    const fn new(x: usize, z: usize, width: f64) -> Self {
        Self {
            cells: [x, z],
            width,
        }
    }

    /// Whether one of its cells is the one at x, z.
    fn covers(&self, x: usize, z: usize) -> bool {
        let [first_x, first_z] = self.cells;
        (first_x..first_x + 2).contains(&x) && (first_z..first_z + 2).contains(&z)
    }

    /// Extent of the hole along x and along z, metres.
    fn hole(&self, ticks: &Ticks) -> [[f64; 2]; 2] {
        let [x, z] = self.cells;
        [ticks.x[x + 1], ticks.z[z + 1]]
            .map(|centre| [-0.5, 0.5].map(|half| centre + half * self.width * SCALE))
    }
}

/// From floor to ceiling.
const COLUMNS: [Spot; 6] = [
    Spot::new(1, 1, 9.0),
    Spot::new(3, 1, 9.0),
    Spot::new(5, 1, 9.0),
    Spot::new(1, 5, 9.0),
    Spot::new(3, 5, 9.0),
    Spot::new(5, 5, 9.0),
];

/// In the ceiling of the hall.
const PANELS: [Spot; 2] = [Spot::new(1, 3, 14.0), Spot::new(3, 3, 14.0)];

/// In the ceiling behind the partition.
const BACK_PANEL: Spot = Spot::new(8, 1, 11.0);

/// A glowing cube standing on the floor.
const LANTERN: Spot = Spot::new(5, 3, 9.0);

/// The cells' ends, metres.
struct Ticks {
    x: [f64; 12],
    y: [f64; 4],
    z: [f64; 9],
}

fn is_partition([x, y, z]: Cell) -> bool {
    let in_portal = (3..5).contains(&z) && y < 2;
    x == PARTITION_X && z < 6 && !in_portal
}

fn is_podium([x, y, z]: Cell) -> bool {
    x == 0 && y == 0 && (3..5).contains(&z)
}

fn is_bench([x, y, z]: Cell) -> bool {
    (3..5).contains(&x) && y == 0 && z == 7
}

/// What the room and the blocks in it look like.
struct Looks {
    floor: Look,
    ceiling: Look,
    wall: Look,
    partition: Look,
    podium: Look,
    bench: Look,
}

impl Looks {
    fn of(&self, face: &Face) -> Look {
        match face.solid {
            Some(cell) if is_partition(cell) => self.partition,
            Some(cell) if is_podium(cell) => self.podium,
            Some(_) => self.bench,
            None if face.plane.axis != 1 => self.wall,
            None if face.plane.positive => self.floor,
            None => self.ceiling,
        }
    }
}

pub fn build(settings: &Settings) -> Builder {
    let mut builder = Builder::default();
    let mut solid =
        |name: &str, own| builder.look(name, reflectance_or(settings, Rgb::from(own)), Rgb::ZERO);
    let looks = Looks {
        floor: solid("floor", [0.46, 0.36, 0.27]),
        ceiling: solid("ceiling", [0.82, 0.81, 0.78]),
        wall: solid("wall", [0.70, 0.67, 0.60]),
        partition: solid("partition", [0.62, 0.33, 0.24]),
        podium: solid("podium", [0.34, 0.45, 0.52]),
        bench: solid("bench", [0.42, 0.50, 0.34]),
    };
    let column = solid("columns", [0.72, 0.66, 0.55]);
    let mut lamp = |name: &str, tint| {
        let glass = reflectance_or(settings, Rgb::splat(0.5));
        builder.look(name, glass, emission_or(settings, Rgb::from(tint)))
    };
    let panel = lamp("ceiling panels", [1.0, 0.92, 0.80]);
    let back_panel = lamp("back panel", [0.62, 0.80, 1.0]);
    let lantern = lamp("lantern", [1.0, 0.62, 0.30]);

    let ticks = Ticks {
        x: X.map(|x| x * SCALE),
        y: Y.map(|y| y * SCALE),
        z: Z.map(|z| z * SCALE),
    };
    room(&mut builder, &ticks, &looks);
    for spot in &COLUMNS {
        let [x, z] = spot.hole(&ticks);
        builder.column(x, z, &ticks.y, column);
    }
    let [floor, ceiling] = floor_and_ceiling(&ticks);
    for (spot, look) in [
        (&PANELS[0], panel),
        (&PANELS[1], panel),
        (&BACK_PANEL, back_panel),
    ] {
        let [x, z] = spot.hole(&ticks);
        builder.rectangle(ceiling, z, x, look);
    }
    let [x, z] = LANTERN.hole(&ticks);
    let height = LANTERN.width * SCALE;
    builder.column(x, z, &[floor.at, height], lantern);
    let top = Plane {
        at: height,
        ..floor
    };
    builder.rectangle(top, z, x, lantern);
    builder
}

fn floor_and_ceiling(ticks: &Ticks) -> [Plane; 2] {
    [(0, true), (3, false)].map(|(level, positive)| Plane {
        axis: 1,
        at: ticks.y[level],
        positive,
    })
}

/// Floor, ceiling, walls, partition, podium and bench, with holes in floor and ceiling where columns
/// and lamps are.
fn room(builder: &mut Builder, ticks: &Ticks, looks: &Looks) {
    let mut grid = Grid::new([ticks.x.to_vec(), ticks.y.to_vec(), ticks.z.to_vec()]);
    grid.fill(|cell| is_partition(cell) || is_podium(cell) || is_bench(cell));

    let [floor, ceiling] = floor_and_ceiling(ticks);
    let holes: [(Plane, Vec<&Spot>); 2] = [
        (floor, COLUMNS.iter().chain([&LANTERN]).collect()),
        (
            ceiling,
            COLUMNS.iter().chain(&PANELS).chain([&BACK_PANEL]).collect(),
        ),
    ];
    for face in grid.faces() {
        let [x, _, z] = face.empty;
        let has_hole = holes
            .iter()
            .any(|(plane, spots)| *plane == face.plane && spots.iter().any(|s| s.covers(x, z)));
        if !has_hole {
            builder.rectangle(face.plane, face.u, face.v, looks.of(&face));
        }
    }
    for (plane, spots) in holes {
        let look = if plane == floor {
            looks.floor
        } else {
            looks.ceiling
        };
        for spot in spots {
            let [x, z] = spot.cells;
            let [hole_x, hole_z] = spot.hole(ticks);
            builder.frame(
                plane,
                [0, 1, 2].map(|k| ticks.z[z + k]),
                [0, 1, 2].map(|k| ticks.x[x + k]),
                hole_z,
                hole_x,
                look,
            );
        }
    }
}
