//! The materials of surfaces: those of the file, and with textures or vertex colours one for each mean colour.

use std::collections::{HashMap, HashSet};
use std::path::PathBuf;

use glam::DVec2;

use super::ImportOptions;
use super::reflectance::{limited, told};
use super::terms::Terms;
use super::texture::{Picture, Textures};
use super::texture_mean::{mean, rounded};
use super::wrap::Wrap;
use crate::{Material, MaterialId, Rgb};

/// A material as faces have it.
#[derive(Clone, Debug)]
pub(crate) struct Taken {
    /// What it is where it has no textures, or they cannot be had. Its reflectance is the file's, which may be 1 or more.
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

/// What a triangle says of its look.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    /// Where it is in the texture of the reflectance, and in that of the emission.
    pub of_reflectance: Coordinates,
    pub of_emission: Coordinates,
    /// What its reflectance is multiplied by, dimensionless, in [0, 1].
    pub tint: Rgb,
}

/// What materials have textures of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Property {
    Reflectance,
    Emission,
}

/// The look of a triangle: its material in the file, the means of its textures of reflectance and emission, where it has such,
/// and its tint, all as bits.
type Look = (usize, [Option<[u32; 3]>; 2], [u32; 3]);

pub(crate) struct Looks {
    /// As the file has them; the first of `materials` are theirs.
    taken: Vec<Taken>,
    options: ImportOptions,
    terms: Terms,
    materials: Vec<Material>,
    textures: Textures,
    /// Textures that some face has without texture coordinates.
    without_places: HashSet<(usize, Property)>,
    /// Materials of the file that some face has as they are.
    seen: HashSet<usize>,
    by_look: HashMap<Look, MaterialId>,
}

impl Looks {
    pub(crate) fn new(taken: Vec<Taken>, options: &ImportOptions, terms: Terms) -> Self {
        let plain = |Taken { material, .. }: &Taken| Material {
            reflectance: limited(material.reflectance, options),
            ..material.clone()
        };
        Self {
            materials: taken.iter().map(plain).collect(),
            taken,
            options: options.clone(),
            terms,
            textures: Textures::default(),
            without_places: HashSet::new(),
            seen: HashSet::new(),
            by_look: HashMap::new(),
        }
    }

    /// What says that a material of the file is not there to see.
    pub(crate) fn absence(&self, material: usize) -> Option<&str> {
        self.taken[material].absence.as_deref()
    }

    /// The material of a triangle that has a material of the file: its reflectance and emission are multiplied by their textures'
    /// means, and its reflectance by the tint.
    pub(crate) fn id(
        &mut self,
        material: usize,
        place: &Place,
        warnings: &mut Vec<String>,
    ) -> MaterialId {
        let reflectance = self.mean(material, Property::Reflectance, place, warnings);
        let emission = self.mean(material, Property::Emission, place, warnings);
        let tint = rounded(place.tint);
        let taken = &self.taken[material];
        let is_plain = reflectance.is_none() && tint == Rgb::ONE;
        if is_plain && taken.reflectance.is_none() && self.seen.insert(material) {
            warnings.extend(told(&taken.material, &self.options, &self.terms));
        }
        if is_plain && emission.is_none() {
            return MaterialId(material as u32);
        }
        let bits = |colour: Rgb| colour.to_array().map(f32::to_bits);
        let means = [&reflectance, &emission].map(|mean| mean.as_ref().map(|mean| bits(mean.mean)));
        let look = (material, means, bits(tint));
        *self.by_look.entry(look).or_insert_with(|| {
            let Material {
                name,
                reflectance: plain,
                emission: plain_emission,
            } = taken.material.clone();
            let untinted = reflectance.map_or(plain, |mean| mean.factor * mean.mean);
            self.materials.push(Material {
                name,
                reflectance: limited(untinted * tint, &self.options),
                emission: emission.map_or(plain_emission, |mean| mean.factor * mean.mean),
            });
            MaterialId(self.materials.len() as u32 - 1)
        })
    }

    /// The mean of the texture of a property of a material over a triangle, if it has one that can be had.
    fn mean(
        &mut self,
        material: usize,
        property: Property,
        place: &Place,
        warnings: &mut Vec<String>,
    ) -> Option<Mean> {
        let taken = &self.taken[material];
        let (textured, corners) = match property {
            Property::Reflectance => (&taken.reflectance, place.of_reflectance),
            Property::Emission => (&taken.emission, place.of_emission),
        };
        let textured = textured.as_ref()?;
        let texels = self
            .textures
            .get(&textured.picture, &self.terms, warnings)?;
        let [Some(a), Some(b), Some(c)] = corners else {
            if self.without_places.insert((material, property)) {
                let plain = &self.materials[material];
                warnings.push(without_places(plain, property, textured, &self.terms));
            }
            return None;
        };
        Some(Mean {
            factor: textured.factor,
            mean: mean(texels, [a, b, c], textured.wrap),
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

/// The mean of a texture, and what it is multiplied by.
struct Mean {
    factor: Rgb,
    mean: Rgb,
}

fn without_places(
    plain: &Material,
    property: Property,
    textured: &Textured,
    terms: &Terms,
) -> String {
    let there = match property {
        Property::Reflectance => format!("it has reflectance {}", plain.reflectance),
        Property::Emission => "nothing is emitted".to_owned(),
    };
    format!(
        "material \"{}\": some of its faces have no texture coordinates ({}); there {there} instead of {}",
        plain.name,
        terms.coordinates,
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
