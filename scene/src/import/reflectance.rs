//! Reflectances that no surface has, and what is taken for them.

use super::ImportOptions;
use super::terms::Terms;
use crate::{Material, Rgb, SceneError};

/// Reflectance of what has none, dimensionless.
pub(crate) const GREY: f32 = 0.5;

/// What is taken for a reflectance of 1 or more, which no surface has, unless the options say otherwise, dimensionless.
const WHITE: f32 = 0.95;

/// Says what is taken for the reflectance of a material of the file, where it is another one; but not where the caller gives it
/// one of its own.
pub(super) fn told(material: &Material, options: &ImportOptions, terms: &Terms) -> Option<String> {
    let before = material.reflectance;
    let taken = limited(before, options);
    let Material { name, .. } = material;
    if taken == before || options.repainted.contains(name) {
        return None;
    }
    let Rgb { x, y, z } = before;
    let Rgb { x: r, y: g, z: b } = taken;
    Some(format!(
        "material \"{name}\": {} {x} {y} {z} is taken as {r} {g} {b}, since surfaces reflect less than they receive; \
         --reflectance \"{name}\"=R,G,B says otherwise",
        terms.colour
    ))
}

/// Checks a material of the file, whose reflectance may be 1 or more.
pub(crate) fn check(material: &Material, options: &ImportOptions) -> Result<(), SceneError> {
    let reflectance = limited(material.reflectance, options);
    let taken = Material {
        reflectance,
        ..material.clone()
    };
    taken.validate()
}

/// A reflectance below 1; what is not finite stays.
pub(super) fn limited(reflectance: Rgb, options: &ImportOptions) -> Rgb {
    let most = options.max_reflectance.unwrap_or(WHITE);
    let limited = |value: f32| {
        let is_too_much = match options.max_reflectance {
            Some(most) => value > most,
            None => value >= 1.0,
        };
        if is_too_much && value.is_finite() {
            most
        } else {
            value
        }
    };
    Rgb::from(reflectance.to_array().map(limited))
}
