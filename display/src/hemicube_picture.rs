//! A picture of what a patch sees and what that brings it: four unfolded hemicubes.
//!
//! | | |
//! |---|---|
//! | patch IDs, in colours of their own | radiosities, toned as in a picture |
//! | delta form factors, the largest one white | products of both, toned likewise |
//!
//! The products are B_k dF_k / max dF, W/m^2, so that they have the radiosities' brightness where pixels count most. Their
//! caption has the irradiance H = sum_k B_k dF_k, as a luminance. As the thesis's figures show it, the method is these
//! four pictures.

use compute::settings::{FormFactorSettings, Maps, Seed};
use glam::DVec3;
use image::RgbImage;
use scene::{PatchId, Rgb, Scene, Solution};

use crate::distinct::distinct_color;
use crate::hemicube::{HemicubeError, Seen, UnfoldedHemicube};
use crate::luminance::luminance;
use crate::multipliers::Multipliers;
use crate::number::{ends, with_digits};
use crate::panels::{Panel, Sheet, around};
use crate::range;
use crate::settings::{Mode, Range, RenderSettings};
use crate::tone::Tone;

/// Digits of numbers in captions.
const DIGITS: usize = 4;

/// Display light of backs of surfaces among the IDs: darker than any patch, and not black as nothing is.
const BACK: Rgb = Rgb::splat(0.03);

/// What a hemicube's picture shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HemicubeSettings {
    /// Pixels along a face, even, 2 to [`MAX_RESOLUTION`](visibility::hemicube::MAX_RESOLUTION).
    pub resolution: u32,
    /// How the hemicube is turned about its normal.
    pub seed: Seed,
    /// The pixels' multipliers.
    pub maps: Maps,
    /// How radiosities become colours; not [`Mode::Ids`].
    pub mode: Mode,
    /// The scale's ends, W/m^2; chosen by the patches where there are none.
    pub range: Option<Range>,
    /// One radiosity a patch even where there is an irradiance function.
    pub flat: bool,
}

/// As a run of `compute` and a picture have it by default.
impl Default for HemicubeSettings {
    fn default() -> Self {
        let FormFactorSettings {
            resolution,
            seed,
            maps,
            ..
        } = FormFactorSettings::default();
        Self {
            resolution,
            seed,
            maps,
            mode: Mode::default(),
            range: None,
            flat: false,
        }
    }
}

/// A hemicube's picture.
#[derive(Clone, Debug)]
pub struct HemicubePicture {
    /// The four panels with their captions, sRGB.
    pub image: RgbImage,
    /// What the pixels bring: the irradiance of the patch's centroid by this hemicube alone, W/m^2.
    pub irradiance: Rgb,
    /// How radiosities were mapped.
    pub tone: Tone,
}

/// Draws what a patch sees of a scene. Without a solution the radiosities are the emissions.
pub fn render(
    scene: &Scene,
    solution: Option<&Solution>,
    patch: PatchId,
    settings: &HemicubeSettings,
) -> Result<HemicubePicture, HemicubeError> {
    let &HemicubeSettings {
        resolution,
        seed,
        maps,
        mode,
        range,
        flat,
    } = settings;
    let shown = RenderSettings {
        mode,
        flat,
        range,
        ..RenderSettings::default()
    };
    if mode == Mode::Ids {
        return Err(HemicubeError::ModeIds);
    }
    shown.validate()?;
    let hemicube = UnfoldedHemicube::new(scene, patch, resolution, seed)?;
    let of_patches = match solution {
        Some(solution) => solution.mean_radiosity(scene),
        None => scene.patch_emissions(),
    };
    let range =
        range.unwrap_or_else(|| range::suiting(&range::of_patches(scene, &of_patches), mode));
    let tone = Tone::new(mode, range);
    let function = solution.and_then(|solution| solution.function.as_ref());
    let radiosities = hemicube.radiosities(&of_patches, function.filter(|_| !flat));
    let multipliers = Multipliers::new(maps, hemicube.unfolding());
    let irradiance = multipliers.irradiance(&radiosities);
    let lines = [
        stand(scene, &hemicube),
        circumstances(scene, solution, patch, settings),
    ];
    let image = {
        let panels = panels(&hemicube, patch, &radiosities, &multipliers, &tone);
        Sheet::new(&panels, hemicube.unfolding().side(), 2, &lines).image()
    };
    Ok(HemicubePicture {
        image,
        irradiance,
        tone,
    })
}

fn panels<'p>(
    hemicube: &'p UnfoldedHemicube,
    patch: PatchId,
    radiosities: &'p [Rgb],
    multipliers: &'p Multipliers,
    tone: &'p Tone,
) -> [Panel<'p>; 4] {
    let ids = hemicube.ids();
    // What is no pixel of the hemicube looks like what is around it.
    let is_inside = |k: usize| ids[k] != Seen::Outside;
    let toned = move |k: usize, part: f32| {
        if is_inside(k) {
            tone.display_light(part * radiosities[k])
        } else {
            around()
        }
    };
    let relative = move |k: usize| {
        if is_inside(k) {
            Rgb::splat(multipliers.relative(k))
        } else {
            around()
        }
    };
    let [low, high] = ends(tone.scale().range());
    let irradiance = f64::from(luminance(multipliers.irradiance(radiosities)));
    let irradiance = with_digits(irradiance, DIGITS);
    [
        Panel {
            caption: format!("patch {} sees: patch IDs", patch.0),
            light: Box::new(move |k| id_light(ids[k])),
        },
        Panel {
            caption: format!("radiosity, {low} to {high} W/m²"),
            light: Box::new(move |k| toned(k, 1.0)),
        },
        Panel {
            caption: "delta form factors".into(),
            light: Box::new(relative),
        },
        Panel {
            caption: format!("product: irradiance {irradiance} W/m²"),
            light: Box::new(move |k| toned(k, multipliers.relative(k))),
        },
    ]
}

/// Display light of what a pixel sees.
fn id_light(seen: Seen) -> Rgb {
    match seen {
        Seen::Patch(patch) => distinct_color(patch),
        Seen::Back => BACK,
        Seen::Nothing => Rgb::ZERO,
        Seen::Outside => around(),
    }
}

/// Where the hemicube stands, in the model's own coordinates.
fn stand(scene: &Scene, hemicube: &UnfoldedHemicube) -> String {
    let frame = hemicube.frame();
    let place = scene.to_model(frame.position);
    format!(
        "from {} along {}, up is {}",
        vector(place, DIGITS),
        vector(frame.normal, 2),
        vector(hemicube.up_in_scene(), 2)
    )
}

/// How it was drawn, and what the solution says.
fn circumstances(
    scene: &Scene,
    solution: Option<&Solution>,
    patch: PatchId,
    settings: &HemicubeSettings,
) -> String {
    let HemicubeSettings {
        resolution,
        seed,
        maps,
        ..
    } = settings;
    let maps = match maps {
        Maps::Exact => "exact",
        Maps::Thesis => "thesis",
    };
    let mean = solution.and_then(|solution| {
        let irradiance = solution.mean_irradiance(scene);
        irradiance.get(patch.index()).copied()
    });
    let mean = match mean {
        Some(mean) => format!(
            "mean in the solution {} W/m²",
            with_digits(f64::from(luminance(mean)), DIGITS)
        ),
        None => "no solution".to_owned(),
    };
    format!("{resolution} pixels, seed {seed}, maps {maps}; {mean}")
}

/// Three numbers; what f64 has left of a zero is one.
fn vector(vector: DVec3, digits: usize) -> String {
    let largest = vector.abs().max_element();
    let numbers = vector.to_array().map(|value| {
        let is_zero = value.abs() <= 1e-6 * largest;
        with_digits(if is_zero { 0.0 } else { value }, digits)
    });
    format!("({})", numbers.join(", "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vectors_are_short() {
        let text = vector(DVec3::new(0.278_04, -1e-12, 1234.56), 3);
        assert_eq!(text, "(0.278, 0, 1230)");
        assert_eq!(vector(DVec3::ZERO, 3), "(0, 0, 0)");
    }

    #[test]
    fn backs_nothing_and_patches_are_told_apart() {
        let darkest = (0..1000)
            .map(|k| luminance(distinct_color(PatchId(k))))
            .fold(f32::MAX, f32::min);
        let back = luminance(id_light(Seen::Back));
        assert!(luminance(id_light(Seen::Nothing)) < 0.5 * back && back < 0.5 * darkest);
    }
}
