//! Patches that no light can reach: their irradiance is 0, so nobody needs their rows.
//!
//! # Theory
//! Light goes from one surface to another only where each has a part in front of the other's plane. It starts at what
//! emits, and goes on from what it reaches and what reflects: a flood. Occlusion can only take away from what
//! is so reached. What is not is dark in the solution: the bottom of a box, the outside of a house that is
//! lit inside, everything where nothing emits. The relation is symmetric, so what reflects and is lit sees
//! nothing that is left out.
//!
//! # Practice
//! The flood goes over regions ([`crate::cpu::regions`]), of which there are few. In front is what is so by more
//! than half the rounding that item buffers allow ([`crate::cpu::is_in_plane`]): nearer than that they draw
//! nothing. Emitters keep their rows, since they tell how much light leaves the scene, and are shot. Left out
//! is what has no light in the state that a run starts from either, so that no bit of any iteration changes.

use glam::DVec3;
use scene::{Rgb, Scene, Solution};

use crate::cpu::{COORDINATE_ULPS, Drawable};
use crate::hemicubes::Hemicubes;

/// The most products of a corner with a plane, a fraction of a second's; if they do not do, all is taken to be lit.
const MOST_PRODUCTS: usize = 1 << 27;

/// True for each patch that hemicubes stand on and no light can reach, one per patch; `None` where there is none, or where `start` has
/// light there.
pub fn unlit(hemicubes: &Hemicubes, start: &Solution) -> Option<Vec<bool>> {
    let (scene, drawable) = (hemicubes.receivers(), hemicubes.drawable());
    let lit = lit_regions(drawable)?;
    let mut unlit = Vec::with_capacity(scene.patch_count() as usize);
    for (id, tree) in (0..).map(scene::SurfaceId).zip(scene.mesh().trees()) {
        let is_unlit = !lit[drawable.region_of(id) as usize];
        unlit.extend(tree.patches().map(|_| is_unlit));
    }
    (unlit.contains(&true) && is_dark(start, &unlit)).then_some(unlit)
}

/// True where no patch of these has light in a solution.
fn is_dark(solution: &Solution, patches: &[bool]) -> bool {
    let unfinished = solution.unfinished.as_ref().map(|u| &u.irradiance);
    let unshot = solution.unshot.as_ref();
    [Some(&solution.irradiance), unfinished, unshot]
        .into_iter()
        .flatten()
        .all(|values| {
            let mut values = values.iter().zip(patches);
            values.all(|(&value, &is_meant)| !is_meant || value == Rgb::ZERO)
        })
}

/// True for each region that emits or that light can reach; `None` where it would take too long to tell.
fn lit_regions(drawable: &Drawable) -> Option<Vec<bool>> {
    let faces = faces(drawable);
    let mut lit: Vec<bool> = faces.iter().map(|face| face.emits).collect();
    let mut senders: Vec<usize> = (0..faces.len()).filter(|&k| lit[k]).collect();
    let mut unlit: Vec<usize> = (0..faces.len()).filter(|&k| !lit[k]).collect();
    let mut products = 0;
    while let Some(sender) = senders.pop() {
        let sender = &faces[sender];
        unlit.retain(|&k| {
            products += sender.corners.len() + faces[k].corners.len();
            let is_reached = sender.sees(&faces[k]);
            if is_reached {
                lit[k] = true;
                if faces[k].reflects {
                    senders.push(k);
                }
            }
            !is_reached
        });
        if products > MOST_PRODUCTS {
            return None;
        }
    }
    Some(lit)
}

/// A region and its plane.
struct Face {
    /// Unit vector.
    normal: DVec3,
    /// A point of the plane, metres.
    through: DVec3,
    /// Metres.
    corners: Vec<DVec3>,
    /// How far from the plane is in it, at most, metres.
    tolerance: f64,
    emits: bool,
    reflects: bool,
}

impl Face {
    fn sees(&self, other: &Self) -> bool {
        self.has_in_front(other) && other.has_in_front(self)
    }

    /// True where a part of the other one is in front of this one's plane.
    fn has_in_front(&self, other: &Self) -> bool {
        let height = |p: &DVec3| (p - self.through).dot(self.normal);
        other.corners.iter().any(|p| height(p) > self.tolerance)
    }
}

/// One per region.
fn faces(drawable: &Drawable) -> Vec<Face> {
    let (scene, regions): (&Scene, _) = (drawable.scene(), drawable.regions());
    let face = |region: &crate::cpu::regions::Region| {
        let pieces = region.pieces.clone();
        let corners: Vec<DVec3> = pieces
            .flat_map(|piece| regions.corners(piece as usize))
            .map(|&vertex| regions.vertices()[vertex as usize].as_dvec3())
            .collect();
        let reach = corners
            .iter()
            .fold(DVec3::ZERO, |most, p| most.max(p.abs()));
        let rounding = COORDINATE_ULPS * region.normal.abs().dot(reach);
        let material = scene.material(scene.surface(region.surfaces[0]).material);
        Face {
            normal: region.normal,
            through: region.reference[0],
            corners,
            tolerance: 0.5 * rounding.min(drawable.plane_tolerance()),
            emits: material.is_emitter(),
            reflects: material.reflectance.max_element() > 0.0,
        }
    };
    regions.regions().iter().map(face).collect()
}
