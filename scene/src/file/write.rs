//! Writing a file so that its name always holds one whole file.

use std::io::Write;
use std::path::Path;

use bytemuck::Pod;
use serde::Serialize;

use super::layout::{
    ALIGNMENT, Header, LayerNames, LayerVertexRecord, MAGIC, MaterialRecord, Names, OpeningRecord,
    REQUIRED, Section, SectionName, SurfaceRecord, VERSION, VertexRecord,
};
use super::{FileError, FileFault, table};
use crate::layers::Layers;
use crate::{Level, ModelAxes, Rgb, Scene, Solution, State};

/// Writes a scene, with or without a solution, replacing the file at once or not at all.
///
/// A solution that could not be read back (of the wrong length, with a NaN) is refused, so that it
/// cannot take the place of a good one.
pub fn save(path: &Path, scene: &Scene, solution: Option<&Solution>) -> Result<(), FileError> {
    if let Some(solution) = solution {
        solution
            .validate(scene)
            .map_err(|error| FileError::new(path, error))?;
    }
    write_atomically(path, |out| out.write_all(&to_bytes(scene, solution)))
}

/// Writes to a temporary file beside `path`, syncs it and renames it over `path`.
///
/// On any error, and if the process dies, `path` is as it was. The temporary file is removed on
/// errors; one left by a killed process has a name starting with a dot and ending in `.tmp`.
/// A device or a pipe, which renaming would destroy, is written to as it is; a file that is read-only is left alone.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut dyn Write) -> std::io::Result<()>,
) -> Result<(), FileError> {
    let fail = |action| move |source| FileError::new(path, FileFault::Io { action, source });
    if is_device_or_pipe(path) {
        let device = std::fs::OpenOptions::new().write(true).open(path);
        let mut buffered = std::io::BufWriter::new(device.map_err(fail("write"))?);
        return write(&mut buffered)
            .and_then(|()| buffered.flush())
            .map_err(fail("write"));
    }
    // A rename asks the folder alone.
    if is_read_only(path) {
        return Err(FileError::new(path, FileFault::ReadOnly));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let mut builder = tempfile::Builder::new();
    #[cfg(unix)]
    {
        // tempfile's default is private to the user; a result is an ordinary file. The umask still applies.
        use std::os::unix::fs::PermissionsExt;
        builder.permissions(std::fs::Permissions::from_mode(0o666));
    }
    let mut file = builder
        .prefix(&format!(".{name}."))
        .suffix(".tmp")
        .tempfile_in(folder_of(path))
        .map_err(without_path)
        .map_err(fail("write"))?;
    let mut buffered = std::io::BufWriter::with_capacity(1 << 20, file.as_file_mut());
    write(&mut buffered)
        .and_then(|()| buffered.flush())
        .map_err(fail("write"))?;
    drop(buffered);
    file.as_file().sync_all().map_err(fail("sync"))?;
    file.persist(path)
        .map_err(|error| error.error)
        .map_err(fail("replace"))?;
    // The rename itself must reach the disk too. Not every system can open a folder; the rename
    // has happened by now, so that is no error.
    if let Ok(folder) = std::fs::File::open(folder_of(path)) {
        folder.sync_all().ok();
    }
    Ok(())
}

/// An error of tempfile's without the temporary file's name, which it puts last.
fn without_path(error: std::io::Error) -> std::io::Error {
    let text = error.to_string();
    match text.split_once(" at path ") {
        Some((cause, _)) => std::io::Error::new(error.kind(), cause),
        None => error,
    }
}

/// True for what is neither a file nor a folder, and so cannot be replaced.
pub(super) fn is_device_or_pipe(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|m| !m.is_file() && !m.is_dir())
}

/// True for a file that must not be replaced, although a rename would do it.
pub(super) fn is_read_only(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|m| m.is_file() && m.permissions().readonly())
}

/// The folder a file is in.
pub(super) fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}

/// The bytes of a file.
pub fn to_bytes(scene: &Scene, solution: Option<&Solution>) -> Vec<u8> {
    let names = Names {
        materials: scene.materials().iter().map(|m| m.name.clone()).collect(),
        objects: scene.objects().to_vec(),
    };
    let materials: Vec<MaterialRecord> = scene
        .materials()
        .iter()
        .map(|m| MaterialRecord {
            reflectance: m.reflectance.into(),
            emission: m.emission.into(),
        })
        .collect();
    let surfaces: Vec<SurfaceRecord> = scene
        .surfaces()
        .iter()
        .zip(scene.mesh().trees())
        .map(|(surface, tree)| SurfaceRecord {
            corners: surface.corners.map(Into::into),
            material: surface.material.0,
            object: surface.object.0,
            bisections: tree.depth,
        })
        .collect();

    let mut file = FileBuilder::default();
    file.json(SectionName::NAMES, REQUIRED, &names);
    file.records(SectionName::MATERIALS, REQUIRED, &materials);
    file.records(SectionName::SURFACES, REQUIRED, &surfaces);
    file.records(SectionName::FACES, 0, scene.faces());
    if !scene.inside().is_empty() {
        let inside: Vec<u32> = scene.inside().iter().map(|patch| patch.0).collect();
        file.records(SectionName::INSIDE, 0, &inside);
    }
    if !scene.openings().is_empty() {
        let openings = scene.openings().iter().map(|opening| OpeningRecord {
            corners: opening.corners.map(Into::into),
            object: opening.object.0,
        });
        file.records(SectionName::OPENINGS, 0, &openings.collect::<Vec<_>>());
    }
    let axes = scene.axes();
    if axes != ModelAxes::default() {
        // Who does not know the unit would take places for others.
        file.json(SectionName::AXES, REQUIRED, &axes);
    }
    if let Some(solution) = solution {
        file.json(SectionName::PROVENANCE, 0, &solution.provenance);
        file.records(SectionName::IRRADIANCE, 0, &solution.irradiance);
        if let Level::Gathering { gathered, .. } = &solution.provenance.level {
            file.records(SectionName::GATHERED, 0, gathered);
        }
        match &solution.state {
            State::AtRest => {}
            State::Unfinished { irradiance } => {
                file.records(SectionName::UNFINISHED, 0, irradiance);
            }
            State::Shooting { unshot, remainder } => {
                file.records(SectionName::UNSHOT, 0, unshot);
                file.records(SectionName::REMAINDER, 0, remainder);
            }
        }
    }
    if let Some(function) = solution.and_then(|solution| solution.function.as_ref()) {
        let mesh = function.mesh();
        let values = function.irradiance().iter().zip(function.direct());
        let vertices = mesh.vertices().iter().zip(values);
        let vertices = vertices.map(|(&position, (&irradiance, &direct))| VertexRecord {
            position: position.into(),
            irradiance: irradiance.into(),
            direct: direct.into(),
        });
        file.records(SectionName::FUNCTION_ROOTS, 0, mesh.roots());
        file.records(SectionName::FUNCTION_NODES, 0, mesh.nodes());
        file.records(SectionName::VERTICES, 0, &vertices.collect::<Vec<_>>());
        if !function.error().is_empty() {
            file.records(SectionName::PATCH_ERROR, 0, function.error());
        }
    }
    if let Some(layers) = solution.and_then(|solution| solution.layers.as_ref()) {
        file.layers(layers);
    }
    file.finish(scene.origin().into())
}

/// Sections, each with its bytes, until their offsets are known.
#[derive(Default)]
struct FileBuilder {
    sections: Vec<(Section, Vec<u8>)>,
}

impl FileBuilder {
    fn layers(&mut self, layers: &Layers) {
        let all = || layers.layers.iter();
        let names = LayerNames {
            kind: layers.kind,
            names: all().map(|layer| layer.name.clone()).collect(),
            lamps: all().filter_map(|layer| layer.lamp).collect(),
        };
        self.json(SectionName::LAYERS, 0, &names);
        let irradiance: Vec<Rgb> = all().flat_map(|layer| layer.irradiance.clone()).collect();
        self.records(SectionName::LAYER_IRRADIANCE, 0, &irradiance);
        let vertices = all().flat_map(|layer| &layer.vertices);
        let vertices = vertices.map(|&[irradiance, direct]| LayerVertexRecord {
            irradiance: irradiance.into(),
            direct: direct.into(),
        });
        self.records(
            SectionName::LAYER_VERTICES,
            0,
            &vertices.collect::<Vec<_>>(),
        );
    }

    fn records<T: Pod>(&mut self, name: SectionName, flags: u32, records: &[T]) {
        let section = Section {
            name,
            record_bytes: size_of::<T>() as u32,
            flags,
            offset: 0,
            count: records.len() as u64,
        };
        self.sections
            .push((section, bytemuck::cast_slice(records).to_vec()));
    }

    fn json(&mut self, name: SectionName, flags: u32, value: &impl Serialize) {
        // Serialising strings and numbers to memory has no way to fail.
        self.records(name, flags, &serde_json::to_vec(value).unwrap_or_default());
    }

    fn finish(mut self, origin: [f64; 3]) -> Vec<u8> {
        let aligned = |size: usize| size.next_multiple_of(ALIGNMENT);
        let mut end = size_of::<Header>() + self.sections.len() * size_of::<Section>();
        for (section, bytes) in &mut self.sections {
            section.offset = aligned(end) as u64;
            end = aligned(end) + bytes.len();
        }
        let mut file = vec![0; size_of::<Header>()];
        file.reserve_exact(end - file.len());
        for (section, _) in &self.sections {
            file.extend_from_slice(bytemuck::bytes_of(section));
        }
        for (section, bytes) in &self.sections {
            file.resize(section.offset as usize, 0);
            file.extend_from_slice(bytes);
        }
        let mut header = Header {
            magic: MAGIC,
            version: VERSION,
            section_count: self.sections.len() as u32,
            file_bytes: file.len() as u64,
            checksum: 0,
            origin,
            reserved: 0,
        };
        header.checksum = table::checksum(&header, &file[size_of::<Header>()..]);
        file[..size_of::<Header>()].copy_from_slice(bytemuck::bytes_of(&header));
        file
    }
}
