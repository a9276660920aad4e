//! What the lamps of a scene are.

#[cfg(test)]
mod tests;

use std::ops::Range;

use glam::{DVec3, Vec3};
use scene::weld::{Place, place};
use scene::{Scene, SurfaceId};

use visibility::{Drawable, is_in_plane, reach};

/// Emitting surfaces that touch, in one plane or as a convex body.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    /// In their order.
    pub surfaces: Vec<SurfaceId>,
    /// Those that they, and nothing else, are drawn in, ascending.
    pub regions: Vec<u32>,
    /// Their patches, as ascending ranges.
    pub patches: Vec<Range<u32>>,
    /// Emission summed over channels, W/m^2.
    pub emission: f64,
}

/// The most work to find out whether a body is convex: its surfaces times its corners.
const MOST_CONVEXITY_TESTS: usize = 1 << 28;

/// Groups at a corner that its other surfaces are compared with: at the tip of a cone each is one of its own.
const MOST_APART: usize = 64;

/// The lamps of a scene, in the order of their first surfaces.
pub(super) fn lamps(drawable: &Drawable) -> Vec<Lamp> {
    let scene = drawable.scene();
    let emitters: Vec<SurfaceId> = (0..scene.surfaces().len() as u32)
        .map(SurfaceId)
        .filter(|&id| scene.material(scene.surface(id).material).is_emitter())
        .collect();
    let alike = |a: SurfaceId, b: SurfaceId| scene.surface(a).material == scene.surface(b).material;
    let mut groups: Vec<Vec<SurfaceId>> = Vec::new();
    for body in touching(scene, &emitters, alike) {
        if is_convex(drawable, &body) {
            groups.push(body);
        } else {
            groups.extend(touching(scene, &body, |a, b| is_one_plane(drawable, a, b)));
        }
    }
    groups.sort_unstable_by_key(|surfaces| surfaces[0]);
    groups
        .into_iter()
        .filter_map(|surfaces| {
            let emission = scene.material(scene.surface(surfaces[0]).material).emission;
            let mut regions: Vec<u32> = surfaces.iter().map(|&id| drawable.region_of(id)).collect();
            regions.sort_unstable();
            regions.dedup();
            // What is drawn together with something else is left to the hemicube.
            let drawn = regions
                .iter()
                .map(|&region| drawable.regions().regions()[region as usize].surfaces.len());
            (drawn.sum::<usize>() == surfaces.len()).then(|| Lamp {
                regions,
                patches: patches(scene, &surfaces),
                surfaces,
                emission: f64::from(emission.element_sum()),
            })
        })
        .collect()
}

/// The patches of ascending surfaces, as few ranges.
fn patches(scene: &Scene, surfaces: &[SurfaceId]) -> Vec<Range<u32>> {
    let mut ranges: Vec<Range<u32>> = Vec::new();
    for &id in surfaces {
        let next = scene.mesh().tree(id).patches();
        match ranges.last_mut() {
            Some(last) if last.end == next.start => last.end = next.end,
            _ => ranges.push(next),
        }
    }
    ranges
}

/// Groups of surfaces that share corners with those that they may be joined to; each in its order.
fn touching(
    scene: &Scene,
    surfaces: &[SurfaceId],
    may_join: impl Fn(SurfaceId, SurfaceId) -> bool,
) -> Vec<Vec<SurfaceId>> {
    // Each surface's group is named by its first one; touching ones take the smaller name until nothing
    // changes any more.
    let mut first: Vec<usize> = (0..surfaces.len()).collect();
    let by_corner = {
        let mut corners: Vec<([u32; 3], usize)> = surfaces
            .iter()
            .enumerate()
            .flat_map(|(k, &id)| corner_bits(scene, id).map(|bits| (bits, k)))
            .collect();
        corners.sort_unstable();
        corners
    };
    let root = |first: &mut [usize], mut k: usize| {
        while first[k] != k {
            // Halves the path for those who come after.
            first[k] = first[first[k]];
            k = first[k];
        }
        k
    };
    // One of each group at a corner.
    let mut apart: Vec<usize> = Vec::new();
    for same in by_corner.chunk_by(|a, b| a.0 == b.0) {
        apart.clear();
        for &(_, k) in same {
            let mut is_apart = true;
            for &j in apart.iter().take(MOST_APART) {
                if may_join(surfaces[j], surfaces[k]) {
                    let (a, b) = (root(&mut first, j), root(&mut first, k));
                    first[a.max(b)] = a.min(b);
                    is_apart = false;
                }
            }
            if is_apart {
                apart.push(k);
            }
        }
    }
    let mut groups: Vec<(usize, Vec<SurfaceId>)> = Vec::new();
    for (k, &id) in surfaces.iter().enumerate() {
        let name = root(&mut first, k);
        // Names come in growing order: a group's first surface comes before its others.
        match groups.binary_search_by_key(&name, |(name, _)| *name) {
            Ok(found) => groups[found].1.push(id),
            Err(_) => groups.push((name, vec![id])),
        }
    }
    groups.into_iter().map(|(_, group)| group).collect()
}

/// Corners to compare for being the same.
fn corner_bits(scene: &Scene, id: SurfaceId) -> [Place; 3] {
    let corners = scene.surface(id).corners;
    corners.map(place)
}

/// True where no surface has a part of the others in front of it, so that none hides another.
fn is_convex(drawable: &Drawable, surfaces: &[SurfaceId]) -> bool {
    let (scene, tolerance) = (drawable.scene(), drawable.plane_tolerance());
    let mut corners: Vec<[u32; 3]> = surfaces
        .iter()
        .flat_map(|&id| corner_bits(scene, id))
        .collect();
    corners.sort_unstable();
    corners.dedup();
    let corners: Vec<DVec3> = corners
        .into_iter()
        .map(|bits| Vec3::from(bits.map(f32::from_bits)).as_dvec3())
        .collect();
    surfaces.len() * corners.len() <= MOST_CONVEXITY_TESTS
        && surfaces.iter().all(|&id| {
            let surface = scene.surface(id);
            let (normal, through) = (drawable.normal_of(id), surface.corners[0].as_dvec3());
            let reach = reach(surface);
            corners.iter().all(|&p| {
                let height = (p - through).dot(normal);
                height <= 0.0 || is_in_plane(height, tolerance, normal, reach.max(p.abs()))
            })
        })
}

/// True where two surfaces lie in one plane, face the same way, and emit alike. What is drawn together does.
fn is_one_plane(drawable: &Drawable, a: SurfaceId, b: SurfaceId) -> bool {
    if drawable.region_of(a) == drawable.region_of(b) {
        return true;
    }
    let (scene, tolerance) = (drawable.scene(), drawable.plane_tolerance());
    let (normal, other_normal) = (drawable.normal_of(a), drawable.normal_of(b));
    let (a, b) = (scene.surface(a), scene.surface(b));
    let through = a.corners[0].as_dvec3();
    let reach = reach(a).max(reach(b));
    a.material == b.material
        && normal.dot(other_normal) > 0.0
        && b.corners.iter().all(|p| {
            let height = (p.as_dvec3() - through).dot(normal).abs();
            is_in_plane(height, tolerance, normal, reach)
        })
}
