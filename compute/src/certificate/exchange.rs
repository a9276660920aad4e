//! What sources send to each other, seen from both sides.

use scene::PatchId;

use super::{Known, Reciprocity, SEEN_BY_CHANCE, object_name};
use crate::row_cache::RowCache;
use crate::rows::UNITS_PER_ONE;
use crate::sources::SourceId;

/// What sources send and receive, each the sum over its patches; a patch is its own source unless sources are
/// coarser.
pub(super) struct Exchange {
    /// Area, A_j sum_i F_ji and sum_i A_i F_ij of each source, m^2.
    sources: Vec<[f64; 3]>,
    /// Whether others see its source, one per patch.
    pub is_seen: Vec<bool>,
}

impl Exchange {
    /// `areas` has one element per patch, m^2.
    pub fn new(rows: &RowCache, areas: &[f64]) -> Self {
        let sources = rows.sources();
        let mut exchange = Self {
            sources: Vec::with_capacity(sources.count() as usize),
            is_seen: Vec::with_capacity(areas.len()),
        };
        for source in 0..sources.count() {
            let [mut area, mut sent, mut sent_to_backs] = [0.0; 3];
            let patches = sources.patches_in(SourceId(source));
            for i in patches.clone().map(|patch| patch as usize) {
                let back_face = rows.unseen()[i].map_or(0, |unseen| unseen.back_face);
                area += areas[i];
                sent += areas[i] * rows.received().row_sum(i);
                sent_to_backs += areas[i] * f64::from(back_face) / f64::from(UNITS_PER_ONE);
            }
            let received = rows.received().area(source as usize);
            let is_seen = received > SEEN_BY_CHANCE * (sent + sent_to_backs);
            exchange.sources.push([area, sent, received]);
            exchange.is_seen.extend(patches.map(|_| is_seen));
        }
        exchange
    }

    pub fn reciprocity(&self, rows: &RowCache, known: &Known) -> Reciprocity {
        let inside = known.inside.unwrap_or_default();
        let sources = rows.sources();
        let is_unlit = rows.unlit();
        // Unlit patches, whose rows nobody knows, see no lit ones but black ones.
        let all_lit = !is_unlit.contains(&true);
        let reflectances = sources.patches().patch_reflectances();
        let counts = |source: u32| {
            let patches = sources.patches_in(SourceId(source));
            let patch = patches.start as usize;
            let is_inside = patches
                .clone()
                .all(|k| inside.binary_search(&PatchId(k)).is_ok());
            !is_inside && (all_lit || !is_unlit[patch] && reflectances[patch].max_element() > 0.0)
        };
        let (mut squares, mut whole) = (0.0, 0.0);
        let (mut worst_source, mut worst) = (0, 0.0_f64);
        let exchanges = (0..).zip(&self.sources);
        for (source, &[area, sent, received]) in exchanges.filter(|&(source, _)| counts(source)) {
            let larger = sent.max(received);
            let by_chance = sent == 0.0 && received <= SEEN_BY_CHANCE * area;
            let difference = if by_chance {
                0.0
            } else {
                (received - sent) / larger
            };
            squares += area * difference * difference;
            whole += area;
            if difference.abs() > worst.abs() {
                (worst_source, worst) = (source, difference);
            }
        }
        let worst_receiver = sources.patches_in(SourceId(worst_source)).start as usize;
        Reciprocity {
            rms: (squares / f64::max(whole, f64::MIN_POSITIVE)).sqrt(),
            worst_patch: known.patches_in(worst_receiver).start,
            worst_object: object_name(sources.patches(), worst_receiver),
            worst,
        }
    }
}
