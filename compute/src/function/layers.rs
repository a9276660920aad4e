//! Layers of a function: parts of the sources' light, gathered by the same rows.
//!
//! What a vertex receives besides its row, since sources are not one value each, is every layer's in proportion to what it reflects there.

use glam::DVec3;
use scene::Rgb;
use scene::layers::{Lamp, Layer};

use super::gatherer::Light;

/// A part of the light of sources, W/m^2, all one per source.
#[derive(Clone, Debug)]
pub struct SourceLayer {
    /// What people call it.
    pub name: String,
    /// What emits in it, if it is of a lamp.
    pub lamp: Option<Lamp>,
    /// What arrives without reflection comes from these emissions.
    pub emission: Vec<Rgb>,
    /// The rest comes from these radiosities.
    pub reflected: Vec<Rgb>,
    /// What arrives at sources.
    pub irradiance: Vec<Rgb>,
}

/// What a place receives of a layer, W/m^2.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerLight {
    pub direct: DVec3,
    pub by_sources: DVec3,
}

impl LayerLight {
    /// All of it, and what is direct, where all layers together make this light.
    fn of(self, light: &Light) -> [Rgb; 2] {
        let all = light.by_sources;
        let share = DVec3::select(all.cmpgt(DVec3::ZERO), self.by_sources / all, DVec3::ZERO);
        // As the whole light is bounded by what is direct.
        let reflected = (all + light.correction).max(DVec3::ZERO);
        [self.direct + share * reflected, self.direct].map(DVec3::as_vec3)
    }
}

/// A layer of patches and vertices. `lights` are those of all layers together at patches that have gathered themselves, `gathered`, and
/// at vertices after these, and `of_places` the layer's.
pub(super) fn layer(
    of_sources: &SourceLayer,
    mut patches: Vec<Rgb>,
    gathered: &[scene::PatchId],
    lights: &[Light],
    of_places: &[LayerLight],
) -> Layer {
    let mut values = of_places
        .iter()
        .zip(lights)
        .map(|(part, light)| part.of(light));
    for patch in gathered {
        if let Some([all, _]) = values.next() {
            patches[patch.index()] = all;
        }
    }
    Layer {
        name: of_sources.name.clone(),
        lamp: of_sources.lamp,
        irradiance: patches,
        vertices: values.collect(),
    }
}
