//! Up to nine views that are kept and gone back to.

use crate::camera_control::Pose;

/// How many views there are: those of the keys 1 to 9.
pub const COUNT: usize = 9;

/// The views, each at its number less one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SavedViews([Option<Pose>; COUNT]);

impl SavedViews {
    /// Keeps a view in place of what was there. Nothing happens beyond the last one.
    pub fn store(&mut self, index: usize, pose: Pose) {
        if let Some(place) = self.0.get_mut(index) {
            *place = Some(pose);
        }
    }

    /// The view that is kept there.
    pub fn recall(&self, index: usize) -> Option<Pose> {
        self.0.get(index).copied().flatten()
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    #[test]
    fn each_of_nine_views_is_recalled_as_it_was_stored() {
        let pose = |k: usize| Pose {
            target: DVec3::splat(k as f64),
            forward: DVec3::X,
            distance: 1.0,
        };
        let mut views = SavedViews::default();
        for k in 0..COUNT + 3 {
            assert_eq!(views.recall(k), None);
            views.store(k, pose(k));
        }
        for k in 0..COUNT + 3 {
            assert_eq!(views.recall(k), (k < COUNT).then(|| pose(k)));
        }
    }
}
