//! Receivers: where hemicubes stand.
//!
//! A receiver is one point with a normal, or several whose rows are averaged: a rule of equal weights. Its row is what
//! its points see of the [sources](crate::sources), in the mean. The receivers of a solver are the scene's
//! [patches](Patches); those of a measurement are [`Sensors`]. Nothing that draws rows asks which of them it has.

mod patches;
mod point_count;
mod rule;
mod sensors;
mod turn;

use std::fmt::Debug;

use glam::DVec3;
use scene::SurfaceId;
use visibility::Frame;

pub use patches::{Closer, Patches};
pub use sensors::{Sensor, Sensors};
pub(crate) use turn::{mixed, turn};

/// How many points the rule of equal weights and a higher order than the centroid's has that has so many or more, as far as there is
/// one.
pub(crate) fn count_of_at_least(points: u32) -> u32 {
    rule::Rule::of_at_least(points).count()
}

/// The points of that rule in a triangle.
pub(crate) fn points_in(corners: [DVec3; 3], at_least: u32) -> Vec<DVec3> {
    rule::Rule::of_at_least(at_least).points(corners)
}

/// Index of a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ReceiverId(pub u32);

/// Points with normals, in groups under rules of equal weights.
///
/// Points are numbered through all receivers, one receiver's after the other's. A receiver has one, unless its kind says otherwise.
pub trait Receivers: Debug + Send + Sync {
    /// How many receivers there are.
    fn count(&self) -> u32;

    /// How many points a receiver has.
    fn point_count(&self, _receiver: ReceiverId) -> u32 {
        1
    }

    /// Number of a receiver's first point; for the receiver after the last one, the number of all.
    fn first_point(&self, receiver: ReceiverId) -> u64 {
        receiver.0.into()
    }

    /// The numbers of points that receivers have, each once, ascending.
    fn point_counts(&self) -> Vec<u32> {
        vec![1]
    }

    /// Where the hemicubes of a receiver stand; its form factors are the mean over them.
    fn frames(&self, receiver: ReceiverId) -> Vec<Frame>;

    /// The surface that a receiver lies on, if any: nothing in that surface's plane is seen.
    fn surface(&self, receiver: ReceiverId) -> Option<SurfaceId>;
}
