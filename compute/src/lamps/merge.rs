//! Putting what is seen of lamps into a row.

use std::ops::Range;

use super::view::Seen;
use crate::rows::{Entry, UNITS_PER_ONE, Unseen};

/// True where one of the ascending ranges holds the patch.
pub(super) fn is_in(ranges: &[Range<u32>], patch: u32) -> bool {
    let after = ranges.partition_point(|range| range.start <= patch);
    after > 0 && ranges[after - 1].contains(&patch)
}

/// The row with the lamps' entries replaced, all others scaled to keep the sum, in patch order. `None`
/// where the hemicube sees nothing else that could take or give the difference.
pub(super) fn merge(row: &[Entry], unseen: Unseen, seen: &Seen) -> Option<(Vec<Entry>, Unseen)> {
    if seen.replaced.is_empty() {
        return None;
    }
    let one = f64::from(UNITS_PER_ONE);
    let lamps: Vec<Entry> = seen
        .factors
        .iter()
        .map(|&(patch, factor)| Entry {
            patch,
            units: (factor * one) as f32,
        })
        .filter(|entry| entry.units > 0.0)
        .collect();
    let sum = |entries: &mut dyn Iterator<Item = &Entry>| -> f64 {
        entries.map(|entry| f64::from(entry.units)).sum()
    };
    let lamp_units = sum(&mut lamps.iter());
    let others = sum(&mut row.iter().filter(|e| !is_in(&seen.replaced, e.patch)))
        + f64::from(unseen.open)
        + f64::from(unseen.back_face);
    if others <= 0.0 || lamp_units > one {
        return None;
    }
    let scale = (one - lamp_units) / others;
    let mut merged = Vec::with_capacity(row.len() + lamps.len());
    let mut lamps = lamps.into_iter().peekable();
    for entry in row.iter().filter(|e| !is_in(&seen.replaced, e.patch)) {
        while let Some(lamp) = lamps.next_if(|lamp| lamp.patch < entry.patch) {
            merged.push(lamp);
        }
        merged.push(Entry {
            units: (f64::from(entry.units) * scale) as f32,
            ..*entry
        });
    }
    merged.extend(lamps);
    let unseen = Unseen {
        open: (f64::from(unseen.open) * scale).round() as u32,
        back_face: (f64::from(unseen.back_face) * scale).round() as u32,
    };
    Some((merged, unseen))
}
