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
            units: (factor * one).round() as u32,
        })
        .filter(|entry| entry.units > 0)
        .collect();
    let lamp_units: u64 = lamps.iter().map(|e| u64::from(e.units)).sum();
    let drawn_units: u64 = row
        .iter()
        .filter(|e| is_in(&seen.replaced, e.patch))
        .map(|e| u64::from(e.units))
        .sum();
    let others = u64::from(UNITS_PER_ONE) - drawn_units;
    if others == 0 || lamp_units > u64::from(UNITS_PER_ONE) {
        return None;
    }
    let scale = (u64::from(UNITS_PER_ONE) - lamp_units) as f64 / others as f64;
    // Rounding is carried along, so that the sum is kept to the unit.
    let (mut before, mut given) = (0_u64, 0_u64);
    let mut scaled = |units: u32| {
        before += u64::from(units);
        let now = (before as f64 * scale).round() as u64;
        let share = now.saturating_sub(given);
        given = now;
        share as u32
    };
    let mut merged = Vec::with_capacity(row.len() + lamps.len());
    let mut lamps = lamps.into_iter().peekable();
    for entry in row.iter().filter(|e| !is_in(&seen.replaced, e.patch)) {
        while let Some(lamp) = lamps.next_if(|lamp| lamp.patch < entry.patch) {
            merged.push(lamp);
        }
        let units = scaled(entry.units);
        if units > 0 {
            merged.push(Entry { units, ..*entry });
        }
    }
    merged.extend(lamps);
    let unseen = Unseen {
        open: scaled(unseen.open),
        back_face: scaled(unseen.back_face),
    };
    Some((merged, unseen))
}
