//! Layers: parts of a solution's light that sum to all of it.
//!
//! Radiosity is linear in the emission: what arrives is the sum of what each lamp alone would bring, and the sum over bounces, of
//! what arrives without reflection, after one, after two. A lamp's light times a factor is what it brings when it is dimmed.

use glam::Vec3;
use serde::{Deserialize, Serialize};

use crate::function::IrradianceFunction;
use crate::{MaterialId, ObjectId, Rgb, Scene, SceneError, Solution, Surface, SurfaceId};

/// What the layers of a solution are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum LayerKind {
    /// The light of one lamp each.
    Lamps,
    /// The light of some bounces each.
    Bounces,
}

impl std::fmt::Display for LayerKind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Lamps => "lamps",
            Self::Bounces => "bounces",
        })
    }
}

/// What emits in a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Lamp {
    /// An object's surfaces.
    Object(u32),
    /// A material's surfaces.
    Material(u32),
}

impl Lamp {
    /// The lamps of a scene, each a name and what emits: objects where several emit, else materials.
    pub fn of(scene: &Scene) -> Vec<(String, Self)> {
        let emits = |surface: &&Surface| scene.material(surface.material).is_emitter();
        let emitting = || scene.surfaces().iter().filter(emits);
        let objects: Vec<ObjectId> = sorted(emitting().map(|surface| surface.object));
        if objects.len() > 1 {
            let lamp = |object: ObjectId| (scene.object(object).to_owned(), Self::Object(object.0));
            return objects.into_iter().map(lamp).collect();
        }
        let materials: Vec<MaterialId> = sorted(emitting().map(|surface| surface.material));
        let lamp = |id: MaterialId| (scene.material(id).name.clone(), Self::Material(id.0));
        materials.into_iter().map(lamp).collect()
    }

    /// Whether a surface is part of it.
    pub fn has(self, surface: &Surface) -> bool {
        match self {
            Self::Object(object) => surface.object.0 == object,
            Self::Material(material) => surface.material.0 == material,
        }
    }
}

fn sorted<T: Ord>(values: impl Iterator<Item = T>) -> Vec<T> {
    let mut values: Vec<T> = values.collect();
    values.sort_unstable();
    values.dedup();
    values
}

/// One part of the light.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The lamp's name, or which bounces they are.
    pub name: String,
    /// What emits in it; `None` for bounces.
    pub lamp: Option<Lamp>,
    /// Irradiance, W/m^2, one per patch, as [`Solution::irradiance`] has it.
    pub irradiance: Vec<Rgb>,
    /// Irradiance at the function's vertices, and the part of it that comes from emitters without reflection, W/m^2, one per vertex;
    /// empty where there is no function.
    pub vertices: Vec<[Rgb; 2]>,
}

/// The layers of a solution.
#[derive(Clone, Debug, PartialEq)]
pub struct Layers {
    /// What they are.
    pub kind: LayerKind,
    /// One or more.
    pub layers: Vec<Layer>,
}

impl Layers {
    /// Checks the lengths, that every value is finite and at least 0, and that layers of lamps have lamps, and no others.
    pub fn validate(
        &self,
        scene: &Scene,
        function: Option<&IrradianceFunction>,
    ) -> Result<(), SceneError> {
        let vertices = function.map_or(0, |function| function.mesh().vertex_count());
        for layer in &self.layers {
            let name = || layer.name.clone();
            if layer.lamp.is_some() != (self.kind == LayerKind::Lamps) {
                return Err(SceneError::LayerLamp { layer: name() });
            }
            let (patches, found) = (scene.patch_count() as usize, layer.irradiance.len());
            if found != patches || layer.vertices.len() != vertices as usize {
                return Err(SceneError::LayerLength { layer: name() });
            }
            let all = layer
                .irradiance
                .iter()
                .chain(layer.vertices.iter().flatten());
            let mut values = all.flat_map(Vec3::to_array);
            if let Some(value) = values.find(|value| !(value.is_finite() && *value >= 0.0)) {
                return Err(SceneError::LayerValue {
                    layer: name(),
                    value,
                });
            }
        }
        Ok(())
    }
}

impl Solution {
    /// What there is to be seen where each layer has these factors, one per layer and channel, at least 0: the scene, whose lamps emit
    /// as much, and its solution. `None` where there are no layers.
    ///
    /// # Errors
    /// Factors that are too many, too few, negative or not finite, and light that no f32 holds.
    pub fn mixed(
        &self,
        scene: &Scene,
        factors: &[Rgb],
    ) -> Option<Result<(Scene, Self), SceneError>> {
        let layers = self.layers.as_ref()?;
        Some(self.mix(scene, layers, factors))
    }

    fn mix(
        &self,
        scene: &Scene,
        layers: &Layers,
        factors: &[Rgb],
    ) -> Result<(Scene, Self), SceneError> {
        let count = layers.layers.len();
        let are_good = factors
            .iter()
            .all(|factor| factor.is_finite() && factor.min_element() >= 0.0);
        if factors.len() != count || !are_good {
            return Err(SceneError::LayerFactors { count });
        }
        let sum = |of: &dyn Fn(&Layer) -> Rgb| -> Rgb {
            let terms = layers.layers.iter().zip(factors);
            terms.map(|(layer, &factor)| factor * of(layer)).sum()
        };
        let irradiance = (0..self.irradiance.len())
            .map(|patch| sum(&|layer| layer.irradiance[patch]))
            .collect();
        let function = match &self.function {
            None => None,
            Some(function) => {
                let vertices = 0..function.mesh().vertex_count() as usize;
                let [all, direct] = [0, 1].map(|part| {
                    let value = |vertex: usize| sum(&|layer| layer.vertices[vertex][part]);
                    vertices.clone().map(value).collect()
                });
                Some(IrradianceFunction::new(
                    function.mesh().clone(),
                    all,
                    direct,
                )?)
            }
        };
        let solution = Self {
            irradiance,
            function,
            layers: None,
            ..self.clone()
        };
        solution.validate(scene)?;
        Ok((with_emissions(scene, layers, factors)?, solution))
    }
}

/// The same scene, whose lamps emit so many times as much. A material that several lamps share becomes several.
fn with_emissions(scene: &Scene, layers: &Layers, factors: &[Rgb]) -> Result<Scene, SceneError> {
    let mut materials = scene.materials().to_vec();
    let mut of_surface: Vec<MaterialId> = scene.surfaces().iter().map(|s| s.material).collect();
    for (layer, &factor) in layers.layers.iter().zip(factors) {
        let Some(lamp) = layer.lamp else {
            continue;
        };
        let mut replaced: Vec<(MaterialId, MaterialId)> = Vec::new();
        for (surface, own) in scene.surfaces().iter().zip(&mut of_surface) {
            let material = scene.material(surface.material);
            if !lamp.has(surface) || !material.is_emitter() {
                continue;
            }
            let known = replaced
                .iter()
                .find(|(before, _)| *before == surface.material);
            *own = if let Some(&(_, now)) = known {
                now
            } else {
                let now = MaterialId(materials.len() as u32);
                let mut dimmed = material.clone();
                dimmed.emission *= factor;
                materials.push(dimmed);
                replaced.push((surface.material, now));
                now
            };
        }
    }
    scene.with_materials(materials, |surface: SurfaceId| of_surface[surface.index()])
}
