//! Which surfaces rise above the plane of a surface: all that its hemicubes can see.
//!
//! Found in f64, on the host, once for all hemicubes that stand on a surface; the device gets a bit for each
//! surface of the scene. What of these comes into a face it finds itself.

use glam::DVec3;
use scene::{Scene, SurfaceId};

/// The surfaces above one surface's horizon.
#[derive(Clone, Debug, Default)]
pub struct Horizon {
    own: Option<SurfaceId>,
    /// A bit for each surface.
    words: Vec<u32>,
    count: u32,
}

/// Words of a horizon over so many surfaces.
pub fn words(surface_count: usize) -> usize {
    surface_count.div_ceil(u32::BITS as usize)
}

impl Horizon {
    /// Whose it is.
    pub fn own(&self) -> Option<SurfaceId> {
        self.own
    }

    /// A bit for each surface.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// How many surfaces there are.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Finds the surfaces that rise above the plane of `own`, where all its hemicubes stand, with the cpu's
    /// tolerance. `normal` is theirs.
    pub fn find(&mut self, scene: &Scene, own: SurfaceId, normal: DVec3, tolerance: f64) {
        if self.own == Some(own) {
            return;
        }
        let height = |p: glam::Vec3| p.as_dvec3().dot(normal);
        let own_height = height(scene.surface(own).corners[0]);
        let own_reach = visibility::reach(scene.surface(own));
        self.own = Some(own);
        self.words.clear();
        self.words.resize(words(scene.surfaces().len()), 0);
        for (index, surface) in scene.surfaces().iter().enumerate() {
            let reach = visibility::reach(surface).max(own_reach);
            let is_above = surface.corners.into_iter().any(|p| {
                let above = height(p) - own_height;
                above > 0.0 && !visibility::is_in_plane(above, tolerance, normal, reach)
            });
            let bit = u32::from(is_above && index != own.index());
            self.words[index / u32::BITS as usize] |= bit << (index % u32::BITS as usize);
        }
        self.count = self.words.iter().map(|word| word.count_ones()).sum();
    }
}
