//! The surfaces that rise above a horizon: all that the hemicubes on one surface can see.
//!
//! They are found in f64, on the host, once for all hemicubes that stand on a surface; the device gets a bit for each
//! surface of the scene. What of these comes into a face it finds itself.

use glam::DVec3;
use scene::{Scene, SurfaceId};
use visibility::Frame;

/// The surfaces above one horizon.
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
    /// A bit for each surface.
    pub fn words(&self) -> &[u32] {
        &self.words
    }

    /// How many surfaces there are.
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Finds the surfaces that rise above the horizon of the hemicube at `frame`, with the cpu's tolerance; all
    /// hemicubes on the surface `own` have the same.
    pub fn find(&mut self, scene: &Scene, own: Option<SurfaceId>, frame: &Frame, tolerance: f64) {
        if own.is_some() && self.own == own {
            return;
        }
        let normal = frame.normal;
        let height = |p: DVec3| p.dot(normal);
        let (own_point, own_reach) = match own.map(|own| scene.surface(own)) {
            Some(surface) => (surface.corners[0].as_dvec3(), visibility::reach(surface)),
            None => (frame.position, frame.position.abs()),
        };
        let own_height = height(own_point);
        self.own = own;
        self.words.clear();
        self.words.resize(words(scene.surfaces().len()), 0);
        for (index, surface) in scene.surfaces().iter().enumerate() {
            let reach = visibility::reach(surface).max(own_reach);
            let is_above = surface.corners.into_iter().any(|p| {
                let above = height(p.as_dvec3()) - own_height;
                above > 0.0 && !visibility::is_in_plane(above, tolerance, normal, reach)
            });
            let is_own = own.is_some_and(|own| own.index() == index);
            let bit = u32::from(is_above && !is_own);
            self.words[index / u32::BITS as usize] |= bit << (index % u32::BITS as usize);
        }
        self.count = self.words.iter().map(|word| word.count_ones()).sum();
    }
}
