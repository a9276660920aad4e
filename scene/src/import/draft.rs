//! From a file's triangles to a model: what is turned, what is dropped, and what is left is numbered anew.

use std::collections::BTreeMap;

use glam::DVec3;

use super::looks::Looks;
use super::repairs::{drop_repeated, turn_to_normals};
use super::{ImportOptions, ImportReport, ImportedModel};
use crate::{ModelAxes, Surface};

/// A triangle on its way to a surface.
pub(crate) struct Piece {
    pub surface: Surface,
    /// The file's triangle, from 0.
    pub face: u32,
    /// Where it is in the file, as the format counts; pieces of one face are at one place.
    pub place: usize,
    /// Whether the file's own normals are on its back; `None` where there are none.
    pub is_against: Option<bool>,
}

/// A model whose triangles have been read.
pub(crate) struct Draft {
    /// Pieces of one face follow each other.
    pub pieces: Vec<Piece>,
    pub looks: Looks,
    /// By the numbers that the pieces have.
    pub objects: Vec<String>,
    /// All of the file, those counted that were dropped.
    pub triangles: usize,
    /// Triangles that are not there to see, by the file's materials.
    pub absent: BTreeMap<usize, usize>,
    pub origin: DVec3,
    pub axes: ModelAxes,
    pub report: ImportReport,
}

impl Draft {
    /// Whether a triangle of this material is not there to see; if so it is counted.
    pub(crate) fn leaves_out(&mut self, material: usize) -> bool {
        let is_absent = self.looks.absence(material).is_some();
        if is_absent {
            *self.absent.entry(material).or_insert(0) += 1;
        }
        is_absent
    }

    /// Tells of the materials that are not there to see.
    pub(crate) fn warn_of_absent(&mut self) {
        for (&material, count) in &self.absent {
            if let Some(why) = self.looks.absence(material) {
                self.report.warnings.push(format!(
                    "material \"{}\" is wholly transparent ({why}): its {count} triangles are left out",
                    self.looks.name(material)
                ));
            }
        }
    }

    /// The model, once pieces are turned and dropped; `place` is how warnings call the place of a piece.
    pub(crate) fn finish(
        mut self,
        options: &ImportOptions,
        place: &dyn Fn(usize) -> String,
    ) -> ImportedModel {
        turn_to_normals(&mut self.pieces, options.orient, place, &mut self.report);
        drop_repeated(&mut self, place);
        let Self {
            mut pieces,
            looks,
            objects,
            origin,
            axes,
            report,
            ..
        } = self;
        let (materials, files) = looks.into_materials();
        let mut kept_materials = Kept::new(materials.len());
        let mut kept_objects = Kept::new(objects.len());
        for Piece { surface, .. } in &mut pieces {
            surface.material.0 = kept_materials.id(surface.material.index());
            surface.object.0 = kept_objects.id(surface.object.index());
        }
        ImportedModel {
            materials: kept_materials.of(&materials),
            objects: kept_objects.of(&objects),
            faces: pieces.iter().map(|piece| piece.face).collect(),
            surfaces: pieces.into_iter().map(|piece| piece.surface).collect(),
            origin,
            axes,
            report,
            files,
        }
    }
}

/// New numbers by first use.
struct Kept {
    /// By old number.
    new: Vec<Option<u32>>,
    old: Vec<usize>,
}

impl Kept {
    fn new(count: usize) -> Self {
        Self {
            new: vec![None; count],
            old: Vec::new(),
        }
    }

    fn id(&mut self, old: usize) -> u32 {
        let next = self.old.len() as u32;
        *self.new[old].get_or_insert_with(|| {
            self.old.push(old);
            next
        })
    }

    fn of<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.old.iter().map(|&old| all[old].clone()).collect()
    }
}
