//! Small scenes: rooms and boxes, turned in space.

use compute::hemicubes::Hemicubes;
use compute::receivers::ReceiverId;
use glam::{DQuat, DVec3, EulerRot};
use scene::planar::box_sides;
use scene::{Material, MaterialId, ObjectId, PatchId, Scene, Surface};
use visibility::Frame;

/// The sides of a box: bottom, top, then the four around. Counter-clockwise as seen from outside, or
/// from inside if it is a room.
fn sides(low: DVec3, high: DVec3, is_room: bool) -> [[DVec3; 4]; 6] {
    box_sides(low, high).map(|mut corners| {
        if !is_room {
            corners.reverse();
        }
        corners
    })
}

/// Triangles of quads, turned in space so that nothing lies along an axis, unless it is upright.
#[derive(Clone, Default)]
pub struct Model {
    pub triangles: Vec<[DVec3; 3]>,
    pub is_upright: bool,
}

impl Model {
    /// Corners counter-clockwise as seen from the front.
    fn quad(&mut self, [a, b, c, d]: [DVec3; 4]) {
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// A quad in parts: its side from `a` to `b` is divided into the first number of them, that from
    /// `b` to `c` into the second.
    fn divided_quad(&mut self, [a, b, c, d]: [DVec3; 4], [along_ab, along_bc]: [u32; 2]) {
        let at = |i: u32, j: u32| {
            let (u, v) = (
                f64::from(i) / f64::from(along_ab),
                f64::from(j) / f64::from(along_bc),
            );
            a.lerp(b, u).lerp(d.lerp(c, u), v)
        };
        for j in 0..along_bc {
            for i in 0..along_ab {
                self.quad([at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
    }

    /// The parts of a horizontal rectangle around a hole: their corners lie on the edges of their
    /// neighbours. Counter-clockwise as seen from above, or from below.
    fn around_hole(&mut self, outer: [DVec3; 2], hole: [DVec3; 2], z: f64, is_floor: bool) {
        let ([o0, o1], [h0, h1]) = (outer, hole);
        for [x0, x1, y0, y1] in [
            [o0.x, h0.x, o0.y, o1.y],
            [h1.x, o1.x, o0.y, o1.y],
            [h0.x, h1.x, o0.y, h0.y],
            [h0.x, h1.x, h1.y, o1.y],
        ] {
            let mut corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1]];
            if !is_floor {
                corners.reverse();
            }
            self.quad(corners.map(|[x, y]| DVec3::new(x, y, z)));
        }
    }

    /// The sides of a box, seen from outside, or from inside if it is a room.
    fn cuboid(&mut self, low: DVec3, high: DVec3, is_room: bool) {
        for side in sides(low, high, is_room) {
            self.quad(side);
        }
    }

    fn surfaces(&self) -> Vec<Surface> {
        let turn = if self.is_upright {
            DQuat::IDENTITY
        } else {
            DQuat::from_euler(EulerRot::XYZ, 0.3, 0.5, 0.7)
        };
        self.triangles
            .iter()
            .map(|corners| Surface {
                corners: corners.map(|p| (turn * p).as_vec3()),
                material: MaterialId(0),
                object: ObjectId(0),
            })
            .collect()
    }

    pub fn scene(&self, max_area: f64) -> Scene {
        let material = Material {
            name: "grey".into(),
            reflectance: glam::Vec3::splat(0.5),
            emission: glam::Vec3::ZERO,
        };
        let objects = vec!["model".into()];
        Scene::with_max_area(
            vec![material],
            objects,
            self.surfaces(),
            max_area,
            DVec3::ZERO,
        )
        .unwrap()
    }
}

/// A closed room with two boxes that hover this high over its floor.
pub fn room_with_boxes_at(height: f64) -> Model {
    let low = height - 1.0;
    let mut model = Model::default();
    model.cuboid(
        DVec3::new(-2.0, -1.5, -1.0),
        DVec3::new(2.0, 1.5, 1.0),
        true,
    );
    model.cuboid(
        DVec3::new(-1.2, -0.9, low),
        DVec3::new(-0.3, 0.1, 0.5),
        false,
    );
    model.cuboid(DVec3::new(0.4, 0.0, low), DVec3::new(1.1, 1.0, -0.2), false);
    model
}

/// A closed room with two boxes on its floor, into which the patches below them look from inside.
pub fn room() -> Model {
    room_with_boxes_at(0.0)
}

/// Opposite corners of the rooms whose walls touch without sharing corners, m.
pub const ROOM: [DVec3; 2] = [DVec3::new(0.0, 0.0, 0.0), DVec3::new(4.0, 3.0, 2.0)];

/// A closed room with a block that stands on a cut-out of the floor, without a bottom.
pub fn room_with_block() -> Model {
    let (low, high) = (DVec3::new(1.1, 0.7, 0.0), DVec3::new(2.3, 1.6, 0.9));
    let mut model = Model::default();
    model.around_hole(ROOM, [low, high], 0.0, true);
    for side in &sides(ROOM[0], ROOM[1], true)[1..] {
        model.quad(*side);
    }
    for side in &sides(low, high, false)[1..] {
        model.quad(*side);
    }
    model
}

/// A closed room with a column between cut-outs of floor and ceiling.
pub fn room_with_column() -> Model {
    let (low, high) = (DVec3::new(1.3, 1.1, 0.0), DVec3::new(1.9, 1.7, 2.0));
    let mut model = Model::default();
    model.around_hole(ROOM, [low, high], 0.0, true);
    model.around_hole(ROOM, [low, high], 2.0, false);
    for side in &sides(ROOM[0], ROOM[1], true)[2..] {
        model.quad(*side);
    }
    for side in &sides(low, high, false)[2..] {
        model.quad(*side);
    }
    model
}

/// A closed room, each of whose sides is divided in its own way, so that no edge between two sides is
/// shared.
pub fn patchwork_room() -> Model {
    divided_room([[2, 3], [5, 1], [3, 7], [4, 2], [1, 6], [7, 5]])
}

/// The same of more surfaces than a workgroup has threads, in every face of a hemicube.
pub fn fine_patchwork_room() -> Model {
    divided_room([[22, 23], [25, 21], [23, 27], [24, 22], [21, 26], [27, 25]])
}

fn divided_room(parts: [[u32; 2]; 6]) -> Model {
    let mut model = Model::default();
    for (side, parts) in sides(ROOM[0], ROOM[1], true).into_iter().zip(parts) {
        model.divided_quad(side, parts);
    }
    model
}

/// A block seen from inside, by a tile in its middle, for which the edges of the block lie
/// symmetrically, and by one beside it: its triangles are the first four.
pub fn tiles_in_a_block() -> Model {
    let mut model = Model::default();
    for x in [-0.25, 0.4] {
        let at = |x, y| DVec3::new(x, y, -0.75);
        model.quad([
            at(x, -0.25),
            at(x + 0.5, -0.25),
            at(x + 0.5, 0.25),
            at(x, 0.25),
        ]);
    }
    model.cuboid(DVec3::splat(-1.0), DVec3::splat(1.0), false);
    model
}

/// Walls with gaps between them, and a sheet whose back is in view.
pub fn ruin() -> Model {
    let mut model = room();
    model
        .triangles
        .retain(|corners| corners.iter().any(|p| p.z < 0.9));
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.7);
    model.quad([at(-1.0, -1.0), at(-1.0, 0.5), at(1.0, 0.5), at(1.0, -1.0)]);
    model.quad([at(1.2, -1.0), at(1.8, -1.0), at(1.8, 1.0), at(1.2, 1.0)]);
    model
}

/// The room, with a box outside it that is millions of times as far away as its walls.
pub fn room_far_from_a_box() -> Model {
    let mut model = room();
    model.cuboid(DVec3::splat(1e7), DVec3::splat(1.1e7), false);
    model
}

/// The hemicube on a patch's centroid.
pub fn frame(scene: &Scene, patch: PatchId) -> Frame {
    Hemicubes::new(scene, super::settings(2))
        .receivers()
        .frames(ReceiverId(patch.0))[0]
}
