//! Boxes, and rooms made of boxes.

use glam::{DVec3, Vec3};
use scene::planar::box_sides;
use scene::{Material, MaterialId, ObjectId, Scene, Surface};

/// A grey material: reflectance, dimensionless, and emission, W/m^2.
pub fn material(reflectance: f32, emission: f32) -> Material {
    Material {
        name: "wall".into(),
        reflectance: Vec3::splat(reflectance),
        emission: Vec3::splat(emission),
    }
}

/// A quadrilateral, counter-clockwise from its front, as two triangles.
pub fn quad(corners: [Vec3; 4], material: u32) -> [Surface; 2] {
    let surface = |corners| Surface {
        corners,
        material: MaterialId(material),
        object: ObjectId(0),
    };
    let [a, b, c, d] = corners;
    [surface([a, b, c]), surface([a, c, d])]
}

/// The twelve triangles of a box, seen from inside, or from outside if `solid`.
pub fn block(low: Vec3, high: Vec3, solid: bool, material: u32) -> Vec<Surface> {
    let sides = box_sides(low.as_dvec3(), high.as_dvec3()).into_iter();
    sides
        .flat_map(|mut side| {
            if solid {
                side.reverse();
            }
            quad(side.map(DVec3::as_vec3), material)
        })
        .collect()
}

/// The same triangles with every corner moved a little, the same way wherever it occurs, so that no
/// ray from one patch's centroid meets an edge exactly.
pub fn shaken(surfaces: Vec<Surface>) -> Vec<Surface> {
    let shake = |p: Vec3| {
        let phase = p.dot(Vec3::new(12.9898, 78.233, 37.719));
        p + 0.05 * Vec3::new(phase.sin(), (1.7 * phase).cos(), (2.3 * phase).sin())
    };
    surfaces
        .into_iter()
        .map(|s| Surface {
            corners: s.corners.map(shake),
            ..s
        })
        .collect()
}

/// A scene of one object.
pub fn scene(materials: Vec<Material>, surfaces: Vec<Surface>, max_area: f64) -> Scene {
    Scene::with_max_area(
        materials,
        vec!["all".into()],
        surfaces,
        max_area,
        DVec3::ZERO,
    )
    .unwrap()
}

/// A closed unit cube whose walls all emit and reflect alike.
pub fn furnace(reflectance: f32, emission: f32, max_area: f64) -> Scene {
    scene(
        vec![material(reflectance, emission)],
        block(Vec3::ZERO, Vec3::ONE, false, 0),
        max_area,
    )
}

/// A closed room with two blocks floating in it.
pub fn furnished_room(max_area: f64) -> Scene {
    scene(
        vec![material(0.5, 0.0), material(0.3, 2.0)],
        furnished_room_surfaces(),
        max_area,
    )
}

/// The triangles of [`furnished_room`].
pub fn furnished_room_surfaces() -> Vec<Surface> {
    let mut surfaces = block(Vec3::ZERO, Vec3::new(4.0, 3.0, 2.0), false, 0);
    surfaces.extend(block(
        Vec3::new(1.0, 1.0, 0.5),
        Vec3::new(1.7, 1.4, 1.3),
        true,
        1,
    ));
    surfaces.extend(block(
        Vec3::new(2.5, 0.5, 0.2),
        Vec3::new(3.1, 2.1, 0.9),
        true,
        1,
    ));
    surfaces
}

/// A room whose walls differ in reflectance and emission, in every channel.
pub fn colourful_room(max_area: f64) -> Scene {
    let coloured = |reflectance: [f32; 3], emission: [f32; 3]| Material {
        name: "wall".into(),
        reflectance: reflectance.into(),
        emission: emission.into(),
    };
    let mut surfaces = furnished_room_surfaces();
    // The ceiling is a lamp, and one wall is red.
    for (first, material) in [(2, 2), (4, 3)] {
        for surface in &mut surfaces[first..first + 2] {
            surface.material = MaterialId(material);
        }
    }
    scene(
        vec![
            coloured([0.5, 0.6, 0.7], [0.0; 3]),
            coloured([0.3, 0.2, 0.1], [0.0, 0.0, 0.5]),
            coloured([0.1, 0.2, 0.3], [10.0, 8.0, 6.0]),
            coloured([0.75, 0.05, 0.05], [0.0; 3]),
        ],
        surfaces,
        max_area,
    )
}
