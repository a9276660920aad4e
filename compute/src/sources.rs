//! Sources: what the IDs in an item buffer mean, and what the radiosity equation is solved among.
//!
//! Sources are the scene's patches, or inner nodes of the surfaces' bisection trees, each a run of consecutive patches.
//! Either way they are the patches of a scene over the same surfaces, so that all that draws and solves needs no more.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;
use scene::{PatchId, Rgb, Scene};
use visibility::Drawable;

/// Index of a source.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SourceId(pub u32);

/// Sources over the patches of a scene.
#[derive(Clone, Debug)]
pub struct Sources<'a> {
    patches: &'a Scene,
    /// Of the scene whose patches the sources are.
    drawable: Arc<Drawable<'a>>,
}

impl<'a> Sources<'a> {
    /// Each patch is a source.
    pub fn patches_of(scene: &'a Scene) -> Self {
        Self::coarse(scene, scene)
    }

    /// The sources are the patches of `coarse`, a scene over the same surfaces each of whose patches is one of `scene`'s
    /// or several ([`Scene::coarsened`]).
    pub fn coarse(scene: &'a Scene, coarse: &'a Scene) -> Self {
        Self::drawn_as(scene, &Arc::new(Drawable::new(coarse)))
    }

    /// The sources are the patches of what is drawn: the same, of a scene that is laid out already.
    ///
    /// # Panics
    /// Where the surfaces are not as many.
    pub fn drawn_as(scene: &'a Scene, drawable: &Arc<Drawable<'a>>) -> Self {
        assert_eq!(scene.surfaces().len(), drawable.scene().surfaces().len());
        Self {
            patches: scene,
            drawable: Arc::clone(drawable),
        }
    }

    /// The scene whose patches they are made of.
    pub fn patches(&self) -> &'a Scene {
        self.patches
    }

    /// The scene whose patches they are.
    pub fn scene(&self) -> &'a Scene {
        self.drawable.scene()
    }

    /// What item buffers draw of them.
    pub fn drawable(&self) -> &Arc<Drawable<'a>> {
        &self.drawable
    }

    /// How many there are.
    pub fn count(&self) -> u32 {
        self.scene().patch_count()
    }

    /// True where each patch is a source.
    pub fn are_patches(&self) -> bool {
        self.count() == self.patches.patch_count()
    }

    /// The patches that a source is made of.
    pub fn patches_in(&self, source: SourceId) -> Range<u32> {
        let mesh = self.scene().mesh();
        let surface = mesh.surface_of(PatchId(source.0));
        let (coarse, fine) = (mesh.tree(surface), self.patches.mesh().tree(surface));
        fine.node(coarse.depth, source.0 - coarse.first_patch.0)
    }

    /// The mean of each source over its patches; of values of the first patches alone, that of the sources they fill.
    pub fn restricted(&self, values: &[Rgb]) -> Vec<Rgb> {
        let mut left = values;
        self.runs()
            .map_while(|length| {
                let (run, rest) = left.split_at_checked(length)?;
                left = rest;
                let sum: DVec3 = run.iter().map(|value| value.as_dvec3()).sum();
                Some((sum / length as f64).as_vec3())
            })
            .collect()
    }

    /// The value of its source for each patch; of values of the first sources alone, for the patches of these.
    pub fn prolonged(&self, values: &[Rgb]) -> Vec<Rgb> {
        self.runs()
            .zip(values)
            .flat_map(|(length, &value)| std::iter::repeat_n(value, length))
            .collect()
    }

    /// How many patches each source is made of.
    fn runs(&self) -> impl Iterator<Item = usize> {
        let fine = self.patches.mesh().trees().iter();
        let trees = fine.zip(self.scene().mesh().trees());
        trees.flat_map(|(fine, coarse)| {
            let length = 1 << (fine.depth - coarse.depth);
            std::iter::repeat_n(length, coarse.patches().len())
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_prolonged_is_restricted_to_itself() {
        let cornell = genx::Settings {
            max_area: Some(0.0005),
            ..genx::Settings::new(genx::Model::Cornell)
        };
        let scene = genx::make(&cornell).unwrap().scene;
        let coarse = scene.coarsened(|_, bisections| bisections.saturating_sub(3));
        let sources = Sources::coarse(&scene, &coarse);
        assert!(sources.count() < scene.patch_count() / 4);
        let value = |s: u32| Rgb::new(s as f32 / 3.0, 0.1, -1.0);
        let values: Vec<Rgb> = (0..sources.count()).map(value).collect();
        let fine = sources.prolonged(&values);
        assert_eq!(fine.len(), scene.patch_count() as usize);
        assert_eq!(sources.restricted(&fine), values);
        // Of an iteration that was stopped on its way.
        let some = sources.prolonged(&values[..7]);
        assert_eq!(sources.restricted(&some), values[..7]);
        for (s, value) in (0..).map(SourceId).zip(&values) {
            let mut patches = sources.patches_in(s);
            assert!(patches.all(|p| fine[p as usize] == *value));
        }
    }
}
