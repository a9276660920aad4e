//! What patches are likely to be off by: what a function says that goes through their means.

use glam::DVec3;
use scene::PatchId;
use scene::function::{NodeId, Refinement, VertexId};

use super::Taking;
use crate::function::gatherer::Light;
use crate::function::growth::asked;
use crate::function::lit_mesh::{LitMesh, Size, sum};
use crate::function::vertices::Place;
use crate::function::{Order, place, roots};
use crate::rows::BackendError;
use crate::sources::Sources;

/// What is linear a centroid tells rightly, but where it varies much it is seldom linear: the share of its largest difference, squared,
/// that a patch is taken to be off by for that.
const SLOPE: f64 = 0.05;

/// The mean around a corner is not what is there, which shows where it is not the mean of what the corners of a patch have. So many
/// times the difference is added to these.
const SHARPENED: u32 = 2;

/// The share of what is asked, squared, that is missed at most of light that falls from close to patches; leaves that make the other
/// one of what is missed are bisected at a time, and there are so many more vertices at most, and one for two patches.
const SPOTS_SHARE: f64 = 0.02;
const MARKED: f64 = 0.6;
const FEWEST_SPOTS: u32 = 1 << 12;

impl<'a> Taking<'_, 'a> {
    /// Gathers at vertices where light falls from close to patches, until little is missed of that. Whether there are any; `None`
    /// where it is cancelled.
    pub(super) fn find_spots(&mut self) -> Result<Option<bool>, BackendError> {
        let target = asked(&self.order.target);
        let most = self.mesh.vertex_count() + FEWEST_SPOTS + self.patches.len() as u32 / 2;
        while self.mesh.vertex_count() < most {
            let lit = self.lit();
            let mut spots = lit.likely_by_spots(&lit.size());
            let need = |missed: [f64; 2]| (missed[0] / target[0]).max(missed[1] / target[1]);
            spots.sort_by(|a, b| need(b.1).total_cmp(&need(a.1)).then(a.0.cmp(&b.0)));
            let all: f64 = spots.iter().map(|&(_, missed)| need(missed)).sum();
            if all <= SPOTS_SHARE {
                break;
            }
            let before = self.mesh.vertex_count();
            let mut vertices = Vec::new();
            let mut marked = 0.0;
            for (leaf, missed) in spots {
                if marked > MARKED * all {
                    break;
                }
                marked += need(missed);
                vertices.extend(self.mesh.corners(leaf));
                self.mesh.bisect(leaf);
            }
            vertices.retain(|vertex| !self.gathered.contains_key(vertex));
            vertices.sort_unstable();
            vertices.dedup();
            vertices.extend((before..self.mesh.vertex_count()).map(VertexId));
            let places: Vec<Place> = vertices
                .iter()
                .map(|&vertex| place(&self.mesh, vertex))
                .collect();
            let Some(lights) = self.gatherer.gather(&places)? else {
                return Ok(None);
            };
            self.gathered.extend(vertices.into_iter().zip(lights));
            if self.mesh.vertex_count() == before {
                break;
            }
        }
        Ok(Some(!self.gathered.is_empty()))
    }

    /// The function that is linear between the means around each corner of patches.
    pub(super) fn lit(&self) -> LitMesh<'a> {
        let mut lit = LitMesh::new(self.scene, self.mesh.clone());
        let mut lights = around_corners(&lit, |patch, _| self.light(patch));
        for (vertex, &gathered) in &self.gathered {
            let light = &mut lights[vertex.0 as usize];
            let within = light.within;
            *light = Light { within, ..gathered };
        }
        lit.take(lights);
        lit.light_patches(&self.irradiance(), self.order.is_lit);
        lit
    }

    /// The same function, whose means are more like those of patches.
    pub(super) fn sharpened(&self, mut lit: LitMesh<'a>) -> LitMesh<'a> {
        for _ in 0..SHARPENED {
            let more = around_corners(&lit, |patch, leaf| {
                let [a, b, c] = lit.lights(leaf).map(Light::irradiance);
                Light {
                    by_sources: self.patches[patch.index()].irradiance - (a + b + c) / 3.0,
                    ..Light::DARK
                }
            });
            lit.renew_by(|vertex, light| {
                if self.gathered.contains_key(&vertex) {
                    light
                } else {
                    light.plus(1.0, &more[vertex.0 as usize])
                }
            });
        }
        lit
    }

    /// What a patch receives.
    pub(super) fn light(&self, patch: PatchId) -> Light {
        let patch = &self.patches[patch.index()];
        let direct = patch.direct.min(patch.irradiance);
        Light {
            direct,
            by_sources: patch.irradiance - direct,
            correction: DVec3::ZERO,
            surfaces: patch.surfaces,
            within: patch.within,
        }
    }

    /// What each patch is likely to be off by at its row's points, by target and area.
    pub(super) fn likely(&self, lit: &LitMesh, size: &Size) -> Vec<[f64; 2]> {
        let mut likely = vec![[0.0; 2]; self.patches.len()];
        for (leaf, varies) in lit.likely(size) {
            let corners = lit.radiosities(leaf);
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            let patches = lit.patches_of(leaf);
            let each = lit.mesh().area(leaf) / patches.len() as f64;
            for patch in patches.map(PatchId) {
                let radiosity = self.radiosity(patch);
                let bends = size.weighed(middle - radiosity, radiosity);
                let likely = &mut likely[patch.index()];
                *likely = sum(*likely, bends.map(|bends| each * bends));
            }
            spread(lit, leaf, varies.map(|varies| SLOPE * varies), &mut likely);
        }
        for (leaf, missed) in lit.likely_by_spots(size) {
            spread(lit, leaf, missed, &mut likely);
        }
        for flat in lit.flat() {
            likely[flat.patch.index()] = flat.missed(size);
        }
        for (likely, patch) in likely.iter_mut().zip(&self.patches) {
            *likely = patch.was_off.unwrap_or(*likely);
        }
        likely
    }

    /// What each patch is likely to be off by since those that it sees are one value each, by target and area.
    pub(super) fn of_sources(&self, lit: &LitMesh, size: &Size) -> Vec<[f64; 2]> {
        let mut of_patches = vec![[0.0; 2]; self.patches.len()];
        for leaf in lit.mesh().leaves() {
            let missed = lit.missed_of_sources(leaf, size);
            spread(lit, leaf, missed, &mut of_patches);
        }
        of_patches
    }
}

/// A mesh of the walls that light can reach, whose leaves are their patches, or smaller.
pub(super) fn mesh_of_patches(sources: &Sources, order: &Order) -> Refinement {
    let scene = sources.patches();
    let mut mesh = roots::roots(scene, sources.drawable(), order.is_lit);
    loop {
        let is_large = |leaf: &NodeId| {
            let (depth, _) = mesh.bisections(*leaf);
            depth < scene.mesh().tree(mesh.surface(*leaf)).depth
        };
        let large: Vec<NodeId> = mesh.leaves().filter(is_large).collect();
        if large.is_empty() {
            return mesh;
        }
        for leaf in large {
            mesh.bisect(leaf);
        }
    }
}

/// The mean of something over the patches around each vertex, which may depend on the leaf there.
fn around_corners(lit: &LitMesh, of: impl Fn(PatchId, NodeId) -> Light) -> Vec<Light> {
    let mut sums = vec![(0.0, Light::DARK); lit.mesh().vertex_count() as usize];
    for leaf in lit.mesh().leaves() {
        let area = lit.mesh().area(leaf);
        for patch in lit.patches_of(leaf) {
            let light = of(PatchId(patch), leaf);
            for vertex in lit.mesh().corners(leaf) {
                let (all, sum) = &mut sums[vertex.0 as usize];
                *all += area;
                *sum = sum.plus(area, &light);
            }
        }
    }
    let mean = |(area, sum): (f64, Light)| Light::DARK.plus(1.0 / area, &sum);
    sums.into_iter().map(mean).collect()
}

/// Adds what a leaf misses to the patches that it covers, or is a part of.
fn spread(lit: &LitMesh, leaf: NodeId, missed: [f64; 2], of_patches: &mut [[f64; 2]]) {
    let patches = lit.patches_of(leaf);
    let share = 1.0 / patches.len() as f64;
    for patch in patches {
        let all = &mut of_patches[patch as usize];
        *all = sum(*all, missed.map(|missed| share * missed));
    }
}
