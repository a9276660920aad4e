//! A model's walls in other triangles than its own, on which it is solved instead.
//!
//! A wall that arrives as a hundred thousand triangles is one in which as little happens as in one of two. What
//! is gathered for a function's error does not need them: they would only be the smallest sources and the fewest vertices there can
//! be. So the same walls are solved in triangles that are as large as sources may be (`remesh.rs`), whatever they came as, and the
//! function is carried over ([`crate::function::carried_over`]).

mod remesh;

use std::ops::Range;

use glam::{DVec2, DVec3, Vec3};
use scene::{PatchId, Rgb, Scene, Surface, SurfaceId, bisection};
use visibility::Drawable;
use visibility::regions::walls;

use crate::foot::Feet;

/// Walls are worth it where a scene has so many times as many surfaces as they have patches, or more. Where it has a few times as many,
/// these are vertices to begin with that do no harm.
const WORTH: u64 = 8;

/// A wall's triangles are sought by a grid where they are more.
const FEW: usize = 8;

/// A scene's walls in other triangles.
pub struct Walls<'a> {
    original: &'a Scene,
    scene: Scene,
    /// One per surface of the original.
    wall_of: Vec<u32>,
    /// Of each wall.
    triangles: Vec<Triangles>,
    /// Of each wall, those of the original.
    surfaces: Vec<Triangles>,
    /// Of each patch of the original, the one in the walls that has its centroid.
    patch_of: Vec<PatchId>,
}

/// The triangles of a wall, among a scene's.
struct Triangles {
    ids: Vec<SurfaceId>,
    grid: Option<Grid>,
}

/// Which triangles lie in which squares of a plane.
struct Grid {
    axes: [DVec3; 2],
    low: DVec2,
    /// Of a cell.
    size: DVec2,
    /// Columns and rows.
    counts: [usize; 2],
    /// Of each cell, row by row, as indices among the wall's.
    cells: Vec<Vec<u32>>,
}

impl<'a> Walls<'a> {
    /// The walls of a scene, with patches of at most so many m^2; `None` where they are not much fewer triangles than its surfaces.
    pub fn of(original: &'a Scene, max_area: f64) -> Option<Self> {
        let drawable = Drawable::new(original);
        let pieces = drawable.regions().pieces().len() as u64;
        if WORTH * pieces > original.surfaces().len() as u64 {
            return None;
        }
        let feet = Feet::new(&drawable);
        // Of triangles that are half of a square.
        let step = (2.0 * max_area).sqrt();
        let object = |id: SurfaceId| original.surface(id).object;
        let found = walls(original, |[a, b], ends| {
            object(a) != object(b) || feet.is_foot(a, ends)
        });
        let mut surfaces: Vec<Surface> = Vec::new();
        let mut wall_of = vec![0; original.surfaces().len()];
        let mut ranges = Vec::new();
        for (wall, found) in (0..).zip(&found) {
            let first = surfaces.len() as u32;
            let like = *original.surface(found.surfaces[0]);
            let coarse = found.coarse.as_ref();
            let triangles = coarse.and_then(|coarse| remesh::remeshed(coarse, step));
            let of_wall = triangles.into_iter().flatten();
            let mut of_wall: Vec<Surface> =
                of_wall.map(|corners| Surface { corners, ..like }).collect();
            let is_odd = of_wall.iter().any(Surface::is_degenerate);
            if is_odd || of_wall.is_empty() || of_wall.len() > found.surfaces.len() {
                let ids = found.surfaces.iter();
                of_wall = ids.map(|&id| *original.surface(id)).collect();
            }
            surfaces.append(&mut of_wall);
            for surface in &found.surfaces {
                wall_of[surface.index()] = wall;
            }
            ranges.push(first..surfaces.len() as u32);
        }
        let depth = |surface: &Surface| bisection::bisections_for(surface.area(), max_area);
        let depths = surfaces.iter().map(depth).collect::<Option<Vec<u32>>>()?;
        let patches: u64 = depths.iter().map(|depth| 1 << depth).sum();
        if WORTH * patches > original.surfaces().len() as u64 {
            return None;
        }
        let scene = Scene::new(
            original.materials().to_vec(),
            original.objects().to_vec(),
            surfaces,
            &depths,
            original.origin(),
        );
        let scene = scene
            .ok()?
            .with_openings(original.openings().to_vec())
            .ok()?;
        let triangles = |range: Range<u32>| Triangles::new(&scene, range.map(SurfaceId).collect());
        let triangles = ranges.into_iter().map(triangles).collect();
        let surfaces = found
            .into_iter()
            .map(|wall| Triangles::new(original, wall.surfaces));
        let mut walls = Self {
            original,
            triangles,
            surfaces: surfaces.collect(),
            scene,
            wall_of,
            patch_of: Vec::new(),
        };
        let patches = (0..original.patch_count()).map(PatchId);
        walls.patch_of = patches.map(|patch| walls.find_patch(patch)).collect();
        Some(walls)
    }

    /// What they are the walls of.
    pub fn original(&self) -> &'a Scene {
        self.original
    }

    /// The walls.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Which wall a surface of the original is of.
    pub fn wall_of(&self, surface: SurfaceId) -> u32 {
        self.wall_of[surface.index()]
    }

    /// How many they are.
    pub fn count(&self) -> u32 {
        self.triangles.len() as u32
    }

    /// The triangles of a wall.
    pub fn triangles(&self, wall: u32) -> &[SurfaceId] {
        &self.triangles[wall as usize].ids
    }

    /// The patch of the walls that has a patch's centroid.
    pub fn patch_of(&self, patch: PatchId) -> PatchId {
        self.patch_of[patch.index()]
    }

    /// Values of the original's patches, from those of the walls'.
    pub fn values(&self, of_walls: &[Rgb]) -> Vec<Rgb> {
        let values = self.patch_of.iter();
        values.map(|patch| of_walls[patch.index()]).collect()
    }

    /// The triangle of its wall in which a point of a surface of the original lies, metres, and its barycentric coordinates there,
    /// which may be a little below 0.
    pub fn place(&self, surface: SurfaceId, point: DVec3) -> (SurfaceId, DVec3) {
        self.triangles[self.wall_of(surface) as usize].at(&self.scene, point)
    }

    /// The surface of the original in which a point of a wall lies, and its barycentric coordinates there.
    pub fn place_in_original(&self, wall: u32, point: DVec3) -> (SurfaceId, DVec3) {
        self.surfaces[wall as usize].at(self.original, point)
    }

    fn find_patch(&self, patch: PatchId) -> PatchId {
        let centroid = self.original.patch(patch).centroid();
        let surface = self.original.mesh().surface_of(patch);
        let (surface, barycentric) = self.place(surface, centroid);
        let within = barycentric.max(DVec3::ZERO).as_vec3().to_array();
        let (patch, _) = self.scene.mesh().locate(surface, within);
        patch
    }
}

impl Triangles {
    fn new(scene: &Scene, ids: Vec<SurfaceId>) -> Self {
        Self {
            grid: (ids.len() > FEW).then(|| Grid::new(scene, &ids)),
            ids,
        }
    }

    /// The one in which a point of their plane lies, or nearly, and its barycentric coordinates there.
    fn at(&self, scene: &Scene, point: DVec3) -> (SurfaceId, DVec3) {
        let inside = |id: SurfaceId| (id, barycentric(scene.surface(id), point));
        let best = |ids: &mut dyn Iterator<Item = SurfaceId>| {
            let all = ids.map(inside);
            all.max_by(|a, b| a.1.min_element().total_cmp(&b.1.min_element()))
        };
        let near = self.grid.as_ref().and_then(|grid| {
            let cell = grid.at(point).iter();
            best(&mut cell.map(|&k| self.ids[k as usize]))
        });
        // A cell may be beside them all; there is one at least.
        let found = near.or_else(|| best(&mut self.ids.iter().copied()));
        found.unwrap_or((SurfaceId(0), DVec3::X))
    }
}

impl Grid {
    /// That of some triangles in one plane.
    fn new(scene: &Scene, ids: &[SurfaceId]) -> Self {
        let normal = scene.surface(ids[0]).normal();
        let triangles = || ids.iter().map(|&id| scene.surface(id));
        let axis = normal.any_orthonormal_vector();
        let axes = [axis, normal.cross(axis)];
        let flat = |p: Vec3| DVec2::from(axes.map(|axis| axis.dot(p.as_dvec3())));
        let bounds = |points: &mut dyn Iterator<Item = DVec2>| {
            points.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], p| {
                [low.min(p), high.max(p)]
            })
        };
        let all = triangles().flat_map(|triangle| triangle.corners);
        let [low, high] = bounds(&mut all.map(flat));
        let extent = (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        // As many cells as triangles, about.
        let side = (extent.x * extent.y / ids.len() as f64).sqrt();
        let counts = extent
            .to_array()
            .map(|extent| ((extent / side) as usize).clamp(1, 1 << 10));
        let mut grid = Self {
            axes,
            low,
            size: extent / DVec2::new(counts[0] as f64, counts[1] as f64),
            counts,
            cells: vec![Vec::new(); counts[0] * counts[1]],
        };
        for (k, triangle) in (0..).zip(triangles()) {
            let [low, high] = bounds(&mut triangle.corners.into_iter().map(flat));
            let ([left, bottom], [right, top]) = (grid.cell(low), grid.cell(high));
            for row in bottom..=top {
                for column in left..=right {
                    grid.cells[row * counts[0] + column].push(k);
                }
            }
        }
        grid
    }

    /// Column and row.
    fn cell(&self, p: DVec2) -> [usize; 2] {
        let place = ((p - self.low) / self.size).to_array();
        [0, 1].map(|k| (place[k] as usize).min(self.counts[k] - 1))
    }

    fn at(&self, point: DVec3) -> &[u32] {
        let [column, row] = self.cell(DVec2::from(self.axes.map(|axis| axis.dot(point))));
        &self.cells[row * self.counts[0] + column]
    }
}

/// Barycentric coordinates of a point in the plane of a triangle; they sum to 1.
pub(crate) fn barycentric(surface: &Surface, point: DVec3) -> DVec3 {
    let [a, b, c] = surface.corners.map(Vec3::as_dvec3);
    let across = (b - a).cross(c - a);
    let of =
        |p: DVec3, q: DVec3| (p - point).cross(q - point).dot(across) / across.length_squared();
    let (second, third) = (of(c, a), of(a, b));
    DVec3::new(1.0 - second - third, second, third)
}
