//! The walls of a scene in few triangles.
//!
//! What is drawn as few polygons ([`super::pieces`]) can be modelled as few triangles, too: those that are left when the vertices are
//! taken out that the outline does not need, flipped until none has a vertex of its neighbour in its circle (Lawson, "Software for C1
//! surface interpolation", 1977), which makes the smallest angles as large as they can be. Unlike pieces, these triangles conform:
//! where two share a part of a side they share all of it.

use std::collections::VecDeque;

use glam::{DVec2, DVec3, Vec3};
use rayon::prelude::*;
use scene::{Scene, SurfaceId};

use super::flood::{self, Group};
use super::outline::{NONE, Outline, RegionMesh, next, previous};
use super::pieces;
use super::weld::Welded;

/// How often an edge is flipped at most, on the mean: rounding could flip one to and fro.
const MOST_FLIPS: usize = 16;

/// The least sine of a corner between which and its opposite an edge may be flipped, so that no triangle without area comes of it.
const LEAST_SINE: f64 = 1e-6;

/// Surfaces that are one wall: what connects them is their own sides.
#[derive(Clone, Debug, PartialEq)]
pub struct Wall {
    /// Ascending.
    pub surfaces: Vec<SurfaceId>,
    /// The same in fewer triangles; `None` where there are not fewer.
    pub coarse: Option<Coarse>,
}

/// A wall in few triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Coarse {
    /// Counter-clockwise from the front, metres.
    pub triangles: Vec<[Vec3; 3]>,
    /// Their sides beyond which the wall does not go on, each with the wall to its left; those of a slit twice.
    pub outline: Vec<[Vec3; 2]>,
    /// Unit normal.
    pub normal: DVec3,
}

/// All walls, in the order of their first surfaces. Surfaces in one plane that share a side are one wall but where they `are_apart`: a
/// question about the two and the ends of the side.
pub fn walls(
    scene: &Scene,
    are_apart: impl Fn([SurfaceId; 2], [Vec3; 2]) -> bool + Sync,
) -> Vec<Wall> {
    let welded = Welded::new(scene.surfaces());
    let of_groups = flood::groups(scene, &welded).into_par_iter();
    let mut walls: Vec<Wall> = of_groups
        .flat_map_iter(|group| walls_of(&welded, group, &are_apart))
        .collect();
    let mut is_done = vec![false; scene.surfaces().len()];
    for surface in walls.iter().flat_map(|wall| &wall.surfaces) {
        is_done[surface.index()] = true;
    }
    let single = (0..).map(SurfaceId).zip(is_done);
    walls.extend(single.filter(|(_, is_done)| !is_done).map(|(id, _)| Wall {
        surfaces: vec![id],
        coarse: None,
    }));
    walls.sort_unstable_by_key(|wall| wall.surfaces[0]);
    walls
}

/// The walls of surfaces in one plane.
fn walls_of(
    welded: &Welded,
    group: Group,
    are_apart: &impl Fn([SurfaceId; 2], [Vec3; 2]) -> bool,
) -> Vec<Wall> {
    let Some(mut mesh) = RegionMesh::new(welded, &group) else {
        let alone = |surface| Wall {
            surfaces: vec![SurfaceId(surface)],
            coarse: None,
        };
        return group.surfaces.into_iter().map(alone).collect();
    };
    part(&mut mesh, &group, are_apart);
    connected(&mesh)
        .into_iter()
        .map(|triangles| {
            let surfaces: Vec<u32> = triangles.iter().map(|&t| group.surfaces[t]).collect();
            let group = Group { surfaces, ..group };
            Wall {
                coarse: coarse(welded, &group, are_apart),
                surfaces: group.surfaces.into_iter().map(SurfaceId).collect(),
            }
        })
        .collect()
}

/// Takes half-edges from each other whose surfaces are apart.
fn part(
    mesh: &mut RegionMesh,
    group: &Group,
    are_apart: &impl Fn([SurfaceId; 2], [Vec3; 2]) -> bool,
) {
    for half in 0..mesh.mates.len() as u32 {
        let mate = mesh.mates[half as usize];
        if mate == NONE || mate < half {
            continue;
        }
        let surfaces = [half, mate].map(|half| SurfaceId(group.surfaces[half as usize / 3]));
        let ends = [half, next(half)].map(|half| mesh.points[mesh.origin(half) as usize].as_vec3());
        if are_apart(surfaces, ends) {
            mesh.mates[half as usize] = NONE;
            mesh.mates[mate as usize] = NONE;
        }
    }
}

/// Triangles that half-edges connect, each lot ascending.
fn connected(mesh: &RegionMesh) -> Vec<Vec<usize>> {
    let mut is_done = vec![false; mesh.corners.len()];
    let mut all = Vec::new();
    for first in 0..mesh.corners.len() {
        if std::mem::replace(&mut is_done[first], true) {
            continue;
        }
        let mut lot = vec![first];
        let mut done = 0;
        while done < lot.len() {
            let triangle = lot[done];
            done += 1;
            for &mate in &mesh.mates[3 * triangle..3 * triangle + 3] {
                let other = mate as usize / 3;
                if mate != NONE && !std::mem::replace(&mut is_done[other], true) {
                    lot.push(other);
                }
            }
        }
        lot.sort_unstable();
        all.push(lot);
    }
    all
}

/// What connected surfaces in one plane are in fewer triangles.
fn coarse(
    welded: &Welded,
    group: &Group,
    are_apart: &impl Fn([SurfaceId; 2], [Vec3; 2]) -> bool,
) -> Option<Coarse> {
    let mut mesh = RegionMesh::new(welded, group)?;
    part(&mut mesh, group, are_apart);
    let outline = Outline::new(&mesh)?;
    let (mut corners, mut mates) = pieces::triangles(&mesh, &outline)?;
    if corners.len() >= group.surfaces.len() {
        return None;
    }
    flip(&mesh, &mut corners, &mut mates);
    let point = |vertex: u32| mesh.points[vertex as usize].as_vec3();
    let origin = |half: u32| point(corners[half as usize / 3][half as usize % 3]);
    let halves = (0..).zip(&mates).filter(|&(_, &mate)| mate == NONE);
    Some(Coarse {
        outline: halves
            .map(|(half, _)| [half, next(half)].map(origin))
            .collect(),
        triangles: corners.iter().map(|c| c.map(point)).collect(),
        normal: mesh.normal,
    })
}

/// Flips edges until no triangle has a vertex of its neighbour in its circle. Half-edges are as in a [`RegionMesh`].
fn flip(mesh: &RegionMesh, corners: &mut [[u32; 3]], mates: &mut [u32]) {
    let along = mesh.normal.any_orthonormal_vector();
    let across = mesh.normal.cross(along);
    let flat: Vec<DVec2> = mesh
        .points
        .iter()
        .map(|p| DVec2::new(p.dot(along), p.dot(across)))
        .collect();
    let mut open: VecDeque<u32> = (0..mates.len() as u32).collect();
    let mut left = MOST_FLIPS * mates.len();
    while let Some(half) = open.pop_front() {
        let mate = mates[half as usize];
        if mate == NONE || left == 0 {
            continue;
        }
        let origin = |half: u32| corners[half as usize / 3][half as usize % 3];
        // From a to b, with c on the left and d on the right.
        let [a, b] = [origin(half), origin(mate)];
        let [c, d] = [previous(half), previous(mate)].map(origin);
        let [pa, pb, pc, pd] = [a, b, c, d].map(|vertex| flat[vertex as usize]);
        if !(is_in_circle([pa, pb, pc], pd) && turns_left([pd, pb, pc]) && turns_left([pc, pa, pd]))
        {
            continue;
        }
        left -= 1;
        // The sides around both: b to c, c to a, a to d, d to b.
        let [bc, ca, ad, db] = [next(half), previous(half), next(mate), previous(mate)]
            .map(|side| mates[side as usize]);
        let [first, second] = [half / 3, mate / 3];
        corners[first as usize] = [c, d, b];
        corners[second as usize] = [d, c, a];
        let sides = [
            (3 * first, 3 * second),
            (3 * first + 1, db),
            (3 * first + 2, bc),
            (3 * second + 1, ca),
            (3 * second + 2, ad),
        ];
        for (side, other) in sides {
            mates[side as usize] = other;
            if other != NONE {
                mates[other as usize] = side;
            }
            open.push_back(side);
        }
    }
}

/// Whether a point is within the circle of a triangle that is counter-clockwise, by more than rounding.
fn is_in_circle([a, b, c]: [DVec2; 3], p: DVec2) -> bool {
    let [a, b, c] = [a - p, b - p, c - p];
    let lifted = a.length_squared() * b.perp_dot(c)
        + b.length_squared() * c.perp_dot(a)
        + c.length_squared() * a.perp_dot(b);
    let size = a
        .length_squared()
        .max(b.length_squared())
        .max(c.length_squared());
    lifted > 1e-9 * size * size
}

fn turns_left([a, b, c]: [DVec2; 3]) -> bool {
    (b - a).perp_dot(c - b) > LEAST_SINE * (b - a).length() * (c - b).length()
}

#[cfg(test)]
mod tests {
    use scene::{Material, MaterialId, ObjectId, Rgb, Surface};

    use super::*;

    /// A square wall of so many squares a side, the middle of which is left out.
    fn wall_with_a_hole(count: usize) -> Scene {
        let at = |i: usize, j: usize| Vec3::new(i as f32, j as f32, 1.0);
        let mut surfaces = Vec::new();
        for i in 0..count {
            for j in 0..count {
                if [i, j].iter().all(|&k| 3 * k >= count && 3 * k < 2 * count) {
                    continue;
                }
                let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                surfaces.extend([[a, b, c], [a, c, d]].map(|corners| Surface {
                    corners,
                    material: MaterialId(0),
                    object: ObjectId(0),
                }));
            }
        }
        let material = Material {
            name: "m".into(),
            reflectance: Rgb::splat(0.5),
            emission: Rgb::ZERO,
        };
        let depths = vec![0; surfaces.len()];
        Scene::new(
            vec![material],
            vec!["o".into()],
            surfaces,
            &depths,
            DVec3::ZERO,
        )
        .unwrap()
    }

    fn triangles(wall: &Wall) -> &[[Vec3; 3]] {
        &wall.coarse.as_ref().unwrap().triangles
    }

    fn area(triangles: &[[Vec3; 3]]) -> f32 {
        let twice = triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).z);
        0.5 * twice.sum::<f32>()
    }

    /// A ring between two squares has eight corners and one hole, and so eight triangles, whatever it was made of.
    #[test]
    fn a_wall_is_as_many_triangles_as_its_outline_asks_for() {
        for count in [3, 9, 30] {
            let scene = wall_with_a_hole(count);
            let walls = walls(&scene, |_, _| false);
            assert_eq!(walls.len(), 1);
            assert_eq!(walls[0].surfaces.len(), scene.surfaces().len());
            let Coarse {
                triangles, outline, ..
            } = walls[0].coarse.as_ref().unwrap();
            assert_eq!((triangles.len(), outline.len()), (8, 8));
            let expected = (count * count) as f32 * 8.0 / 9.0;
            assert!((area(triangles) - expected).abs() < 1e-3 * expected);
            // From a corner a side of the hole is seen under atan 1/3.
            for &[a, b, c] in triangles {
                for [a, b, c] in [[a, b, c], [b, c, a], [c, a, b]] {
                    let sine = (b - a).cross(c - a).length() / (b - a).length() / (c - a).length();
                    assert!(sine > 0.316, "{sine}");
                }
            }
        }
    }

    /// Where surfaces are apart that is a side of both walls.
    #[test]
    fn what_is_apart_is_no_wall() {
        let scene = wall_with_a_hole(9);
        let is_middle = |ends: [Vec3; 2]| ends.iter().all(|p| (p.x - 6.0).abs() < 0.1);
        let parted = walls(&scene, |_, ends| is_middle(ends));
        let sizes: Vec<usize> = parted.iter().map(|wall| triangles(wall).len()).collect();
        // The other side is a rectangle; that of the hole has two reflex corners.
        assert_eq!(sizes, [6, 2]);
        let areas = parted.iter().map(|wall| area(triangles(wall)));
        assert_eq!(areas.collect::<Vec<_>>(), [45.0, 27.0]);
        // A slit from the hole to the border leaves one wall, and stays.
        let is_slit = |ends: [Vec3; 2]| is_middle(ends) && ends.iter().all(|p| p.y <= 3.0);
        let slit = walls(&scene, |_, ends| is_slit(ends));
        assert_eq!(slit.len(), 1);
        let triangles = triangles(&slit[0]);
        assert!(triangles.len() < scene.surfaces().len() / 4);
        assert!((area(triangles) - 72.0).abs() < 1e-3);
        let crosses = |[a, b, c]: &[Vec3; 3]| {
            let xs = [a, b, c].map(|p| p.x);
            let low = a.y.min(b.y).min(c.y);
            xs.iter().any(|&x| x < 6.0) && xs.iter().any(|&x| x > 6.0) && low < 2.9
        };
        assert!(!triangles.iter().any(crosses));
    }
}
