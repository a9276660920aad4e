//! A scene in smaller patches than its own, on which it is solved instead.
//!
//! Who leaves a wall whole in a scene's file wants it to be meshed as the light asks for. Sources are at most as large as patches,
//! and one value each: two triangles of a floor would be two of them, whatever stands there. So surfaces whose patches are much
//! larger than sources may be are bisected, and what comes of it is put together again: the function's mesh has the same surfaces,
//! and fits as it is.

use std::ops::Range;

use glam::DVec3;
use scene::function::IrradianceFunction;
use scene::{PatchId, Rgb, Scene, SceneError, bisection};

/// Patches are too large where they have so many times the area that sources may have, or more. What less brings is left to the
/// function, which tells what varies within sources.
const TOO_LARGE: f64 = 4.0;

/// Sources that are sought this way have at least this share of the scene's area.
const FINEST: f64 = 1.0 / 8192.0;

/// A scene in smaller patches.
pub struct Finer<'a> {
    original: &'a Scene,
    scene: Scene,
}

impl<'a> Finer<'a> {
    /// A scene whose patches have at most so many m^2 where they were much larger; `None` where they were not anywhere, and where
    /// they would be more than there may be.
    pub fn of(original: &'a Scene, max_area: f64) -> Option<Self> {
        let max_area = max_area.max(FINEST * original.area());
        let scene = original.refined(|surface, depth| {
            let area = original.surface(surface).area();
            let is_too_large = area / f64::from(1_u32 << depth) >= TOO_LARGE * max_area;
            let wanted = bisection::bisections_for(area, max_area);
            wanted.filter(|_| is_too_large).unwrap_or(depth)
        });
        let scene = scene.ok()?;
        let is_finer = scene.patch_count() > original.patch_count();
        is_finer.then_some(Self { original, scene })
    }

    /// What it was made of.
    pub fn original(&self) -> &'a Scene {
        self.original
    }

    /// The scene in smaller patches.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The patches that a patch of the original is made of.
    pub fn patches_in(&self, patch: PatchId) -> Range<u32> {
        let surface = self.original.mesh().surface_of(patch);
        let coarse = self.original.mesh().tree(surface);
        let fine = self.scene.mesh().tree(surface);
        fine.node(coarse.depth, patch.0 - coarse.first_patch.0)
    }

    /// Means over the original's patches of values of the smaller ones.
    pub fn values(&self, of_finer: &[Rgb]) -> Vec<Rgb> {
        self.over_patches(of_finer, |values| {
            let sum: DVec3 = values.iter().map(|value| value.as_dvec3()).sum();
            (sum / values.len() as f64).as_vec3()
        })
    }

    /// The original's function, from that of the smaller patches: with root mean squares of their errors, if it has them.
    ///
    /// # Errors
    /// None but for errors that are none.
    pub fn put_together(
        &self,
        of_finer: &IrradianceFunction,
    ) -> Result<IrradianceFunction, SceneError> {
        if of_finer.error().is_empty() {
            return Ok(of_finer.clone());
        }
        let errors = self.over_patches(of_finer.error(), |errors| {
            let squares = errors.iter().map(|&error| f64::from(error).powi(2));
            (squares.sum::<f64>() / errors.len() as f64).sqrt() as f32
        });
        of_finer.clone().with_error(errors)
    }

    /// One value a patch of the original from those of the smaller ones, which all have the same area.
    fn over_patches<T>(&self, of_finer: &[T], one: impl Fn(&[T]) -> T) -> Vec<T> {
        let patches = (0..self.original.patch_count()).map(PatchId);
        let of_patch = |patch| {
            let Range { start, end } = self.patches_in(patch);
            one(&of_finer[start as usize..end as usize])
        };
        patches.map(of_patch).collect()
    }
}
