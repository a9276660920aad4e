//! The materials of surfaces: those of the file, and with textures one for each mean colour.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use glam::DVec2;

use super::mtl::Taken;
use super::texture::Textures;
use crate::{Material, MaterialId, Rgb};

pub(super) struct Looks {
    /// As the file has them; the first of `materials` are theirs.
    taken: Vec<Taken>,
    materials: Vec<Material>,
    textures: Textures,
    /// Materials with textures that some face has without texture coordinates.
    without_places: HashSet<usize>,
    by_colour: HashMap<(usize, [u32; 3]), MaterialId>,
}

impl Looks {
    pub(super) fn new(taken: Vec<Taken>) -> Self {
        Self {
            materials: taken.iter().map(|taken| taken.material.clone()).collect(),
            taken,
            textures: Textures::default(),
            without_places: HashSet::new(),
            by_colour: HashMap::new(),
        }
    }

    /// Whether a material of the file is not there to see.
    pub(super) fn is_absent(&self, material: usize) -> bool {
        self.taken[material].is_absent
    }

    /// The material of a triangle that has a material of the file and these texture coordinates, if any: its reflectance
    /// is multiplied by the texture's mean.
    pub(super) fn id(
        &mut self,
        material: usize,
        at: [Option<DVec2>; 3],
        warnings: &mut Vec<String>,
    ) -> MaterialId {
        let mean = self.mean(material, at, warnings);
        let Some((mean, reflectance)) = mean else {
            return MaterialId(material as u32);
        };
        let key = (material, mean.to_array().map(f32::to_bits));
        *self.by_colour.entry(key).or_insert_with(|| {
            let plain = &self.taken[material].material;
            self.materials.push(Material {
                reflectance,
                ..plain.clone()
            });
            MaterialId(self.materials.len() as u32 - 1)
        })
    }

    /// The texture's mean over a triangle, and the reflectance that it makes.
    fn mean(
        &mut self,
        material: usize,
        at: [Option<DVec2>; 3],
        warnings: &mut Vec<String>,
    ) -> Option<(Rgb, Rgb)> {
        let taken = &self.taken[material];
        let textured = taken.texture.as_ref()?;
        let texture = self.textures.get(&textured.path, warnings)?;
        let [Some(a), Some(b), Some(c)] = at else {
            if self.without_places.insert(material) {
                warnings.push(format!(
                    "material \"{}\": some of its faces have no texture coordinates (vt); there it has reflectance {} instead of {}",
                    taken.material.name,
                    taken.material.reflectance,
                    textured.path.display()
                ));
            }
            return None;
        };
        let mean = texture.mean([a, b, c]);
        Some((mean, textured.reflectance(mean)))
    }

    pub(super) fn get(&self, material: MaterialId) -> &Material {
        &self.materials[material.index()]
    }

    /// The names of the file's materials.
    pub(super) fn names(&self) -> Vec<String> {
        let names = self.taken.iter().map(|taken| taken.material.name.clone());
        names.collect()
    }

    /// All materials, and the pictures that were asked for.
    pub(super) fn into_materials(self) -> (Vec<Material>, Vec<PathBuf>) {
        (self.materials, self.textures.into_files().collect())
    }
}

/// New numbers by first use.
pub(super) struct Kept {
    /// By old number.
    new: Vec<Option<u32>>,
    old: Vec<usize>,
}

impl Kept {
    pub(super) fn new(count: usize) -> Self {
        Self {
            new: vec![None; count],
            old: Vec::new(),
        }
    }

    pub(super) fn id(&mut self, old: usize) -> u32 {
        let next = self.old.len() as u32;
        *self.new[old].get_or_insert_with(|| {
            self.old.push(old);
            next
        })
    }

    pub(super) fn of<T: Clone>(&self, all: &[T]) -> Vec<T> {
        self.old.iter().map(|&old| all[old].clone()).collect()
    }
}
