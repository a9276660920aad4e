//! What the lamps of a scene are.

use scene::{Scene, SurfaceId};

use crate::cpu::{is_in_plane, plane_tolerance, reach};

/// Emitting surfaces that touch in one plane.
#[derive(Clone, Debug)]
pub(super) struct Lamp {
    /// In their order.
    pub surfaces: Vec<SurfaceId>,
    /// Emission summed over channels, W/m^2.
    pub emission: f64,
}

/// The lamps of a scene, in the order of their first surfaces.
pub(super) fn lamps(scene: &Scene) -> Vec<Lamp> {
    let emitters: Vec<SurfaceId> = (0..scene.surfaces().len() as u32)
        .map(SurfaceId)
        .filter(|&id| scene.material(scene.surface(id).material).is_emitter())
        .collect();
    // Each emitter's lamp is named by its first surface; touching ones take the smaller name until
    // nothing changes any more.
    let mut first: Vec<usize> = (0..emitters.len()).collect();
    let by_corner = {
        let mut corners: Vec<([u32; 3], usize)> = emitters
            .iter()
            .enumerate()
            .flat_map(|(k, &id)| {
                scene
                    .surface(id)
                    .corners
                    .map(|p| (p.to_array().map(|x| (x + 0.0).to_bits()), k))
            })
            .collect();
        corners.sort_unstable();
        corners
    };
    let tolerance = plane_tolerance(scene);
    let root = |first: &mut [usize], mut k: usize| {
        while first[k] != k {
            // Halves the path for those who come after.
            first[k] = first[first[k]];
            k = first[k];
        }
        k
    };
    for same in by_corner.chunk_by(|a, b| a.0 == b.0) {
        for pair in same.windows(2) {
            let (j, k) = (pair[0].1, pair[1].1);
            let (a, b) = (root(&mut first, j), root(&mut first, k));
            if a != b && is_one_plane(scene, emitters[j], emitters[k], tolerance) {
                first[a.max(b)] = a.min(b);
            }
        }
    }
    let mut lamps: Vec<(usize, Lamp)> = Vec::new();
    for (k, &id) in emitters.iter().enumerate() {
        let name = root(&mut first, k);
        // Names come in growing order: a lamp's first surface comes before its others.
        if let Ok(found) = lamps.binary_search_by_key(&name, |(name, _)| *name) {
            lamps[found].1.surfaces.push(id);
        } else {
            let emission = scene.material(scene.surface(id).material).emission;
            let lamp = Lamp {
                surfaces: vec![id],
                emission: f64::from(emission.element_sum()),
            };
            lamps.push((name, lamp));
        }
    }
    lamps.into_iter().map(|(_, lamp)| lamp).collect()
}

/// True where two surfaces lie in one plane, face the same way, and emit alike.
fn is_one_plane(scene: &Scene, a: SurfaceId, b: SurfaceId, tolerance: f64) -> bool {
    let (a, b) = (scene.surface(a), scene.surface(b));
    let normal = a.normal();
    let through = a.corners[0].as_dvec3();
    let reach = reach(a).max(reach(b));
    a.material == b.material
        && normal.dot(b.normal()) > 0.0
        && b.corners.iter().all(|p| {
            let height = (p.as_dvec3() - through).dot(normal).abs();
            is_in_plane(height, tolerance, normal, reach)
        })
}
