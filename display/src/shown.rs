//! The values that are shown of a solution, of its patches and between them.

use scene::{PatchId, Rgb, Scene, Solution};

use crate::quantity::{Quantity, Shown};
use crate::settings::SettingsError;
use crate::shade::ShownFunction;

impl Shown {
    /// The values that are shown, one per patch.
    ///
    /// # Errors
    /// Where the solution does not have them.
    pub fn of_patches(
        self,
        scene: &Scene,
        solution: Option<&Solution>,
    ) -> Result<Vec<Rgb>, SettingsError> {
        let mut values = match self.quantity {
            Quantity::Emission => scene.patch_emissions(),
            Quantity::Reflectance => scene.patch_reflectances(),
            Quantity::Radiosity | Quantity::Radiance => match solution {
                Some(solution) => solution.mean_radiosity(scene),
                None => scene.patch_emissions(),
            },
            Quantity::Irradiance => match solution {
                Some(solution) => solution.mean_irradiance(scene),
                None => vec![Rgb::ZERO; scene.patch_count() as usize],
            },
            Quantity::Direct | Quantity::Indirect => self.parts(scene, solution)?,
            Quantity::Error => {
                let error = solution.and_then(Solution::error);
                let error = error.ok_or(SettingsError::NoError)?;
                error.iter().map(|&error| Rgb::splat(error)).collect()
            }
        };
        let factor = self.factor();
        for value in &mut values {
            *value = self.of_channels(factor * *value);
        }
        Ok(values)
    }

    /// Direct or indirect irradiance, W/m^2, one per patch: that of the function, and where there are no vertices all of it is
    /// indirect.
    fn parts(self, scene: &Scene, solution: Option<&Solution>) -> Result<Vec<Rgb>, SettingsError> {
        let missing = SettingsError::NoParts {
            quantity: self.quantity,
        };
        let solution = solution.ok_or(missing.clone())?;
        let function = solution.function.as_ref().ok_or(missing)?;
        let direct = (0..scene.patch_count()).map(|patch| {
            let mean = function.mean_over(scene, function.direct(), PatchId(patch));
            mean.unwrap_or(Rgb::ZERO)
        });
        if self.quantity == Quantity::Direct {
            return Ok(direct.collect());
        }
        let all = solution.mean_irradiance(scene);
        Ok(direct
            .zip(all)
            .map(|(direct, all)| (all - direct).max(Rgb::ZERO))
            .collect())
    }

    /// The values that are shown between patches, where the solution has light there and they are not one value a patch; `means`
    /// are [`Self::of_patches`].
    pub fn function<'a>(
        self,
        scene: &'a Scene,
        solution: Option<&'a Solution>,
        means: &'a [Rgb],
    ) -> Option<ShownFunction<'a>> {
        let function = solution?.function.as_ref()?;
        let is_sent_out = match self.quantity {
            Quantity::Radiosity | Quantity::Radiance => true,
            Quantity::Irradiance | Quantity::Direct | Quantity::Indirect => false,
            Quantity::Emission | Quantity::Reflectance | Quantity::Error => return None,
        };
        let values = match self.quantity {
            Quantity::Direct => function.direct().to_vec(),
            Quantity::Indirect => {
                let both = function.irradiance().iter().zip(function.direct());
                both.map(|(&all, &direct)| (all - direct).max(Rgb::ZERO))
                    .collect()
            }
            _ => function.irradiance().to_vec(),
        };
        let factor = self.factor();
        let materials = scene.materials().iter().map(|material| {
            if is_sent_out {
                [factor * material.emission, factor * material.reflectance]
            } else {
                [Rgb::ZERO, Rgb::splat(factor)]
            }
        });
        Some(ShownFunction {
            scene,
            function,
            values,
            of_material: materials.collect(),
            shown: self,
            means,
        })
    }
}
