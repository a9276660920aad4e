//! The means of patches, taken at more points where one says too little.
//!
//! # Theory
//! A patch's row says what arrives at some of its points, by hemicubes that have pixels. What that is off by shows when the patch
//! gathers at several times as many points, turned otherwise. Patches are chosen by chance, by what they are likely to be off by, so
//! that each stands for as much area as it was likely to be missed, and what they are off by makes an estimate of all.
//! Where that is more than was asked for, those that are likely to be off most gather at more points. What they receive then, over
//! what their rows say, is added to these ([`Receives::BesidesItsRow`]), and the equation is solved again. Likely is what a function
//! says that is linear between the mean values around each corner: how much it varies over the patch, and of lamps, how much their
//! closed form does.
//!
//! The same function says what it brings that patches send out one value each: some places, by chance where most is seen that varies,
//! look once more, at the function ([`super::second_look`]).

mod likely;
mod looks;

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use glam::DVec3;
use scene::function::{Refinement, VertexId};
use scene::{PatchId, Rgb, Scene};

use super::gatherer::{Gatherer, Light};
use super::growth::{asked, is_below, room, squares};
use super::lit_mesh::{LitMesh, Size, sum};
use super::report::worst_object;
use super::vertices::Place;
use super::{
    ErrorByCause, FunctionEnd, FunctionFault, FunctionReport, NEXT_ROUND, Order, Receives, Resolve,
};
use crate::FormFactors;
use crate::compact_rows::Row;
use crate::receivers::{count_of_at_least, points_in};
use crate::rows::{BackendError, UNITS_PER_ONE};
use crate::settings::Wanted;
use crate::sources::Sources;
use likely::mesh_of_patches;
use looks::Looked;

/// Who looks more closely does so at as many times as many points, or more; nobody who has so many gathers at more. Looking at all
/// patches then takes what a run at that many takes, which bounds what an error can cost that cannot be reached.
const FINER: u32 = 3;
const MOST_POINTS: u32 = 1 << 5;

/// The share of what is asked, squared, at which nothing more is done: an estimate has an error itself.
const SURE: f64 = 0.9;

/// The share of what is asked of points, squared, that those patches are to leave that do not gather at more.
const AIM: f64 = 0.6;

/// The share of what is asked, squared, that what varies within patches may bring before somebody does something about it, and how
/// often that helps.
const SOURCES_SHARE: f64 = 0.6;
const MOST_REFINED: u32 = 3;

/// The means of patches, and what is said of them.
#[derive(Clone, Debug)]
pub struct MeansOfPatches {
    /// What patches receive, W/m^2, one per patch.
    pub irradiance: Vec<Rgb>,
    /// What is said of its error.
    pub report: FunctionReport,
}

/// Estimates the error of the means of patches, and lets those gather at more points that need it, until it is as small as the
/// target asks for. Patches receive this `irradiance`, W/m^2, by rows of so many `points`, both one per patch. `None` where it is
/// cancelled.
///
/// # Errors
/// A back end that does not open or cannot go on, and values that no f32 holds.
pub fn means_of_patches<'a>(
    form_factors: &FormFactors<'a>,
    sources: &Sources<'a>,
    irradiance: &[Rgb],
    points: &[u32],
    order: &Order,
    resolve: &mut dyn Resolve,
) -> Result<Option<MeansOfPatches>, FunctionFault> {
    let scene = sources.patches();
    let of_sources = sources.restricted(irradiance);
    let patch = |(&points, &irradiance): (&u32, &Rgb)| Patch {
        points,
        irradiance: irradiance.as_dvec3(),
        surfaces: 1.0,
        ..Patch::default()
    };
    let mut taking = Taking {
        scene,
        mesh: mesh_of_patches(sources, order),
        gatherer: Gatherer::new(form_factors, sources, &of_sources, &[], order.cancel)?,
        order,
        resolve,
        areas: scene.patch_areas(),
        patches: points.iter().zip(irradiance).map(patch).collect(),
        gathered: BTreeMap::new(),
        calibration: [[1.0; 2]; 2],
        refined: 0,
        round: 0,
    };
    let Some(report) = taking.run()? else {
        return Ok(None);
    };
    Ok(Some(MeansOfPatches {
        irradiance: taking.irradiance(),
        report,
    }))
}

/// A patch and its mean.
#[derive(Clone, Copy, Debug, Default)]
struct Patch {
    /// How many points that is taken at.
    points: u32,
    /// W/m^2.
    irradiance: DVec3,
    /// What of it is not in its row.
    besides: DVec3,
    /// What it receives from emitters without reflection, by its row, W/m^2; 0 where nobody knows.
    direct: DVec3,
    /// The share of what it sees that is fronts of surfaces.
    surfaces: f64,
    /// See [`Light::within`].
    within: f64,
    /// What it was off by before it gathered at more points than its row, by target and area; `None` where it has not.
    was_off: Option<[f64; 2]>,
}

/// The means of patches on their way.
struct Taking<'t, 'a> {
    scene: &'a Scene,
    /// Its leaves are the patches, or smaller, where light falls from close to them.
    mesh: Refinement,
    gatherer: Gatherer<'a, 't>,
    order: &'t Order<'t>,
    resolve: &'t mut dyn Resolve,
    /// One per patch, m^2.
    areas: Vec<f64>,
    patches: Vec<Patch>,
    /// What vertices receive that have gathered.
    gathered: BTreeMap<VertexId, Light>,
    /// What patches are off by, squared, over what they are likely to be, of those that have their row's points and of the others,
    /// as the last looks say.
    calibration: [[f64; 2]; 2],
    /// How often it was seen to what varies within patches.
    refined: u32,
    round: u32,
}

impl Taking<'_, '_> {
    fn run(&mut self) -> Result<Option<FunctionReport>, FunctionFault> {
        let target = asked(&self.order.target).map(|target| SURE * target);
        let is_fixed = self.order.target.of == Wanted::MeansAtPoints;
        let mut next = Duration::ZERO;
        loop {
            let start = Instant::now();
            let is_first = self.round == 0;
            if !self.resolve()? || (is_first && !self.begin()?) {
                return Ok(None);
            }
            let lit = self.lit();
            let size = lit.size();
            let likely = self.likely(&lit, &size);
            let lit = self.sharpened(lit);
            let Some(looked) = self.look(&lit, &likely, &size)? else {
                return Ok(None);
            };
            let error = self.judge(&lit, &size, &likely, &looked);
            let others = [error.sources, error.iterations];
            let room = room(target, others.iter().map(squares).fold([0.0; 2], sum));
            let is_enough = is_below(error.sampling, room);
            let mut end = if is_below(error.total, target) {
                Some(FunctionEnd::Error)
            } else if (self.order.is_late)(next) {
                Some(FunctionEnd::TimeLimit)
            } else if is_fixed {
                Some(FunctionEnd::OtherCauses)
            } else if self.wants_finer_sources(&error) && (is_enough || self.refined > 0) {
                if !self.refine(&lit)? {
                    return Ok(None);
                }
                next = start.elapsed().mul_f64(NEXT_ROUND);
                continue;
            } else if is_enough {
                Some(FunctionEnd::OtherCauses)
            } else {
                None
            };
            if end.is_none() {
                match self.gather_more(&size, &likely, &looked, room)? {
                    None => return Ok(None),
                    Some(false) => end = Some(FunctionEnd::OtherCauses),
                    Some(true) => next = start.elapsed().mul_f64(NEXT_ROUND),
                }
            }
            if let Some(end) = end {
                return Ok(Some(self.report(&size, &likely, &looked, &error, end)));
            }
        }
    }

    /// Learns what is to be known at first; false where it is cancelled.
    fn begin(&mut self) -> Result<bool, BackendError> {
        Ok(self.read_rows()?
            && match self.find_spots()? {
                Some(true) => self.read_rows()?,
                Some(false) => true,
                None => false,
            })
    }

    /// Whether what varies within patches takes more than its share of what is asked of all causes, and something can be done.
    fn wants_finer_sources(&self, error: &ErrorByCause) -> bool {
        let share = asked(&self.order.target).map(|target| SOURCES_SHARE * target);
        self.refined < MOST_REFINED && !is_below(error.sources, share)
    }

    /// From now on patches are within as the function says; false where it is cancelled.
    fn refine(&mut self, lit: &LitMesh) -> Result<bool, FunctionFault> {
        let means = lit.means(self.gatherer.sources());
        let within = self.gatherer.within(lit.function()?, &means);
        let reflecting = (0..self.patches.len() as u32).map(PatchId);
        let reflecting: Vec<PatchId> = reflecting
            .filter(|&patch| self.radiosity(patch) != DVec3::ZERO)
            .collect();
        let middle = |&patch: &PatchId| {
            let [a, b, c] = self.scene.patch_in_surface(patch);
            Place {
                surface: self.scene.mesh().surface_of(patch),
                barycentric: (a + b + c) / 3.0,
            }
        };
        let middles: Vec<Place> = reflecting.iter().map(middle).collect();
        let Some(looks) = self.gatherer.look_again(&within, &middles) else {
            return Ok(false);
        };
        for (patch, look) in reflecting.into_iter().zip(looks) {
            let patch = &mut self.patches[patch.index()];
            patch.besides += look.by_function;
            patch.irradiance += look.by_function;
        }
        self.refined += 1;
        let resolution = self.gatherer.coarser();
        Ok(self.gatherer.refine(within, resolution).is_some())
    }

    /// Solves the equation with what patches receive besides their rows; false where it is cancelled.
    fn resolve(&mut self) -> Result<bool, BackendError> {
        let besides = self.patches.iter().map(|patch| patch.besides);
        let known: Vec<Receives> = besides.map(Receives::BesidesItsRow).collect();
        if let Some(irradiance) = self.resolve.resolve(&known)? {
            for (patch, irradiance) in self.patches.iter_mut().zip(&irradiance) {
                patch.irradiance = irradiance.as_dvec3();
            }
            self.gatherer.receive(&irradiance);
        }
        Ok(!self.order.cancel.is_cancelled())
    }

    /// Learns from rows what patches see; false where it is cancelled.
    fn read_rows(&mut self) -> Result<bool, BackendError> {
        let lit = self.lit();
        let means = lit.means(self.gatherer.sources());
        let emission = self.scene.patch_emissions();
        let patches = &mut self.patches;
        self.resolve.for_each_row(&mut |k, row: Row| {
            let (mut direct, mut surfaces, mut within) = (DVec3::ZERO, 0.0, 0.0);
            for entry in row {
                let share = f64::from(entry.units) / f64::from(UNITS_PER_ONE);
                let source = entry.source as usize;
                surfaces += share;
                within += share * share * means[source].variance;
                direct += share * emission[source].as_dvec3();
            }
            patches[k] = Patch {
                direct,
                surfaces,
                within,
                ..patches[k]
            };
        })?;
        Ok(!self.order.cancel.is_cancelled())
    }

    /// W/m^2, one per patch.
    fn irradiance(&self) -> Vec<Rgb> {
        let irradiance = self.patches.iter().map(|patch| patch.irradiance);
        irradiance.map(|h| h.max(DVec3::ZERO).as_vec3()).collect()
    }

    /// Reflected radiosity of a patch that light can reach, W/m^2.
    fn radiosity(&self, patch: PatchId) -> DVec3 {
        if (self.order.is_lit)(self.scene.mesh().surface_of(patch)) {
            self.reflected(patch, self.patches[patch.index()].irradiance)
        } else {
            DVec3::ZERO
        }
    }

    /// Reflected radiosity of a patch where it receives this, W/m^2.
    fn reflected(&self, patch: PatchId, irradiance: DVec3) -> DVec3 {
        let surface = self.scene.mesh().surface_of(patch);
        let material = self.scene.surface(surface).material;
        self.scene.material(material).reflectance.as_dvec3() * irradiance
    }

    /// What patches receive at more points than they have; `None` where it is cancelled.
    fn gather(&mut self, patches: &[PatchId]) -> Result<Option<Vec<Light>>, BackendError> {
        let mut places = Vec::new();
        let mut ends = Vec::with_capacity(patches.len());
        for &patch in patches {
            let surface = self.scene.mesh().surface_of(patch);
            let corners = self.scene.patch_in_surface(patch);
            let points = points_in(corners, self.finer(patch));
            places.extend(points.into_iter().map(|barycentric| Place {
                surface,
                barycentric,
            }));
            ends.push(places.len());
        }
        let Some(lights) = self.gatherer.gather(&places)? else {
            return Ok(None);
        };
        let mut start = 0;
        let mean = |end: usize| {
            let share = 1.0 / (end - start) as f64;
            let mean = lights[start..end].iter();
            let mean = mean.fold(Light::DARK, |sum, light| sum.plus(share, light));
            start = end;
            mean
        };
        Ok(Some(ends.into_iter().map(mean).collect()))
    }

    /// How many points a patch is looked at more closely at.
    fn finer(&self, patch: PatchId) -> u32 {
        count_of_at_least(FINER * self.patches[patch.index()].points)
    }

    /// What a patch is off by where it receives this at more points, W/m^2, by target and area.
    fn off(&self, size: &Size, patch: PatchId, closer: &Light) -> [f64; 2] {
        let gathered = self.reflected(patch, closer.irradiance());
        let shown = self.reflected(patch, self.patches[patch.index()].irradiance);
        let area = self.areas[patch.index()];
        size.weighed(shown - gathered, gathered).map(|w| area * w)
    }

    /// Lets patches gather at more points that are likely to be off most, until the others leave what is asked for, squared; those
    /// that have been looked at have. False where none is left that can; `None` where it is cancelled.
    fn gather_more(
        &mut self,
        size: &Size,
        likely: &[[f64; 2]],
        looked: &Looked,
        room: [f64; 2],
    ) -> Result<Option<bool>, BackendError> {
        let estimated = self.estimated(likely);
        let mut is_closer = vec![false; self.patches.len()];
        let mut closer: Vec<(PatchId, Light)> = Vec::new();
        for &(patch, light) in &looked.closer {
            if !std::mem::replace(&mut is_closer[patch.index()], true) {
                closer.push((patch, light));
            }
        }
        let mut left = [0.0; 2];
        let mut wanted: Vec<(f64, PatchId)> = Vec::new();
        for (patch, &off) in (0..).map(PatchId).zip(&estimated) {
            if is_closer[patch.index()] {
                continue;
            }
            left = sum(left, off);
            if self.patches[patch.index()].points < MOST_POINTS {
                let need = (off[0] / room[0]).max(off[1] / room[1]);
                wanted.push((need / f64::from(self.finer(patch)), patch));
            }
        }
        wanted.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
        let mut more = Vec::new();
        for (need, patch) in wanted {
            if need == 0.0 || (0..2).all(|t| left[t] <= AIM * room[t]) {
                break;
            }
            let off = estimated[patch.index()];
            left = [0, 1].map(|t| left[t] - off[t]);
            more.push(patch);
        }
        let Some(lights) = self.gather(&more)? else {
            return Ok(None);
        };
        closer.extend(more.into_iter().zip(lights));
        let mut is_more = false;
        for (patch, light) in closer {
            let finer = self.finer(patch);
            if self.patches[patch.index()].points >= MOST_POINTS {
                continue;
            }
            let off = self.off(size, patch, &light);
            let patch = &mut self.patches[patch.index()];
            let gathered = light.irradiance();
            patch.besides += gathered - patch.irradiance;
            patch.irradiance = gathered;
            patch.points = finer;
            patch.was_off = Some(off);
            is_more = true;
        }
        Ok(Some(is_more))
    }

    fn report(
        &self,
        size: &Size,
        likely: &[[f64; 2]],
        looked: &Looked,
        error: &ErrorByCause,
        stopped_by: FunctionEnd,
    ) -> FunctionReport {
        let is_known = !looked.closer.is_empty() && self.order.iterations.is_some();
        // Who would have gone on, to be sure, may be there all the same.
        let is_reached = is_known && is_below(error.total, asked(&self.order.target));
        let of_patch = |(&[off, _], &area): (&[f64; 2], &f64)| size.unweighed(off, area) as f32;
        let estimated = self.estimated(likely);
        let off: Vec<f32> = estimated.iter().zip(&self.areas).map(of_patch).collect();
        let points = self.patches.iter().map(|patch| u64::from(patch.points));
        FunctionReport {
            vertices: 0,
            triangles: 0,
            covered: 1.0,
            checks: looked.closer.len() as u32,
            error: is_known.then_some(*error),
            points: Some(points.sum()),
            is_reached,
            stopped_by: if is_reached {
                FunctionEnd::Error
            } else {
                stopped_by
            },
            mostly_by: is_known.then(|| error.worst(&self.order.target)),
            mostly_on: worst_object(self.scene, &off),
        }
    }
}
