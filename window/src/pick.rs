//! What is known of the patch that is picked.

use display::number::with_digits;
use scene::{PatchId, Rgb, Solution};

use crate::loaded::Loaded;

/// Significant digits of a value.
const DIGITS: usize = 4;

/// What is known of a patch.
#[derive(Clone, Debug, PartialEq)]
pub struct Facts {
    /// Its number.
    pub patch: PatchId,
    /// The number of its surface.
    pub surface: u32,
    /// The name of its object.
    pub object: String,
    /// The name of its material.
    pub material: String,
    /// m^2.
    pub area: f64,
    /// E, W/m^2.
    pub emission: Rgb,
    /// rho, dimensionless.
    pub reflectance: Rgb,
    /// H, W/m^2; `None` where nothing is solved.
    pub irradiance: Option<Rgb>,
    /// B = E + rho H, W/m^2; E where nothing is solved.
    pub radiosity: Rgb,
    /// An estimate of the error of the reflected radiosity, W/m^2; `None` where there is none.
    pub error: Option<f32>,
}

impl Facts {
    /// Those of a patch; `None` where there is no such patch.
    pub fn of(loaded: &Loaded, patch: PatchId) -> Option<Self> {
        let Loaded {
            scene, solution, ..
        } = loaded;
        if patch.0 >= scene.patch_count() {
            return None;
        }
        let solution = solution.as_ref();
        let geometry = scene.patch(patch);
        let surface = scene.surface(geometry.surface);
        let material = scene.material(surface.material);
        let irradiance = solution.map(|solution| {
            let function = solution.function.as_ref();
            function
                .and_then(|f| f.mean_over(scene, f.irradiance(), patch))
                .unwrap_or(solution.irradiance[patch.index()])
        });
        let reflected = material.reflectance * irradiance.unwrap_or(Rgb::ZERO);
        Some(Self {
            patch,
            surface: geometry.surface.0,
            object: scene.object(surface.object).to_owned(),
            material: material.name.clone(),
            area: geometry.area,
            emission: material.emission,
            reflectance: material.reflectance,
            irradiance,
            radiosity: material.emission + reflected,
            error: solution
                .and_then(Solution::error)
                .and_then(|error| error.get(patch.index()).copied()),
        })
    }

    /// What a panel says: names and values, line by line.
    pub fn lines(&self) -> Vec<(&'static str, String)> {
        let number = |value: f64| with_digits(value, DIGITS);
        let rgb = |value: Rgb| value.to_array().map(|v| number(f64::from(v))).join("  ");
        let light = |value: Rgb| format!("{} W/m²", rgb(value));
        let mut lines = vec![
            ("patch", self.patch.0.to_string()),
            ("surface", self.surface.to_string()),
            ("object", self.object.clone()),
            ("material", self.material.clone()),
            ("area", format!("{} m²", number(self.area))),
            ("E", light(self.emission)),
            ("rho", rgb(self.reflectance)),
        ];
        lines.extend(self.irradiance.map(|h| ("H", light(h))));
        lines.push(("B", light(self.radiosity)));
        let error = self.error.map(|error| number(f64::from(error)));
        lines.extend(error.map(|error| ("error", format!("{error} W/m²"))));
        lines
    }
}

#[cfg(test)]
mod tests {
    use scene::Solution;
    use test_scenes::colourful_room;

    use super::*;

    fn solved() -> Loaded {
        let scene = colourful_room(0.3);
        let mut solution = Solution::dark(&scene);
        for (k, irradiance) in solution.irradiance.iter_mut().enumerate() {
            *irradiance = Rgb::new(1.0, 2.0, 3.0) + k as f32;
        }
        Loaded::new(scene, Some(solution))
    }

    #[test]
    fn radiosity_is_emission_and_what_is_reflected_of_the_irradiance() {
        let loaded = solved();
        let radiosity = loaded.solution.as_ref().unwrap().radiosity(&loaded.scene);
        for (k, &expected) in radiosity.iter().enumerate() {
            let facts = Facts::of(&loaded, PatchId(k as u32)).unwrap();
            assert_eq!(facts.radiosity, expected);
        }
    }

    #[test]
    fn areas_of_all_patches_are_that_of_the_scene() {
        let loaded = solved();
        let patches = (0..loaded.scene.patch_count()).map(PatchId);
        let sum: f64 = patches
            .map(|patch| Facts::of(&loaded, patch).unwrap().area)
            .sum();
        // f64 rounding of some hundred additions.
        assert!((sum / loaded.scene.area() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn there_is_nothing_to_say_of_a_patch_that_is_none() {
        let loaded = solved();
        let beyond = PatchId(loaded.scene.patch_count());
        assert_eq!(Facts::of(&loaded, beyond), None);
        assert_eq!(Facts::of(&loaded, scene::NO_PATCH), None);
    }
}
