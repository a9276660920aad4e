//! The materials of surfaces: those of the file, and with textures one for each mean colour.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use glam::DVec2;

use super::ImportOptions;
use super::reflectance::limited;
use super::texture::{Picture, Textures};
use super::texture_mean::mean;
use super::wrap::Wrap;
use crate::{Material, MaterialId, Rgb};

/// What a format calls things, for messages.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Terms {
    /// The colour of a material.
    pub colour: &'static str,
    /// Texture coordinates.
    pub coordinates: &'static str,
    /// What counts where a picture cannot be read.
    pub without_picture: &'static str,
}

/// A material as faces have it.
#[derive(Clone, Debug)]
pub(crate) struct Taken {
    /// Where it has no textures, or they cannot be had.
    pub material: Material,
    /// The picture that its reflectance has.
    pub reflectance: Option<Textured>,
    /// The picture that its emission has.
    pub emission: Option<Textured>,
    /// What says that it is wholly transparent: its faces are not there.
    pub absence: Option<String>,
}

/// A picture on a material.
#[derive(Clone, Debug)]
pub(crate) struct Textured {
    pub picture: Picture,
    /// What its colours are multiplied by.
    pub factor: Rgb,
    /// What is beyond its sides, along u and v.
    pub wrap: [Wrap; 2],
}

/// Texture coordinates of a triangle's corners, (0, 0) at the lower left of the picture.
pub(crate) type Coordinates = [Option<DVec2>; 3];

/// Bits of the means of the textures of reflectance and emission, where there are such.
type Means = [Option<[u32; 3]>; 2];

pub(crate) struct Looks {
    /// As the file has them; the first of `materials` are theirs.
    taken: Vec<Taken>,
    options: ImportOptions,
    terms: Terms,
    materials: Vec<Material>,
    textures: Textures,
    /// Materials with textures that some face has without texture coordinates.
    without_places: HashSet<usize>,
    by_colour: HashMap<(usize, Means), MaterialId>,
}

impl Looks {
    pub(crate) fn new(taken: Vec<Taken>, options: &ImportOptions, terms: Terms) -> Self {
        Self {
            materials: taken.iter().map(|taken| taken.material.clone()).collect(),
            taken,
            options: *options,
            terms,
            textures: Textures::default(),
            without_places: HashSet::new(),
            by_colour: HashMap::new(),
        }
    }

    /// What says that a material of the file is not there to see.
    pub(crate) fn absence(&self, material: usize) -> Option<&str> {
        self.taken[material].absence.as_deref()
    }

    /// The material of a triangle that has a material of the file and these texture coordinates, if any, for its reflectance
    /// and its emission: each is multiplied by its texture's mean.
    pub(crate) fn id(
        &mut self,
        material: usize,
        [of_reflectance, of_emission]: [Coordinates; 2],
        warnings: &mut Vec<String>,
    ) -> MaterialId {
        let taken = &self.taken[material];
        let means = [
            (&taken.reflectance, of_reflectance),
            (&taken.emission, of_emission),
        ]
        .map(|(textured, at)| {
            let textured = textured.as_ref()?;
            let texels = self
                .textures
                .get(&textured.picture, &self.terms, warnings)?;
            let [Some(a), Some(b), Some(c)] = at else {
                if self.without_places.insert(material) {
                    warnings.push(without_places(&taken.material, textured, &self.terms));
                }
                return None;
            };
            let mean = mean(texels, [a, b, c], textured.wrap);
            Some((mean, textured.factor * mean))
        });
        if means == [None, None] {
            return MaterialId(material as u32);
        }
        let bits = means.map(|mean| mean.map(|(mean, _)| mean.to_array().map(f32::to_bits)));
        *self.by_colour.entry((material, bits)).or_insert_with(|| {
            let mut look = taken.material.clone();
            if let Some((_, reflectance)) = means[0] {
                look.reflectance = limited(reflectance, &self.options);
            }
            if let Some((_, emission)) = means[1] {
                look.emission = emission;
            }
            self.materials.push(look);
            MaterialId(self.materials.len() as u32 - 1)
        })
    }

    pub(crate) fn get(&self, material: MaterialId) -> &Material {
        &self.materials[material.index()]
    }

    /// The name of a material of the file.
    pub(crate) fn name(&self, material: usize) -> &str {
        &self.taken[material].material.name
    }

    /// The names of the file's materials.
    pub(crate) fn names(&self) -> Vec<String> {
        let names = self.taken.iter().map(|taken| taken.material.name.clone());
        names.collect()
    }

    /// All materials, and the files of pictures that were asked for.
    pub(crate) fn into_materials(self) -> (Vec<Material>, Vec<PathBuf>) {
        (self.materials, self.textures.into_files())
    }
}

fn without_places(plain: &Material, textured: &Textured, terms: &Terms) -> String {
    format!(
        "material \"{}\": some of its faces have no texture coordinates ({}); there it has reflectance {} instead of {}",
        plain.name,
        terms.coordinates,
        plain.reflectance,
        textured.picture.name.display()
    )
}

/// Tells what of a material is left out, if anything is.
pub(crate) fn left_out(name: &str, items: &[String]) -> Option<String> {
    let joined = match items {
        [] => return None,
        [one] => format!("{one} is"),
        [rest @ .., last] => format!("{} and {last} are", rest.join(", ")),
    };
    Some(format!(
        "material \"{name}\": {joined} left out: surfaces are opaque and reflect diffusely"
    ))
}
