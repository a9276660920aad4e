//! Reading a file, trusting nothing in it.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use bytemuck::Pod;
use glam::{DVec3, Vec3};
use serde::de::DeserializeOwned;
use twox_hash::XxHash3_64;

use super::layout::{
    ALIGNMENT, Header, MAGIC, MaterialRecord, Names, Section, SurfaceRecord, VERSION, kind,
};
use super::{FileError, FileFault};
use crate::{Material, MaterialId, ObjectId, Rgb, Scene, Solution, Surface, Unfinished};

/// Reads a scene and, where the file has one, its solution.
pub fn load(path: &Path) -> Result<(Scene, Option<Solution>), FileError> {
    let read = || from_bytes(&read_bytes(path)?);
    read().map_err(|fault| FileError::new(path, fault))
}

/// All bytes of a file whose header fits it. A wrong or truncated file is told from its first
/// bytes and its size, however large it is or claims to be.
fn read_bytes(path: &Path) -> Result<Vec<u8>, FileFault> {
    let io = |source| FileFault::Io {
        action: "read",
        source,
    };
    let mut file = File::open(path).map_err(io)?;
    let metadata = file.metadata().map_err(io)?;
    let mut bytes = Vec::new();
    (&mut file)
        .take(size_of::<Header>() as u64)
        .read_to_end(&mut bytes)
        .map_err(io)?;
    let header = Header::read(&bytes)?;
    let rest = header.file_bytes.saturating_sub(bytes.len() as u64);
    if metadata.is_file() {
        header.check_size(metadata.len())?;
        bytes
            .try_reserve_exact(usize::try_from(rest).unwrap_or(usize::MAX))
            .map_err(|_| io(std::io::ErrorKind::OutOfMemory.into()))?;
    }
    // One byte more tells of a file that grew, or of a pipe that holds too much.
    file.take(rest.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(io)?;
    Ok(bytes)
}

/// Reads a scene from the bytes of a file.
pub fn from_bytes(bytes: &[u8]) -> Result<(Scene, Option<Solution>), FileFault> {
    let sections = Sections::parse(bytes)?;

    let names: Names = sections.json(kind::NAMES, "names")?;
    let materials = sections.records::<MaterialRecord>(kind::MATERIALS, "materials")?;
    if names.materials.len() != materials.len() {
        return Err(structure(format!(
            "{} names for {} materials",
            names.materials.len(),
            materials.len()
        )));
    }
    let materials = names
        .materials
        .into_iter()
        .zip(materials)
        .map(|(name, record)| Material {
            name,
            reflectance: Rgb::from(record.reflectance),
            emission: Rgb::from(record.emission),
        })
        .collect();
    let (surfaces, depths): (Vec<_>, Vec<_>) = sections
        .records::<SurfaceRecord>(kind::SURFACES, "surfaces")?
        .into_iter()
        .map(|record| {
            let surface = Surface {
                corners: record.corners.map(Vec3::from),
                material: MaterialId(record.material),
                object: ObjectId(record.object),
            };
            (surface, record.bisections)
        })
        .unzip();
    let origin = DVec3::from(sections.header.origin);
    let scene = Scene::new(materials, names.objects, surfaces, &depths, origin)?;

    if sections.find(kind::IRRADIANCE).is_none() {
        return Ok((scene, None));
    }
    let optional = |kind, what| {
        sections
            .find(kind)
            .map(|_| sections.records::<Rgb>(kind, what))
            .transpose()
    };
    let solution = Solution {
        irradiance: sections.records(kind::IRRADIANCE, "irradiance")?,
        provenance: sections.json(kind::PROVENANCE, "provenance")?,
        unfinished: optional(kind::UNFINISHED, "unfinished irradiance")?
            .map(|irradiance| Unfinished { irradiance }),
        unshot: optional(kind::UNSHOT, "unshot radiosity")?,
        remainder: optional(kind::REMAINDER, "remainder of the irradiance")?,
    };
    solution.validate(&scene)?;
    Ok((scene, Some(solution)))
}

fn structure(what: String) -> FileFault {
    FileFault::Structure { what }
}

impl Header {
    /// The header of a file that starts with these bytes.
    fn read(bytes: &[u8]) -> Result<Self, FileFault> {
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
        // Before the sizes: another version may have other sizes.
        if header.version != VERSION {
            return Err(FileFault::Version {
                found: header.version,
            });
        }
        Ok(header)
    }

    fn check_size(&self, found: u64) -> Result<(), FileFault> {
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
}

/// A file whose size, checksum and section table have been checked.
struct Sections<'a> {
    bytes: &'a [u8],
    header: Header,
    table: Vec<Section>,
}

impl<'a> Sections<'a> {
    fn parse(bytes: &'a [u8]) -> Result<Self, FileFault> {
        let header = Header::read(bytes)?;
        header.check_size(bytes.len() as u64)?;
        let checksum = checksum(&header, &bytes[size_of::<Header>()..]);
        if checksum != header.checksum {
            return Err(FileFault::Checksum {
                found: checksum,
                expected: header.checksum,
            });
        }
        let table_bytes = (header.section_count as usize)
            .checked_mul(size_of::<Section>())
            .and_then(|size| size.checked_add(size_of::<Header>()))
            .and_then(|end| bytes.get(size_of::<Header>()..end))
            .ok_or_else(|| {
                structure(format!(
                    "{} sections do not fit the file",
                    header.section_count
                ))
            })?;
        let table = bytemuck::allocation::pod_collect_to_vec(table_bytes);
        Ok(Self {
            bytes,
            header,
            table,
        })
    }

    fn find(&self, kind: u32) -> Option<&Section> {
        self.table.iter().find(|section| section.kind == kind)
    }

    /// The bytes of a section that must be there.
    fn section(&self, kind: u32, record_bytes: usize, what: &str) -> Result<&'a [u8], FileFault> {
        let section = self
            .find(kind)
            .ok_or_else(|| structure(format!("there is no section \"{what}\"")))?;
        if section.record_bytes as usize != record_bytes {
            return Err(structure(format!(
                "section \"{what}\" has records of {} bytes, expected {record_bytes}",
                section.record_bytes
            )));
        }
        if !section.offset.is_multiple_of(ALIGNMENT as u64) {
            return Err(structure(format!(
                "section \"{what}\" starts at byte {}, which is no multiple of {ALIGNMENT}",
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
                    "section \"{what}\" of {} records at byte {} does not fit the file",
                    section.count, section.offset
                ))
            })
    }

    fn records<T: Pod>(&self, kind: u32, what: &str) -> Result<Vec<T>, FileFault> {
        Ok(bytemuck::allocation::pod_collect_to_vec(self.section(
            kind,
            size_of::<T>(),
            what,
        )?))
    }

    fn json<T: DeserializeOwned>(&self, kind: u32, what: &str) -> Result<T, FileFault> {
        serde_json::from_slice(self.section(kind, 1, what)?)
            .map_err(|error| structure(format!("section \"{what}\": {error}")))
    }
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
