//! The function on its way: vertices gather, checks tell the error, and the mesh grows, until it is enough.

use std::time::{Duration, Instant};

use scene::function::{IrradianceFunction, VertexId};
use scene::layers::Layer;
use scene::{PatchId, Rgb, Scene, SceneError};

use super::checks::Sample;
use super::gatherer::{Gatherer, Light};
use super::growth::{self, Growth};
use super::lit_mesh::LitMesh;
use super::second_look::Within;
use super::vertices::Place;
use super::{
    ErrorByCause, Errors, FunctionEnd, FunctionFault, FunctionReport, Gathered, NEXT_ROUND, Order,
    Receives, Resolve, first_mesh, gathering_patches, layers, place, report,
};
use crate::FormFactors;
use crate::rows::BackendError;
use crate::sources::Sources;

/// How many other samples have to confirm together that the error is as small as was asked for.
const CONFIRMATIONS: u32 = 2;

/// What goes with the error that was asked for, see [`Target::in_pictures`], is sought with so many times as many vertices as that took.
const MOST_FOR_PICTURES: u32 = 2;

/// One point in so many looks a second time.
const LOOK_EVERY: usize = 4;

/// Gathers the function of a solution among `sources`, with as many vertices as the target asks for, or as there is time for.
/// `irradiance` is what sources receive, W/m^2. Now and then it is told how many vertices there are, and the estimated error, once it
/// is known. Where it is cancelled, it is the last one whose error is known; `None` where there is none yet.
///
/// # Errors
/// A back end that does not open or cannot go on, and values that no f32 holds.
pub fn gather<'a>(
    form_factors: &FormFactors<'a>,
    sources: &Sources<'a>,
    irradiance: &[Rgb],
    order: &Order,
    resolve: &mut dyn Resolve,
    tell: &mut dyn FnMut(u32, Option<Errors>),
) -> Result<Option<Gathered>, FunctionFault> {
    let scene = sources.patches();
    let mesh = first_mesh(scene, sources.drawable(), order.is_lit);
    let gathering = gathering_patches(sources, &mesh, order);
    let vertices = (0..mesh.vertex_count()).map(VertexId);
    let first: Vec<Place> = vertices.map(|vertex| place(&mesh, vertex)).collect();
    let mut making = Making {
        scene,
        growth: Growth::new(LitMesh::new(scene, mesh), order.target.in_pictures()),
        gatherer: Gatherer::new(form_factors, sources, irradiance, &first, order.cancel)?,
        order,
        resolve,
        tell,
        patches: sources.prolonged(irradiance),
        gathering,
        are_sources_final: false,
        reached_at: u32::MAX,
        judged: None,
    };
    let Some((function, report)) = making.run()?.or_else(|| making.interrupted()) else {
        return Ok(None);
    };
    let is_whole = report.stopped_by != FunctionEnd::Interrupt;
    let layers = if is_whole { making.layers()? } else { None };
    Ok(Some(Gathered {
        function,
        report,
        irradiance: making.patches,
        layers,
    }))
}

/// A function on its way.
struct Making<'m, 'a> {
    scene: &'a Scene,
    growth: Growth<'a>,
    gatherer: Gatherer<'a, 'm>,
    order: &'m Order<'m>,
    resolve: &'m mut dyn Resolve,
    tell: &'m mut dyn FnMut(u32, Option<Errors>),
    /// What patches receive, W/m^2, one per patch.
    patches: Vec<Rgb>,
    /// Those that have gathered themselves, before all vertices.
    gathering: Vec<PatchId>,
    /// Whether no more is to be done about the size of sources.
    are_sources_final: bool,
    /// With how many vertices what was asked for was reached first.
    reached_at: u32,
    /// The last function of which the error is known, that error, and at how many points.
    judged: Option<(IrradianceFunction, ErrorByCause, u32)>,
}

impl Making<'_, '_> {
    fn run(&mut self) -> Result<Option<(IrradianceFunction, FunctionReport)>, FunctionFault> {
        let Some(lights) = self.gather_patches()? else {
            return Ok(None);
        };
        self.light_patches(&lights);
        let iterations = Errors::splat(self.order.iterations.unwrap_or(0.0));
        let mut can_grow = true;
        // What the next round is likely to take.
        let mut next = Duration::ZERO;
        loop {
            let start = Instant::now();
            let new = self.growth.lit().new_vertices();
            let places: Vec<Place> = new
                .map(|vertex| place(self.growth.lit().mesh(), vertex))
                .collect();
            let Some(lights) = self.gatherer.gather_and_keep(&places)? else {
                return Ok(None);
            };
            self.growth.take(lights);
            self.tell();
            let is_late = (self.order.is_late)(next);
            let is_last = self.growth.is_full() || is_late || !can_grow;
            if is_last || self.growth.wants_checks() {
                if !self.balance()? {
                    return Ok(None);
                }
                let function = self.growth.lit().function()?;
                let means = self.growth.lit().means(self.gatherer.sources());
                let within = self.gatherer.within(function.clone(), &means);
                let Some(mut sample) = self.sampled(&within, 1)? else {
                    return Ok(None);
                };
                let mut error = self.growth.judge(&sample, iterations);
                // Who believes the first sample that looks good has been lucky as a rule: other ones tell.
                if self.growth.is_reached(error.total) {
                    let others = self.sampled(&within, CONFIRMATIONS)?;
                    let Some(others) = others else {
                        return Ok(None);
                    };
                    sample = others;
                    error = self.growth.judge(&sample, iterations);
                }
                let checks = sample.checks.len() as u32;
                self.judged = Some((function, error, checks));
                let can_refine = !is_last && !self.are_sources_final;
                self.growth.ask(&error, can_refine);
                if can_refine
                    && self.growth.wants_finer_sources(&error)
                    && self.growth.is_enough(error.mesh)
                {
                    if !self.refine_sources(within, &sample, &error) {
                        return Ok(None);
                    }
                    continue;
                }
                if let Some(end) = self.end(&error, is_late, can_grow) {
                    return Ok(self.finished(end)?);
                }
            }
            can_grow = self.growth.grow();
            next = start.elapsed().mul_f64(NEXT_ROUND);
        }
    }

    /// The parts of the light that are asked for.
    fn layers(&mut self) -> Result<Option<Vec<Layer>>, BackendError> {
        let Some(of_sources) = self.resolve.layers()? else {
            return Ok(None);
        };
        let Some(of_places) = self.gatherer.layers(&of_sources)? else {
            return Ok(None);
        };
        let layers = of_sources
            .iter()
            .zip(of_places)
            .map(|(of_sources, of_places)| {
                let patches = self.gatherer.prolonged(&of_sources.irradiance);
                let lights = self.gatherer.lights();
                layers::layer(of_sources, patches, &self.gathering, lights, &of_places)
            });
        Ok(Some(layers.collect()))
    }

    /// Tells how many vertices there are, and what error was known last.
    fn tell(&mut self) {
        let judged = self.judged.as_ref();
        let known = judged.filter(|_| self.order.iterations.is_some());
        let vertices = self.growth.lit().mesh().vertex_count();
        (self.tell)(vertices, known.map(|(_, error, _)| error.total));
    }

    /// Lets sources be within as they are from now on, if hemicubes tell that which are not too dear: what is bright and small, as the
    /// ceiling over a lamp that shines up, is a pixel or none of coarse ones. False where it is cancelled.
    fn refine_sources(&mut self, within: Within, sample: &Sample, error: &ErrorByCause) -> bool {
        self.are_sources_final = true;
        let looks = sample.looks.iter();
        let places: Vec<Place> = looks.map(|&(k, _)| sample.checks[k].place).collect();
        let mut resolution = self.gatherer.coarser();
        let noise = loop {
            let noise = self
                .gatherer
                .noise_of_corrections(&within, &places, resolution);
            let Some(noise) = noise else {
                return false;
            };
            let noise = self.growth.noise_of(sample, &noise);
            if self.growth.hardly_counts(noise) || resolution >= self.gatherer.finest() {
                break noise;
            }
            resolution = (2 * resolution).min(self.gatherer.finest());
        };
        if self.growth.is_worth(noise, error) {
            let Some(lights) = self.gatherer.refine(within, resolution) else {
                return false;
            };
            let lights = lights.to_vec();
            self.renew(&lights);
            self.growth.is_corrected(noise);
        }
        true
    }

    /// Why it is to end now, if it is.
    fn end(&mut self, error: &ErrorByCause, is_late: bool, can_grow: bool) -> Option<FunctionEnd> {
        let vertices = self.growth.lit().mesh().vertex_count();
        let is_reached = self.is_reached(error);
        if is_reached {
            self.reached_at = self.reached_at.min(vertices);
        }
        let has_enough = is_reached && vertices / MOST_FOR_PICTURES >= self.reached_at;
        let growth = &mut self.growth;
        let end = if growth.is_reached(error.total) || has_enough {
            FunctionEnd::Error
        } else if growth.is_full() {
            FunctionEnd::Vertices
        } else if is_late {
            FunctionEnd::TimeLimit
        } else if !can_grow || growth.is_enough(error.mesh) || growth.is_stuck(error.mesh) {
            FunctionEnd::OtherCauses
        } else {
            return None;
        };
        // What goes with it may be beyond reach.
        Some(if is_reached { FunctionEnd::Error } else { end })
    }

    /// Whether an error is as small as was asked for.
    fn is_reached(&self, error: &ErrorByCause) -> bool {
        growth::is_below(error.total, growth::asked(&self.order.target))
    }

    /// The function with the estimates of its error, and what is said of it.
    fn finished(
        &mut self,
        stopped_by: FunctionEnd,
    ) -> Result<Option<(IrradianceFunction, FunctionReport)>, SceneError> {
        let Some((function, error, checks)) = self.judged.take() else {
            return Ok(None);
        };
        let patch_errors = self.growth.patch_errors(&error);
        let mostly_on = report::worst_object(self.scene, &patch_errors);
        let report = FunctionReport {
            mostly_on,
            ..self.report(&function, &error, checks, stopped_by)
        };
        Ok(Some((function.with_error(patch_errors)?, report)))
    }

    /// What there is where it is cancelled. The mesh has grown since, so that nobody knows any more which patches its error was of.
    fn interrupted(&mut self) -> Option<(IrradianceFunction, FunctionReport)> {
        let (function, error, checks) = self.judged.take()?;
        let report = self.report(&function, &error, checks, FunctionEnd::Interrupt);
        Some((function, report))
    }

    fn report(
        &self,
        function: &IrradianceFunction,
        error: &ErrorByCause,
        checks: u32,
        stopped_by: FunctionEnd,
    ) -> FunctionReport {
        let is_known = checks > 0 && self.order.iterations.is_some();
        let mesh = function.mesh();
        FunctionReport {
            vertices: mesh.vertex_count(),
            triangles: mesh.leaf_count(),
            covered: self.growth.lit().area() / self.scene.area(),
            checks,
            points: None,
            error: is_known.then_some(*error),
            is_reached: is_known && self.is_reached(error),
            stopped_by,
            mostly_by: is_known.then(|| error.worst(&self.order.target)),
            mostly_on: None,
        }
    }

    /// What is found in so many rounds of checks, where sources are within as they are now; `None` where it is cancelled.
    fn sampled(&mut self, within: &Within, rounds: u32) -> Result<Option<Sample>, BackendError> {
        let mut sample = Sample::default();
        for _ in 0..rounds {
            let checks = self.growth.checks();
            let places: Vec<Place> = checks.iter().map(|check| check.place).collect();
            let Some(lights) = self.gatherer.gather(&places)? else {
                return Ok(None);
            };
            // Which cost several times what gathering does, and find much the same everywhere.
            let again: Vec<usize> = (0..places.len()).step_by(LOOK_EVERY).collect();
            let places: Vec<Place> = again.iter().map(|&k| places[k]).collect();
            let Some(looks) = self.gatherer.look_again(within, &places) else {
                return Ok(None);
            };
            sample = sample.and(Sample {
                checks,
                lights,
                looks: again.into_iter().zip(looks).collect(),
            });
        }
        Ok(Some(sample))
    }

    /// What patches gather that are smaller than their sources and have no vertices.
    fn gather_patches(&mut self) -> Result<Option<Vec<Light>>, BackendError> {
        let middle = |&patch: &PatchId| {
            let [a, b, c] = self.scene.patch_in_surface(patch);
            Place {
                surface: self.scene.mesh().surface_of(patch),
                barycentric: (a + b + c) / 3.0,
            }
        };
        let places: Vec<Place> = self.gathering.iter().map(middle).collect();
        self.gatherer.gather_and_keep(&places)
    }

    /// Gives patches their light: those that have gathered themselves this, W/m^2.
    fn light_patches(&mut self, gathered: &[Light]) {
        for (patch, light) in self.gathering.iter().zip(gathered) {
            self.patches[patch.index()] = light.irradiance().as_vec3();
        }
        self.growth.light_patches(&self.patches, self.order.is_lit);
    }

    /// Lets sources receive on the mean what the function says, and all else what then arrives; false where it is cancelled.
    fn balance(&mut self) -> Result<bool, BackendError> {
        let means = self.growth.lit().means(self.gatherer.sources());
        let known: Vec<Receives> = means.iter().map(|means| means.receives).collect();
        let irradiance = self.resolve.resolve(&known)?;
        if self.order.cancel.is_cancelled() {
            return Ok(false);
        }
        if let Some(irradiance) = &irradiance {
            self.patches = self.gatherer.prolonged(irradiance);
        }
        let irradiance = irradiance.as_deref();
        let Some(lights) = self.gatherer.gather_again(irradiance, &means)? else {
            return Ok(false);
        };
        let lights = lights.to_vec();
        self.renew(&lights);
        Ok(true)
    }

    /// Gives all places that are kept another light: first patches, then vertices.
    fn renew(&mut self, lights: &[Light]) {
        let (of_patches, of_vertices) = lights.split_at(self.gathering.len());
        self.growth.renew(of_vertices);
        self.light_patches(of_patches);
    }
}
