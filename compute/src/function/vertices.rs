//! Places on surfaces as receivers: vertices, and points at which the function is checked.
//!
//! More of them come while a mesh grows, so that one back end draws for all.

use std::sync::{Arc, PoisonError, RwLock};

use glam::{DVec3, Vec3};
use scene::{Scene, SurfaceId};
use visibility::{Drawable, Frame};

use crate::receivers::{ReceiverId, Receivers, turn};
use crate::settings::Seed;

/// A place on a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// What it lies on.
    pub surface: SurfaceId,
    /// Its barycentric coordinates there, which sum to 1.
    pub barycentric: DVec3,
}

/// Places, each a receiver with one point; clones have the same ones.
#[derive(Clone, Debug)]
pub(super) struct Places<'a> {
    scene: &'a Scene,
    /// Of the same surfaces.
    drawable: Arc<Drawable<'a>>,
    seed: Seed,
    all: Arc<RwLock<Vec<Place>>>,
}

impl<'a> Places<'a> {
    /// None as yet. What is drawn may have coarser patches over the scene's surfaces.
    pub fn new(scene: &'a Scene, drawable: &Arc<Drawable<'a>>, seed: Seed) -> Self {
        Self {
            scene,
            drawable: Arc::clone(drawable),
            seed,
            all: Arc::default(),
        }
    }

    /// Adds some, which have the next numbers.
    pub fn extend(&self, places: impl IntoIterator<Item = Place>) {
        let mut all = self.all.write().unwrap_or_else(PoisonError::into_inner);
        all.extend(places);
    }

    fn get(&self, receiver: ReceiverId) -> Place {
        let all = self.all.read().unwrap_or_else(PoisonError::into_inner);
        all[receiver.0 as usize]
    }
}

impl Receivers for Places<'_> {
    fn count(&self) -> u32 {
        let all = self.all.read().unwrap_or_else(PoisonError::into_inner);
        all.len() as u32
    }

    fn frames(&self, receiver: ReceiverId) -> Vec<Frame> {
        let Place {
            surface: id,
            barycentric,
        } = self.get(receiver);
        let surface = self.scene.surface(id);
        let [a, b, c] = surface.corners.map(Vec3::as_dvec3);
        let position = barycentric.x * a + barycentric.y * b + barycentric.z * c;
        let normal = self.drawable.normal_of(id);
        let along = (b - a).reject_from_normalized(normal);
        let aligned = along
            .try_normalize()
            .unwrap_or_else(|| normal.any_orthonormal_vector());
        let turn = turn(surface, barycentric, self.seed);
        vec![Frame::at(position, normal, aligned, turn)]
    }

    fn surface(&self, receiver: ReceiverId) -> Option<SurfaceId> {
        Some(self.get(receiver).surface)
    }
}
