//! Who gathers: what places receive from solved sources.

use std::f64::consts::SQRT_2;
use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use scene::function::IrradianceFunction;
use scene::{Rgb, Scene};

use super::layers::{LayerLight, SourceLayer};
use super::means::Means;
use super::second_look::{Reflected, SecondLook, Within};
use super::vertices::{Place, Places};
use crate::FormFactors;
use crate::backend::Backend;
use crate::cancel::CancelToken;
use crate::problem::Problem;
use crate::receivers::Receivers;
use crate::rows::{BackendError, Entry, UNITS_PER_ONE};
use crate::settings::{FormFactorSettings, Seed};
use crate::sources::Sources;

/// Places that look a second time between two questions whether to stop.
const BATCH: usize = 1 << 12;

/// Pixels along a hemicube's face below which differences are noise themselves.
const FEWEST_PIXELS: u32 = 16;

/// The most pixels that corrections take where half of the resolution are fewer.
const MOST_PIXELS: u32 = 64;

/// The most by which what varies within a source is scaled to what it reflects.
const MOST_SCALED: f32 = 2.0;

/// What a place receives, W/m^2.
#[derive(Clone, Copy, Debug)]
pub(super) struct Light {
    /// From emitters without reflection.
    pub direct: DVec3,
    /// The rest, if sources are one value each.
    pub by_sources: DVec3,
    /// How much more of reflected light it is if they are not.
    pub correction: DVec3,
    /// The share of what it sees, by form factors, that is fronts of surfaces and no opening.
    pub surfaces: f64,
    /// What it is likely to miss of what varies within sources, squared and summed over channels, (W/m^2)^2: of each as much as the form
    /// factor to it and its deviation make. 0 before it is known.
    pub within: f64,
}

impl Light {
    /// None, where nothing is seen.
    pub const DARK: Self = Self {
        direct: DVec3::ZERO,
        by_sources: DVec3::ZERO,
        correction: DVec3::ZERO,
        surfaces: 0.0,
        within: 0.0,
    };

    /// The same and so much more of another one, each part of it.
    #[must_use]
    pub fn plus(self, share: f64, other: &Self) -> Self {
        Self {
            direct: self.direct + share * other.direct,
            by_sources: self.by_sources + share * other.by_sources,
            correction: self.correction + share * other.correction,
            surfaces: self.surfaces + share * other.surfaces,
            within: self.within + share * other.within,
        }
    }

    /// All that it receives. A correction is a small difference, and may be more than all that a dark place receives.
    pub fn irradiance(&self) -> DVec3 {
        (self.direct + self.by_sources + self.correction).max(self.direct)
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

/// Places whose light changes with what sources send out.
#[derive(Default)]
struct Kept {
    places: Vec<Place>,
    lights: Vec<Light>,
    /// As receivers.
    receivers: Vec<u32>,
    /// The rows of the first ones, one after the other, and where each ends. Those of the others do not fit, and are drawn
    /// again.
    entries: Vec<Entry>,
    ends: Vec<usize>,
    /// Whether a row did not fit.
    is_full: bool,
}

/// What places on surfaces receive from solved sources.
pub(super) struct Gatherer<'a, 'c> {
    places: Places<'a>,
    /// How many of the places have gathered.
    done: u32,
    backend: Backend<'a>,
    sources: Sources<'a>,
    settings: FormFactorSettings,
    problem: Problem,
    /// One per source, W/m^2.
    radiosity: Vec<Rgb>,
    kept: Kept,
    most_kept_bytes: u64,
    /// Once they are refined, and by hemicubes of how many pixels.
    within: Option<(Within, u32)>,
    cancel: &'c CancelToken,
}

impl<'a, 'c> Gatherer<'a, 'c> {
    /// From sources that receive this, W/m^2, one per source. A back end is tried at the `first` places.
    pub fn new(
        form_factors: &FormFactors<'a>,
        sources: &Sources<'a>,
        irradiance: &[Rgb],
        first: &[Place],
        cancel: &'c CancelToken,
    ) -> Result<Self, BackendError> {
        let settings = form_factors.settings();
        let places = Places::new(sources.patches(), sources.drawable(), settings.seed);
        places.extend(first.iter().copied());
        let problem = Problem::new(sources.scene());
        Ok(Self {
            radiosity: radiosities(&problem, irradiance),
            problem,
            backend: form_factors.at(Box::new(places.clone()), sources.clone())?,
            sources: sources.clone(),
            settings,
            done: places.count(),
            places,
            kept: Kept::default(),
            most_kept_bytes: form_factors.memory_bytes(),
            within: None,
            cancel,
        })
    }

    /// The scene whose patches the sources are.
    pub fn sources(&self) -> &'a Scene {
        self.sources.scene()
    }

    /// The value of its source for each patch.
    pub fn prolonged(&self, values: &[Rgb]) -> Vec<Rgb> {
        self.sources.prolonged(values)
    }

    /// From now on sources receive this, W/m^2, one per source.
    pub fn receive(&mut self, irradiance: &[Rgb]) {
        self.radiosity = radiosities(&self.problem, irradiance);
    }

    /// What some more places receive; `None` where it is cancelled.
    pub fn gather(&mut self, places: &[Place]) -> Result<Option<Vec<Light>>, BackendError> {
        self.gather_at(places, false)
    }

    /// The same of places that are kept.
    pub fn gather_and_keep(
        &mut self,
        places: &[Place],
    ) -> Result<Option<Vec<Light>>, BackendError> {
        let lights = self.gather_at(places, true)?;
        if let Some(lights) = &lights {
            self.kept.places.extend_from_slice(places);
            self.kept.lights.extend_from_slice(lights);
        }
        Ok(lights)
    }

    fn gather_at(
        &mut self,
        places: &[Place],
        are_kept: bool,
    ) -> Result<Option<Vec<Light>>, BackendError> {
        self.places.extend(places.iter().copied());
        let (from, end) = (self.done, self.places.count());
        let mut lights = Vec::with_capacity(places.len());
        let (emission, radiosity) = (&self.problem.emission, &self.radiosity);
        let kept = &mut self.kept;
        let is_done = draw(&mut self.backend, from..end, self.cancel, |row| {
            let direct = sum(row, emission);
            let units: f64 = row.iter().map(|entry| f64::from(entry.units)).sum();
            lights.push(Light {
                direct,
                by_sources: sum(row, radiosity) - direct,
                correction: DVec3::ZERO,
                surfaces: units / f64::from(UNITS_PER_ONE),
                within: 0.0,
            });
            if are_kept {
                kept.keep(row, self.most_kept_bytes);
            }
        })?;
        if !is_done {
            return Ok(None);
        }
        self.done = end;
        if are_kept {
            self.kept.receivers.extend(from..end);
        }
        let Some(corrections) = self.corrections(places) else {
            return Ok(None);
        };
        for (light, correction) in lights.iter_mut().zip(corrections) {
            light.correction = correction;
        }
        Ok(Some(lights))
    }

    /// What kept places receive where sources receive this, W/m^2, or what they did, and are within as these means say, both one
    /// per source; `None` where it is cancelled.
    pub fn gather_again(
        &mut self,
        irradiance: Option<&[Rgb]>,
        means: &[Means],
    ) -> Result<Option<&[Light]>, BackendError> {
        if let Some(irradiance) = irradiance {
            self.receive(irradiance);
        }
        let radiosity = &self.radiosity;
        let renew = |light: &mut Light, row: &[Entry]| {
            light.by_sources = sum(row, radiosity) - light.direct;
            let missed = |entry: &Entry| {
                let share = f64::from(entry.units) / f64::from(UNITS_PER_ONE);
                share * share * means[entry.source as usize].variance
            };
            light.within = row.iter().map(missed).sum();
        };
        let Kept {
            lights,
            receivers,
            entries,
            ends,
            ..
        } = &mut self.kept;
        let (first, others) = lights.split_at_mut(ends.len());
        first.par_iter_mut().enumerate().for_each(|(k, light)| {
            let start = if k == 0 { 0 } else { ends[k - 1] };
            renew(light, &entries[start..ends[k]]);
        });
        let mut others = others.iter_mut();
        for run in receivers[ends.len()..].chunk_by(|a, b| a + 1 == *b) {
            let is_done = draw(
                &mut self.backend,
                run[0]..run[0] + run.len() as u32,
                self.cancel,
                |row| {
                    if let Some(light) = others.next() {
                        renew(light, row);
                    }
                },
            )?;
            if !is_done {
                return Ok(None);
            }
        }
        Ok(Some(&self.kept.lights))
    }

    /// What kept places receive, the first ones first.
    pub fn lights(&self) -> &[Light] {
        &self.kept.lights
    }

    /// What kept places receive of each of these layers; `None` where it is cancelled.
    pub fn layers(
        &mut self,
        layers: &[SourceLayer],
    ) -> Result<Option<Vec<Vec<LayerLight>>>, BackendError> {
        let parts = |row: &[Entry]| -> Vec<LayerLight> {
            let part = |layer: &SourceLayer| LayerLight {
                direct: sum(row, &layer.emission),
                by_sources: sum(row, &layer.reflected),
            };
            layers.iter().map(part).collect()
        };
        let Kept {
            receivers,
            entries,
            ends,
            ..
        } = &self.kept;
        let kept = (0..ends.len()).into_par_iter().map(|k| {
            let start = if k == 0 { 0 } else { ends[k - 1] };
            parts(&entries[start..ends[k]])
        });
        let mut of_places: Vec<Vec<LayerLight>> = kept.collect();
        for run in receivers[ends.len()..].chunk_by(|a, b| a + 1 == *b) {
            let range = run[0]..run[0] + run.len() as u32;
            let take = |row: &[Entry]| of_places.push(parts(row));
            if !draw(&mut self.backend, range, self.cancel, take)? {
                return Ok(None);
            }
        }
        let of_layer = |k: usize| of_places.iter().map(|parts| parts[k]).collect();
        Ok(Some((0..layers.len()).map(of_layer).collect()))
    }

    /// What places see when they look a second time, where sources are within as they are `now`; `None` where it is cancelled.
    pub fn look_again(&self, now: &Within, places: &[Place]) -> Option<Vec<Look>> {
        let FormFactorSettings {
            resolution, seed, ..
        } = self.settings;
        let now = self.look(now, places, resolution, seed)?;
        let before = match &self.within {
            Some((within, _)) => self.look(within, places, resolution, seed)?,
            None => vec![Reflected::default(); places.len()],
        };
        let looks = now.into_iter().zip(before);
        let look = |(now, before): (Reflected, Reflected)| Look {
            by_sources: now.by_sources,
            by_function: now.within - before.within,
        };
        Some(looks.map(look).collect())
    }

    /// From now on sources are within as they are `now`, as hemicubes of so many pixels tell; tells what kept places receive. `None`
    /// where it is cancelled.
    pub fn refine(&mut self, now: Within, resolution: u32) -> Option<&[Light]> {
        self.within = Some((now, resolution));
        let corrections = self.corrections(&self.kept.places)?;
        for (light, correction) in self.kept.lights.iter_mut().zip(corrections) {
            light.correction = correction;
        }
        Some(&self.kept.lights)
    }

    /// How much more light places receive that sources are not one value each, W/m^2; `None` where it is cancelled.
    fn corrections(&self, places: &[Place]) -> Option<Vec<DVec3>> {
        let Some((within, resolution)) = &self.within else {
            return Some(vec![DVec3::ZERO; places.len()]);
        };
        let looks = self.look(within, places, *resolution, self.settings.seed)?;
        Some(looks.into_iter().map(|look| look.within).collect())
    }

    /// What pixels bring to such corrections by hemicubes of so many of them, W/m^2; `None` where it is cancelled.
    pub fn noise_of_corrections(
        &self,
        within: &Within,
        places: &[Place],
        resolution: u32,
    ) -> Option<Vec<DVec3>> {
        let seed = self.settings.seed;
        let looks = self.look(within, places, resolution, seed)?;
        let others = self.look(within, places, resolution, seed.otherwise())?;
        let both = looks.into_iter().zip(others);
        Some(both.map(|(a, b)| (a.within - b.within) / SQRT_2).collect())
    }

    /// The most pixels along a hemicube's face that corrections are worth, which take several times as long as rows.
    pub fn finest(&self) -> u32 {
        let finer = (2 * self.settings.resolution).min(MOST_PIXELS);
        finer.max(self.coarser())
    }

    /// What sources are like within by a function of which they have these means.
    pub fn within(&self, function: IrradianceFunction, means: &[Means]) -> Within {
        let reflected = self.reflected();
        let by_function: Vec<Rgb> = means
            .iter()
            .zip(&self.problem.reflectance)
            .zip(&reflected)
            .map(|((means, &rho), &reflected)| {
                let linear = means.linear.map(DVec3::as_vec3);
                linear.map_or(reflected, |linear| rho * linear)
            })
            .collect();
        let scale = |(&does, &would): (&Rgb, &Rgb)| {
            let scale = (does / would).min(Rgb::splat(MOST_SCALED));
            Rgb::select(would.cmpgt(Rgb::ZERO), scale, Rgb::ZERO)
        };
        Within {
            scales: reflected.iter().zip(&by_function).map(scale).collect(),
            means: by_function,
            function,
        }
    }

    /// What sources reflect, W/m^2, one per source.
    fn reflected(&self) -> Vec<Rgb> {
        let radiosity = self.radiosity.iter().zip(&self.problem.emission);
        radiosity.map(|(&b, &e)| b - e).collect()
    }

    /// The resolution that mostly does for differences that share their pixels: half of it, but not below [`FEWEST_PIXELS`].
    pub fn coarser(&self) -> u32 {
        let resolution = self.settings.resolution;
        let half = (resolution / 2).next_multiple_of(2);
        half.max(FEWEST_PIXELS).min(resolution)
    }

    /// What places receive of reflected light, see [`SecondLook`]; `None` where it is cancelled.
    fn look(
        &self,
        within: &Within,
        places: &[Place],
        resolution: u32,
        seed: Seed,
    ) -> Option<Vec<Reflected>> {
        let look = SecondLook {
            drawable: self.sources.drawable(),
            resolution,
            maps: self.settings.maps,
            seed,
            reflected: &self.reflected(),
            within,
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

impl Kept {
    /// Keeps one more row, unless all would take more than so many bytes.
    fn keep(&mut self, row: &[Entry], most_bytes: u64) {
        let bytes = (self.entries.len() + row.len()) * size_of::<Entry>();
        self.is_full |= bytes as u64 > most_bytes;
        if !self.is_full {
            self.entries.extend_from_slice(row);
            self.ends.push(self.entries.len());
        }
    }
}

/// Hands out the rows of these receivers, one after the other; false where it is cancelled.
fn draw(
    backend: &mut Backend,
    receivers: Range<u32>,
    cancel: &CancelToken,
    mut take: impl FnMut(&[Entry]),
) -> Result<bool, BackendError> {
    let batch = backend.source.preferred_batch().max(1);
    let mut next = receivers.start;
    while next < receivers.end {
        if cancel.is_cancelled() {
            return Ok(false);
        }
        let end = receivers.end.min(next.saturating_add(batch));
        let rows = backend.source.draw_rows(next..end)?;
        for k in 0..rows.receivers().len() {
            take(rows.row(k));
        }
        next = end;
    }
    Ok(true)
}

/// What sources send out that receive this, W/m^2, one per source.
fn radiosities(problem: &Problem, irradiance: &[Rgb]) -> Vec<Rgb> {
    let irradiance = irradiance.iter().enumerate();
    irradiance.map(|(s, &h)| problem.radiosity(s, h)).collect()
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
        let light = Light {
            direct: DVec3::splat(0.125),
            by_sources: DVec3::splat(0.125),
            correction: DVec3::new(0.5, -0.0625, -0.5),
            surfaces: 1.0,
            within: 0.0,
        };
        assert_eq!(light.irradiance(), DVec3::new(0.75, 0.1875, 0.125));
    }
}
