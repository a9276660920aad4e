//! The power balance of a solution.
//!
//! # Theory
//! Power balance, by channel, W: what is emitted, sum A E, is absorbed, sum A (1 - rho) H, or lost
//! through openings, sum A B f with f the share of a patch's hemisphere that sees nothing, or lost to
//! back faces, which are black. At the solution they balance up to the error of the form factors'
//! reciprocity: patches gather by F_ij, and leave by F_ji. The imbalance says how large that is.

use glam::DVec3;
use scene::{PatchId, Scene, Solution};
use serde::Serialize;

use crate::row_cache::RowCache;
use crate::rows::UNITS_PER_ONE;

/// Power balance, W, by channel.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Energy {
    /// By lamps.
    pub emitted_w: [f64; 3],
    /// By patches.
    pub absorbed_w: [f64; 3],
    /// Through openings; null where no row was drawn or read in this run.
    pub lost_w: Option<[f64; 3]>,
    /// To back faces; null as above.
    pub back_faces_w: Option<[f64; 3]>,
    /// (emitted - absorbed - lost - back faces) / emitted, all channels together, dimensionless; null
    /// where something is unknown or nothing is emitted.
    pub imbalance: Option<f64>,
}

/// Row sums of patches outside of solids, dimensionless.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Closure {
    /// Smallest.
    pub min: f64,
    /// By area.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// Power balance, row sums and share of back faces. `inside` are the patches inside of solids, as far as they are known.
pub fn measure(
    scene: &Scene,
    solution: &Solution,
    rows: &RowCache,
    inside: &[PatchId],
) -> (Energy, Option<Closure>, Option<f64>) {
    let areas = scene.patch_areas();
    let reflectance = scene.patch_reflectances();
    let radiosity = solution.radiosity(scene);
    let [mut absorbed, mut lost, mut back] = [DVec3::ZERO; 3];
    let (mut sum_min, mut sum_max) = (f64::INFINITY, f64::NEG_INFINITY);
    let (mut sum_area, mut back_area, mut drawn_area) = (0.0, 0.0, 0.0);
    let mut all_drawn = true;
    for (i, &area) in areas.iter().enumerate() {
        let irradiance = solution.irradiance[i].as_dvec3();
        absorbed += area * (1.0 - reflectance[i].as_dvec3()) * irradiance;
        let Some(unseen) = rows.unseen()[i] else {
            // What is unlit loses nothing.
            all_drawn &= rows.unlit()[i];
            continue;
        };
        let open = f64::from(unseen.open) / f64::from(UNITS_PER_ONE);
        let back_face = f64::from(unseen.back_face) / f64::from(UNITS_PER_ONE);
        let leaving = area * radiosity[i].as_dvec3();
        lost += open * leaving;
        back += back_face * leaving;
        if inside.binary_search(&PatchId(i as u32)).is_ok() {
            continue;
        }
        let sum = rows.received().row_sum(i);
        sum_min = sum_min.min(sum);
        sum_max = sum_max.max(sum);
        sum_area += area * sum;
        back_area += area * back_face;
        drawn_area += area;
    }
    let emitted = scene.emitted_power();
    let total = emitted.element_sum();
    let energy = Energy {
        emitted_w: emitted.into(),
        absorbed_w: absorbed.into(),
        lost_w: all_drawn.then(|| lost.into()),
        back_faces_w: all_drawn.then(|| back.into()),
        imbalance: (all_drawn && total > 0.0)
            .then(|| (emitted - absorbed - lost - back).element_sum() / total),
    };
    let any_drawn = drawn_area > 0.0;
    let closure = any_drawn.then(|| Closure {
        min: sum_min,
        mean: sum_area / drawn_area,
        max: sum_max,
    });
    (energy, closure, any_drawn.then(|| back_area / drawn_area))
}
