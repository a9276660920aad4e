//! Which patches lie inside of solids.
//!
//! What sees backs for the most part and stays dark does: the floor below a box sees nothing else, that below a column the ceiling
//! above it too; what of a box is sunk in the floor sees that floor's back, and out. Such patches have no part in means and
//! errors.

use scene::{PatchId, Solution};

use super::SEEN_BY_CHANCE;
use crate::row_cache::RowCache;
use crate::rows::UNITS_PER_ONE;

/// Relative residual from which on what is dark stays dark.
const NEAR_ITS_END: f64 = 0.01;

/// The patches that lie inside of solids or behind walls: most of what they see is backs and openings, and they neither emit
/// nor are lit, but by chance.
///
/// `None` unless all rows of lit patches were drawn and the solution is near its end.
pub fn inside(rows: &RowCache, solution: &Solution) -> Option<Vec<PatchId>> {
    let scene = rows.sources().patches();
    let all_drawn = rows.unseen().iter().flatten().count() as u32 == rows.lit_count();
    let residual = solution.provenance.residuals.last();
    if !all_drawn || residual.is_none_or(|&residual| residual > NEAR_ITS_END) {
        return None;
    }
    let irradiance = |j: usize| f64::from(solution.irradiance[j].element_sum());
    let areas = scene.patch_areas();
    let received: f64 = (0..areas.len()).map(|j| areas[j] * irradiance(j)).sum();
    let by_chance = SEEN_BY_CHANCE * received / areas.iter().sum::<f64>();
    let emissions = scene.patch_emissions();
    let is_inside = |&j: &usize| {
        let sees_backs = rows.unseen()[j].is_some_and(|unseen| {
            let [backs, open] = [unseen.back_face, unseen.open].map(f64::from);
            let most = 0.5 * f64::from(UNITS_PER_ONE);
            backs > SEEN_BY_CHANCE * most && backs + open > most
        });
        sees_backs && irradiance(j) <= by_chance && emissions[j].max_element() == 0.0
    };
    let inside = (0..areas.len()).filter(is_inside);
    Some(inside.map(|j| PatchId(j as u32)).collect())
}
