//! Small scenes: rooms and boxes, turned in space.

use compute::hemicube::Frame;
use compute::hemicubes::Hemicubes;
use glam::{DQuat, DVec3, EulerRot};
use scene::{Material, MaterialId, ObjectId, PatchId, Scene, Surface};

/// Triangles of quads, turned in space so that nothing lies along an axis.
#[derive(Default)]
pub struct Model {
    pub triangles: Vec<[DVec3; 3]>,
}

impl Model {
    /// Corners counter-clockwise as seen from the front.
    fn quad(&mut self, [a, b, c, d]: [DVec3; 4]) {
        self.triangles.extend([[a, b, c], [a, c, d]]);
    }

    /// The sides of a box, seen from outside, or from inside if it is a room.
    fn cuboid(&mut self, low: DVec3, high: DVec3, is_room: bool) {
        let corner = |k: usize| {
            DVec3::new(
                if k & 1 == 0 { low.x } else { high.x },
                if k & 2 == 0 { low.y } else { high.y },
                if k & 4 == 0 { low.z } else { high.z },
            )
        };
        for side in [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ] {
            let mut corners = side.map(corner);
            if is_room {
                corners.reverse();
            }
            self.quad(corners);
        }
    }

    fn surfaces(&self) -> Vec<Surface> {
        let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, 0.5, 0.7);
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
    Hemicubes::new(scene, super::settings(2)).frames(patch)[0]
}
