//! What is solved instead of a scene: the same walls in as many triangles and patches as the error asks for.

use scene::{PatchId, Rgb, Scene};

use crate::finer::Finer;
use crate::form_factors::area_of_function_sources;
use crate::settings::{SolveSettings, SourceArea, Target};
use crate::walls::Walls;

/// A scene that stands in for another one.
pub enum StandIn<'a> {
    /// Walls that come as many more triangles than sources need be.
    Walls(Walls<'a>),
    /// Surfaces in patches that are larger than sources may be.
    Finer(Finer<'a>),
}

impl<'a> StandIn<'a> {
    /// What is solved instead of a scene, and what is asked of its function; `None` where the scene is solved as it is.
    pub fn to_solve(original: &'a Scene, settings: &SolveSettings) -> Option<(Self, Target)> {
        let target = settings.function()?;
        if settings.solution.source_area != SourceArea::Auto {
            return None;
        }
        let max_area = area_of_function_sources(original, target);
        // A wall may be of two lamps.
        let is_apart = settings.layers.is_some();
        let walls = (!is_apart).then(|| Walls::of(original, max_area)).flatten();
        let walls = walls.map(Self::Walls);
        let stand_in = walls.or_else(|| Finer::of(original, max_area).map(Self::Finer));
        Some((stand_in?, target))
    }

    /// What it stands in for.
    pub fn original(&self) -> &'a Scene {
        match self {
            Self::Walls(walls) => walls.original(),
            Self::Finer(finer) => finer.original(),
        }
    }

    /// What stands in for it.
    pub fn scene(&self) -> &Scene {
        match self {
            Self::Walls(walls) => walls.scene(),
            Self::Finer(finer) => finer.scene(),
        }
    }

    /// Values of the original's patches, from those of what stands in for it.
    pub fn values(&self, values: &[Rgb]) -> Vec<Rgb> {
        match self {
            Self::Walls(walls) => walls.values(values),
            Self::Finer(finer) => finer.values(values),
        }
    }

    /// The original's patches, ascending, that lie in these of what stands in for it, which ascend, too.
    pub fn lying_in(&self, patches: &[PatchId]) -> Vec<PatchId> {
        let is_in = |patch: PatchId| patches.binary_search(&patch).is_ok();
        let lies_in = |patch: &PatchId| match self {
            Self::Walls(walls) => is_in(walls.patch_of(*patch)),
            Self::Finer(finer) => finer.patches_in(*patch).map(PatchId).all(is_in),
        };
        let original = (0..self.original().patch_count()).map(PatchId);
        original.filter(lies_in).collect()
    }

    /// A patch of the original that has something of this one.
    pub fn patch_with(&self, patch: PatchId) -> PatchId {
        let has = |original: &PatchId| match self {
            Self::Walls(walls) => walls.patch_of(*original) == patch,
            Self::Finer(finer) => finer.patches_in(*original).contains(&patch.0),
        };
        let mut original = (0..self.original().patch_count()).map(PatchId);
        original.find(has).unwrap_or(PatchId(0))
    }
}
