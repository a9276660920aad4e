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
//! is large are bisected though their corners say nothing. What neither corners nor chance would find, the spot of a lamp a hand's
//! breadth before a wall, the closed form of its unhidden light does (`direct.rs`).
//!
//! Sources are one value each, and near a contact that is too bright. Where that matters, each vertex gathers once more by the
//! function itself, at each pixel's own place, less by the sources: the difference is added, and what the next such
//! difference would be is what is left of the error. Either is reflected around the scene, which its mean tells, as ambient light.
//!
//! Of many samples the first that looks good is a lucky one, so that what it says is not what is stated: others are drawn.
//!
//! A side of a wall holds the plane of the next one, so a vertex there gathers a little inside of the triangle that it came
//! with.

mod checks;
mod direct;
mod gatherer;
mod growth;
mod lit_mesh;
mod report;
mod roots;
mod second_look;
mod vertices;

use std::time::{Duration, Instant};

use glam::DVec3;
use scene::function::{IrradianceFunction, NodeId, Refinement, VertexId};
use scene::{PatchId, Scene, SceneError, Solution, SurfaceId};
use visibility::Drawable;

use crate::FormFactors;
use crate::cancel::CancelToken;
use crate::rows::BackendError;
use crate::settings::Target;
use crate::sources::Sources;
use checks::Sample;
use gatherer::Gatherer;
use growth::Growth;
use lit_mesh::{FlatPatch, LitMesh};
use vertices::Place;

pub use report::{Cause, ErrorByCause, Errors, FunctionEnd, FunctionReport};

/// Leaves are at most this share of the scene's area.
const COARSEST: f64 = 1.0 / 512.0;

/// How far inside of the triangle that it came with a vertex on a wall's side gathers, as a share of the way to its middle.
const INSET: f64 = 1.0 / 64.0;

/// How many other samples have to confirm together that the error is as small as was asked for.
const CONFIRMATIONS: u32 = 2;

/// How much longer the next round is taken to be than the last one, when time is short.
const NEXT_ROUND: f64 = 1.5;

/// One point in so many looks a second time.
const LOOK_EVERY: usize = 4;

/// What a function is gathered for, and until when.
#[derive(Clone, Copy)]
pub struct Order<'o> {
    /// What is asked for.
    pub target: Target,
    /// How far the solution is from where its solver goes, relative.
    pub iterations: f64,
    /// Which surfaces light can reach.
    pub is_lit: &'o dyn Fn(SurfaceId) -> bool,
    /// Whether the time is over after so much more of it.
    pub is_late: &'o dyn Fn(Duration) -> bool,
    /// Stops it.
    pub cancel: &'o CancelToken,
}

/// Why there is no function.
#[derive(Debug, thiserror::Error)]
#[allow(missing_docs)] // the messages say it
pub enum FunctionFault {
    #[error(transparent)]
    Backend(#[from] BackendError),
    #[error("there is no irradiance function: {0}")]
    Values(#[from] SceneError),
}

/// Gathers the function of a solution from `sources` over its patches, with as many vertices as the target asks for, or as there
/// is time for. `None` where it is cancelled.
///
/// # Errors
/// A back end that does not open or cannot go on, and values that no f32 holds.
pub fn gather<'a>(
    form_factors: &FormFactors<'a>,
    sources: Sources<'a>,
    solution: &Solution,
    order: &Order,
) -> Result<Option<(IrradianceFunction, FunctionReport)>, FunctionFault> {
    let scene = sources.patches();
    let mesh = first_mesh(scene, sources.drawable(), order.is_lit);
    let flat = flat_patches(scene, &mesh, solution, order.is_lit);
    let mut growth = Growth::new(LitMesh::new(scene, mesh, flat), order.target);
    let mut gatherer = Gatherer::new(form_factors, sources, solution, order.cancel)?;
    let covered = growth.lit().area() / scene.area();
    let iterations = Errors::splat(order.iterations);
    let mut can_grow = true;
    // What the next round is likely to take.
    let mut next = Duration::ZERO;
    loop {
        let start = Instant::now();
        let new = growth.lit().new_vertices();
        let places: Vec<Place> = new
            .map(|vertex| place(growth.lit().mesh(), vertex))
            .collect();
        let Some(lights) = gatherer.gather(&places)? else {
            return Ok(None);
        };
        growth.take(lights);
        let is_late = (order.is_late)(next);
        let is_last = growth.is_full() || is_late || !can_grow;
        if is_last || growth.wants_checks() {
            let function = growth.lit().function()?;
            let Some(mut sample) = sampled(&mut growth, &mut gatherer, &function, 1)? else {
                return Ok(None);
            };
            let mut error = growth.judge(&sample, iterations);
            // Who believes the first sample that looks good has been lucky as a rule: other ones tell.
            if growth.is_reached(error.total) {
                let others = sampled(&mut growth, &mut gatherer, &function, CONFIRMATIONS)?;
                let Some(others) = others else {
                    return Ok(None);
                };
                sample = others;
                error = growth.judge(&sample, iterations);
            }
            let check_count = sample.checks.len() as u32;
            let can_refine = !is_last && !gatherer.is_refined();
            growth.ask(&error, can_refine);
            if can_refine && growth.wants_finer_sources(&error) && growth.is_enough(error.mesh) {
                let mesh = growth.lit().mesh();
                let vertices = (0..mesh.vertex_count()).map(VertexId);
                let places: Vec<Place> = vertices.map(|vertex| place(mesh, vertex)).collect();
                let Some(finer) = gatherer.refine(function, &places) else {
                    return Ok(None);
                };
                gatherer.add_ambient(growth.add(&finer));
                continue;
            }
            let is_reached = growth.is_reached(error.total);
            let end = if is_reached {
                Some(FunctionEnd::Error)
            } else if growth.is_full() {
                Some(FunctionEnd::Vertices)
            } else if is_late {
                Some(FunctionEnd::TimeLimit)
            } else if !can_grow || growth.is_enough(error.mesh) || growth.is_stuck(error.mesh) {
                Some(FunctionEnd::OtherCauses)
            } else {
                None
            };
            if let Some(stopped_by) = end {
                let patch_errors = growth.patch_errors(&error);
                let is_known = check_count > 0;
                let mesh = growth.lit().mesh();
                let report = FunctionReport {
                    vertices: mesh.vertex_count(),
                    triangles: mesh.leaves().count() as u32,
                    covered,
                    checks: check_count,
                    error: is_known.then_some(error),
                    is_reached,
                    stopped_by,
                    mostly_by: is_known.then(|| error.worst(&order.target)),
                    mostly_on: report::worst_object(scene, &patch_errors),
                };
                let function = function.with_error(patch_errors)?;
                return Ok(Some((function, report)));
            }
        }
        can_grow = growth.grow();
        next = start.elapsed().mul_f64(NEXT_ROUND);
    }
}

/// What is found in so many rounds of checks; `None` where it is cancelled.
fn sampled(
    growth: &mut Growth,
    gatherer: &mut Gatherer,
    function: &IrradianceFunction,
    rounds: u32,
) -> Result<Option<Sample>, BackendError> {
    let mut sample = Sample::default();
    for _ in 0..rounds {
        let checks = growth.checks();
        let places: Vec<Place> = checks.iter().map(|check| check.place).collect();
        let Some(lights) = gatherer.gather(&places)? else {
            return Ok(None);
        };
        // Which cost several times what gathering does, and find much the same everywhere.
        let again: Vec<usize> = (0..places.len()).step_by(LOOK_EVERY).collect();
        let places: Vec<Place> = again.iter().map(|&k| places[k]).collect();
        let Some(looks) = gatherer.look_again(function, &places) else {
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

/// The mesh to begin with.
fn first_mesh(
    scene: &Scene,
    drawable: &Drawable,
    is_lit: &dyn Fn(SurfaceId) -> bool,
) -> Refinement {
    let mut mesh = roots::roots(scene, drawable, is_lit);
    let coarsest = COARSEST * scene.area();
    loop {
        let leaves = mesh.leaves();
        let large: Vec<NodeId> = leaves.filter(|&leaf| mesh.area(leaf) > coarsest).collect();
        if large.is_empty() {
            return mesh;
        }
        for leaf in large {
            mesh.bisect(leaf);
        }
    }
}

/// What light can reach and reflects it, but has no vertices.
fn flat_patches(
    scene: &Scene,
    mesh: &Refinement,
    solution: &Solution,
    is_lit: &dyn Fn(SurfaceId) -> bool,
) -> Vec<FlatPatch> {
    let trees = (0..).map(SurfaceId).zip(scene.mesh().trees());
    let flat = trees.filter(|&(surface, _)| !mesh.has_vertices(surface) && is_lit(surface));
    let patches = flat.flat_map(|(surface, tree)| {
        let surface = scene.surface(surface);
        let rho = scene.material(surface.material).reflectance.as_dvec3();
        let area = surface.area() / f64::from(1_u32 << tree.depth);
        tree.patches().map(PatchId).map(move |patch| FlatPatch {
            patch,
            area,
            radiosity: rho * solution.irradiance[patch.index()].as_dvec3(),
        })
    });
    patches
        .filter(|patch| patch.radiosity != DVec3::ZERO)
        .collect()
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
