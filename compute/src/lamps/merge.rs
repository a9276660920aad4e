//! Putting what is seen of lamps into a row.

use std::ops::Range;

use super::view::Seen;
use crate::rows::{Entry, Row, UNITS_PER_ONE, Unseen};

/// The parts of a row between some ascending ranges of patches.
fn unreplaced<'r>(
    mut row: &'r [Entry],
    replaced: &[Range<u32>],
) -> impl Iterator<Item = &'r [Entry]> {
    replaced
        .iter()
        .cloned()
        .chain(std::iter::once(u32::MAX..u32::MAX))
        .map(move |range| {
            let end = row.partition_point(|entry| entry.source < range.start);
            let next = row.partition_point(|entry| entry.source < range.end);
            let part = &row[..end];
            row = &row[next..];
            part
        })
}

/// The row with the lamps' entries replaced, all others scaled to keep the sum, in patch order. `None`
/// where the hemicube sees nothing else that could take or give the difference.
pub(super) fn merge(row: &Row, seen: &Seen) -> Option<Row> {
    if seen.replaced.is_empty() {
        return None;
    }
    let Row {
        entries: row,
        unseen,
    } = row;
    let one = f64::from(UNITS_PER_ONE);
    let lamps: Vec<Entry> = seen
        .factors
        .iter()
        .map(|&(patch, factor)| Entry {
            source: patch,
            units: (factor * one) as f32,
        })
        .filter(|entry| entry.units > 0.0)
        .collect();
    let sum = |entries: &[Entry]| -> f64 { entries.iter().map(|e| f64::from(e.units)).sum() };
    let lamp_units = sum(&lamps);
    let others: f64 = unreplaced(row, &seen.replaced).map(sum).sum::<f64>()
        + f64::from(unseen.open)
        + f64::from(unseen.back_face);
    if others <= 0.0 || lamp_units > one {
        return None;
    }
    let scale = (one - lamp_units) / others;
    let mut merged = Vec::with_capacity(row.len() + lamps.len());
    let mut lamps = &lamps[..];
    for part in unreplaced(row, &seen.replaced).filter(|part| !part.is_empty()) {
        let before = lamps.partition_point(|lamp| lamp.source < part[0].source);
        merged.extend_from_slice(&lamps[..before]);
        lamps = &lamps[before..];
        merged.extend(part.iter().map(|entry| Entry {
            units: (f64::from(entry.units) * scale) as f32,
            ..*entry
        }));
    }
    merged.extend_from_slice(lamps);
    let unseen = Unseen {
        open: (f64::from(unseen.open) * scale).round() as u32,
        back_face: (f64::from(unseen.back_face) * scale).round() as u32,
    };
    Some(Row {
        entries: merged,
        unseen,
    })
}
