//! Two levels: coarse sources, fine receivers.
//!
//! # Theory
//! What a patch receives is a mean over all that it sees, so sources may be coarser than receivers (Cohen, Greenberg,
//! Immel and Brock, "An efficient radiosity approach for realistic image synthesis", IEEE Computer Graphics and
//! Applications 6(3), 1986, where sources are "patches" and receivers "elements"). Sources here are inner nodes of
//! the bisection trees, each a run of consecutive patches. The radiosity equation is solved among sources,
//!
//! B_s = E_s + rho_s sum_t F_st B_t,
//!
//! whose rows are few enough to be kept, and then each patch gathers once from what the sources have:
//!
//! H_i = sum_s F_is B_s.
//!
//! So a patch costs one row, whatever the number of iterations, and no row of patches is kept.
//!
//! # Error
//! Within a source the radiosity is a constant. Gathering averages what that misses, and the error of H falls in
//! proportion to the sources' size, or faster. [`SourceArea::Auto`](crate::settings::SourceArea::Auto) quarters the
//! sources' area until the estimate of the error is at most [`MOST_ERROR`]: the change of irradiance that the
//! last quartering has brought, over the irradiance, root mean square by area, halved. For an error in proportion to
//! h^p, h the sources' size,
//!
//! |H_h - H_0| = |H_2h - H_h| / (2^p - 1),
//!
//! which is all of the change for p = 1 and a third for p = 2; in `tests/two_levels.rs` it is 0.2 to 0.5 of it.
//!
//! Measured against the solution among all patches, models 1, 2, 3 and cornell of 5,000 to 27,000 patches: 0.12 to
//! 0.29 percent of irradiance with sources of two patches, 0.23 to 1.3 with four, and a tenth to a half of that in
//! radiosity, emission included.
//!
//! # Differences
//! Cohen et al. average the rows of a source's elements to get its own; here a source has hemicubes of its own,
//! placed as for a patch of its size.

mod gather;
mod on_sources;

pub use gather::GatherOnce;
pub use on_sources::OnSources;

use rayon::prelude::*;
use scene::{Rgb, Scene, bisection};

use crate::compact_rows::{Channels, CompactRows, Gatherer};
use crate::problem::Problem;
use crate::row_cache::RowCache;
use crate::rows::BackendError;

/// The largest error of irradiance that automatic sources may be estimated to bring, root mean square by area,
/// relative.
pub const MOST_ERROR: f64 = 0.005;

/// Sources of the first try, if the surfaces are no more.
const FEWEST_SOURCES: f64 = 1024.0;

/// The scene with patches of at most `max_area`, m^2, where this one's are smaller: its sources.
pub fn sources(scene: &Scene, max_area: f64) -> Scene {
    scene.coarsened(|id, bisections| {
        bisection::bisections_for(scene.surface(id).area(), max_area).unwrap_or(bisections)
    })
}

/// The largest areas to be tried, each a quarter of the one before, m^2.
pub fn areas_to_try(scene: &Scene) -> impl Iterator<Item = f64> {
    let first = scene.area() / FEWEST_SOURCES;
    std::iter::successors(Some(first), |area| Some(area / 4.0))
}

/// Whether `count` sources are so many more than `coarser` ones that the change between them tells of an error:
/// where most surfaces are a source each already, quartering the area changes nothing.
pub fn is_refinement(count: u32, coarser: u32) -> bool {
    count >= coarser.saturating_mul(5) / 2
}

/// Radiosities to gather from.
#[derive(Debug)]
struct Radiosities {
    channels: Channels,
    gatherer: Gatherer,
}

impl Radiosities {
    /// Of sources with these irradiances, both W/m^2, one per source.
    fn new(sources: &Problem, irradiance: &[Rgb]) -> Self {
        let radiosity = irradiance.iter().enumerate();
        Self {
            channels: Channels::new(radiosity.map(|(s, &h)| sources.radiosity(s, h))),
            gatherer: Gatherer::default(),
        }
    }

    /// The irradiances, W/m^2, of the batch's patches from patch `from` on.
    fn gather(&self, batch: &CompactRows, from: u32) -> Vec<Rgb> {
        let first = batch.receivers().start;
        (from..batch.receivers().end)
            .into_par_iter()
            .map(|patch| {
                let row = batch.row((patch - first) as usize);
                self.gatherer.irradiance(row, &self.channels)
            })
            .collect()
    }
}

/// The estimate of the error of irradiance that sources bring, whose rows these are, relative, root mean square by area: half of how
/// what is gathered changes between `irradiance`, their solution, and `coarser` irradiances; both W/m^2, one per
/// source. `None` where it is cancelled.
///
/// # Errors
/// What drawing rows that are not kept says.
pub fn estimated_error(
    rows: &mut RowCache,
    irradiance: &[Rgb],
    coarser: &[Rgb],
) -> Result<Option<f64>, BackendError> {
    let sources = rows.sources().scene();
    let problem = Problem::new(sources);
    // Both are gathered, since a solution by shooting is one of slightly different form factors.
    let both = [irradiance, coarser].map(|irradiance| Radiosities::new(&problem, irradiance));
    let (mut change, mut norm) = (0.0, 0.0);
    let mut next = 0;
    while next < sources.patch_count() {
        if rows.cancel().is_cancelled() {
            return Ok(None);
        }
        let batch = rows.batch_with(next)?;
        let [fine, coarse] = both.each_ref().map(|from| from.gather(batch, next));
        for ((source, fine), coarse) in (next as usize..).zip(fine).zip(coarse) {
            let area = problem.areas[source];
            change += area * (fine - coarse).as_dvec3().length_squared();
            norm += area * fine.as_dvec3().length_squared();
        }
        next = batch.receivers().end;
    }
    Ok(Some(if norm == 0.0 {
        0.0
    } else {
        0.5 * (change / norm).sqrt()
    }))
}
