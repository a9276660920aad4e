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
//! The user's patches are no matter: where they are more than some thousand, sources are coarser. What a source receives on the mean
//! its own row does not know where light varies, but the function does, so that the equation is solved again with what it says
//! ([`Resolve`]) whenever it is checked. Power is balanced by that: what a wall sends out is what the function says that it receives.
//!
//! Sources are still one value each, and near a contact that is too bright. Where that matters, each vertex gathers once more by the
//! function itself, at each pixel's own place, less by the sources: the difference is added, and what the next such
//! difference would be, reflected around the scene as ambient light, is what is left of the error.
//!
//! Of many samples the first that looks good is a lucky one, so that what it says is not what is stated: others are drawn.
//!
//! A side of a wall holds the plane of the next one, so a vertex there gathers a little inside of the triangle that it came
//! with.

mod carried;
mod checks;
mod direct;
mod gatherer;
mod gradients;
mod growth;
mod layers;
mod lit_mesh;
mod making;
mod means;
mod patches;
mod report;
mod roots;
mod second_look;
mod vertices;

use std::time::Duration;

use glam::DVec3;
use scene::function::{IrradianceFunction, NodeId, Refinement, VertexId};
use scene::layers::Layer;
use scene::{PatchId, Rgb, Scene, SceneError, SurfaceId};
use visibility::Drawable;

use crate::cancel::CancelToken;
use crate::compact_rows::Row;
use crate::rows::BackendError;
use crate::settings::Target;
use crate::sources::Sources;
use vertices::Place;

pub use carried::carried_over;
pub use layers::SourceLayer;
pub use making::gather;
pub use patches::{MeansOfPatches, means_of_patches};
pub use report::{Cause, ErrorByCause, Errors, FunctionEnd, FunctionReport};

/// Leaves are at most this share of the scene's area.
const COARSEST: f64 = 1.0 / 512.0;

/// How far inside of the triangle that it came with a vertex on a wall's side gathers, as a share of the way to its middle.
const INSET: f64 = 1.0 / 64.0;

/// The share of the mean radiosity below which differences of what is visible count for less and less.
pub(crate) const VISIBLE_FLOOR: f64 = 0.05;

/// How much longer the next round is taken to be than the last one, when time is short.
const NEXT_ROUND: f64 = 1.5;

/// What a function is gathered for, and until when.
#[derive(Clone, Copy)]
pub struct Order<'o> {
    /// What is asked for.
    pub target: Target,
    /// How far the solution is from where its solver goes, relative; `None` where nobody knows.
    pub iterations: Option<f64>,
    /// Which surfaces light can reach.
    pub is_lit: &'o dyn Fn(SurfaceId) -> bool,
    /// Whether patches without vertices gather, too, though they have what they received among sources: where the solution is not
    /// what they would gather from it.
    pub all_gather: bool,
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

/// What is known of what a source receives from what all sources send out, W/m^2.
#[derive(Clone, Copy, Debug)]
pub enum Receives {
    /// This, on the mean.
    OnTheMean(DVec3),
    /// What its row says, and this.
    BesidesItsRow(DVec3),
}

/// Who solves the equation once more.
pub trait Resolve {
    /// What sources receive, W/m^2, one per source, where this is known of what they receive from what all send out now. `None`
    /// where it is cancelled, or is to stay as it was solved.
    ///
    /// # Errors
    /// What a back end says.
    fn resolve(&mut self, known: &[Receives]) -> Result<Option<Vec<Rgb>>, BackendError>;

    /// The parts that what sources receive is to be taken apart into; `None` where nobody asks for them, or it is cancelled.
    ///
    /// # Errors
    /// What a back end says.
    fn layers(&mut self) -> Result<Option<Vec<SourceLayer>>, BackendError>;

    /// Hands out the rows of sources to each other, those that light cannot reach left out. False where there are none, or it is
    /// cancelled.
    ///
    /// # Errors
    /// What a back end says.
    fn for_each_row(&mut self, take: &mut dyn FnMut(usize, Row)) -> Result<bool, BackendError>;
}

/// A function, and what goes with it.
#[derive(Clone, Debug)]
pub struct Gathered {
    /// With the estimates of its error.
    pub function: IrradianceFunction,
    /// What is said of it.
    pub report: FunctionReport,
    /// What patches receive, W/m^2, one per patch: as much as their sources, or where they have no vertices and are smaller than
    /// these, what they have gathered themselves.
    pub irradiance: Vec<Rgb>,
    /// Parts of the light that [`Resolve::layers`] tells of.
    pub layers: Option<Vec<Layer>>,
}

impl Gathered {
    /// Whether somebody stopped it.
    pub fn is_interrupted(&self) -> bool {
        self.report.stopped_by == FunctionEnd::Interrupt
    }
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

/// Patches that light can reach and that have no vertices, but are smaller than their sources, or all of them.
fn gathering_patches(sources: &Sources, mesh: &Refinement, order: &Order) -> Vec<PatchId> {
    let scene = sources.patches();
    let trees = (0..).map(SurfaceId).zip(scene.mesh().trees());
    let coarse = sources.scene().mesh();
    let gathering = trees.filter(|&(surface, tree)| {
        let is_finer = tree.depth > coarse.tree(surface).depth;
        (is_finer || order.all_gather) && !mesh.has_vertices(surface) && (order.is_lit)(surface)
    });
    let patches = gathering.flat_map(|(_, tree)| tree.patches().map(PatchId));
    patches.collect()
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
