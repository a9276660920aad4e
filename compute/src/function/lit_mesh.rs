//! A mesh whose vertices have light, and what it is likely to miss.

use std::collections::BTreeMap;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use scene::function::{IrradianceFunction, NodeId, Refinement, VertexId};
use scene::{PatchId, Rgb, Scene, SceneError, Surface, SurfaceId};

use super::checks::{self, Candidate, Check, Part};
use super::direct::{self, Emitters, Spots};
use super::gatherer::Light;
use super::gradients::{self, Gradients};
use super::means::{self, Means, mean_square};
use super::{ErrorByCause, VISIBLE_FLOOR, reflectances};

/// The fewest points at which a function is checked at a time, and their number as a share of the leaves beyond that.
const FEWEST_CHECKS: usize = 320;
const CHECKED: f64 = 0.02;

/// The share of the squared difference of its corners that a leaf is taken to miss at least.
const OF_CORNERS: f64 = 0.03;

/// By what points are drawn: area, so that nothing is left out for good, and what is likely to be missed, by both targets, as
/// corners tell, as spots do, and as what varies within the sources that are seen does.
const MEASURES: usize = 7;

/// What one value a patch is taken to miss of it, relative, when points are drawn: most where it is bright, beside lamps.
const FLAT_MISSES: f64 = 0.1;

/// The share of a spot that is taken to be there though a triangle's corners see nothing of its lamp.
const LEAST_VISIBLE: f64 = 0.1;

/// A patch that has no vertices.
#[derive(Clone, Copy, Debug)]
pub(super) struct FlatPatch {
    pub patch: PatchId,
    /// m^2.
    pub area: f64,
    /// Reflected radiosity, W/m^2.
    pub radiosity: DVec3,
}

impl FlatPatch {
    /// What it is taken to miss, by target.
    pub fn missed(&self, size: &Size) -> [f64; 2] {
        let missed = size.weighed(FLAT_MISSES * self.radiosity, self.radiosity);
        missed.map(|missed| self.area * missed)
    }
}

/// A mesh with the light of its vertices, and what has no vertices.
pub(super) struct LitMesh<'s> {
    scene: &'s Scene,
    mesh: Refinement,
    /// What has no vertices.
    flat: Vec<FlatPatch>,
    /// One per surface.
    reflectance: Vec<DVec3>,
    /// One per vertex that has gathered.
    lights: Vec<Light>,
    emitters: Emitters,
    /// Of the leaves that have any, among those before the next one.
    spots: BTreeMap<NodeId, Spots>,
    next: NodeId,
}

impl<'s> LitMesh<'s> {
    /// A mesh whose vertices have no light as yet.
    pub fn new(scene: &'s Scene, mesh: Refinement) -> Self {
        Self {
            scene,
            flat: Vec::new(),
            mesh,
            reflectance: reflectances(scene),
            lights: Vec::new(),
            emitters: Emitters::new(scene),
            spots: BTreeMap::new(),
            next: NodeId(0),
        }
    }

    pub fn mesh(&self) -> &Refinement {
        &self.mesh
    }

    /// Bisects a leaf, and what its neighbours need with it.
    pub fn bisect(&mut self, leaf: NodeId) {
        self.mesh.bisect(leaf);
    }

    /// The area that has vertices, m^2.
    pub fn area(&self) -> f64 {
        self.mesh.leaves().map(|leaf| self.mesh.area(leaf)).sum()
    }

    /// The vertices that have no light yet.
    pub fn new_vertices(&self) -> impl Iterator<Item = VertexId> + use<> {
        (self.lights.len() as u32..self.mesh.vertex_count()).map(VertexId)
    }

    /// Gives them theirs.
    pub fn take(&mut self, lights: Vec<Light>) {
        self.lights.extend(lights);
        self.find_spots();
    }

    /// Gives all vertices another light.
    pub fn renew(&mut self, lights: &[Light]) {
        self.lights.copy_from_slice(lights);
    }

    /// Gives each vertex a light that depends on the one it has.
    pub fn renew_by(&mut self, light: impl Fn(VertexId, Light) -> Light) {
        for (vertex, before) in (0..).map(VertexId).zip(&mut self.lights) {
            *before = light(vertex, *before);
        }
    }

    /// What the corners of a leaf receive.
    pub fn lights(&self, leaf: NodeId) -> [&Light; 3] {
        let corners = self.mesh.corners(leaf);
        corners.map(|vertex| &self.lights[vertex.0 as usize])
    }

    /// Gives patches that have no vertices their light: what they receive, W/m^2, one per patch. `is_lit` tells which surfaces
    /// light can reach.
    pub fn light_patches(&mut self, irradiance: &[Rgb], is_lit: &dyn Fn(SurfaceId) -> bool) {
        let trees = (0..).map(SurfaceId).zip(self.scene.mesh().trees());
        let flat =
            trees.filter(|&(surface, _)| !self.mesh.has_vertices(surface) && is_lit(surface));
        let patches = flat.flat_map(|(surface, tree)| {
            let rho = self.reflectance[surface.index()];
            let area = self.scene.surface(surface).area() / f64::from(1_u32 << tree.depth);
            tree.patches().map(PatchId).map(move |patch| FlatPatch {
                patch,
                area,
                radiosity: rho * irradiance[patch.index()].as_dvec3(),
            })
        });
        self.flat = patches
            .filter(|patch| patch.radiosity != DVec3::ZERO)
            .collect();
    }

    /// What sources receive, one per source; `sources` is the scene whose patches they are.
    pub fn means(&self, sources: &Scene) -> Vec<Means> {
        means::means(&self.mesh, &self.lights, &self.reflectance, sources)
    }

    /// What has no vertices.
    pub fn flat(&self) -> &[FlatPatch] {
        &self.flat
    }

    /// The reflectance where a function is checked, dimensionless.
    pub fn reflectance(&self, check: &Check) -> DVec3 {
        self.reflectance[check.place.surface.index()]
    }

    /// The area that would absorb as much as all surfaces and openings do if it were black, m^2 a channel; above 0.
    pub fn absorbing_area(&self) -> DVec3 {
        let surfaces = self.scene.surfaces().iter();
        let mut area = DVec3::splat(surfaces.map(Surface::area).sum());
        for leaf in self.mesh.leaves() {
            let rho = self.reflectance[self.mesh.surface(leaf).index()];
            let seen = self.mesh.corners(leaf);
            let seen = seen.map(|vertex| self.lights[vertex.0 as usize].surfaces);
            area -= self.mesh.area(leaf) * rho * seen.iter().sum::<f64>() / 3.0;
        }
        for flat in &self.flat {
            let surface = self.scene.mesh().surface_of(flat.patch);
            area -= flat.area * self.reflectance[surface.index()];
        }
        area.max(DVec3::splat(f64::MIN_POSITIVE))
    }

    /// Reflected radiosities at the corners of a leaf, W/m^2.
    pub fn radiosities(&self, leaf: NodeId) -> [DVec3; 3] {
        let rho = self.reflectance[self.mesh.surface(leaf).index()];
        self.mesh
            .corners(leaf)
            .map(|vertex| rho * self.lights[vertex.0 as usize].irradiance())
    }

    /// What reflected radiosities are compared with.
    pub fn size(&self) -> Size {
        let mut size = Size::default();
        for leaf in self.mesh.leaves() {
            let [a, b, c] = self.radiosities(leaf);
            let area = self.mesh.area(leaf);
            size.area += area;
            size.square += area * mean_square([a, b, c]);
            size.mean += area * (a + b + c).element_sum() / 9.0;
        }
        for &FlatPatch {
            area, radiosity, ..
        } in &self.flat
        {
            size.area += area;
            size.square += area * radiosity.length_squared();
            size.mean += area * radiosity.element_sum() / 3.0;
        }
        size.square /= size.area.max(f64::MIN_POSITIVE);
        size.mean /= size.area.max(f64::MIN_POSITIVE);
        size
    }

    /// What each leaf is likely to miss, by target, by area: as gradients tell, and at least a share of its corners' largest
    /// difference, since what passes between them may be as large.
    pub fn likely(&self, size: &Size) -> Vec<(NodeId, [f64; 2])> {
        let gradients = Gradients::new(&self.mesh, |leaf| self.radiosities(leaf));
        let of_leaf = |leaf: NodeId| {
            let corners = self.radiosities(leaf);
            let area = self.mesh.area(leaf);
            let missed = gradients::mean_square(gradients.missed_of_sides(leaf));
            let mut most = size.weighed_square(missed, middle(corners));
            for k in 0..3 {
                let difference = corners[k] - corners[(k + 1) % 3];
                let weighed = size.weighed(difference, middle(corners));
                most = [0, 1].map(|t| most[t].max(OF_CORNERS * weighed[t]));
            }
            (leaf, most.map(|weighed| area * weighed))
        };
        self.mesh.leaves().map(of_leaf).collect()
    }

    /// What each leaf that has spots is likely to miss of them, by target.
    pub fn likely_by_spots(&self, size: &Size) -> Vec<(NodeId, [f64; 2])> {
        let of_leaf = |(&leaf, spots): (&NodeId, &Spots)| {
            let missed = self.missed_of_spots(leaf, spots, size);
            (leaf, missed.into_iter().fold([0.0; 2], sum))
        };
        self.spots.iter().map(of_leaf).collect()
    }

    /// Finds those of new leaves.
    fn find_spots(&mut self) {
        let next = self.next;
        let new: Vec<NodeId> = self.mesh.leaves().filter(|&leaf| leaf >= next).collect();
        if let Some(last) = new.iter().max() {
            self.next = NodeId(last.0 + 1);
        }
        let (scene, mesh, emitters) = (self.scene, &self.mesh, &self.emitters);
        let of_leaf = |leaf: NodeId| {
            let spots = emitters.spots(scene, mesh.surface(leaf), mesh.in_surface(leaf));
            spots.map(|spots| (leaf, spots))
        };
        let found: Vec<_> = new.into_par_iter().filter_map(of_leaf).collect();
        self.spots.retain(|&leaf, _| mesh.is_leaf(leaf));
        self.spots.extend(found);
    }

    /// What is likely to be missed of spots, part by part: of what falls there if nothing is in the way, as much as
    /// its corners receive of what they would.
    fn missed_of_spots(&self, leaf: NodeId, spots: &Spots, size: &Size) -> Vec<[f64; 2]> {
        let rho = self.reflectance[self.mesh.surface(leaf).index()];
        let corners = self.mesh.corners(leaf);
        let direct = corners.map(|vertex| self.lights[vertex.0 as usize].direct);
        let (mut seen, mut all) = (0.0, 0.0);
        for (direct, unhidden) in direct.iter().zip(spots.at_corners) {
            let unhidden = unhidden.element_sum();
            seen += direct.element_sum().min(unhidden);
            all += unhidden;
        }
        let visible = if all > 0.0 { seen / all } else { 1.0 };
        let visible = visible.max(LEAST_VISIBLE);
        let area = self.mesh.area(leaf);
        let corners = self.radiosities(leaf);
        let middle = middle(corners);
        let of_part = |part: &direct::Part| {
            let surplus = visible * rho * part.surplus;
            size.weighed(surplus, middle + surplus)
                .map(|w| part.share * area * w)
        };
        spots.parts.iter().map(of_part).collect()
    }

    /// What a leaf is likely to miss since sources are one value each, by target.
    pub fn missed_of_sources(&self, leaf: NodeId, size: &Size) -> [f64; 2] {
        let rho = self.reflectance[self.mesh.surface(leaf).index()];
        let corners = self.mesh.corners(leaf);
        let within = corners.map(|vertex| self.lights[vertex.0 as usize].within);
        let square = within.into_iter().sum::<f64>() / 3.0;
        let corners = self.radiosities(leaf);
        let middle = middle(corners);
        let difference = rho * (square / 3.0).sqrt();
        let area = self.mesh.area(leaf);
        size.weighed(difference, middle).map(|w| area * w)
    }

    /// Points by chance, in leaves by what they are likely to miss, others for each round.
    pub fn checks(&self, round: u32) -> Vec<Check> {
        let size = self.size();
        let mut all: Vec<(Candidate, [f64; MEASURES])> = Vec::new();
        for (leaf, [power, visible]) in self.likely(&size) {
            let area = self.mesh.area(leaf);
            let whole = Candidate {
                part: Part::Leaf(leaf),
                surface: self.mesh.surface(leaf),
                in_part: [DVec3::X, DVec3::Y, DVec3::Z],
                corners: self.mesh.in_surface(leaf),
                area,
            };
            let [by_sources, visible_by_sources] = self.missed_of_sources(leaf, &size);
            let Some(spots) = self.spots.get(&leaf) else {
                let of_sources = [by_sources, visible_by_sources];
                let measures = [area, power, visible, 0.0, 0.0, of_sources[0], of_sources[1]];
                all.push((whole, measures));
                continue;
            };
            let missed = self.missed_of_spots(leaf, spots, &size);
            for (part, missed) in spots.parts.iter().zip(missed) {
                let shares = [area, power, visible, by_sources, visible_by_sources];
                let [area, power, visible, by_sources, visible_by_sources] =
                    shares.map(|all| part.share * all);
                let candidate = Candidate {
                    in_part: part.in_triangle,
                    area,
                    ..whole
                };
                let [spots, visible_spots] = missed;
                let measures = [
                    area,
                    power,
                    visible,
                    spots,
                    visible_spots,
                    by_sources,
                    visible_by_sources,
                ];
                all.push((candidate, measures));
            }
        }
        for flat in &self.flat {
            let [power, visible] = flat.missed(&size);
            let candidate = Candidate {
                part: Part::Patch(flat.patch, flat.radiosity),
                surface: self.scene.mesh().surface_of(flat.patch),
                in_part: [DVec3::X, DVec3::Y, DVec3::Z],
                corners: self.scene.patch_in_surface(flat.patch),
                area: flat.area,
            };
            all.push((candidate, [flat.area, power, visible, 0.0, 0.0, 0.0, 0.0]));
        }
        let parts = self.mesh.leaves().count() + self.flat.len();
        let count = FEWEST_CHECKS.max((CHECKED * parts as f64) as usize);
        checks::draw(&all, count, round)
    }

    /// What is estimated of the error patch by patch, W/m^2, see [`IrradianceFunction::error`]: that of the mesh where it is likely
    /// to miss something, as gradients tell and spots do, that of all other causes where there is light.
    pub fn patch_errors(&self, error: &ErrorByCause) -> Vec<f32> {
        let size = self.size();
        let gradients = Gradients::new(&self.mesh, |leaf| self.radiosities(leaf));
        let ErrorByCause {
            mesh,
            sources,
            pixels,
            iterations,
            ..
        } = error;
        let others = [sources, pixels, iterations];
        let others: f64 = others.iter().map(|cause| cause.power.powi(2)).sum();
        // The squares of both, integrated, where they are: first what is missed, then what is there.
        let mut of_patch = vec![[0.0; 2]; self.scene.patch_count() as usize];
        for leaf in self.mesh.leaves() {
            let missed = gradients::mean_square(gradients.missed_of_sides(leaf));
            let [missed, _] = size.weighed_square(missed, DVec3::ZERO);
            let spots = self.spots.get(&leaf);
            let of_spots = spots.map(|spots| self.missed_of_spots(leaf, spots, &size));
            let [of_spots, _] = of_spots.into_iter().flatten().fold([0.0; 2], sum);
            let area = self.mesh.area(leaf);
            let missed = area * missed + of_spots;
            let there = area * mean_square(self.radiosities(leaf));
            let patches = self.patches_of(leaf);
            let share = 1.0 / patches.len() as f64;
            for patch in patches {
                let sums = &mut of_patch[patch as usize];
                *sums = sum(*sums, [share * missed, share * there]);
            }
        }
        for flat in &self.flat {
            let [missed, _] = flat.missed(&size);
            of_patch[flat.patch.index()] = [missed, flat.area * flat.radiosity.length_squared()];
        }
        let all: f64 = of_patch.iter().map(|[missed, _]| missed).sum();
        let scale = mesh.power.powi(2) * size.square * size.area / all.max(f64::MIN_POSITIVE);
        let areas = self.scene.mesh().trees().iter().zip(self.scene.surfaces());
        let areas = areas.flat_map(|(tree, surface)| {
            let area = surface.area() / f64::from(1_u32 << tree.depth);
            tree.patches().map(move |_| area)
        });
        let errors = of_patch.iter().zip(areas);
        errors
            .map(|([missed, there], area)| {
                ((scale * missed + others * there) / (3.0 * area)).sqrt() as f32
            })
            .collect()
    }

    /// The patches that a leaf covers, or the one that it is a part of.
    pub fn patches_of(&self, leaf: NodeId) -> Range<u32> {
        let tree = self.scene.mesh().tree(self.mesh.surface(leaf));
        let (depth, code) = self.mesh.bisections(leaf);
        let first = tree.first_patch.0;
        if let Some(deeper) = depth.checked_sub(tree.depth) {
            let patch = first + (code >> deeper);
            return patch..patch + 1;
        }
        let deeper = tree.depth - depth;
        first + (code << deeper)..first + ((code + 1) << deeper)
    }

    /// The function as it is; an error where a value is beyond what f32 holds.
    pub fn function(&self) -> Result<IrradianceFunction, SceneError> {
        let mesh = self.mesh.mesh()?;
        let lights = self.lights.iter();
        let irradiance = lights.clone().map(|light| light.irradiance().as_vec3());
        let direct = lights.map(|light| light.direct.as_vec3());
        IrradianceFunction::new(mesh, irradiance.collect(), direct.collect())
    }
}

/// The size of the mesh and of the reflected radiosity on it.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Size {
    /// m^2.
    pub area: f64,
    /// Mean of the square, summed over channels, (W/m^2)^2.
    square: f64,
    /// Mean over area and channels, W/m^2.
    mean: f64,
}

impl Size {
    /// A difference of radiosities as each target weighs it: squared, over what the target relates it to.
    pub fn weighed(&self, difference: DVec3, radiosity: DVec3) -> [f64; 2] {
        self.weighed_square(difference * difference, radiosity)
    }

    /// The same of its square, or of a mean of squares, channel by channel.
    pub fn weighed_square(&self, square: DVec3, radiosity: DVec3) -> [f64; 2] {
        let power = square.element_sum() / self.square.max(f64::MIN_POSITIVE);
        let floor = VISIBLE_FLOOR * self.mean;
        let base = radiosity.max(DVec3::ZERO) + floor.max(f64::MIN_POSITIVE);
        let relative = (square / base / base).element_sum();
        [power / self.area, relative / 3.0 / self.area]
    }
}

impl Size {
    /// The root mean square over an area, m^2, and the channels of what is so much as the first target weighs it, W/m^2.
    pub fn unweighed(&self, power: f64, area: f64) -> f64 {
        (power * self.square * self.area / (3.0 * area)).sqrt()
    }
}

/// What a change of what surfaces receive comes to when it is reflected around, as a share of all reflected light. Spread evenly that
/// would be an ambient radiosity, as [`ambient_radiosity`](crate::solver::ambient_radiosity) says of unshot light, but there is less of
/// it in a dark corner.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ambient {
    /// What more is reflected, W a channel.
    more: DVec3,
    /// Area times what is received of reflected light, W a channel.
    received: DVec3,
    /// m^2.
    area: f64,
}

impl Ambient {
    /// A part of the surfaces: its area, m^2, its reflectance, how much more it receives, and what it receives of reflected light,
    /// W/m^2.
    pub fn add(&mut self, area: f64, reflectance: DVec3, more: DVec3, received: DVec3) {
        self.more += area * reflectance * more;
        self.received += area * received;
        self.area += area;
    }

    /// The share, where surfaces absorb as much as this black area does, m^2 a channel.
    pub fn share(self, absorbing_area: DVec3) -> DVec3 {
        let mean = (self.received / self.area).max(DVec3::splat(f64::MIN_POSITIVE));
        let share = self.more / absorbing_area / mean;
        // Where nothing is received or nothing absorbed there is nothing to go by.
        DVec3::select(share.abs().cmplt(DVec3::ONE), share, DVec3::ZERO)
    }
}

/// The value in the middle of a triangle.
fn middle([a, b, c]: [DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
}

/// Of two targets.
pub(super) fn sum(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] + b[0], a[1] + b[1]]
}
