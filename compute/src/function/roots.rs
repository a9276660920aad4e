//! Which surfaces have vertices, and which of them are one wall.

use glam::Vec3;
use scene::function::Refinement;
use scene::{Rgb, Scene, SurfaceId};
use visibility::Drawable;

use crate::foot::Feet;

/// Walls of a smaller share of the scene's area have what their patches have: most are facets of curved bodies, between which
/// light changes by steps, and which have more corners than patches.
const SMALL_WALL: f64 = 1.0 / 4000.0;

/// A mesh of the walls of a scene that are large enough and that light can reach, whole as yet. Surfaces are one wall where
/// they share a side on which nothing else stands, in one region. `is_lit` tells of surfaces.
pub(super) fn roots(
    scene: &Scene,
    drawable: &Drawable,
    is_lit: impl Fn(SurfaceId) -> bool,
) -> Refinement {
    let regions = drawable.regions();
    let area_of = |surfaces: &[SurfaceId]| -> f64 {
        surfaces.iter().map(|&id| scene.surface(id).area()).sum()
    };
    let least = SMALL_WALL * scene.area();
    let is_large: Vec<bool> = regions
        .regions()
        .iter()
        .map(|region| area_of(&region.surfaces) >= least)
        .collect();
    let is_black =
        |id: SurfaceId| scene.material(scene.surface(id).material).reflectance == Rgb::ZERO;
    let has_vertices =
        |id: SurfaceId| is_large[regions.region_of(id) as usize] && is_lit(id) && !is_black(id);
    let feet = Feet::new(drawable);
    let joins = |[a, b]: [SurfaceId; 2], ends: [Vec3; 2]| {
        regions.region_of(a) == regions.region_of(b) && !feet.is_foot(a, ends)
    };
    Refinement::new(scene, has_vertices, joins)
}
