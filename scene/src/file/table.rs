//! The section table of a file, trusting nothing in it.

use std::collections::HashSet;

use bytemuck::Pod;
use serde::de::DeserializeOwned;
use twox_hash::XxHash3_64;

use super::layout::{ALIGNMENT, Header, MAGIC, REQUIRED, Section, SectionName, VERSION};
use super::{FileFault, version_1};

impl Header {
    /// The header of a file that starts with these bytes.
    pub(super) fn read(bytes: &[u8]) -> Result<Self, FileFault> {
        if bytes.is_empty() {
            return Err(FileFault::Empty);
        }
        let magic_bytes = bytes.len().min(MAGIC.len());
        if bytes[..magic_bytes] != MAGIC[..magic_bytes] {
            return Err(FileFault::Magic);
        }
        let Some(header) = bytes.get(..size_of::<Self>()) else {
            return Err(FileFault::Truncated {
                found: bytes.len() as u64,
                expected: size_of::<Self>() as u64,
            });
        };
        let header: Self = bytemuck::pod_read_unaligned(header);
        // Before the sizes: a later version may have other sizes.
        if !(1..=VERSION).contains(&header.version) {
            return Err(FileFault::Version {
                found: header.version,
            });
        }
        Ok(header)
    }

    /// Checks what the file says of its size against what it has, bytes.
    pub(super) fn check_size(&self, found: u64) -> Result<(), FileFault> {
        let expected = self.file_bytes;
        if found < expected {
            return Err(FileFault::Truncated { found, expected });
        }
        if found > expected {
            return Err(FileFault::TrailingBytes {
                extra: found - expected,
            });
        }
        Ok(())
    }

    /// The records of the section table, which `bytes`, the whole file, must hold.
    pub(super) fn table<T: Pod>(&self, bytes: &[u8]) -> Result<Vec<T>, FileFault> {
        let table = (self.section_count as usize)
            .checked_mul(size_of::<T>())
            .and_then(|size| size.checked_add(size_of::<Self>()))
            .and_then(|end| bytes.get(size_of::<Self>()..end))
            .ok_or_else(|| {
                let sections = self.section_count;
                structure(format!("{sections} sections do not fit the file"))
            })?;
        Ok(bytemuck::allocation::pod_collect_to_vec(table))
    }
}

/// A file whose size, checksum and section table have been checked.
pub(super) struct Sections<'a> {
    bytes: &'a [u8],
    pub header: Header,
    /// Of names that are known, each once.
    table: Vec<Section>,
}

impl<'a> Sections<'a> {
    pub(super) fn parse(bytes: &'a [u8]) -> Result<Self, FileFault> {
        let header = Header::read(bytes)?;
        header.check_size(bytes.len() as u64)?;
        let checksum = checksum(&header, &bytes[size_of::<Header>()..]);
        if checksum != header.checksum {
            return Err(FileFault::Checksum {
                found: checksum,
                expected: header.checksum,
            });
        }
        let mut table = if header.version == version_1::VERSION {
            version_1::table(&header, bytes)?
        } else {
            header.table(bytes)?
        };
        check_names_and_flags(&table)?;
        table.retain(|section| section.name.is_known());
        Ok(Self {
            bytes,
            header,
            table,
        })
    }

    /// Whether the file is of version 1.
    pub(super) fn is_version_1(&self) -> bool {
        self.header.version == version_1::VERSION
    }

    pub(super) fn find(&self, name: SectionName) -> Option<&Section> {
        self.table.iter().find(|section| section.name == name)
    }

    /// The bytes of a section that must be there.
    fn section(&self, name: SectionName, record_bytes: usize) -> Result<&'a [u8], FileFault> {
        let section = self
            .find(name)
            .ok_or_else(|| structure(format!("there is no section {name}")))?;
        if section.record_bytes as usize != record_bytes {
            return Err(structure(format!(
                "section {name} has records of {} bytes, expected {record_bytes}",
                section.record_bytes
            )));
        }
        if !section.offset.is_multiple_of(ALIGNMENT as u64) {
            return Err(structure(format!(
                "section {name} starts at byte {}, which is no multiple of {ALIGNMENT}",
                section.offset
            )));
        }
        section
            .count
            .checked_mul(record_bytes as u64)
            .and_then(|size| size.checked_add(section.offset))
            .and_then(|end| {
                let range = usize::try_from(section.offset).ok()?..usize::try_from(end).ok()?;
                self.bytes.get(range)
            })
            .ok_or_else(|| {
                structure(format!(
                    "section {name} of {} records at byte {} does not fit the file",
                    section.count, section.offset
                ))
            })
    }

    /// The records of a section that must be there.
    pub(super) fn records<T: Pod>(&self, name: SectionName) -> Result<Vec<T>, FileFault> {
        let bytes = self.section(name, size_of::<T>())?;
        Ok(bytemuck::allocation::pod_collect_to_vec(bytes))
    }

    /// The records of a section that may be missing.
    pub(super) fn records_if_any<T: Pod>(
        &self,
        name: SectionName,
    ) -> Result<Option<Vec<T>>, FileFault> {
        self.find(name).map(|_| self.records(name)).transpose()
    }

    /// Whether there is a section of this name.
    pub(super) fn has(&self, name: SectionName) -> bool {
        self.find(name).is_some()
    }

    /// What a section that must be there says in JSON.
    pub(super) fn json<T: DeserializeOwned>(&self, name: SectionName) -> Result<T, FileFault> {
        serde_json::from_slice(self.section(name, 1)?)
            .map_err(|error| structure(format!("section {name}: {error}")))
    }
}

/// Refuses what the module's documentation says that a reader refuses.
fn check_names_and_flags(table: &[Section]) -> Result<(), FileFault> {
    let mut names = HashSet::new();
    for &Section { name, flags, .. } in table {
        if !name.is_valid() {
            return Err(structure(format!("{name} is no name of a section")));
        }
        if !names.insert(name) {
            return Err(structure(format!("there are two sections {name}")));
        }
        if flags & !REQUIRED != 0 {
            return Err(FileFault::UnknownFlags {
                section: name.to_string(),
                flags: flags & !REQUIRED,
            });
        }
        if flags & REQUIRED != 0 && !name.is_known() {
            return Err(FileFault::UnknownSection {
                section: name.to_string(),
            });
        }
    }
    Ok(())
}

pub(super) fn structure(what: String) -> FileFault {
    FileFault::Structure { what }
}

/// XXH3-64 of the header with a checksum of zero, then of the rest of the file.
pub(super) fn checksum(header: &Header, rest: &[u8]) -> u64 {
    use std::hash::Hasher;
    let mut hasher = XxHash3_64::new();
    hasher.write(bytemuck::bytes_of(&Header {
        checksum: 0,
        ..*header
    }));
    hasher.write(rest);
    hasher.finish()
}
