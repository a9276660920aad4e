//! The irradiance function: gathered at the vertices of a mesh that grows where light varies.
//!
//! # Theory
//! The radiosity equation is solved among patches, or coarser sources. Then H(x) = sum_j F_j(x) B_j is gathered at vertices, from
//! all sources j (a final gather: Reichert, "A two-pass radiosity method driven by lights and viewer position", 1992), and is
//! linear between them. Two errors tell how far it is from what it would be with vertices everywhere, both without the
//! emission of emitters, over the area A that light can reach and all channels:
//!
//! power error: sqrt(sum A (rho H - rho H')^2 / sum A (rho H')^2)
//!
//! visible error: sqrt(mean over A of ((B - B') / (B' + 0.05 mean B'))^2), B = rho H
//!
//! The second is what an eye minds that has adapted to the scene: what is wrong in a dark corner counts as much as in a
//! bright one, down to a twentieth of the mean.
//!
//! # Practice
//! Leaves whose corners differ most, by area, are bisected, as many as make a share of the sum (Doerfler, "A convergent
//! adaptive algorithm for Poisson's equation", SIAM J. Numer. Anal. 33(3), 1996). What is left is measured, not inferred: at
//! points that are no vertices, chosen by chance in leaves by their share of the sum, the function is compared with what is
//! gathered there; each difference stands for as much area as it was likely to be missed. Leaves in which a difference
//! is large are bisected though their corners say nothing.
//!
//! A side of a wall holds the plane of the next one, so a vertex there gathers a little inside of the triangle that it came
//! with.

mod growth;
mod roots;
mod second_look;
mod vertices;

use std::sync::Arc;

use glam::DVec3;
use scene::function::{IrradianceFunction, NodeId, Refinement, VertexId};
use scene::{Rgb, Scene, Solution, SurfaceId};
use serde::Serialize;
use visibility::Drawable;

use crate::FormFactors;
use crate::backend::Backend;
use crate::cancel::CancelToken;
use crate::problem::Problem;
use crate::receivers::Receivers;
use crate::rows::{BackendError, Entry, UNITS_PER_ONE};
use crate::settings::{FormFactorSettings, Target};
use crate::sources::Sources;
use growth::Growth;
use second_look::{Reflected, SecondLook};
use vertices::{Place, Places};

/// Two errors of a function, relative.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Errors {
    /// What is wrong, over what is right, root mean square over the area.
    pub power: f64,
    /// The same of what is wrong over what is right in each place.
    pub visible: f64,
}

/// What a function came to.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct FunctionReport {
    /// How many vertices it has.
    pub vertices: u32,
    /// How many triangles.
    pub triangles: u32,
    /// Share of the scene's area that has vertices; the rest has what its patches have, and no estimate of its error.
    pub covered: f64,
    /// Points at which it was checked.
    pub checks: u32,
    /// Estimates of its error, by cause; null where nothing has vertices.
    pub error: Option<ErrorByCause>,
    /// Whether that is as small as was asked for.
    pub is_reached: bool,
}

/// What makes a function wrong, as far as is known.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct ErrorByCause {
    /// All causes together.
    pub total: Errors,
    /// That it is linear between vertices.
    pub mesh: Errors,
    /// That sources are as large as they are.
    pub sources: Errors,
    /// That hemicubes have pixels.
    pub pixels: Errors,
    /// That the iteration came to an end.
    pub iterations: Errors,
}

impl ErrorByCause {
    /// Causes that know nothing of each other add up in squares.
    fn new(mesh: Errors, sources: Errors, pixels: Errors, iterations: Errors) -> Self {
        let total = |of: fn(&Errors) -> f64| {
            let causes = [mesh, sources, pixels, iterations];
            causes
                .iter()
                .map(|cause| of(cause).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        Self {
            total: Errors {
                power: total(|errors| errors.power),
                visible: total(|errors| errors.visible),
            },
            mesh,
            sources,
            pixels,
            iterations,
        }
    }

    /// The cause that has most of the power error.
    fn worst(&self) -> &'static str {
        let causes = [
            (self.mesh, "the mesh"),
            (self.sources, "the size of patches"),
            (self.pixels, "pixels"),
            (self.iterations, "iterations"),
        ];
        let worst = causes
            .iter()
            .max_by(|(a, _), (b, _)| a.power.total_cmp(&b.power));
        worst.map_or("", |(_, name)| name)
    }
}

impl std::fmt::Display for FunctionReport {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Some(error) = &self.error else {
            return f.write_str("not known: no wall that light reaches is large enough");
        };
        let Errors { power, visible } = error.total;
        write!(
            f,
            "{:.2} % power, {:.2} % visible, mostly by {}; {} vertices",
            100.0 * power,
            100.0 * visible,
            error.worst(),
            self.vertices
        )?;
        if self.covered < MOSTLY {
            write!(f, " on {:.0} % of the area", 100.0 * self.covered)?;
        }
        if !self.is_reached {
            f.write_str("; more than was asked for")?;
        }
        Ok(())
    }
}

/// The share of the area that has vertices from which on nothing is said of the rest.
const MOSTLY: f64 = 0.95;

/// Leaves are at most this share of the scene's area.
const COARSEST: f64 = 1.0 / 512.0;

/// How far inside of the triangle that it came with a vertex on a wall's side gathers, as a share of the way to its middle.
const INSET: f64 = 1.0 / 64.0;

/// What places on surfaces receive from solved sources.
struct Gatherer<'a> {
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
}

/// Irradiance and the direct part of it, W/m^2.
pub(super) type Light = [DVec3; 2];

impl<'a> Gatherer<'a> {
    /// What a solution of the patches that `sources` are made of sends out.
    fn new(
        form_factors: &FormFactors<'a>,
        sources: Sources<'a>,
        solution: &Solution,
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
        })
    }

    /// What some more places receive; `None` where it is cancelled.
    fn gather(
        &mut self,
        places: &[Place],
        cancel: &CancelToken,
    ) -> Result<Option<Vec<Light>>, BackendError> {
        self.places.extend(places.iter().copied());
        let end = self.places.count();
        let mut lights = Vec::with_capacity(places.len());
        while self.done < end {
            if cancel.is_cancelled() {
                return Ok(None);
            }
            let batch = self.backend.source.preferred_batch().max(1);
            let next = end.min(self.done.saturating_add(batch));
            let rows = self.backend.source.draw_rows(self.done..next)?;
            self.done = next;
            lights.extend((0..rows.receivers().len()).map(|k| {
                [&self.radiosity, &self.emission].map(|exitances| sum(rows.row(k), exitances))
            }));
        }
        Ok(Some(lights))
    }

    /// What places receive of reflected light once more, see [`SecondLook`].
    fn look_again(&self, function: &IrradianceFunction, places: &[Place]) -> Vec<Reflected> {
        let radiosity = self.radiosity.iter().zip(&self.emission);
        let reflected: Vec<Rgb> = radiosity.map(|(&b, &e)| b - e).collect();
        let FormFactorSettings {
            resolution,
            maps,
            seed,
            ..
        } = self.settings;
        SecondLook {
            drawable: &self.drawable,
            resolution,
            maps,
            seed,
            reflected: &reflected,
            function,
        }
        .at(places)
    }
}

/// The sum over a row of the form factors times some exitances, one per source, W/m^2.
fn sum(row: &[Entry], exitances: &[Rgb]) -> DVec3 {
    let terms = row
        .iter()
        .map(|entry| f64::from(entry.units) * exitances[entry.source as usize].as_dvec3());
    terms.sum::<DVec3>() / f64::from(UNITS_PER_ONE)
}

/// What a function is gathered for, and until when.
#[derive(Clone, Copy)]
pub struct Order<'o> {
    /// What is asked for.
    pub target: Target,
    /// How far the solution is from where its solver goes, relative.
    pub iterations: f64,
    /// Which surfaces light can reach.
    pub is_lit: &'o dyn Fn(SurfaceId) -> bool,
    /// Whether the time is over.
    pub is_late: &'o dyn Fn() -> bool,
    /// Stops it.
    pub cancel: &'o CancelToken,
}

/// Gathers the function of a solution from `sources` over its patches, with as many vertices as the target asks for, or as there
/// is time for. `None` where it is cancelled.
///
/// # Errors
/// A back end that does not open or cannot go on.
pub fn gather<'a>(
    form_factors: &FormFactors<'a>,
    sources: Sources<'a>,
    solution: &Solution,
    order: &Order,
) -> Result<Option<(IrradianceFunction, FunctionReport)>, BackendError> {
    let Order {
        target,
        iterations,
        is_lit,
        is_late,
        cancel,
    } = *order;
    let scene = sources.patches();
    let drawable = Arc::clone(sources.drawable());
    let mut mesh = roots::roots(scene, &drawable, is_lit);
    let mut gatherer = Gatherer::new(form_factors, sources, solution)?;
    let iterations = Errors {
        power: iterations,
        visible: iterations,
    };
    let coarsest = COARSEST * scene.area();
    loop {
        let large: Vec<NodeId> = mesh
            .leaves()
            .filter(|&leaf| mesh.area(leaf) > coarsest)
            .collect();
        if large.is_empty() {
            break;
        }
        for leaf in large {
            mesh.bisect(leaf);
        }
    }
    let mut growth = Growth::new(scene, mesh, target);
    let mut report = FunctionReport {
        vertices: 0,
        triangles: 0,
        covered: growth.area() / scene.area(),
        checks: 0,
        error: None,
        is_reached: false,
    };
    loop {
        let new = growth.new_vertices();
        let places: Vec<Place> = new.map(|vertex| place(growth.mesh(), vertex)).collect();
        let Some(lights) = gatherer.gather(&places, cancel)? else {
            return Ok(None);
        };
        growth.take(lights);
        let is_last = growth.is_full() || is_late();
        if is_last || growth.wants_checks() {
            let checks = growth.checks();
            let places: Vec<Place> = checks.iter().map(|check| check.place).collect();
            let Some(lights) = gatherer.gather(&places, cancel)? else {
                return Ok(None);
            };
            let Some(function) = growth.function() else {
                return Ok(None);
            };
            let second = gatherer.look_again(&function, &places);
            let [sources, pixels] = growth.causes(&checks, &lights, &second);
            let mesh = growth.compare(&checks, &lights);
            let error = ErrorByCause::new(mesh, sources, pixels, iterations);
            growth.ask(&error);
            report.checks += checks.len() as u32;
            if is_last || growth.is_reached(error.total) || growth.is_enough(mesh) {
                report.error = (report.covered > 0.0).then_some(error);
                report.is_reached = report.error.is_some() && growth.is_reached(error.total);
                report.vertices = growth.mesh().vertex_count();
                report.triangles = growth.mesh().leaves().count() as u32;
                return Ok(Some((function, report)));
            }
        }
        growth.grow();
    }
}

/// Where a vertex gathers.
fn place(mesh: &Refinement, vertex: VertexId) -> Place {
    let (surface, [vertex, inside]) = mesh.place_of(vertex);
    Place {
        surface,
        barycentric: vertex.lerp(inside, INSET),
    }
}

/// The reflectance of each surface, dimensionless.
pub(super) fn reflectances(scene: &Scene) -> Vec<DVec3> {
    let materials = scene
        .surfaces()
        .iter()
        .map(|surface| scene.material(surface.material));
    materials
        .map(|material| material.reflectance.as_dvec3())
        .collect()
}
