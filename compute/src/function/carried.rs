//! A function on walls, carried over to the surfaces that they came as.
//!
//! The mesh there begins with the surfaces' own triangles and is bisected until it shows what the walls' function shows: at some points
//! in each leaf of that, weighed as the errors of a function are. Nothing is gathered for it.

use glam::{DVec3, Vec3};
use scene::function::{IrradianceFunction, NodeId, Refinement, VertexId};
use scene::{PatchId, Rgb, SceneError, Surface, SurfaceId};
use visibility::Drawable;

use super::VISIBLE_FLOOR;
use crate::foot::Feet;
use crate::settings::Target;
use crate::walls::Walls;

/// The share of the error that is asked for that carrying over may bring.
const SHARE: f64 = 0.1;

/// Leaves that make this share of what is missing are bisected at a time.
const MARKED: f64 = 0.7;

/// How far the points of a leaf are from its corners, as a share of the way to its middle.
const INSIDE: f64 = 0.1;

/// A point of the original, and what is there.
struct Point {
    surface: SurfaceId,
    /// In it.
    barycentric: DVec3,
    /// What it stands for, m^2.
    area: f64,
    /// Reflected radiosity there, W/m^2.
    right: DVec3,
    reflectance: DVec3,
}

/// The function of the original of some walls, from that of these: with errors of patches, if it has them. Errors that are asked for
/// decide how near it is.
///
/// # Errors
/// Values that are beyond what f32 holds.
pub fn carried_over(
    of_walls: &IrradianceFunction,
    walls: &Walls,
    target: &Target,
) -> Result<IrradianceFunction, SceneError> {
    let scene = walls.original();
    let mut carried = Carried {
        mesh: first_mesh(of_walls, walls),
        of_walls,
        walls,
        values: Vec::new(),
    };
    let points = carried.points();
    loop {
        carried.evaluate();
        let (missing, leaves) = carried.missing(&points);
        let asked = [target.power, target.visible];
        let asked = asked.map(|error| error.map_or(f64::INFINITY, |error| (SHARE * error).powi(2)));
        let is_full = carried.mesh.vertex_count() >= target.most_vertices;
        let before = carried.mesh.vertex_count();
        if (missing[0] > asked[0] || missing[1] > asked[1]) && !is_full {
            carried.bisect(leaves, asked);
        }
        if carried.mesh.vertex_count() == before {
            break;
        }
    }
    let [irradiance, direct] = [0, 1].map(|k| carried.values.iter().map(|v| v[k]).collect());
    let function = IrradianceFunction::new(carried.mesh.mesh()?, irradiance, direct)?;
    let error = of_walls.error();
    if error.is_empty() {
        return Ok(function);
    }
    let patches = (0..scene.patch_count()).map(PatchId);
    function.with_error(
        patches
            .map(|patch| error[walls.patch_of(patch).index()])
            .collect(),
    )
}

/// The surfaces of walls that have vertices.
fn first_mesh(of_walls: &IrradianceFunction, walls: &Walls) -> Refinement {
    let scene = walls.original();
    let drawable = Drawable::new(scene);
    let feet = Feet::new(&drawable);
    let has_vertices = |surface: SurfaceId| {
        let mut triangles = walls.triangles(walls.wall_of(surface)).iter();
        triangles.all(|&triangle| of_walls.mesh().has_vertices(triangle))
    };
    let joins = |[a, b]: [SurfaceId; 2], ends: [Vec3; 2]| {
        walls.wall_of(a) == walls.wall_of(b) && !feet.is_foot(a, ends)
    };
    Refinement::new(scene, has_vertices, joins)
}

/// A function that is being carried over.
struct Carried<'w> {
    mesh: Refinement,
    of_walls: &'w IrradianceFunction,
    walls: &'w Walls<'w>,
    /// Irradiance, and what of it is direct, of each vertex, W/m^2.
    values: Vec<[Rgb; 2]>,
}

impl Carried<'_> {
    /// The walls' function at new vertices.
    fn evaluate(&mut self) {
        let new = self.values.len() as u32..self.mesh.vertex_count();
        for vertex in new.map(VertexId) {
            let (surface, [place, inside]) = self.mesh.place_of(vertex);
            let corners = self.walls.original().surface(surface).corners;
            let at = |barycentric: DVec3| position(corners, barycentric);
            // On the side of a foot where the surface is.
            let (triangle, _) = self.walls.place(surface, at(place.lerp(inside, 1e-3)));
            let within = within(self.walls.scene().surface(triangle), at(place));
            let values = [self.of_walls.irradiance(), self.of_walls.direct()];
            let value = |values| self.of_walls.interpolate(values, triangle, within);
            let value = values.map(|values| value(values).unwrap_or_default().max(Rgb::ZERO));
            self.values.push(value);
        }
    }

    /// Points in each leaf of the walls' function.
    fn points(&self) -> Vec<Point> {
        let mesh = self.of_walls.mesh();
        let mut points = Vec::new();
        for wall in 0..self.walls.count() {
            for &triangle in self.walls.triangles(wall) {
                let surface = self.walls.scene().surface(triangle);
                let material = self.walls.scene().material(surface.material);
                let reflectance = material.reflectance.as_dvec3();
                for (vertices, depth) in mesh.leaves(triangle) {
                    let area = surface.area() / 2.0_f64.powi(depth as i32) / 4.0;
                    let corners = vertices.map(|v| mesh.vertices()[v as usize].as_dvec3());
                    let values =
                        vertices.map(|v| self.of_walls.irradiance()[v as usize].as_dvec3());
                    let third = DVec3::splat(1.0 / 3.0);
                    let near = [DVec3::X, DVec3::Y, DVec3::Z].map(|at| at.lerp(third, INSIDE));
                    for at in near.into_iter().chain([third]) {
                        let mix = |of: [DVec3; 3]| at.x * of[0] + at.y * of[1] + at.z * of[2];
                        let (surface, barycentric) =
                            self.walls.place_in_original(wall, mix(corners));
                        points.push(Point {
                            surface,
                            barycentric,
                            area,
                            right: reflectance * mix(values),
                            reflectance,
                        });
                    }
                }
            }
        }
        points
    }

    /// What is missing, squared, power then visible, and of it what each leaf has at each of its points.
    fn missing(&self, points: &[Point]) -> ([f64; 2], Vec<(NodeId, [f64; 2])>) {
        let sum = |value: &dyn Fn(&Point) -> f64| points.iter().map(value).sum::<f64>();
        let area = sum(&|p| p.area).max(f64::MIN_POSITIVE);
        let square = sum(&|p| p.area * p.right.length_squared()).max(f64::MIN_POSITIVE);
        let floor = VISIBLE_FLOOR * sum(&|p| p.area * p.right.element_sum()) / 3.0 / area;
        let floor = floor.max(f64::MIN_POSITIVE);
        let mut all = [0.0; 2];
        let mut leaves = Vec::new();
        for point in points {
            let Some((leaf, at)) = self.mesh.leaf_at(point.surface, point.barycentric) else {
                continue;
            };
            let corners = self
                .mesh
                .corners(leaf)
                .map(|v| self.values[v.0 as usize][0].as_dvec3());
            let shown = at.x * corners[0] + at.y * corners[1] + at.z * corners[2];
            let difference = point.reflectance * shown - point.right;
            let relative = difference / (point.right + floor);
            let missing = [
                point.area * difference.length_squared() / square,
                point.area * relative.length_squared() / 3.0 / area,
            ];
            all = [0, 1].map(|t| all[t] + missing[t]);
            leaves.push((leaf, missing));
        }
        (all, leaves)
    }

    /// Bisects leaves in which most is missing of what is asked for, squared.
    fn bisect(&mut self, points: Vec<(NodeId, [f64; 2])>, asked: [f64; 2]) {
        let mut leaves: Vec<(NodeId, f64)> = points
            .into_iter()
            .map(|(leaf, missing)| (leaf, (missing[0] / asked[0]).max(missing[1] / asked[1])))
            .collect();
        leaves.sort_unstable_by_key(|&(leaf, _)| leaf);
        let mut needs: Vec<(f64, NodeId)> = leaves
            .chunk_by(|a, b| a.0 == b.0)
            .map(|of_leaf| (of_leaf.iter().map(|(_, need)| need).sum(), of_leaf[0].0))
            .collect();
        needs.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let all: f64 = needs.iter().map(|(need, _)| need).sum();
        let mut marked = 0.0;
        for (need, leaf) in needs {
            if marked > MARKED * all {
                break;
            }
            marked += need;
            self.mesh.bisect(leaf);
        }
    }
}

/// Barycentric coordinates in a triangle, none below 0.
fn within(surface: &Surface, point: DVec3) -> [f32; 3] {
    let barycentric = crate::walls::barycentric(surface, point);
    barycentric.max(DVec3::ZERO).as_vec3().to_array()
}

fn position(corners: [Vec3; 3], barycentric: DVec3) -> DVec3 {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    barycentric.x * a + barycentric.y * b + barycentric.z * c
}
