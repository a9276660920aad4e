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
//! The flood goes over regions ([`visibility::regions`]), of which there are few. Emitters keep their rows,
//! since they tell how much light leaves the scene, and are shot. Left out is what has no light in the state that a run starts from either, so that no bit of any iteration changes.

use scene::{Level, Rgb, Solution, State};
use visibility::Drawable;
use visibility::facets::facets;

use crate::hemicubes::Hemicubes;

/// The most comparisons of a corner with a plane, a fraction of a second's work; in a scene that needs more all is taken
/// to be lit.
const MOST_PRODUCTS: usize = 1 << 27;

/// True for each patch that hemicubes stand on and no light can reach, one per patch; `None` where there is none, or where `start` has
/// light there.
pub fn unlit(hemicubes: &Hemicubes, start: &Solution) -> Option<Vec<bool>> {
    let (scene, drawable) = (hemicubes.sources().patches(), hemicubes.drawable());
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
    let under_way: &[Rgb] = match &solution.state {
        State::AtRest => &[],
        State::Unfinished { irradiance } => irradiance,
        State::Shooting { unshot, .. } => unshot,
    };
    let gathered: &[Rgb] = match &solution.provenance.level {
        Level::Gathering { gathered, .. } => gathered,
        _ => &[],
    };
    [&solution.irradiance, under_way, gathered]
        .into_iter()
        .all(|values| {
            let mut values = values.iter().zip(patches);
            values.all(|(&value, &is_meant)| !is_meant || value == Rgb::ZERO)
        })
}

/// True for each region that emits or that light can reach; `None` where it would take too long to tell.
fn lit_regions(drawable: &Drawable) -> Option<Vec<bool>> {
    let (facets, scene) = (facets(drawable), drawable.scene());
    let regions = drawable.regions().regions();
    let material = |region: usize| {
        let surface = scene.surface(regions[region].surfaces[0]);
        scene.material(surface.material)
    };
    let mut lit: Vec<bool> = (0..facets.len())
        .map(|k| material(k).is_emitter())
        .collect();
    let mut senders: Vec<usize> = (0..facets.len()).filter(|&k| lit[k]).collect();
    let mut unlit: Vec<usize> = (0..facets.len()).filter(|&k| !lit[k]).collect();
    let mut products = 0;
    while let Some(sender) = senders.pop() {
        let sender = &facets[sender];
        unlit.retain(|&k| {
            products += sender.corners.len() + facets[k].corners.len();
            let is_reached = sender.sees(&facets[k]);
            if is_reached {
                lit[k] = true;
                if material(k).reflectance.max_element() > 0.0 {
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
