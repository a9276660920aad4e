//! A scene laid out for drawing: made once, shared by all eyes.

use glam::DVec3;
use scene::{Scene, SurfaceId};

use super::clusters::Clusters;
use super::hierarchy::Hierarchy;
use super::locate::Locators;
use super::regions::Regions;
use super::rounding::{plane_tolerance, reach};

/// What item buffers draw of a scene.
#[derive(Debug)]
pub struct Drawable<'a> {
    scene: &'a Scene,
    regions: Regions,
    /// The regions' vertices, one axis after the other, metres.
    pub(super) vertices: [Vec<f64>; 3],
    /// One per region.
    pub(super) facts: Vec<RegionFacts>,
    /// Likewise.
    pub(super) trees: Vec<RegionTree>,
    pub(super) locators: Locators,
    /// Where specks are looked for.
    pub(super) clusters: Option<Clusters>,
    pub(super) plane_tolerance: f64,
    /// Where pieces are so many that rays may be cast.
    pub(super) hierarchy: Option<Hierarchy>,
    dense: Dense,
}

/// How triangles that are small and many are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Dense {
    /// As it costs least.
    Cheapest,
    /// All pieces are drawn.
    #[cfg(test)]
    Pieces,
    /// Small ones are specks.
    #[cfg(test)]
    Specks,
    /// Rays are cast.
    #[cfg(test)]
    Rays,
}

/// Specks are looked for in scenes of so many regions.
const FEWEST_REGIONS: usize = 1 << 10;

/// Rays are cast instead of drawing all pieces from so many on for each pixel, where none of them is a speck. Tuned,
/// at 128 pixels, on the scenes of `benches/dense.rs`: a box full of small bodies, of which most are hidden, and a
/// bumpy sphere seen from inside.
const PIECES_PER_PIXEL: f64 = 3.0;

/// The same where specks are looked for, tuned at 32 pixels: at 1,000 it depends on the scene.
const PIECES_PER_PIXEL_WITH_SPECKS: f64 = 800.0;

/// Fewer pixels count as this many: rays for them have their common costs too, and small scenes need no hierarchy.
const FEWEST_PIXELS: usize = 1 << 10;

/// Boxes are larger than what is in them by this many of the scene's plane tolerance: by the margins of
/// fronts, and by the rounding of coordinates and of rays to f32.
pub(super) const BOX_MARGIN: f64 = 8.0;

/// What setting a region up asks for, all in one place.
#[derive(Clone, Copy, Debug)]
pub(super) struct RegionFacts {
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
pub(super) struct RegionTree {
    pub first_patch: u32,
    pub depth: u32,
}

impl<'a> Drawable<'a> {
    /// Lays a scene out.
    pub fn new(scene: &'a Scene) -> Self {
        Self::with(scene, Dense::Cheapest)
    }

    /// Lays a scene out to be drawn in one way.
    pub(super) fn with(scene: &'a Scene, dense: Dense) -> Self {
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
        let trees = trees.collect();
        let plane_tolerance = plane_tolerance(scene);
        let fewest = PIECES_PER_PIXEL * FEWEST_PIXELS as f64;
        let (has_specks, has_rays) = match dense {
            Dense::Cheapest => (
                regions.regions().len() >= FEWEST_REGIONS,
                regions.pieces().len() as f64 > fewest,
            ),
            #[cfg(test)]
            Dense::Pieces => (false, false),
            #[cfg(test)]
            Dense::Specks => (true, false),
            #[cfg(test)]
            Dense::Rays => (false, true),
        };
        let margin = (BOX_MARGIN * plane_tolerance) as f32;
        Self {
            scene,
            locators: Locators::new(&regions),
            clusters: has_specks.then(|| Clusters::new(&regions)),
            vertices: [axis(0), axis(1), axis(2)],
            facts,
            trees,
            plane_tolerance,
            hierarchy: has_rays.then(|| Hierarchy::new(&regions, margin)),
            dense,
            regions,
        }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.scene
    }

    /// What is drawn of it.
    pub fn regions(&self) -> &Regions {
        &self.regions
    }

    /// True where so many pixels are found faster by casting rays than by drawing all pieces, with specks among them or
    /// not.
    pub(super) fn casts(&self, pixels: usize, has_specks: bool) -> bool {
        let pieces = self.regions.pieces().len() as f64;
        let pixels = pixels.max(FEWEST_PIXELS) as f64;
        let per_pixel = match (self.dense, has_specks) {
            (Dense::Cheapest, false) => PIECES_PER_PIXEL,
            (Dense::Cheapest, true) => PIECES_PER_PIXEL_WITH_SPECKS,
            #[cfg(test)]
            _ => 0.0,
        };
        self.hierarchy.is_some() && pieces > per_pixel * pixels
    }

    /// [`plane_tolerance`] of the scene, metres.
    pub fn plane_tolerance(&self) -> f64 {
        self.plane_tolerance
    }

    /// The region that a surface is in.
    pub fn region_of(&self, surface: SurfaceId) -> u32 {
        self.regions.region_of(surface)
    }

    /// Unit normal of the region that a surface is in.
    pub fn normal_of(&self, surface: SurfaceId) -> DVec3 {
        self.regions.regions()[self.region_of(surface) as usize].normal
    }

    /// The surface that holds a point of a region, and the point's barycentric coordinates in it; both kinds of
    /// coordinates have a common factor. `last` is the member to try first, and then the one that was right.
    pub(super) fn surface_at(
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
