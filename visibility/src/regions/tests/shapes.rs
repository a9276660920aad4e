//! Triangles that form walls.

use glam::{DQuat, DVec3, Vec3};
use scene::{Material, MaterialId, ObjectId, Scene, Surface};

pub fn scene(triangles: impl IntoIterator<Item = [DVec3; 3]>) -> Scene {
    let material = |name: &str| Material {
        name: name.into(),
        reflectance: Vec3::splat(0.5),
        emission: Vec3::ZERO,
    };
    let surfaces = triangles
        .into_iter()
        .map(|corners| Surface {
            corners: corners.map(DVec3::as_vec3),
            material: MaterialId(0),
            object: ObjectId(0),
        })
        .collect::<Vec<_>>();
    let depths = vec![1; surfaces.len()];
    Scene::new(
        vec![material("wall")],
        vec!["all".into()],
        surfaces,
        &depths,
        DVec3::ZERO,
    )
    .unwrap()
}

/// Two triangles for each cell of a grid that `is_there`, in the plane z = 0.
pub fn grid(columns: u32, rows: u32, is_there: impl Fn(u32, u32) -> bool) -> Vec<[DVec3; 3]> {
    let point = |i: u32, j: u32| DVec3::new(f64::from(i) * 0.25, f64::from(j) * 0.25, 0.0);
    let mut triangles = Vec::new();
    for j in 0..rows {
        for i in 0..columns {
            if is_there(i, j) {
                let [a, b, c, d] = [
                    point(i, j),
                    point(i + 1, j),
                    point(i + 1, j + 1),
                    point(i, j + 1),
                ];
                if (i + j) % 2 == 0 {
                    triangles.extend([[a, b, c], [a, c, d]]);
                } else {
                    triangles.extend([[a, b, d], [b, c, d]]);
                }
            }
        }
    }
    triangles
}

/// Repeated bisection of some triangles' longest sides, neighbours with them.
pub fn refined(mut triangles: Vec<[DVec3; 3]>, picks: &[(usize, f64)]) -> Vec<[DVec3; 3]> {
    for &(pick, share) in picks {
        let [a, b, c] = triangles[pick % triangles.len()];
        let sides = [(a, b), (b, c), (c, a)];
        let (p, q) = sides
            .into_iter()
            .max_by(|s, t| s.0.distance(s.1).total_cmp(&t.0.distance(t.1)))
            .unwrap();
        let middle = p.lerp(q, share);
        let mut cut = Vec::new();
        triangles.retain(|t| {
            for k in 0..3 {
                let [u, v, w] = [t[k], t[(k + 1) % 3], t[(k + 2) % 3]];
                if (u == p && v == q) || (u == q && v == p) {
                    cut.extend([[u, middle, w], [middle, v, w]]);
                    return false;
                }
            }
            true
        });
        triangles.extend(cut);
    }
    triangles
}

pub fn moved(triangles: Vec<[DVec3; 3]>, turn: DQuat, by: DVec3) -> Vec<[DVec3; 3]> {
    triangles
        .into_iter()
        .map(|t| t.map(|p| turn * p + by))
        .collect()
}

pub fn odd_turn() -> DQuat {
    DQuat::from_axis_angle(DVec3::new(1.0, -2.0, 0.7).normalize(), 0.8)
}
