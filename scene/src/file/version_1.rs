//! Version 1 of the format: sections were known by numbers.
//!
//! The scene is the same. Of a solution only a start is read, its irradiances and how many iterations they have had:
//! what a solver had under way means nothing without the settings, which were a text.

use bytemuck::{Pod, Zeroable};
use serde::Deserialize;

use super::FileFault;
use super::layout::{Header, Section, SectionName};

/// The version that this module reads.
pub const VERSION: u32 = 1;

/// One entry of the section table.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
struct Entry {
    /// 1 to 8, by [`name_of`].
    kind: u32,
    /// Size of one record, bytes.
    record_bytes: u32,
    /// Where it starts in the file, bytes.
    offset: u64,
    /// Number of records.
    count: u64,
    /// Zero.
    reserved: u64,
}

/// The name of the same section today; 6 to 8 were what a solver had under way.
fn name_of(kind: u32) -> Option<SectionName> {
    match kind {
        1 => Some(SectionName::NAMES),
        2 => Some(SectionName::MATERIALS),
        3 => Some(SectionName::SURFACES),
        4 => Some(SectionName::PROVENANCE),
        5 => Some(SectionName::IRRADIANCE),
        _ => None,
    }
}

/// The section table of a file, as it would be today.
pub fn table(header: &Header, bytes: &[u8]) -> Result<Vec<Section>, FileFault> {
    let entries = header.table::<Entry>(bytes)?.into_iter();
    let sections = entries.filter_map(|entry| {
        Some(Section {
            name: name_of(entry.kind)?,
            record_bytes: entry.record_bytes,
            flags: 0,
            offset: entry.offset,
            count: entry.count,
        })
    });
    Ok(sections.collect())
}

/// What still counts of how a solution was made.
#[derive(Debug, Deserialize)]
pub struct Provenance {
    iterations: u64,
}

impl From<Provenance> for crate::Provenance {
    fn from(Provenance { iterations }: Provenance) -> Self {
        Self {
            iterations,
            ..Self::default()
        }
    }
}
