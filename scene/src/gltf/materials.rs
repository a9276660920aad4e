//! Materials: what surfaces reflect and emit of what the file says.

use std::collections::HashMap;
use std::f32::consts::PI;

use glam::{DMat2, DVec2};
use gltf::json::Index;
use gltf::json::extensions::material::PbrSpecularGlossiness;
use gltf::json::material::{AlphaMode, Material as Described};
use gltf::json::texture::Info;
use gltf::json::validation::Checked;

use super::GltfFault;
use super::document::Document;
use super::pictures::texture;
use crate::import::{GREY, ImportOptions, Taken, Terms, left_out, limit, limited};
use crate::{Material, Rgb};

/// What messages call things.
pub(super) const TERMS: Terms = Terms {
    colour: "its base colour",
    coordinates: "TEXCOORD",
    without_picture: "the base colour's factor alone counts, and nothing is emitted where it was to shine",
};

/// Metalness up to this is that of any dull surface, dimensionless.
const METAL: f32 = 0.05;

/// Where texture coordinates are in a picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mapping {
    /// The number of the coordinates' set.
    pub set: u32,
    /// What they are multiplied by.
    pub scaled: DMat2,
    /// What is then added.
    pub offset: DVec2,
}

impl Mapping {
    pub(super) fn apply(&self, coordinates: DVec2) -> DVec2 {
        self.scaled * coordinates + self.offset
    }
}

/// The materials that faces use, by first use.
pub(super) struct Materials<'a> {
    document: &'a Document,
    options: ImportOptions,
    /// By the file's number; `None` for faces without a material.
    numbers: HashMap<Option<usize>, usize>,
    taken: Vec<Taken>,
    used: Vec<Used>,
}

/// What the triangles of a material need.
#[derive(Clone, Copy, Debug)]
pub(super) struct Used {
    /// Where texture coordinates are for the reflectance and the emission.
    pub mappings: [Option<Mapping>; 2],
    pub is_double_sided: bool,
}

impl<'a> Materials<'a> {
    pub(super) fn new(document: &'a Document, options: &ImportOptions) -> Self {
        Self {
            document,
            options: *options,
            numbers: HashMap::new(),
            taken: Vec::new(),
            used: Vec::new(),
        }
    }

    /// The number of the material of some faces.
    pub(super) fn number(
        &mut self,
        material: Option<Index<Described>>,
        warnings: &mut Vec<String>,
    ) -> Result<usize, GltfFault> {
        let key = material.map(|index| index.value());
        if let Some(&number) = self.numbers.get(&key) {
            return Ok(number);
        }
        let (taken, used) = match material {
            None => (self.without(warnings), Used::PLAIN),
            Some(index) => {
                let described = self.document.get(index)?;
                let name = described.name.clone();
                let name = name.filter(|name| !name.trim().is_empty());
                let name = name.unwrap_or_else(|| format!("material {index}"));
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

    /// What stands in for a material where faces have none.
    fn without(&self, warnings: &mut Vec<String>) -> Taken {
        let reflectance = self.options.reflectance.unwrap_or(GREY);
        warnings.push(format!(
            "some primitives have no material; they are grey with reflectance {reflectance}"
        ));
        plain(Material {
            name: "default".to_owned(),
            reflectance: Rgb::splat(reflectance),
            emission: Rgb::ZERO,
        })
    }

    fn taken(
        &self,
        described: &Described,
        name: &str,
        warnings: &mut Vec<String>,
    ) -> Result<(Taken, Used), GltfFault> {
        let Colour {
            factor,
            alpha,
            texture: base,
        } = Colour::of(described);
        let mut material = Material {
            name: name.to_owned(),
            reflectance: factor,
            emission: emission(described),
        };
        let mut notes = notes(described, alpha, base.is_some());
        let mut textured = |info: Option<&Info>, factor, what: &str| {
            let Some(info) = info else {
                return Ok((None, None));
            };
            let Some((textured, mapping)) = texture(self.document, info, factor)? else {
                notes.push(format!("{what} (no picture in PNG or JPEG)"));
                return Ok((None, None));
            };
            Ok((Some(textured), Some(mapping)))
        };
        let emissive = described.emissive_texture.as_ref();
        let emissive = emissive.filter(|_| material.is_emitter());
        let (of_emission, emission_mapping) =
            textured(emissive, material.emission, "emissiveTexture")?;
        let mut of_reflectance = (None, None);
        match self.options.reflectance.filter(|_| !material.is_emitter()) {
            Some(grey) => material.reflectance = Rgb::splat(grey),
            None => of_reflectance = textured(base, factor, "the base colour's texture")?,
        }
        let (reflectance, reflectance_mapping) = of_reflectance;
        if reflectance.is_some() {
            material.reflectance = limited(material.reflectance, &self.options);
        } else {
            warnings.extend(limit(&mut material, &self.options, &TERMS));
        }
        warnings.extend(left_out(name, &notes));
        material.validate().map_err(GltfFault::Material)?;
        if described.emissive_texture.is_some() {
            // Where its texture cannot be had, nobody knows which part of it shines.
            material.emission = Rgb::ZERO;
        }
        let taken = Taken {
            material,
            reflectance,
            emission: of_emission,
            absence: absence(described, alpha, base.is_some()),
        };
        let used = Used {
            mappings: [reflectance_mapping, emission_mapping],
            is_double_sided: described.double_sided,
        };
        Ok((taken, used))
    }
}

impl Used {
    const PLAIN: Self = Self {
        mappings: [None; 2],
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
