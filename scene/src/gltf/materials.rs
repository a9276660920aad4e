//! Materials: what surfaces reflect and emit of what the file says.

use std::collections::HashMap;
use std::f32::consts::PI;

use gltf::json::extensions::material::PbrSpecularGlossiness;
use gltf::json::material::{AlphaMode, Material as Described};
use gltf::json::mesh::{Primitive, Semantic};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;

use super::GltfFault;
use super::document::Document;
use super::names::first_name;
use super::pictures::{Mapping, Pictures};
use crate::import::{GREY, ImportOptions, Taken, Terms, Textured, check, left_out};
use crate::{Material, Rgb};

/// What messages call things.
pub(super) const TERMS: Terms = Terms {
    colour: "its base colour",
    coordinates: "TEXCOORD",
    without_picture: "the base colour's factor alone counts, and nothing is emitted where it was to shine",
};

/// Metalness up to this is that of any dull surface, dimensionless.
const METAL: f32 = 0.05;

/// The materials that faces use, by first use.
pub(super) struct Materials<'a> {
    document: &'a Document,
    pictures: Pictures<'a>,
    options: &'a ImportOptions,
    numbers: HashMap<Key, usize>,
    taken: Vec<Taken>,
    used: Vec<Used>,
}

/// What a primitive says of its material.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
enum Key {
    /// The file's number.
    Described(usize),
    /// It has none, but vertex colours.
    Coloured,
    Without,
}

/// What the triangles of a material need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Used {
    /// Where texture coordinates are for the reflectance and the emission.
    pub mappings: [Option<Mapping>; 2],
    /// Whether vertex colours count.
    pub is_tinted: bool,
    pub is_double_sided: bool,
}

impl<'a> Materials<'a> {
    pub(super) fn new(document: &'a Document, options: &'a ImportOptions) -> Self {
        Self {
            document,
            pictures: Pictures::new(document),
            options,
            numbers: HashMap::new(),
            taken: Vec::new(),
            used: Vec::new(),
        }
    }

    /// The number of the material of a primitive's faces.
    pub(super) fn number(
        &mut self,
        primitive: &Primitive,
        warnings: &mut Vec<String>,
    ) -> Result<usize, GltfFault> {
        let colours = Checked::Valid(Semantic::Colors(0));
        let key = match primitive.material {
            Some(index) => Key::Described(index.value()),
            None if primitive.attributes.contains_key(&colours) => Key::Coloured,
            None => Key::Without,
        };
        if let Some(&number) = self.numbers.get(&key) {
            return Ok(number);
        }
        let (taken, used) = match primitive.material {
            None => self.without(key == Key::Coloured, warnings),
            Some(index) => {
                let described = self.document.get(index)?;
                let name = first_name([described.name.as_ref()], || format!("material {index}"));
                self.taken(described, &name, warnings)?
            }
        };
        self.numbers.insert(key, self.taken.len());
        self.taken.push(taken);
        self.used.push(used);
        Ok(self.taken.len() - 1)
    }

    pub(super) fn used(&self, number: usize) -> Used {
        self.used[number]
    }

    /// Adds the material of a light.
    pub(super) fn add(&mut self, material: Material) -> usize {
        self.taken.push(plain(material));
        self.used.push(Used::PLAIN);
        self.taken.len() - 1
    }

    pub(super) fn into_taken(self) -> Vec<Taken> {
        self.taken
    }

    /// What stands in for a material where faces have none: their vertex colours, else a grey.
    fn without(&self, has_colours: bool, warnings: &mut Vec<String>) -> (Taken, Used) {
        let is_tinted = has_colours && self.options.reflectance.is_none();
        let reflectance = if is_tinted {
            1.0
        } else {
            self.options.reflectance.unwrap_or(GREY)
        };
        if !is_tinted {
            warnings.push(format!(
                "some primitives have no material; they are grey with reflectance {reflectance}"
            ));
        }
        let taken = plain(Material {
            name: "default".to_owned(),
            reflectance: Rgb::splat(reflectance),
            emission: Rgb::ZERO,
        });
        let used = Used {
            is_tinted,
            ..Used::PLAIN
        };
        (taken, used)
    }

    fn taken(
        &mut self,
        described: &Described,
        name: &str,
        warnings: &mut Vec<String>,
    ) -> Result<(Taken, Used), GltfFault> {
        let Colour {
            factor,
            alpha,
            texture: base,
        } = Colour::of(described);
        let emission = emission(described);
        let grey = self.options.reflectance;
        let grey = grey.filter(|_| emission.max_element() <= 0.0);
        let all_of_it = Material {
            name: name.to_owned(),
            reflectance: grey.map_or(factor, Rgb::splat),
            emission,
        };
        check(&all_of_it, self.options).map_err(GltfFault::Material)?;
        let mut notes = notes(described, alpha, base.is_some());
        let reflectance = match grey {
            Some(_) => None,
            None => self.textured(base, factor, "the base colour's texture", &mut notes)?,
        };
        let emissive = described.emissive_texture.as_ref();
        let shining = emissive.filter(|_| all_of_it.is_emitter());
        let of_emission = self.textured(shining, emission, "emissiveTexture", &mut notes)?;
        warnings.extend(left_out(name, &notes));
        let (reflectance, reflectance_mapping) = reflectance.unzip();
        let (of_emission, emission_mapping) = of_emission.unzip();
        let taken = Taken {
            material: Material {
                // Where its texture cannot be had, nobody knows which part of it shines.
                emission: emissive.map_or(emission, |_| Rgb::ZERO),
                ..all_of_it
            },
            reflectance,
            emission: of_emission,
            absence: absence(described, alpha, base.is_some()),
        };
        let used = Used {
            mappings: [reflectance_mapping, emission_mapping],
            is_tinted: grey.is_none(),
            is_double_sided: described.double_sided,
        };
        Ok((taken, used))
    }

    /// The texture of a property, and where texture coordinates are in it; a note where its picture cannot be read.
    fn textured(
        &mut self,
        info: Option<&Info>,
        factor: Rgb,
        what: &str,
        notes: &mut Vec<String>,
    ) -> Result<Option<(Textured, Mapping)>, GltfFault> {
        let Some(info) = info else {
            return Ok(None);
        };
        let found = self.pictures.texture(info, factor)?;
        if found.is_none() {
            notes.push(format!("{what} (no picture in PNG or JPEG)"));
        }
        Ok(found)
    }
}

impl Used {
    const PLAIN: Self = Self {
        mappings: [None; 2],
        is_tinted: false,
        is_double_sided: false,
    };
}

fn plain(material: Material) -> Taken {
    Taken {
        material,
        reflectance: None,
        emission: None,
        absence: None,
    }
}

/// The diffuse colour of a material.
struct Colour<'a> {
    factor: Rgb,
    alpha: f32,
    texture: Option<&'a Info>,
}

impl<'a> Colour<'a> {
    fn of(described: &'a Described) -> Self {
        let metallic = &described.pbr_metallic_roughness;
        let of_metallic = (metallic.base_color_factor.0, &metallic.base_color_texture);
        let ([r, g, b, alpha], texture) = specular_glossiness(described)
            .map_or(of_metallic, |other| {
                (other.diffuse_factor.0, &other.diffuse_texture)
            });
        Self {
            factor: Rgb::new(r, g, b),
            alpha,
            texture: texture.as_ref(),
        }
    }
}

fn specular_glossiness(described: &Described) -> Option<&PbrSpecularGlossiness> {
    described
        .extensions
        .as_ref()?
        .pbr_specular_glossiness
        .as_ref()
}

/// The exitance of a diffuse emitter of the radiance that the material says, W/m^2: M = pi L.
fn emission(described: &Described) -> Rgb {
    let extensions = described.extensions.as_ref();
    let strength = extensions.and_then(|extensions| extensions.emissive_strength.as_ref());
    let strength = strength.map_or(1.0, |strength| strength.emissive_strength.0);
    PI * strength * Rgb::from(described.emissive_factor.0)
}

/// What says that nothing of a material is there to see.
fn absence(described: &Described, alpha: f32, has_texture: bool) -> Option<String> {
    let cutoff = described.alpha_cutoff.map_or(0.5, |cutoff| cutoff.0);
    match described.alpha_mode {
        Checked::Valid(AlphaMode::Blend) if alpha <= 0.0 => {
            Some(format!("alpha {alpha}, alphaMode BLEND"))
        }
        // A texture's alpha is 1 at most.
        Checked::Valid(AlphaMode::Mask) if alpha < cutoff => {
            let of_texture = if has_texture { " at most" } else { "" };
            Some(format!(
                "alpha {alpha}{of_texture}, alphaMode MASK below {cutoff}"
            ))
        }
        _ => None,
    }
}

/// What a material says that is not taken.
fn notes(described: &Described, alpha: f32, has_texture: bool) -> Vec<String> {
    let mut notes = Vec::new();
    let metallic = &described.pbr_metallic_roughness;
    let metalness = metallic.metallic_factor.0;
    if specular_glossiness(described).is_some() {
        notes.push("KHR_materials_pbrSpecularGlossiness beside its diffuse colour".to_owned());
    } else if metalness > METAL {
        let texture = match metallic.metallic_roughness_texture {
            Some(_) => " times its texture",
            None => "",
        };
        notes.push(format!("metallicFactor {metalness}{texture}"));
    }
    let is_see_through = alpha < 1.0 || has_texture;
    match described.alpha_mode {
        Checked::Valid(AlphaMode::Blend) if is_see_through => {
            notes.push(format!("alphaMode BLEND with alpha {alpha}"));
        }
        Checked::Valid(AlphaMode::Mask) if is_see_through => {
            notes.push(format!("alphaMode MASK with alpha {alpha}"));
        }
        _ => {}
    }
    if described.normal_texture.is_some() {
        notes.push("normalTexture".to_owned());
    }
    if let Some(extensions) = &described.extensions {
        notes.extend(extensions.others.keys().cloned());
    }
    notes
}
