//! Reflectances that no surface has, and what is taken for them.

use super::ImportOptions;
use super::looks::Terms;
use crate::{Material, Rgb};

/// Reflectance of what has none, dimensionless.
pub(crate) const GREY: f32 = 0.5;

/// What is taken for a reflectance of 1 or more, which no surface has, unless the options say otherwise, dimensionless.
const WHITE: f32 = 0.95;

/// Brings reflectances below 1, and says so.
pub(crate) fn limit(
    material: &mut Material,
    options: &ImportOptions,
    terms: &Terms,
) -> Option<String> {
    let before = material.reflectance;
    material.reflectance = limited(before, options);
    (material.reflectance != before).then(|| {
        let Rgb { x, y, z } = before;
        let name = &material.name;
        let Rgb { x: r, y: g, z: b } = material.reflectance;
        format!(
            "material \"{name}\": {} {x} {y} {z} is taken as {r} {g} {b}, since surfaces reflect less than they receive; \
             --reflectance \"{name}\"=R,G,B says otherwise",
            terms.colour
        )
    })
}

/// A reflectance below 1; what is not finite stays.
pub(crate) fn limited(reflectance: Rgb, options: &ImportOptions) -> Rgb {
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
