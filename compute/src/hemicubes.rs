//! Everything that decides the rows of form factors: receivers, sources, and what the pixels between them count.
//!
//! Hemicubes stand at the points of [receivers](crate::receivers) and see [sources](crate::sources). They are numbered
//! through all receivers. A hemicube's place on the gpu follows from its number and its turn about its normal from where
//! it stands, so that rows do not depend on what is drawn with them. Back ends, lamps' views and the cache share one of
//! these.

use std::collections::BTreeMap;
use std::sync::Arc;

use scene::Scene;
use visibility::Drawable;

use crate::delta_form_factors::DeltaFormFactors;
use crate::receivers::{Patches, ReceiverId, Receivers};
use crate::rows::UNITS_PER_ONE;
use crate::settings::{FormFactorSettings, Maps};
use crate::sources::Sources;

/// All hemicubes at some receivers that see some sources.
#[derive(Debug)]
pub struct Hemicubes<'a> {
    receivers: Box<dyn Receivers + 'a>,
    sources: Sources<'a>,
    resolution: u32,
    maps: Maps,
    /// By the number of points that a receiver has.
    delta_form_factors: BTreeMap<u32, DeltaFormFactors>,
}

impl<'a> Hemicubes<'a> {
    /// The hemicubes of a scene's patches that see its patches.
    pub fn new(scene: &'a Scene, settings: FormFactorSettings) -> Self {
        Self::of_patches(Sources::patches_of(scene), settings)
    }

    /// The hemicubes of the patches over which the sources are.
    pub fn of_patches(sources: Sources<'a>, settings: FormFactorSettings) -> Self {
        let FormFactorSettings { points, seed, .. } = settings;
        let patches = Patches::new(sources.patches(), sources.drawable(), points, seed);
        Self::at(Box::new(patches), sources, settings)
    }

    /// The hemicubes of any receivers.
    pub fn at(
        receivers: Box<dyn Receivers + 'a>,
        sources: Sources<'a>,
        settings: FormFactorSettings,
    ) -> Self {
        let FormFactorSettings {
            resolution, maps, ..
        } = settings;
        let table = |count: u32| {
            let units = UNITS_PER_ONE / count;
            (count, DeltaFormFactors::new(maps, resolution, units))
        };
        Self {
            delta_form_factors: receivers.point_counts().into_iter().map(table).collect(),
            receivers,
            sources,
            resolution,
            maps,
        }
    }

    /// Where they stand.
    pub fn receivers(&self) -> &(dyn Receivers + 'a) {
        &*self.receivers
    }

    /// What they see.
    pub fn sources(&self) -> &Sources<'a> {
        &self.sources
    }

    /// What item buffers draw of the sources.
    pub fn drawable(&self) -> &Arc<Drawable<'a>> {
        self.sources.drawable()
    }

    /// Pixels along a face.
    pub fn resolution(&self) -> u32 {
        self.resolution
    }

    /// The pixels' multipliers.
    pub fn maps(&self) -> Maps {
        self.maps
    }

    /// How many there are.
    pub fn total(&self) -> u64 {
        self.receivers
            .first_point(ReceiverId(self.receivers.count()))
    }

    /// What the pixels of a receiver that has `count` points count.
    ///
    /// # Panics
    /// Where no receiver has that many.
    pub fn delta_form_factors(&self, count: u32) -> &DeltaFormFactors {
        &self.delta_form_factors[&count]
    }

    /// The tables of [`Self::delta_form_factors`], by the number of points of a receiver, ascending.
    pub fn tables(&self) -> impl Iterator<Item = (u32, &DeltaFormFactors)> {
        self.delta_form_factors
            .iter()
            .map(|(&count, table)| (count, table))
    }
}
