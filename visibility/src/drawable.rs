//! A scene laid out for drawing: made once, shared by all eyes and threads.

use glam::DVec3;
use scene::{Scene, SurfaceId};

use crate::geometry::Geometry;
use crate::look_up::Locators;
use crate::rays::Bvh;
use crate::regions::Regions;
use crate::rounding::BOX_MARGIN;
use crate::specks::Clusters;

/// What item buffers draw of a scene.
#[derive(Debug)]
pub struct Drawable<'a> {
    pub(crate) geometry: Geometry<'a>,
    pub(crate) locators: Locators,
    /// Where hemicubes look for specks.
    pub(crate) clusters: Option<Clusters>,
    /// Where pieces are so many that rays may be cast.
    pub(crate) bvh: Option<Bvh>,
    pub(crate) strategy: Strategy,
}

/// How pixels find what they see. All strategies show the same but for pixels on edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strategy {
    /// Whichever costs least: specks for hemicubes in scenes of 1,024 regions or more, rays for other windows that
    /// have far fewer pixels than the scene has pieces, spans for all else.
    Cheapest,
    /// All pieces are drawn span by span.
    Spans,
    /// Hemicubes take small triangles as specks; other windows are drawn by spans.
    Specks,
    /// Rays are cast for all.
    Rays,
}

/// Specks are looked for in scenes of so many regions.
const FEWEST_REGIONS: usize = 1 << 10;

/// Rays are cast instead of drawing all pieces from so many pieces a pixel on. Tuned, at 128 pixels, on the scenes of
/// `benches/dense.rs`: a box full of small bodies, and a bumpy sphere seen from inside.
const PIECES_PER_PIXEL: f64 = 3.0;

/// Fewer pixels count as this many: rays for them have their common costs too, and small scenes need no hierarchy.
const FEWEST_PIXELS: usize = 1 << 10;

impl<'a> Drawable<'a> {
    /// Lays a scene out.
    pub fn new(scene: &'a Scene) -> Self {
        Self::with_strategy(scene, Strategy::Cheapest)
    }

    /// Lays a scene out to be drawn by one strategy, to compare them.
    pub fn with_strategy(scene: &'a Scene, strategy: Strategy) -> Self {
        let geometry = Geometry::new(scene);
        let regions = &geometry.regions;
        let fewest = PIECES_PER_PIXEL * FEWEST_PIXELS as f64;
        let (has_specks, has_rays) = match strategy {
            Strategy::Cheapest => (
                regions.regions().len() >= FEWEST_REGIONS,
                regions.pieces().len() as f64 > fewest,
            ),
            Strategy::Spans => (false, false),
            Strategy::Specks => (true, false),
            Strategy::Rays => (false, true),
        };
        let margin = (BOX_MARGIN * geometry.plane_tolerance) as f32;
        Self {
            locators: Locators::new(regions),
            clusters: has_specks.then(|| Clusters::new(regions)),
            bvh: has_rays.then(|| Bvh::new(regions, margin)),
            strategy,
            geometry,
        }
    }

    /// The scene.
    pub fn scene(&self) -> &'a Scene {
        self.geometry.scene
    }

    /// What is drawn of it.
    pub fn regions(&self) -> &Regions {
        &self.geometry.regions
    }

    /// [`plane_tolerance`](crate::plane_tolerance) of the scene, metres.
    pub fn plane_tolerance(&self) -> f64 {
        self.geometry.plane_tolerance
    }

    /// The region that a surface is in.
    pub fn region_of(&self, surface: SurfaceId) -> u32 {
        self.regions().region_of(surface)
    }

    /// Unit normal of the region that a surface is in.
    pub fn normal_of(&self, surface: SurfaceId) -> DVec3 {
        self.regions().regions()[self.region_of(surface) as usize].normal
    }

    /// The hierarchy, where so many pixels are found faster by casting rays than by drawing all pieces.
    pub(crate) fn rays_for(&self, pixels: usize) -> Option<&Bvh> {
        let pieces = self.regions().pieces().len() as f64;
        let pixels = pixels.max(FEWEST_PIXELS) as f64;
        let is_cheaper = self.strategy == Strategy::Rays || pieces > PIECES_PER_PIXEL * pixels;
        self.bvh.as_ref().filter(|_| is_cheaper)
    }
}
