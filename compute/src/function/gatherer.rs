//! Who gathers: what places receive from solved sources.

use std::sync::Arc;

use glam::DVec3;
use scene::function::IrradianceFunction;
use scene::{Rgb, Solution};
use visibility::Drawable;

use super::second_look::{Reflected, SecondLook};
use super::vertices::{Place, Places};
use crate::FormFactors;
use crate::backend::Backend;
use crate::cancel::CancelToken;
use crate::problem::Problem;
use crate::receivers::Receivers;
use crate::rows::{BackendError, Entry, UNITS_PER_ONE};
use crate::settings::FormFactorSettings;
use crate::sources::Sources;

/// Places that look a second time between two questions whether to stop.
const BATCH: usize = 1 << 12;

/// Pixels along a hemicube's face below which differences are noise themselves.
const FEWEST_PIXELS: u32 = 16;

/// What a place receives, W/m^2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    /// Irradiance.
    pub irradiance: DVec3,
    /// The part of it that comes from emitters without reflection.
    pub direct: DVec3,
    /// The rest, if sources are one value each.
    pub by_sources: DVec3,
    /// The share of what it sees, by form factors, that is fronts of surfaces and no opening.
    pub surfaces: f64,
}

impl Light {
    /// Adds to what is received of reflected light, W/m^2. It may be less than nothing, but what is received is not.
    pub fn add_reflected(&mut self, more: DVec3) {
        self.irradiance = (self.irradiance + more).max(self.direct);
    }
}

/// What a place sees when it looks a second time, W/m^2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// Reflected light from sources of one value each.
    pub by_sources: DVec3,
    /// How much more it is by the function than by what has been gathered from.
    pub by_function: DVec3,
}

/// What places on surfaces receive from solved sources.
pub(super) struct Gatherer<'a, 'c> {
    places: Places<'a>,
    /// How many of the places have gathered.
    done: u32,
    backend: Backend<'a>,
    /// Of the sources.
    drawable: Arc<Drawable<'a>>,
    settings: FormFactorSettings,
    /// One per source, W/m^2.
    radiosity: Vec<Rgb>,
    emission: Vec<Rgb>,
    /// What the sources are like within, once they are refined.
    within: Option<IrradianceFunction>,
    /// The share of reflected light that is added for what that comes to on the whole.
    ambient: DVec3,
    cancel: &'c CancelToken,
}

impl<'a, 'c> Gatherer<'a, 'c> {
    /// What a solution of the patches that `sources` are made of sends out.
    pub fn new(
        form_factors: &FormFactors<'a>,
        sources: Sources<'a>,
        solution: &Solution,
        cancel: &'c CancelToken,
    ) -> Result<Self, BackendError> {
        let settings = form_factors.settings();
        let places = Places::new(sources.patches(), sources.drawable(), settings.seed);
        let problem = Problem::new(sources.scene());
        let irradiance = sources.restricted(&solution.irradiance);
        let radiosity = irradiance.iter().enumerate();
        Ok(Self {
            radiosity: radiosity.map(|(s, &h)| problem.radiosity(s, h)).collect(),
            emission: problem.emission,
            drawable: Arc::clone(sources.drawable()),
            settings,
            backend: form_factors.at(Box::new(places.clone()), sources)?,
            places,
            done: 0,
            within: None,
            ambient: DVec3::ZERO,
            cancel,
        })
    }

    /// Whether sources are more than one value each.
    pub fn is_refined(&self) -> bool {
        self.within.is_some()
    }

    /// What some more places receive; `None` where it is cancelled.
    pub fn gather(&mut self, places: &[Place]) -> Result<Option<Vec<Light>>, BackendError> {
        self.places.extend(places.iter().copied());
        let end = self.places.count();
        let mut lights = Vec::with_capacity(places.len());
        while self.done < end {
            if self.cancel.is_cancelled() {
                return Ok(None);
            }
            let batch = self.backend.source.preferred_batch().max(1);
            let next = end.min(self.done.saturating_add(batch));
            let rows = self.backend.source.draw_rows(self.done..next)?;
            self.done = next;
            lights.extend((0..rows.receivers().len()).map(|k| {
                let irradiance = sum(rows.row(k), &self.radiosity);
                let direct = sum(rows.row(k), &self.emission);
                Light {
                    irradiance,
                    direct,
                    by_sources: irradiance - direct,
                    surfaces: rows
                        .row(k)
                        .iter()
                        .map(|entry| f64::from(entry.units))
                        .sum::<f64>()
                        / f64::from(UNITS_PER_ONE),
                }
            }));
        }
        if let Some(within) = &self.within {
            let Some(looks) = self.look(within, places, self.coarser()) else {
                return Ok(None);
            };
            for (light, [by_sources, by_function]) in lights.iter_mut().zip(looks) {
                let ambient = self.ambient * light.by_sources;
                light.add_reflected(by_function - by_sources + ambient);
            }
        }
        Ok(Some(lights))
    }

    /// What places see when they look a second time; `None` where it is cancelled.
    pub fn look_again(&self, function: &IrradianceFunction, places: &[Place]) -> Option<Vec<Look>> {
        let resolution = self.settings.resolution;
        let now = self.look(function, places, resolution)?;
        let before = match &self.within {
            Some(within) => self.look(within, places, resolution)?,
            None => now.iter().map(|&[by_sources, _]| [by_sources; 2]).collect(),
        };
        let looks = now.into_iter().zip(before);
        let look = |([by_sources, now], [_, before]): (Reflected, Reflected)| Look {
            by_sources,
            by_function: now - before - self.ambient * by_sources,
        };
        Some(looks.map(look).collect())
    }

    /// From now on sources are within what this function is; tells how much more these places receive that have gathered
    /// already, W/m^2. `None` where it is cancelled.
    pub fn refine(&mut self, function: IrradianceFunction, places: &[Place]) -> Option<Vec<DVec3>> {
        let looks = self.look(&function, places, self.coarser())?.into_iter();
        self.within = Some(function);
        Some(
            looks
                .map(|[by_sources, by_function]| by_function - by_sources)
                .collect(),
        )
    }

    /// From now on this share of all reflected light is added to it.
    pub fn add_ambient(&mut self, share: DVec3) {
        self.ambient = share;
    }

    /// The resolution that does for differences that share their pixels: half of it, but not below [`FEWEST_PIXELS`].
    fn coarser(&self) -> u32 {
        let resolution = self.settings.resolution;
        let half = (resolution / 2).next_multiple_of(2);
        half.max(FEWEST_PIXELS).min(resolution)
    }

    /// What places receive of reflected light, see [`SecondLook`]; `None` where it is cancelled.
    fn look(
        &self,
        function: &IrradianceFunction,
        places: &[Place],
        resolution: u32,
    ) -> Option<Vec<Reflected>> {
        let radiosity = self.radiosity.iter().zip(&self.emission);
        let reflected: Vec<Rgb> = radiosity.map(|(&b, &e)| b - e).collect();
        let FormFactorSettings { maps, seed, .. } = self.settings;
        let look = SecondLook {
            drawable: &self.drawable,
            resolution,
            maps,
            seed,
            reflected: &reflected,
            function,
        };
        let mut all = Vec::with_capacity(places.len());
        for places in places.chunks(BATCH) {
            if self.cancel.is_cancelled() {
                return None;
            }
            all.extend(look.at(places));
        }
        Some(all)
    }
}

/// The sum over a row of the form factors times some exitances, one per source, W/m^2.
fn sum(row: &[Entry], exitances: &[Rgb]) -> DVec3 {
    let terms = row
        .iter()
        .map(|entry| f64::from(entry.units) * exitances[entry.source as usize].as_dvec3());
    terms.sum::<DVec3>() / f64::from(UNITS_PER_ONE)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A correction is a small difference of sums of pixels, and may be more than all that a dark place receives.
    #[test]
    fn no_place_receives_less_than_its_direct_light() {
        let mut light = Light {
            irradiance: DVec3::splat(0.25),
            direct: DVec3::splat(0.125),
            by_sources: DVec3::splat(0.125),
            surfaces: 1.0,
        };
        light.add_reflected(DVec3::new(0.5, -0.0625, -0.5));
        assert_eq!(light.irradiance, DVec3::new(0.75, 0.1875, 0.125));
    }
}
