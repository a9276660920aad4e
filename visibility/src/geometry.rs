//! The geometry that is drawn: regions, their vertices and their planes, made once for a scene.

use glam::DVec3;
use scene::{Scene, SurfaceId};

use crate::regions::Regions;
use crate::rounding::{plane_tolerance, reach};

/// What of a scene can be seen.
#[derive(Debug)]
pub(crate) struct Geometry<'a> {
    pub scene: &'a Scene,
    pub regions: Regions,
    /// The regions' vertices, one axis after the other, metres.
    pub vertices: [Vec<f64>; 3],
    /// One per region.
    pub facts: Vec<RegionFacts>,
    /// Likewise.
    pub trees: Vec<RegionTree>,
    /// [`plane_tolerance`] of the scene, metres.
    pub plane_tolerance: f64,
}

/// What setting a region up asks for, all in one place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RegionFacts {
    /// Unit vector.
    pub normal: DVec3,
    /// Product of the normal with the points of its plane, metres.
    pub offset: f64,
    /// Largest magnitude of its coordinates by axis, metres.
    pub reach: DVec3,
}

/// The bisection tree of a region's one surface; unused where there are more. Kept apart from the facts, since pixels
/// that see specks ask for nothing else.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RegionTree {
    pub first_patch: u32,
    pub depth: u32,
}

impl<'a> Geometry<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        let regions = Regions::new(scene);
        let axis = |k: usize| regions.vertices().iter().map(|p| p[k].into()).collect();
        let facts = regions
            .regions()
            .iter()
            .map(|region| {
                let surfaces = || region.surfaces.iter().map(|&id| scene.surface(id));
                RegionFacts {
                    normal: region.normal,
                    offset: region.normal.dot(region.reference[0]),
                    reach: surfaces().map(reach).fold(DVec3::ZERO, DVec3::max),
                }
            })
            .collect();
        let trees = regions.regions().iter().map(|region| {
            let tree = scene.mesh().tree(region.surfaces[0]);
            RegionTree {
                first_patch: tree.first_patch.0,
                depth: tree.depth,
            }
        });
        Self {
            scene,
            vertices: [axis(0), axis(1), axis(2)],
            facts,
            trees: trees.collect(),
            plane_tolerance: plane_tolerance(scene),
            regions,
        }
    }

    /// The surface that holds a point of a region, and the point's barycentric coordinates in it; both kinds of
    /// coordinates have a common factor. `last` is the member to try first, and then the one that was right.
    pub fn surface_at(
        &self,
        region: u32,
        [u, v, w]: [f64; 3],
        last: &mut usize,
    ) -> (SurfaceId, [f64; 3]) {
        let region = &self.regions.regions()[region as usize];
        let Some(locator) = &region.locator else {
            return (region.surfaces[0], [u, v, w]);
        };
        let barycentric = |index: usize| {
            let [a, b, c] = &locator.members()[index].barycentric;
            let dot = |row: &[f64; 3]| row[0] * u + row[1] * v + row[2] * w;
            [dot(a), dot(b), dot(c)]
        };
        let mut at = barycentric(*last);
        if at.iter().any(|&e| e < 0.0) {
            *last = locator.locate([u as f32, v as f32, w as f32]);
            at = barycentric(*last);
        }
        (locator.members()[*last].surface, at)
    }
}
