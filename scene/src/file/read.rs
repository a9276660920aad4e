//! Reading a file, trusting nothing in it.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use glam::{DVec3, Vec3};

use super::layout::{
    Header, LayerNames, LayerVertexRecord, MaterialRecord, Names, OpeningRecord, SectionName,
    SurfaceRecord, VertexRecord,
};
use super::table::{Sections, structure};
use super::{FileError, FileFault, version_1};
use crate::function::{IrradianceFunction, VertexMesh};
use crate::layers::{Layer, LayerKind, Layers};
use crate::{
    Level, Material, MaterialId, ObjectId, Opening, PatchId, Provenance, Rgb, Scene, Solution,
    State, Surface,
};

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
    let scene = scene(&sections)?;
    let solution = solution(&sections, scene.surfaces().len())?;
    if let Some(solution) = &solution {
        solution.validate(&scene)?;
    }
    Ok((scene, solution))
}

fn scene(sections: &Sections) -> Result<Scene, FileFault> {
    let names: Names = sections.json(SectionName::NAMES)?;
    let materials = sections.records::<MaterialRecord>(SectionName::MATERIALS)?;
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
        .records::<SurfaceRecord>(SectionName::SURFACES)?
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
    let mut scene = Scene::new(materials, names.objects, surfaces, &depths, origin)?;
    if sections.has(SectionName::AXES) {
        scene = scene.with_axes(sections.json(SectionName::AXES)?)?;
    }
    if let Some(inside) = sections.records_if_any::<u32>(SectionName::INSIDE)? {
        scene = scene.with_inside(inside.into_iter().map(PatchId).collect())?;
    }
    if let Some(openings) = sections.records_if_any::<OpeningRecord>(SectionName::OPENINGS)? {
        let openings = openings.into_iter().map(|record| Opening {
            corners: record.corners.map(Vec3::from),
            object: ObjectId(record.object),
        });
        scene = scene.with_openings(openings.collect())?;
    }
    Ok(match sections.records_if_any(SectionName::FACES)? {
        Some(faces) => scene.with_faces(faces)?,
        None => scene,
    })
}

fn solution(sections: &Sections, surfaces: usize) -> Result<Option<Solution>, FileFault> {
    let Some(irradiance) = sections.records_if_any(SectionName::IRRADIANCE)? else {
        return Ok(None);
    };
    if sections.is_version_1() {
        let provenance: version_1::Provenance = sections.json(SectionName::PROVENANCE)?;
        return Ok(Some(Solution {
            irradiance,
            provenance: provenance.into(),
            state: State::AtRest,
            function: None,
            layers: None,
        }));
    }
    let mut provenance: Provenance = sections.json(SectionName::PROVENANCE)?;
    if let Level::Gathering { gathered, .. } = &mut provenance.level {
        *gathered = sections.records(SectionName::GATHERED)?;
    }
    let function = function(sections, surfaces)?;
    let vertices = function.as_ref().map_or(0, |f| f.mesh().vertex_count());
    Ok(Some(Solution {
        layers: layers(sections, irradiance.len(), vertices as usize)?,
        irradiance,
        provenance,
        state: state(sections)?,
        function,
    }))
}

fn layers(
    sections: &Sections,
    patches: usize,
    vertices: usize,
) -> Result<Option<Layers>, FileFault> {
    if !sections.has(SectionName::LAYERS) {
        return Ok(None);
    }
    let LayerNames { kind, names, lamps } = sections.json(SectionName::LAYERS)?;
    let irradiance: Vec<Rgb> = sections.records(SectionName::LAYER_IRRADIANCE)?;
    let of_vertices: Vec<LayerVertexRecord> = sections.records(SectionName::LAYER_VERTICES)?;
    let count = names.len();
    let is_whole = |found: usize, each: usize| each.checked_mul(count) == Some(found);
    let has_lamps = match kind {
        LayerKind::Lamps => lamps.len() == count,
        LayerKind::Bounces => lamps.is_empty(),
    };
    if count == 0
        || !has_lamps
        || !is_whole(irradiance.len(), patches)
        || !is_whole(of_vertices.len(), vertices)
    {
        return Err(structure(format!(
            "{count} layers have {} lamps, {} irradiances and {} vertices",
            lamps.len(),
            irradiance.len(),
            of_vertices.len()
        )));
    }
    let value = |record: &LayerVertexRecord| [record.irradiance, record.direct].map(Rgb::from);
    let layers = names.into_iter().enumerate().map(|(k, name)| Layer {
        name,
        lamp: lamps.get(k).copied(),
        irradiance: irradiance[k * patches..(k + 1) * patches].to_vec(),
        vertices: of_vertices[k * vertices..(k + 1) * vertices]
            .iter()
            .map(value)
            .collect(),
    });
    let layers = layers.collect();
    Ok(Some(Layers { kind, layers }))
}

fn function(sections: &Sections, surfaces: usize) -> Result<Option<IrradianceFunction>, FileFault> {
    let Some(vertices) = sections.records_if_any::<VertexRecord>(SectionName::VERTICES)? else {
        return Ok(None);
    };
    let roots = sections.records(SectionName::FUNCTION_ROOTS)?;
    let nodes = sections.records(SectionName::FUNCTION_NODES)?;
    let positions = vertices.iter().map(|record| record.position.into());
    let mesh = VertexMesh::new(surfaces, roots, nodes, positions.collect())?;
    let irradiance = vertices.iter().map(|record| record.irradiance.into());
    let direct = vertices.iter().map(|record| record.direct.into());
    let function = IrradianceFunction::new(mesh, irradiance.collect(), direct.collect())?;
    Ok(Some(
        match sections.records_if_any(SectionName::PATCH_ERROR)? {
            Some(error) => function.with_error(error)?,
            None => function,
        },
    ))
}

fn state(sections: &Sections) -> Result<State, FileFault> {
    let unfinished = sections.records_if_any(SectionName::UNFINISHED)?;
    let unshot = sections.records_if_any(SectionName::UNSHOT)?;
    let remainder = sections.records_if_any(SectionName::REMAINDER)?;
    match (unfinished, unshot, remainder) {
        (None, None, None) => Ok(State::AtRest),
        (Some(irradiance), None, None) => Ok(State::Unfinished { irradiance }),
        (None, Some(unshot), Some(remainder)) => Ok(State::Shooting { unshot, remainder }),
        _ => Err(structure(format!(
            "sections {} and {} come together, and without {}",
            SectionName::UNSHOT,
            SectionName::REMAINDER,
            SectionName::UNFINISHED
        ))),
    }
}
